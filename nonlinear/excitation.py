"""Harmonic excitation: prescribed motions of one frequency, each with its amplitude and phase."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model


class ExcitationError(ValueError):
    """An excitation that cannot be applied: the message names the argument and what would be accepted."""


@dataclass(frozen=True)
class Harmonic:
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
        if not (np.isfinite(self.frequency_hz) and self.frequency_hz > 0):
            raise ExcitationError(
                f"frequency: {self.frequency_hz!r} Hz received; a positive finite number is needed"
            )
        for name, amplitude in self.amplitudes.items():
            if not np.isfinite(amplitude):
                raise ExcitationError(
                    f"amplitude of {name!r}: {amplitude!r} received; a finite number is needed"
                )

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
        names = [u.name for u in model.system.inputs]
        for name in self.amplitudes:
            if name not in names:
                raise ExcitationError(
                    f"input {name!r}: {model.system.name} has {', '.join(names) or 'no inputs'}"
                )
        return np.array([self.amplitudes.get(name, 0) for name in names], dtype=complex)
