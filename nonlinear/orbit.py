"""A periodic orbit: the coordinates' Fourier series under a harmonic excitation, and what moves on it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from chassym.derivation import Model, Singularity
from chassym.nonlinear import fourier
from chassym.nonlinear.excitation import Harmonic


@dataclass(frozen=True, eq=False)
class Orbit:
    """Coordinates q(t) = Re sum_k c_k exp(i k w t).

    Attributes
    ----------
    model, excitation
        What moves and what moves it.
    coefficients
        Complex c_k, shape (degrees of freedom, harmonics + 1); m or rad.
    """

    model: Model
    excitation: Harmonic
    coefficients: np.ndarray = field(repr=False)

    @property
    def harmonics(self) -> int:
        """Order of the highest harmonic."""
        return self.coefficients.shape[1] - 1

    @cached_property
    def _motion(self) -> np.ndarray:
        """Coefficients of coordinates and rates."""
        frequency = self.excitation.angular_frequency
        return np.concatenate([self.coefficients, fourier.derivative(self.coefficients, frequency)])

    @cached_property
    def _inputs(self) -> np.ndarray:
        """Coefficients of inputs and their rates, harmonics 0 and 1."""
        amplitude = self.excitation.vector(self.model)
        both = np.concatenate([amplitude, 1j * self.excitation.angular_frequency * amplitude])
        return np.stack([np.zeros_like(both), both], axis=1)

    def arguments(self, count: int) -> np.ndarray:
        """The equations' arguments at equidistant phases; accelerations are those of the series."""
        frequency = self.excitation.angular_frequency
        rates = self._motion[self.model.size :]
        series = np.concatenate([self._motion, fourier.derivative(rates, frequency)])
        moved = fourier.samples(series, count)
        return np.concatenate([moved, fourier.samples(self._inputs, count)])

    def arguments_at(self, phases: np.ndarray) -> np.ndarray:
        """The equations' arguments at any phases; accelerations are those the equations of motion ask for."""
        moved, inputs = fourier.at_phases(self._motion, phases), fourier.at_phases(self._inputs, phases)
        return self.with_accelerations(moved, inputs)

    def with_accelerations(self, moved: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """Arguments from coordinates, rates and inputs, with accelerations from the equations.

        They converge faster than those of the series, which has to imitate the corners that the knots of a
        table make.
        """
        still = np.zeros((self.model.size, moved.shape[1]))
        arguments = np.concatenate([moved, still, inputs])
        arguments[2 * self.model.size : 3 * self.model.size] = self.model.accelerations(arguments)
        return arguments

    def sampled(self, count: int) -> np.ndarray:
        """Arguments at equidistant phases with accelerations from the equations of motion."""
        return self.with_accelerations(
            fourier.samples(self._motion, count), fourier.samples(self._inputs, count)
        )

    @cached_property
    def nearest_singularity(self) -> Singularity | None:
        """The nearest approach to the singularity of a rotation sequence; None if there is no sequence."""
        return self.model.nearest_singularity(self.arguments(8 * self.harmonics))

    def outputs(self, count: int) -> np.ndarray:
        """Every output at equidistant phases of one period, shape (outputs, count)."""
        return self.model.outputs(self.sampled(count))

    def outputs_around(self, centres: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Every output at phases near some centres, shape (outputs, len(centres), len(offsets))."""
        both = [fourier.around(c, centres, offsets) for c in (self._motion, self._inputs)]
        moved, inputs = (values.reshape(len(values), -1) for values in both)
        outputs = self.model.outputs(self.with_accelerations(moved, inputs))
        return outputs.reshape(-1, len(centres), len(offsets))

    def state(self, phase: float = 0.0) -> np.ndarray:
        """Coordinates and rates at one phase, shape (2 n,)."""
        return fourier.at_phases(self._motion, np.array([phase]))[:, 0]
