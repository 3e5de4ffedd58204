"""A step of inputs to new values, on a smooth ramp: a motion cannot jump."""

from __future__ import annotations

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


def smooth_ramp(x: Array) -> tuple[Array, Array]:
    """A ramp from 0 at x = 0 to 1 at x = 1, and its slope: 10 x^3 - 15 x^4 + 6 x^5, held outside.

    Slope and curvature are zero at both ends.

    Examples
    --------
    >>> smooth_ramp(np.array([-1.0, 0.0, 0.5, 1.0, 2.0]))
    (array([0. , 0. , 0.5, 1. , 1. ]), array([0.   , 0.   , 1.875, 0.   , 0.   ]))
    """
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10.0 + x * (6.0 * x - 15.0)), 30.0 * (x * (1.0 - x)) ** 2


@dataclass(frozen=True)
class Step(Excitation):
    """Inputs go from zero to a level and stay there.

    Parameters
    ----------
    levels
        What every moving input goes to, by its name, in the input's unit.
    ramp_s
        How long that takes: the acceleration is continuous, the largest rate 1.875 times the mean one.
        Positive.
    start_s
        When it begins.

    Raises
    ------
    ExcitationError
        If a level or the start is not finite, or the ramp's time not positive.
    """

    levels: Mapping[str, float]
    ramp_s: float
    start_s: float = 0.0

    def __post_init__(self) -> None:
        refuse_infinite(self.levels)
        refuse_unless_positive("ramp_s", self.ramp_s, "s")
        if not np.isfinite(self.start_s):
            raise ExcitationError(f"start_s: {self.start_s!r} s received; a finite number is needed")

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input, as `Excitation` says."""
        ramp, slope = smooth_ramp((np.asarray(time_s) - self.start_s) / self.ramp_s)
        levels = of_inputs(model, self.levels).real[:, None]
        return levels * ramp, levels * (slope / self.ramp_s)

    def breaks(self, start_s: float, end_s: float) -> Array:
        """Both ends of the ramp."""
        return inside((self.start_s, self.start_s + self.ramp_s), start_s, end_s)
