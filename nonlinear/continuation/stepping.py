"""From one step of a test to the next, as a rig finds it: along a stable branch, and off it where it ends."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from chassym.nonlinear.collocation.floquet import is_stable
from chassym.nonlinear.continuation.arclength import Tracer
from chassym.nonlinear.continuation.branch_steps import Point, Step
from chassym.nonlinear.continuation.continuation import first_orbit
from chassym.nonlinear.continuation.paths import Path, place
from chassym.nonlinear.continuation.settling import settle
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_equations import samples_at_knots
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.simulation.simulate import SimulationError

Array = np.ndarray

FOLD, STABILITY_LOST, BRANCH_LOST = "fold", "stability lost", "branch lost"

TOLERANCE = 1e-8
"""Relative correction of the rates at which the orbit of a step is balanced."""

_STRAIGHT, _SLIGHT = 0.2, 0.01
"""Distance of an orbit from where the mean slope leads, up to which it is taken for the next one: relative to
the change, and to the motion.

Of 170 orbits found so for a Duffing oscillator, a quarter car and a sedan, the 21 beyond a fold were all
further off than 0.37 of the change and 0.04 of the motion; 129 of the 149 on the same branch were taken.
"""

_HASTE, _SHORTEST = 6, 1 / 100
"""Newton's iterations from where the slope leads, and the least share of a step that is tried so."""

_LONGEST, _MOST_STEPS = 0.05, 600
"""Longest step along a branch, relative to the whole range, and how many may lead to the next orbit."""

_HALVINGS = 12
"""Of the interval in which stability is lost."""


@dataclass(frozen=True, eq=False)
class Departure:
    """Where a stable branch ends.

    Attributes
    ----------
    value
        The path's parameter there.
    orbit
        The last orbit.
    cause
        ``"fold"``, ``"stability lost"``, or ``"branch lost"`` where it cannot be followed.
    """

    value: float
    orbit: FourierOrbit = field(repr=False)
    cause: str


@dataclass(frozen=True, eq=False)
class Arrival:
    """The stable orbit of a step, or why there is none.

    Attributes
    ----------
    orbit
        None if there is none.
    reason
        Why; empty if there is one.
    departure
        Where the branch of the step before ended; None if it goes on to this one.
    """

    orbit: FourierOrbit | None = field(repr=False)
    reason: str = ""
    departure: Departure | None = None


class Stepper:
    """Takes steps of a test.

    Parameters
    ----------
    path
        What the steps change.
    low, high
        Smallest and largest value of the steps.
    harmonics
        Of the orbits.
    """

    def __init__(self, path: Path, low: float, high: float, harmonics: int) -> None:
        self._path, self._harmonics = path, harmonics
        self._span = high - low
        self._bounds = low - self._span, high + self._span

    def first(self, value: float) -> Arrival:
        """The stable orbit that motion from rest comes to."""
        model, excitation = self._path.at(value)
        with suppress(NoPeriodicOrbitError):
            fewest = samples_at_knots(model)
            found = first_orbit(
                model, excitation, self._harmonics, tolerance=TOLERANCE, fewest_samples=fewest
            ).orbit
            if is_stable(found):
                return Arrival(found)
        return self.settled(value, np.zeros(2 * model.size))

    def next(self, orbit: FourierOrbit, begin: float, end: float) -> Arrival:
        """The stable orbit that a test comes to when it steps from a stable one to another value.

        Where the branch of the orbit ends before the step does, it is followed on around its fold. If that
        leads to a single stable orbit, the test comes to it; otherwise the motion is integrated in time.
        """
        fewest = samples_at_knots(orbit.model)
        tracer = Tracer(self._path, self._span, self._harmonics, tolerance=TOLERANCE, fewest_samples=fewest)
        near = self._nearby(tracer, orbit, begin, end)
        if near is not None:
            return Arrival(near)
        departure: Departure | None = None
        stable: list[FourierOrbit] = []
        with suppress(NoPeriodicOrbitError):
            for piece, is_fold in self._pieces(tracer, orbit, begin, end):
                if piece.passes(end):
                    found = tracer.orbit(tracer.landing(piece, end).end)
                    if is_stable(found):
                        stable.append(found)
                    if departure is None:
                        if stable:
                            return Arrival(found)
                        departure = self._loss(tracer, (begin, orbit), (end, found))
                if is_fold and departure is None:
                    departure = Departure(piece.end.value, tracer.orbit(piece.end), FOLD)
        if departure is None:
            departure = Departure(begin, orbit, BRANCH_LOST)
        if len(stable) == 1:
            return Arrival(stable[0], departure=departure)
        return self.settled(end, orbit.state(), departure)

    def settled(self, value: float, state: Array, departure: Departure | None = None) -> Arrival:
        """The stable orbit that motion from a state comes to in time."""
        try:
            found = settle(*self._path.at(value), state, self._harmonics, TOLERANCE)
        except (NoPeriodicOrbitError, SimulationError) as error:
            return Arrival(None, str(error), departure)
        return Arrival(found, departure=departure)

    def _nearby(self, tracer: Tracer, orbit: FourierOrbit, begin: float, end: float) -> FourierOrbit | None:
        """The stable orbit at the end of a branch without folds; None if it is not clearly that."""
        point, left = tracer.begin(orbit, begin, end - begin), end - begin
        while point.value != end and abs(left) > _SHORTEST * abs(end - begin):
            with suppress(NoPeriodicOrbitError):
                near = self._smooth(tracer, point, left)
                point, left = near, end - near.value
                continue
            left *= 0.5
        found = tracer.orbit(point)
        return found if point.value == end and is_stable(found) else None

    def _smooth(self, tracer: Tracer, point: Point, change: float) -> Point:
        """The point of a branch after a change of the parameter, over which its slope hardly changes.

        Raises
        ------
        NoPeriodicOrbitError
            If there is none, or the mean of both slopes does not lead to it: a fold may lie between.
        """
        value = point.value + change
        orbit = tracer.orbit(point)
        guess = fourier.unpacked(point.unknowns + change * point.slopes, orbit.model.size)
        found = tracer.balanced(replace(orbit, coefficients=guess), value, _HASTE)
        after = tracer.begin(found, value, change)
        moved = after.unknowns - point.unknowns
        away = moved - 0.5 * change * (point.slopes + after.slopes)
        allowed = _STRAIGHT * np.linalg.norm(moved) + _SLIGHT * np.linalg.norm(after.unknowns)
        if np.linalg.norm(away) > allowed:
            raise NoPeriodicOrbitError(f"{place(self._path, value)}: another branch")
        return after

    def _pieces(
        self, tracer: Tracer, orbit: FourierOrbit, begin: float, end: float
    ) -> Iterator[tuple[Step, bool]]:
        """Pieces of the branch without folds, and whether each ends in one, while it is near the range."""
        low, high = self._bounds
        march = tracer.march(tracer.begin(orbit, begin, end - begin), _LONGEST)
        for step in islice(march, _MOST_STEPS):
            for piece in tracer.pieces(step):
                yield piece, piece.ends_in_fold
            if not low <= step.end.value <= high:
                return

    def _loss(
        self, tracer: Tracer, kept: tuple[float, FourierOrbit], lost: tuple[float, FourierOrbit]
    ) -> Departure:
        """Where on a branch between a stable and an unstable orbit the last stable one is."""
        for _ in range(_HALVINGS):
            (low, stable), (high, unstable) = kept, lost
            guess = replace(stable, coefficients=0.5 * (stable.coefficients + unstable.coefficients))
            middle = tracer.balanced(guess, 0.5 * (low + high))
            if is_stable(middle):
                kept = 0.5 * (low + high), middle
            else:
                lost = 0.5 * (low + high), middle
        return Departure(*kept, STABILITY_LOST)
