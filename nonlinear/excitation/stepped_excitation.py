"""A stepped sine in time: one frequency after the other, each held for a while, with a continuous phase."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import (
    Array,
    Excitation,
    ExcitationError,
    input_rows,
    inside,
    refuse_infinite,
    refuse_unless_positive,
)
from chassym.nonlinear.excitation.step import smooth_ramp


@dataclass(frozen=True)
class SteppedSine(Excitation):
    """Inputs u(t) = Re(U(t) exp(i 2 pi c(t))), whose frequency dc/dt is constant in every step.

    The cycles c go on from step to step. An amplitude U moves to its new value on a smooth ramp over the
    first cycle of a step, and from zero in the first one; so no input jumps. It is at rest before zero
    seconds; the last step goes on for ever.

    Parameters
    ----------
    frequencies_hz
        One for every step; positive.
    cycles
        How many each step lasts: one number for all steps, or one for each; one or more.
    amplitudes
        Complex amplitudes U by the input's name, in its unit: one number for all steps, or one for each.

    Raises
    ------
    ExcitationError
        If there are no steps, a number is impossible, or there are not as many of one kind as of another.

    Examples
    --------
    >>> sine = SteppedSine((1.0, 2.0), 3, {"road": (0.02, 0.01)})
    >>> sine.starts_s
    array([0., 3.])
    """

    frequencies_hz: Sequence[float]
    cycles: float | Sequence[float]
    amplitudes: Mapping[str, complex | Sequence[complex]]

    def __post_init__(self) -> None:
        if not len(self.frequencies_hz):
            raise ExcitationError("frequencies_hz: none received; a stepped sine needs one or more")
        for frequency in self.frequencies_hz:
            refuse_unless_positive("frequencies_hz", frequency, "Hz")
        for number in self._of_steps("cycles", self.cycles).real:
            if not (np.isfinite(number) and number >= 1):
                raise ExcitationError(f"cycles: {number!r} received; a finite number, 1 or more, is needed")
        for name, given in self.amplitudes.items():
            for amplitude in self._of_steps(f"amplitudes of {name!r}", given):
                refuse_infinite({name: amplitude})

    @classmethod
    def of_durations(
        cls,
        frequencies_hz: Sequence[float],
        seconds: float | Sequence[float],
        amplitudes: Mapping[str, complex | Sequence[complex]],
    ) -> SteppedSine:
        """Steps that last so many seconds, and no less than a cycle, instead of so many cycles."""
        try:
            cycles = np.asarray(seconds, dtype=float) * np.asarray(frequencies_hz, dtype=float)
        except ValueError as error:
            raise ExcitationError(
                f"seconds: {np.size(seconds)} received; one, or one for each of the "
                f"{len(frequencies_hz)} steps, is needed"
            ) from error
        return cls(frequencies_hz, cycles.tolist(), amplitudes)

    def _of_steps(self, name: str, given: complex | Sequence[complex]) -> Array:
        """One number for every step."""
        numbers = np.atleast_1d(np.asarray(given, dtype=complex))
        if len(numbers) not in (1, len(self.frequencies_hz)):
            raise ExcitationError(
                f"{name}: {len(numbers)} received; one, or one for each of the {len(self.frequencies_hz)} "
                "steps, is needed"
            )
        return np.broadcast_to(numbers, len(self.frequencies_hz))

    @cached_property
    def _frequencies(self) -> Array:
        return np.asarray(self.frequencies_hz, dtype=float)

    @cached_property
    def _first_cycles(self) -> Array:
        """Cycles done before every step, and before what follows the last one."""
        return np.concatenate([[0.0], np.cumsum(self._of_steps("cycles", self.cycles).real)])

    @cached_property
    def _edges_s(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(np.diff(self._first_cycles) / self._frequencies)])

    @property
    def starts_s(self) -> Array:
        """When every step begins, shape (steps,)."""
        return self._edges_s[:-1]

    @property
    def end_s(self) -> float:
        """When the last step has had its cycles."""
        return float(self._edges_s[-1])

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input, as `Excitation` says."""
        time_s = np.asarray(time_s, dtype=float)
        step = np.maximum(np.searchsorted(self.starts_s, time_s, side="right") - 1, 0)
        frequency = self._frequencies[step]
        done = (time_s - self.starts_s[step]) * frequency
        amplitudes = self._amplitudes(model)
        before, change = amplitudes[:, step], amplitudes[:, step + 1] - amplitudes[:, step]
        ramp, slope = smooth_ramp(done)
        turning = np.exp(2j * np.pi * (self._first_cycles[step] + done))
        level = before + change * ramp
        rate = frequency * (change * slope + 2j * np.pi * level) * turning
        return (level * turning).real, rate.real

    def _amplitudes(self, model: Model) -> Array:
        """Amplitudes of all inputs before the first and in every step, shape (inputs, steps + 1)."""
        found = np.zeros((len(model.system.inputs), len(self.frequencies_hz) + 1), dtype=complex)
        for row, (name, given) in zip(
            input_rows(model, self.amplitudes), self.amplitudes.items(), strict=True
        ):
            found[row, 1:] = self._of_steps(name, given)
        return found

    def breaks(self, start_s: float, end_s: float) -> Array:
        """Beginnings of the steps, and ends of the ramps after them."""
        return inside(np.concatenate([self.starts_s, self.starts_s + 1 / self._frequencies]), start_s, end_s)
