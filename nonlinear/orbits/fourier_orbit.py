"""A periodic orbit: the coordinates' Fourier series under a harmonic excitation, and what moves on it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.orbits import peaks
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit


@dataclass(frozen=True, eq=False)
class FourierOrbit(PeriodicOrbit):
    """Coordinates q(t) = Re sum_k c_k exp(i k w t / subharmonic).

    Attributes
    ----------
    model, excitation
        What moves and what moves it.
    coefficients
        Complex c_k, shape (degrees of freedom, harmonics + 1); m or rad.
    subharmonic
        Periods of the excitation after which the orbit repeats. Phases run from 0 to 2 pi over all of them.
    """

    model: Model
    excitation: Harmonic
    coefficients: np.ndarray = field(repr=False)
    subharmonic: int = 1

    @property
    def harmonics(self) -> int:
        """Order of the highest harmonic."""
        return self.coefficients.shape[1] - 1

    @cached_property
    def _motion(self) -> np.ndarray:
        """Coefficients of coordinates and rates."""
        rates = fourier.derivative(self.coefficients, self.angular_frequency)
        return np.concatenate([self.coefficients, rates])

    @cached_property
    def _inputs(self) -> np.ndarray:
        """Coefficients of inputs and their rates, up to the harmonic of the excitation."""
        amplitude = self._amplitudes
        both = np.zeros((2 * len(amplitude), self.subharmonic + 1), dtype=complex)
        both[:, -1] = np.concatenate([amplitude, 1j * self.excitation.angular_frequency * amplitude])
        return both

    def arguments(self, count: int) -> np.ndarray:
        """The equations' arguments at equidistant phases; accelerations are those of the series."""
        rates = self._motion[self.model.size :]
        series = np.concatenate([self._motion, fourier.derivative(rates, self.angular_frequency)])
        moved = fourier.samples(series, count)
        return np.concatenate([moved, fourier.samples(self._inputs, count)])

    def motion_at(self, phases: np.ndarray) -> np.ndarray:
        """Coordinates, then rates, shape (2 n, phases)."""
        return fourier.at_phases(self._motion, phases)

    def extremes(self, rows: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Smallest and largest value of some outputs over the orbit, shape (len(rows),) each."""
        return peaks.extremes(self, rows)

    def sampled_motion(self, count: int) -> np.ndarray:
        """The equations' arguments at equidistant phases but for accelerations, which are zero."""
        return self._without_accelerations(
            fourier.samples(self._motion, count), fourier.samples(self._inputs, count)
        )

    def outputs_around(self, centres: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Every output at phases near some centres, shape (outputs, len(centres), len(offsets))."""
        both = [fourier.around(c, centres, offsets) for c in (self._motion, self._inputs)]
        moved, inputs = (values.reshape(len(values), -1) for values in both)
        outputs = self.model.outputs(self.with_accelerations(moved, inputs))
        return outputs.reshape(-1, len(centres), len(offsets))

    def under(self, model: Model, excitation: Harmonic) -> Self:
        """The same motion over phases in another test."""
        return replace(self, model=model, excitation=excitation)
