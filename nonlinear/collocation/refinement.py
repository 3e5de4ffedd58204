"""From a first guess of a periodic orbit to one that is accurate enough: more points, more pieces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from chassym.nonlinear.collocation.collocation import Linearisation, in_pieces
from chassym.nonlinear.collocation.mesh import MOST_PIECES, cut, first_boundaries
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.orbits.knots import knot_phases
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

Array = np.ndarray

FEWEST_POINTS, MOST_POINTS = 4, 24
"""Gauss points of a piece at first, and where the refinement gives up."""

_MOST_STEPS = 40
"""Newton steps to come near the orbit."""

_LONGEST_STEP = 0.5
"""Relative correction beyond which a step is shortened."""

_NEAR = 0.1
"""Relative correction from which every further step is made with one point more."""

_ROUNDING = 1e-10
"""Accelerations (m/s^2 or rad/s^2) that rounding makes of a motion at rest."""

_MOST_PARTS = 4.0
"""Parts that a piece is cut in at once at most."""

_SMALL = 1e-3
"""Part of the largest acceleration below which that of a coordinate does not count by itself."""


@dataclass(frozen=True, eq=False)
class Refined:
    """An orbit after one more step of Newton's method.

    Attributes
    ----------
    orbit
        The orbit.
    correction
        Largest correction of its rates by that step, relative to the rates.
    iterations
        Steps so far.
    deviations
        By how much its starts are expected to be off still, shape (pieces, 2 n). None where the step has
        changed which knots are passed, or the pieces between: nothing can be said then.
    """

    orbit: PiecewiseOrbit
    correction: float
    iterations: int
    deviations: Array | None


def refinements(guess: PeriodicOrbit, rough: float) -> Iterator[Refined]:
    """Ever more accurate orbits, each of which is cut where it passes knots itself.

    The first of them is near enough for Newton's method to converge at once; each one more is one step from
    the last, with one Gauss point more, and pieces that are not resolved are cut in parts.

    Parameters
    ----------
    guess
        An orbit to start from.
    rough
        Part that the highest polynomial may have in the accelerations of a piece that stays whole.

    Raises
    ------
    NoPeriodicOrbitError
        If Newton's method does not come near an orbit, or the motion is too rough.
    ExcitationError
        If the test is too slow for the model's fastest motion to be followed.
    """
    knots, equal = knot_phases(guess), first_boundaries(guess)
    orbit = in_pieces(guess, cut(knots, equal, np.ones(len(equal) - 1)), FEWEST_POINTS)
    points, iterations, is_near = FEWEST_POINTS, 0, False
    while points < MOST_POINTS:
        linear = Linearisation(orbit)
        orbit, correction = _stepped(orbit, linear.corrected())
        iterations += 1
        is_near = is_near or correction < _NEAR
        if not np.isfinite(correction) or (iterations == _MOST_STEPS and not is_near):
            raise NoPeriodicOrbitError(
                f"collocation at {guess.excitation.frequency_hz:g} Hz: correction {iterations} is still "
                f"{correction:.2g} of the motion; start from a smaller amplitude"
            )
        points += is_near
        passed, knots = len(knots), knot_phases(orbit)
        orbit = _cut_again(orbit, knots, points, rough if is_near else np.inf)
        if is_near:
            deviations = linear.deviations(orbit) if len(knots) == passed else None
            yield Refined(orbit, correction, iterations, deviations)


def _cut_again(orbit: PiecewiseOrbit, knots: Array, points: int, rough: float) -> PiecewiseOrbit:
    """The orbit cut where it passes knots now, rough pieces in parts."""
    parts = np.ceil((_roughness(orbit) / rough) ** (1 / (orbit.points - 1)))
    wanted = np.clip(parts, 1.0, _MOST_PARTS)
    if wanted.sum() > MOST_PIECES:
        raise NoPeriodicOrbitError(
            f"collocation at {orbit.excitation.frequency_hz:g} Hz: more than {MOST_PIECES} pieces do not "
            "resolve the motion; ask for less accuracy or a smaller amplitude"
        )
    return in_pieces(orbit, cut(knots, orbit.boundaries, wanted), points)


def _roughness(orbit: PiecewiseOrbit) -> Array:
    """Part of the highest polynomial in the accelerations of every piece, of the worst coordinate."""
    highest = np.abs(orbit.highest_coefficient @ orbit.accelerations)
    largest = np.abs(orbit.accelerations).max(axis=(0, 1))
    return np.asarray((highest / np.maximum(largest, _SMALL * largest.max() + _ROUNDING)).max(axis=1))


def _stepped(orbit: PiecewiseOrbit, found: PiecewiseOrbit) -> tuple[PiecewiseOrbit, float]:
    """A step of Newton's method, shortened if it is long, and its relative correction of the rates."""
    n = orbit.model.size
    change = found.starts - orbit.starts
    correction = float(np.abs(change[:, n:]).max() / orbit.largest_rate)
    if correction > _LONGEST_STEP:
        part = _LONGEST_STEP / correction
        found = replace(
            found,
            starts=orbit.starts + part * change,
            accelerations=orbit.accelerations + part * (found.accelerations - orbit.accelerations),
        )
    return found, correction
