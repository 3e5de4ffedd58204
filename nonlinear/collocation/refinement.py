"""From a first guess of a periodic orbit to one that is accurate enough: more points, more pieces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from chassym.nonlinear.collocation.collocation import Linearisation, in_pieces
from chassym.nonlinear.collocation.mesh import cut, first_boundaries, knot_phases
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

Array = np.ndarray

FEWEST_POINTS, MOST_POINTS = 3, 24
"""Gauss points of a piece at first, and where the refinement gives up."""

_MOST_STEPS = 40
"""Newton steps to come near the orbit."""

_LONGEST_STEP = 0.5
"""Relative correction beyond which a step is shortened."""

_NEAR = 0.1
"""Relative correction from which every further step is made with one point more."""

_MOST_PIECES = 4000
"""Pieces beyond which a motion is too rough to be followed."""

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
    """

    orbit: PiecewiseOrbit
    correction: float
    iterations: int


def refinements(guess: PeriodicOrbit, rough: float) -> Iterator[Refined]:
    """Ever more accurate orbits, the first one near enough for Newton's method to converge at once.

    Each is one step from the last, with one Gauss point more; pieces that are not resolved are halved.

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
    """
    orbit = in_pieces(guess, first_boundaries(guess), FEWEST_POINTS)
    iterations, points, halved = 0, FEWEST_POINTS, np.inf
    while points <= MOST_POINTS:
        found = _stepped(_cut_again(orbit, points, halved), iterations)
        orbit, iterations = found.orbit, found.iterations
        if points > FEWEST_POINTS or found.correction < _NEAR:
            yield found
            points, halved = points + 1, rough
        elif iterations == _MOST_STEPS or not np.isfinite(found.correction):
            raise NoPeriodicOrbitError(
                f"collocation at {orbit.excitation.frequency_hz:g} Hz: correction {iterations} is still "
                f"{found.correction:.2g} of the motion; start from a smaller amplitude"
            )


def _cut_again(orbit: PiecewiseOrbit, points: int, rough: float) -> PiecewiseOrbit:
    """The orbit cut where it passes knots now, rough pieces halved."""
    wanted = np.where(_roughness(orbit) > rough, 2.0, 1.0)
    if wanted.sum() > _MOST_PIECES:
        raise NoPeriodicOrbitError(
            f"collocation at {orbit.excitation.frequency_hz:g} Hz: more than {_MOST_PIECES} pieces do not "
            "resolve the motion; ask for less accuracy or a smaller amplitude"
        )
    return in_pieces(orbit, cut(knot_phases(orbit), orbit.boundaries, wanted), points)


def _roughness(orbit: PiecewiseOrbit) -> Array:
    """Part of the highest polynomial in the accelerations of every piece, of the worst coordinate."""
    highest = np.abs(orbit.highest_coefficient @ orbit.accelerations)
    largest = np.abs(orbit.accelerations).max(axis=(0, 1))
    return np.asarray((highest / np.maximum(largest, _SMALL * largest.max() + 1e-12)).max(axis=1))


def _stepped(orbit: PiecewiseOrbit, iterations: int) -> Refined:
    """One step of Newton's method, shortened if it is long."""
    n = orbit.model.size
    found = Linearisation(orbit).corrected()
    change = found.starts - orbit.starts
    size = max(np.abs(orbit.starts[:, n:]).max(), 1e-9)
    correction = float(np.abs(change[:, n:]).max() / size)
    if correction > _LONGEST_STEP:
        part = _LONGEST_STEP / correction
        found = replace(
            found,
            starts=orbit.starts + part * change,
            accelerations=orbit.accelerations + part * (found.accelerations - orbit.accelerations),
        )
    return Refined(found, correction, iterations + 1)
