"""Floquet multipliers: whether small deviations from a periodic orbit die out."""

from __future__ import annotations

from contextlib import suppress
from functools import singledispatch

import numpy as np

from chassym.nonlinear.collocation.collocation import Linearisation, in_pieces
from chassym.nonlinear.collocation.mesh import FULL_TURN, cut, first_boundaries
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.orbits.knots import knot_phases
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

POINTS = 8
"""Gauss points of a piece at least: the maps of pieces then have fifteen orders."""

_NEAR = 0.1
"""Largest correction of the states of a series, relative to each."""


@singledispatch
def monodromy(orbit: PeriodicOrbit) -> np.ndarray:
    """The map of small deviations over one orbit, shape (2 n, 2 n).

    The orbit is cut where it passes knots; the map is the product of those that collocation makes of the
    pieces (see `chassym.nonlinear.collocation.collocation`), from the first boundary on. It keeps undamped
    deviations undamped, as all Gauss methods do: their multipliers stay on the unit circle (Hairer, Lubich
    and Wanner, Geometric Numerical Integration, 2nd ed., section IV.2).
    """
    return Linearisation(_cut(orbit)).monodromy


@monodromy.register
def _of_series(orbit: FourierOrbit) -> np.ndarray:
    """The same, of what collocation makes of a series that passes knots.

    The errors of multipliers are of first order in the instants of passing, and a series does not know these
    well. A large correction is none: the orbit is about to cease at a fold, or has too few harmonics.
    """
    pieces = _cut(orbit)
    linear = Linearisation(pieces)
    if len(knot_phases(pieces)):
        with suppress(NoPeriodicOrbitError):
            corrected = linear.corrected()
            if _distance(corrected, pieces) < _NEAR:
                return Linearisation(_cut(corrected)).monodromy
    return linear.monodromy


def _cut(orbit: PeriodicOrbit) -> PiecewiseOrbit:
    """An orbit in pieces that end where it passes knots."""
    boundaries, points = _pieces_of(orbit)
    return in_pieces(orbit, cut(knot_phases(orbit), boundaries, np.ones(len(boundaries) - 1)), points)


@singledispatch
def _pieces_of(orbit: PeriodicOrbit) -> tuple[np.ndarray, int]:
    """Boundaries and points of pieces in which a motion is as accurate as it is known."""
    return first_boundaries(orbit), POINTS


@_pieces_of.register
def _as_many_as_harmonics(orbit: FourierOrbit) -> tuple[np.ndarray, int]:
    equal = first_boundaries(orbit)
    return np.linspace(0, FULL_TURN, max(len(equal), orbit.harmonics + 1)), POINTS


@_pieces_of.register
def _its_own(orbit: PiecewiseOrbit) -> tuple[np.ndarray, int]:
    return orbit.boundaries, max(orbit.points, POINTS)


def _distance(one: PiecewiseOrbit, other: PiecewiseOrbit) -> float:
    """Largest distance of states at the same boundaries, relative to the largest state of its kind."""
    size = np.abs(other.starts).max(axis=0)
    return float((np.abs(one.starts - other.starts).max(axis=0) / np.maximum(size, size.max() * 1e-6)).max())


def multipliers(orbit: PeriodicOrbit) -> np.ndarray:
    """Eigenvalues of the monodromy matrix, largest magnitude first, shape (2 n,).

    An orbit is stable if all magnitudes are below one. They are infinite if deviations grow beyond all
    numbers in one orbit. Where forces jump, deviations that pass a knot earlier or later are accounted for.

    Raises
    ------
    ExcitationError
        If the orbit is too slow for the model's fastest motion to be followed.
    """
    around = monodromy(orbit)
    if not np.isfinite(around).all():
        return np.full(len(around), np.inf)
    found = np.linalg.eigvals(around)
    return np.asarray(found[np.argsort(-np.abs(found))])


def die_out(multipliers: np.ndarray) -> np.ndarray:
    """Whether deviations with some Floquet multipliers die out: all magnitudes are below one.

    Parameters
    ----------
    multipliers
        Complex, shape (2 n,) or (orbits, 2 n).

    Returns
    -------
    numpy.ndarray
        Of bool, shape () or (orbits,).

    Examples
    --------
    >>> die_out(np.array([[0.5 + 0.5j, 0.5 - 0.5j], [1.2, 0.1]]))
    array([ True, False])
    """
    return np.asarray(np.abs(multipliers).max(axis=-1) < 1.0)


def is_stable(orbit: PeriodicOrbit) -> bool:
    """Whether small deviations from an orbit die out."""
    return bool(die_out(multipliers(orbit)))
