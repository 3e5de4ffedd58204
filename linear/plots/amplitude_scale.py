"""How an amplitude is drawn: on a logarithmic axis, or in decibels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class AmplitudeScale:
    """From amplitudes to what stands on the axis.

    Attributes
    ----------
    axis
        Scale of the matplotlib axis.
    drawn
        From amplitudes in SI units to what is drawn.
    unit
        From the readable unit of the amplitude to that of the axis.
    """

    axis: str
    drawn: Callable[[Array], Array]
    unit: Callable[[str], str]


def _decibels(amplitude: Array) -> Array:
    with np.errstate(divide="ignore"):  # an amplitude of zero is minus infinity: a gap in the line
        return 20 * np.log10(amplitude)


LOGARITHMIC = AmplitudeScale("log", lambda amplitude: amplitude, lambda unit: unit)
"""Amplitudes on a logarithmic axis."""

DECIBEL = AmplitudeScale("linear", _decibels, lambda unit: f"dB relative to 1 {unit}")
"""20 log10 of the amplitude over one SI unit."""
