"""When and where the force of a contact patch was not a push any more, found while a motion is integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from chassym.derivation import Model
from chassym.nonlinear.orbits.patches import carries_by_contact, patch_of
from chassym.nonlinear.simulation.held_motion import TimeStep

Array = np.ndarray

_NOTHING = 1e-6
"""A smaller force (N) is no push: a tyre in the air has one of rounding."""


@dataclass(frozen=True)
class LossOfContact:
    """A time without contact in a simulation.

    All those in a period of a periodic orbit are a `chassym.nonlinear.rig.PeriodicLossOfContact`.

    Attributes
    ----------
    patch
        Name of the place.
    start_s, end_s
        From when to when; a loss may have begun, or not have ended, with the simulation.
    smallest_force
        Smallest vertical force then (N): zero where the tyre lifts, negative where it is bonded to its pad.
    """

    patch: str
    start_s: float
    end_s: float
    smallest_force: float

    def __str__(self) -> str:
        """One line."""
        return (
            f"{self.patch}: {self.start_s:.6g} to {self.end_s:.6g} s, smallest force "
            f"{self.smallest_force:.4g} N"
        )


class ContactWatch:
    """Follows all patch forces of a model from step to step."""

    def __init__(self, model: Model) -> None:
        outputs = model.system.outputs
        self._rows = [row for row, output in enumerate(outputs) if carries_by_contact(output)]
        self._names = [patch_of(outputs[row].name) for row in self._rows]
        self._open: dict[int, tuple[float, float]] = {}
        self._closed: list[LossOfContact] = []

    def follow(self, step: TimeStep) -> None:
        """Look at a step that begins where the last one ended."""
        if not self._rows:
            return
        forces = step.outputs(step.arguments)[self._rows]
        is_off = forces <= _NOTHING
        for patch, off in enumerate(is_off):
            if off.any() or patch in self._open:
                self._follow(patch, step, forces[patch], off)

    def losses(self, end_s: float) -> tuple[LossOfContact, ...]:
        """Every loss until now, in the order of their beginnings."""
        still = [self._loss(patch, end_s) for patch in self._open]
        return tuple(sorted([*self._closed, *still], key=lambda loss: (loss.start_s, loss.patch)))

    def _follow(self, patch: int, step: TimeStep, forces: Array, is_off: Array) -> None:
        """A step in which a patch is without contact at some samples."""
        for place, off in enumerate(is_off):
            if off and patch not in self._open:
                self._open[patch] = self._change(patch, step, place), np.inf
            if not off and patch in self._open:
                self._close(patch, self._change(patch, step, place))
            if off:
                start_s, smallest = self._open[patch]
                self._open[patch] = start_s, min(smallest, _lowest(forces, place))

    def _change(self, patch: int, step: TimeStep, place: int) -> float:
        """When contact ends or begins: at the first sample, or between another and the one before it."""
        if place == 0:
            return step.start_s
        row = self._rows[patch]
        before_s, after_s = step.times_s[place - 1 : place + 1]
        return float(brentq(lambda t: step.outputs_at(t)[row] - _NOTHING, before_s, after_s, xtol=1e-12))

    def _close(self, patch: int, end_s: float) -> None:
        self._closed.append(self._loss(patch, end_s))
        del self._open[patch]

    def _loss(self, patch: int, end_s: float) -> LossOfContact:
        start_s, smallest = self._open[patch]
        return LossOfContact(self._names[patch], start_s, end_s, smallest)


def _lowest(forces: Array, place: int) -> float:
    """The smallest value around a sample: of a parabola through it and its neighbours if it is lowest."""
    here = float(forces[place])
    if 0 < place < len(forces) - 1:
        before, after = float(forces[place - 1]), float(forces[place + 1])
        bend = before - 2 * here + after
        if bend > 0 and here <= min(before, after):
            return here - (before - after) ** 2 / (8 * bend)
    return here
