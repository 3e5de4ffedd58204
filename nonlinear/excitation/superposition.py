"""Several excitations at once: their motions are added."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Array, Excitation, ExcitationError, inside


@dataclass(frozen=True)
class Superposition(Excitation):
    """The sum of excitations.

    Parameters
    ----------
    parts
        One or more.

    Raises
    ------
    ExcitationError
        If there are none.

    Examples
    --------
    A step on which the road goes on shaking:

    >>> from chassym.nonlinear import Harmonic, Step
    >>> both = Superposition((Step({"road": 0.05}, ramp_s=0.1, start_s=1.0), Harmonic(3.0, {"road": 0.01})))
    >>> both.breaks(0.0, 2.0)
    array([1. , 1.1])
    """

    parts: tuple[Excitation, ...]

    def __post_init__(self) -> None:
        if not self.parts:
            raise ExcitationError("parts: none received; a superposition needs one excitation or more")

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input, as `Excitation` says."""
        values, rates = zip(*(part.signals(model, time_s) for part in self.parts), strict=True)
        return np.sum(values, axis=0), np.sum(rates, axis=0)

    def at(self, model: Model) -> Callable[[float], Array]:
        """A function of one instant, as `Excitation` says."""
        parts = [part.at(model) for part in self.parts]

        def moved(time_s: float) -> Array:
            return np.sum([part(time_s) for part in parts], axis=0)

        return moved

    def breaks(self, start_s: float, end_s: float) -> Array:
        """Those of all parts."""
        return inside(np.concatenate([part.breaks(start_s, end_s) for part in self.parts]), start_s, end_s)
