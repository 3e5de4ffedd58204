"""Passing the knots of tables and the edges of contact: found within a step, to rounding, all at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from chassym.derivation.kinks import Kink
from chassym.nonlinear.dips import possible_dips
from chassym.nonlinear.simulation.held_motion import HeldMotion, TimeStep

Array = np.ndarray

KNOT, CONTACT_MADE, CONTACT_LOST = "knot", "contact made", "contact lost"

_ROUNDING = 1e-12
"""Of distances, relative to the largest and one SI unit."""

_TOGETHER = 1e-12
"""Passings no further apart (s, relative to the time beyond one second) are one event."""


@dataclass(frozen=True)
class Crossing:
    """Knots that are passed at an instant."""

    time_s: float
    knots: tuple[int, ...]


class Crossings:
    """Watches on which side of every knot a motion is, and holds its laws there.

    Parameters
    ----------
    motion
        Its sides are set here.
    time_s, state
        Where it begins.
    slack
        How far beyond a knot a motion has passed it (SI unit of the distance): one that rests there has not.

    Attributes
    ----------
    counts
        Knots passed so far, by what happened.
    """

    def __init__(self, motion: HeldMotion, time_s: float, state: Array, slack: float) -> None:
        self._motion = motion
        self._kinks = motion.model.knot_distances.columns
        self._signs = np.where(motion.distances(time_s, state) < 0, -1.0, 1.0)
        self._largest = np.zeros(len(self._kinks))
        self._least_slack = max(slack, _ROUNDING)
        self._slack = np.full(len(self._kinks), self._least_slack)
        self.counts: Counter[str] = Counter()
        self._hold()

    def look_again(self, time_s: float, state: Array) -> None:
        """Where the excitation breaks, forces may have jumped beyond a knot."""
        distances = self._motion.distances(time_s, state)
        beyond = np.flatnonzero(self._signs * distances < -self._slack)
        self.cross(Crossing(time_s, tuple(map(int, beyond))), state)

    def first(self, step: TimeStep) -> Crossing | None:
        """The first knots passed in a step; None if none is."""
        if not len(self._signs):
            return None
        distances = self._motion.model.knot_distances(step.arguments)
        self._largest = np.maximum(self._largest, np.abs(distances).max(axis=1))
        inside = self._inside(distances)
        brackets = [*self._ends(step, inside), *self._dips(step, inside)]
        passed = [(self._instant(step, knot, *bracket), knot) for knot, *bracket in brackets]
        if not passed:
            return None
        first = min(passed)[0]
        together = first + _TOGETHER * max(1.0, abs(first))
        return Crossing(first, tuple(sorted({knot for time_s, knot in passed if time_s <= together})))

    def cross(self, crossing: Crossing, state: Array) -> None:
        """Hold the laws of the knots passed on their other side."""
        distances = self._motion.distances(crossing.time_s, state)
        for knot in crossing.knots:
            self._signs[knot] *= -1
            short_of_it = -self._signs[knot] * distances[knot]
            rounding = _ROUNDING * (1 + self._largest[knot])
            self._slack[knot] = max(rounding, self._least_slack, 2 * short_of_it)
            self.counts[_event(self._kinks[knot], self._signs[knot])] += 1
        self._hold()

    def _hold(self) -> None:
        self._motion.sides[:] = self._signs > 0

    def _inside(self, distances: Array) -> Array:
        """Distances, positive on the side held; the knot itself belongs to it."""
        return self._signs[:, None] * distances + self._slack[:, None]

    def _ends(self, step: TimeStep, inside: Array) -> Iterator[tuple[int, float, float]]:
        """Knot and bracket of every sample beyond a knot after one that is not."""
        knots, places = np.nonzero((inside[:, 1:] < 0) & (inside[:, :-1] >= 0))
        for knot, place in zip(knots, places, strict=True):
            yield int(knot), step.times_s[place], step.times_s[place + 1]

    def _dips(self, step: TimeStep, inside: Array) -> Iterator[tuple[int, float, float]]:
        """Knot and bracket of every passing and passing back between samples."""
        spacing = step.times_s[1] - step.times_s[0]
        for knot, place in zip(*possible_dips(inside), strict=True):
            lowest = float(step.times_s[0] + spacing * place)
            start = float(step.times_s[max(0, int(place) - 1)])
            if self._beyond(step, int(knot), start) >= 0 > self._beyond(step, int(knot), lowest):
                yield int(knot), start, lowest

    def _beyond(self, step: TimeStep, knot: int, time_s: float) -> float:
        distance = self._motion.distances(time_s, step.curve(time_s))[knot]
        return float(self._signs[knot] * distance + self._slack[knot])

    def _instant(self, step: TimeStep, knot: int, start_s: float, end_s: float) -> float:
        """When a knot is passed between an instant on the side held and one beyond it."""
        return float(brentq(lambda t: self._beyond(step, knot, t), start_s, end_s, xtol=1e-14, rtol=1e-15))


def _event(kink: int, sign: float) -> str:
    """What happens at a knot that is passed to a side."""
    if kink == Kink.KNOT:
        return KNOT
    return CONTACT_MADE if (kink == Kink.CONTACT_ABOVE) == (sign > 0) else CONTACT_LOST
