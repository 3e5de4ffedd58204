"""What every periodic orbit answers, however its motion is written down."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Self

import numpy as np

from chassym.derivation import Model, Singularity
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics import fourier

Array = np.ndarray

_SAMPLES = 1024
"""Instants of one orbit at which its distance from singularities is looked at, and its harmonics read."""


class PeriodicOrbit(ABC):
    """A motion that repeats itself under a harmonic excitation.

    Phases run from 0 to 2 pi over the whole orbit, which takes `subharmonic` periods of the excitation.

    Attributes
    ----------
    model, excitation
        What moves and what moves it.
    subharmonic
        Periods of the excitation after which the orbit repeats.
    """

    model: Model
    excitation: Harmonic
    subharmonic: int

    @property
    def angular_frequency(self) -> float:
        """Of the orbit's first harmonic (rad/s)."""
        return self.excitation.angular_frequency / self.subharmonic

    @property
    def period_s(self) -> float:
        """Time after which the orbit repeats (s)."""
        return self.subharmonic / self.excitation.frequency_hz

    @abstractmethod
    def motion_at(self, phases: Array) -> Array:
        """Coordinates, then rates, shape (2 n, phases)."""

    @abstractmethod
    def extremes(self, rows: list[int]) -> tuple[Array, Array]:
        """Smallest and largest value of some outputs over the orbit, shape (len(rows),) each."""

    @abstractmethod
    def under(self, model: Model, excitation: Harmonic) -> Self:
        """The same motion over phases in another test: rates grow with its frequency."""

    @cached_property
    def _amplitudes(self) -> Array:
        """Complex amplitudes of all inputs."""
        return self.excitation.vector(self.model)

    def inputs_at(self, phases: Array) -> Array:
        """Inputs, then their rates, shape (2 inputs, phases)."""
        turning = self._amplitudes[:, None] * np.exp(1j * self.subharmonic * phases)
        return np.concatenate([turning.real, -self.excitation.angular_frequency * turning.imag])

    def sampled_motion(self, count: int) -> Array:
        """The equations' arguments at equidistant phases but for accelerations, which are zero."""
        phases = 2 * np.pi / count * np.arange(count)
        return self._without_accelerations(self.motion_at(phases), self.inputs_at(phases))

    def _without_accelerations(self, moved: Array, inputs: Array) -> Array:
        return np.concatenate([moved, np.zeros((self.model.size, moved.shape[1])), inputs])

    def arguments_at(self, phases: Array) -> Array:
        """The equations' arguments; accelerations are those the equations of motion ask for."""
        return self.with_accelerations(self.motion_at(phases), self.inputs_at(phases))

    def with_accelerations(self, moved: Array, inputs: Array) -> Array:
        """Arguments from coordinates, rates and inputs, with accelerations from the equations of motion.

        They converge faster than second derivatives of the coordinates, which have to imitate the corners
        that the knots of a table make.
        """
        return self._accelerated(self._without_accelerations(moved, inputs))

    def _accelerated(self, arguments: Array) -> Array:
        """The arguments, their accelerations replaced."""
        n = self.model.size
        arguments[2 * n : 3 * n] = self.model.accelerations(arguments)
        return arguments

    def sampled(self, count: int) -> Array:
        """Arguments at equidistant phases with accelerations from the equations of motion."""
        return self._accelerated(self.sampled_motion(count))

    def outputs_at(self, phases: Array) -> Array:
        """Every output, shape (outputs, phases)."""
        return self.model.outputs(self.arguments_at(phases))

    def outputs(self, count: int) -> Array:
        """Every output at equidistant phases of the orbit, shape (outputs, count)."""
        return self.model.outputs(self.sampled(count))

    def state(self, phase: float = 0.0) -> Array:
        """Coordinates and rates at one phase, shape (2 n,)."""
        return self.motion_at(np.array([phase]))[:, 0]

    def harmonic_content(self, harmonics: int) -> Array:
        """Complex amplitudes of all outputs, shape (outputs, harmonics + 1), orders of the orbit's frequency.

        An output is the sum over k of Re(c_k exp(i k phase)).
        """
        count = max(_SAMPLES, 1 << (8 * harmonics - 1).bit_length())
        return fourier.coefficients(self.outputs(count), harmonics)

    @cached_property
    def nearest_singularity(self) -> Singularity | None:
        """The nearest approach to the singularity of a rotation sequence; None if there is no sequence."""
        if not self.model.system.rotation_sequences:
            return None
        return self.model.nearest_singularity(self.sampled_motion(_SAMPLES))
