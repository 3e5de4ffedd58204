"""What moves a model: the protocol of excitations, and the harmonic one of a single frequency."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from chassym.derivation import Model

Array = np.ndarray

NO_BREAKS = np.empty(0)
"""Of an excitation that is smooth at all times."""


class ExcitationError(ValueError):
    """An excitation that cannot be applied: the message names the argument and what would be accepted."""


class Excitation(Protocol):
    """Prescribed motions, or forces, of a model's inputs over time; inputs it does not name stand still."""

    @abstractmethod
    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input of a model.

        Parameters
        ----------
        time_s
            Shape (samples,).

        Returns
        -------
        tuple of numpy.ndarray
            Values and rates, each of shape (inputs, samples), in the inputs' units and those per second.

        Raises
        ------
        ExcitationError
            If the model has no input of a name, or an instant is outside what is known.
        """

    @abstractmethod
    def breaks(self, start_s: float, end_s: float) -> Array:
        """Ascending instants after the start and before the end where a rate jumps or bends."""

    def at(self, model: Model) -> Callable[[float], Array]:
        """A function of one instant (s) that gives values, then rates, shape (2 inputs,): for inner loops.

        Raises
        ------
        ExcitationError
            If the model has no input of a name.
        """

        def moved(time_s: float) -> Array:
            return np.concatenate(self.signals(model, np.array([time_s])))[:, 0]

        return moved


def input_rows(model: Model, names: Iterable[str]) -> list[int]:
    """Where inputs stand among those of a model.

    Raises
    ------
    ExcitationError
        If the model has no input of a name.
    """
    rows = {motion.name: row for row, motion in enumerate(model.system.inputs)}
    for name in names:
        if name not in rows:
            raise ExcitationError(f"input {name!r}: {model.system.name} has {', '.join(rows) or 'no inputs'}")
    return [rows[name] for name in names]


def of_inputs(model: Model, given: Mapping[str, complex]) -> Array:
    """Numbers of all inputs of a model, in order, from those of some by name; zero for the others, (inputs,).

    Raises
    ------
    ExcitationError
        If the model has no input of a name.
    """
    numbers = np.zeros(len(model.system.inputs), dtype=complex)
    numbers[input_rows(model, given)] = list(given.values())
    return numbers


@dataclass(frozen=True)
class Harmonic(Excitation):
    """Inputs u(t) = Re(U exp(i 2 pi f t)); inputs not named stand still.

    A real amplitude is a cosine, -1j times it a sine, which starts at zero.

    Parameters
    ----------
    frequency_hz
        Positive.
    amplitudes
        Complex amplitude U of every moving input, by its name, in the input's unit.

    Raises
    ------
    ExcitationError
        If the frequency is not positive or an amplitude not finite.

    Examples
    --------
    >>> Harmonic(3.0, {"road": 0.01}).period_s
    0.3333333333333333
    """

    frequency_hz: float
    amplitudes: Mapping[str, complex]

    def __post_init__(self) -> None:
        refuse_unless_positive("frequency", self.frequency_hz, "Hz")
        refuse_infinite(self.amplitudes)

    @property
    def angular_frequency(self) -> float:
        """2 pi f (rad/s)."""
        return 2 * np.pi * self.frequency_hz

    @property
    def period_s(self) -> float:
        """1/f (s)."""
        return 1 / self.frequency_hz

    def scaled(self, factor: float) -> Harmonic:
        """The same excitation with all amplitudes multiplied."""
        return Harmonic(self.frequency_hz, {name: factor * u for name, u in self.amplitudes.items()})

    def vector(self, model: Model) -> np.ndarray:
        """Complex amplitudes of all inputs of a model, in order, shape (inputs,).

        Raises
        ------
        ExcitationError
            If the model has no input of a name.
        """
        return of_inputs(model, self.amplitudes)

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input, as `Excitation` says."""
        turning = np.exp(1j * self.angular_frequency * np.asarray(time_s))
        moved = self.vector(model)[:, None] * turning
        return moved.real, -self.angular_frequency * moved.imag

    def at(self, model: Model) -> Callable[[float], Array]:
        """A function of one instant, as `Excitation` says."""
        amplitude = self.vector(model)
        both = np.concatenate([amplitude, 1j * self.angular_frequency * amplitude])
        combine = np.stack([both.real, -both.imag], axis=1).dot
        turning, frequency = np.empty(2), self.angular_frequency

        def moved(time_s: float) -> Array:
            turned = frequency * time_s
            turning[0], turning[1] = math.cos(turned), math.sin(turned)
            return combine(turning)

        return moved

    def breaks(self, start_s: float, end_s: float) -> Array:
        """None: it is smooth."""
        return NO_BREAKS


def refuse_infinite(amplitudes: Mapping[str, complex]) -> None:
    """Refuse amplitudes that are not finite.

    Raises
    ------
    ExcitationError
        If there is one.
    """
    for name, amplitude in amplitudes.items():
        if not np.isfinite(amplitude):
            raise ExcitationError(f"amplitude of {name!r}: {amplitude!r} received; a finite number is needed")


def refuse_unless_positive(name: str, value: float, unit: str) -> None:
    """Refuse what is not a positive finite number.

    Raises
    ------
    ExcitationError
        If it is not.
    """
    if not (np.isfinite(value) and value > 0):
        raise ExcitationError(f"{name}: {value!r} {unit} received; a positive finite number is needed")


def inside(instants: Iterable[float], start_s: float, end_s: float) -> Array:
    """Those instants that are after a start and before an end, ascending."""
    return np.array(sorted({float(t) for t in instants if start_s < t < end_s}))
