"""Chirps: a sine whose frequency moves from one value to another."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import (
    Array,
    Excitation,
    ExcitationError,
    inside,
    of_inputs,
    refuse_infinite,
    refuse_unless_positive,
)


@dataclass(frozen=True)
class Chirp(Excitation):
    """Inputs u(t) = Re(U exp(i 2 pi c(t))), where the cycles c(t) come ever faster, or slower.

    The sweep begins at zero seconds. Before it the first frequency holds, after it the last; the phase is
    continuous.

    Parameters
    ----------
    start_hz, end_hz
        First and last frequency; positive and different.
    duration_s
        Time from one to the other; positive.
    amplitudes
        Complex amplitude U of every moving input, by its name, in the input's unit; -1j times a real one
        starts at zero.

    Raises
    ------
    ExcitationError
        If a frequency or the duration is not positive, the frequencies are equal, or an amplitude is not
        finite.
    """

    start_hz: float
    end_hz: float
    duration_s: float
    amplitudes: Mapping[str, complex]

    def __post_init__(self) -> None:
        refuse_unless_positive("start_hz", self.start_hz, "Hz")
        refuse_unless_positive("end_hz", self.end_hz, "Hz")
        refuse_unless_positive("duration_s", self.duration_s, "s")
        if self.start_hz == self.end_hz:
            raise ExcitationError(
                f"end_hz: {self.end_hz!r} Hz received, as start_hz; another one is needed, or a Harmonic"
            )
        refuse_infinite(self.amplitudes)

    @abstractmethod
    def _frequency(self, elapsed: Array) -> Array:
        """Frequency (Hz) at parts of the duration between 0 and 1."""

    @abstractmethod
    def _cycles(self, elapsed: Array) -> Array:
        """Its integral from 0 (Hz)."""

    def frequency_hz(self, time_s: Array) -> Array:
        """The momentary frequency."""
        return self._frequency(np.clip(np.asarray(time_s) / self.duration_s, 0.0, 1.0))

    def cycles(self, time_s: Array) -> Array:
        """Cycles since the sweep began; negative before."""
        elapsed = np.asarray(time_s) / self.duration_s
        clipped = np.clip(elapsed, 0.0, 1.0)
        held = (elapsed - clipped) * self._frequency(clipped)
        return np.asarray(self.duration_s * (self._cycles(clipped) + held))

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input, as `Excitation` says."""
        moved = of_inputs(model, self.amplitudes)[:, None] * np.exp(2j * np.pi * self.cycles(time_s))
        return moved.real, -2 * np.pi * self.frequency_hz(time_s) * moved.imag

    def breaks(self, start_s: float, end_s: float) -> Array:
        """Beginning and end of the sweep: there the frequency bends."""
        return inside((0.0, self.duration_s), start_s, end_s)


class LinearChirp(Chirp):
    """A chirp whose frequency changes at a constant rate in Hz/s.

    Examples
    --------
    >>> chirp = LinearChirp(1.0, 3.0, 10.0, {"road": 0.01})
    >>> float(chirp.frequency_hz(5.0)), float(chirp.cycles(10.0))
    (2.0, 20.0)
    """

    def _frequency(self, elapsed: Array) -> Array:
        return self.start_hz + (self.end_hz - self.start_hz) * elapsed

    def _cycles(self, elapsed: Array) -> Array:
        return elapsed * (self.start_hz + (self.end_hz - self.start_hz) * elapsed / 2)


class LogarithmicChirp(Chirp):
    """A chirp whose frequency changes at a constant rate in octaves per second.

    Examples
    --------
    >>> chirp = LogarithmicChirp(1.0, 4.0, 10.0, {"road": 0.01})
    >>> float(chirp.frequency_hz(5.0))
    2.0
    """

    def _frequency(self, elapsed: Array) -> Array:
        return np.asarray(self.start_hz * (self.end_hz / self.start_hz) ** elapsed)

    def _cycles(self, elapsed: Array) -> Array:
        growth = np.log(self.end_hz / self.start_hz)
        return np.asarray(self.start_hz * np.expm1(growth * elapsed) / growth)
