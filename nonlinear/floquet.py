"""Floquet multipliers: whether small deviations from a periodic orbit die out."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from chassym.nonlinear.collocation import Linearisation, in_pieces
from chassym.nonlinear.mesh import cut, first_boundaries, knot_phases
from chassym.nonlinear.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.piecewise_orbit import PiecewiseOrbit

POINTS = 8
"""Gauss points of a piece at least: the maps of pieces then have fifteen orders."""


@singledispatch
def monodromy(orbit: PeriodicOrbit) -> np.ndarray:
    """The map of small deviations over one orbit, shape (2 n, 2 n).

    The orbit is cut where it passes knots; the map is the product of those that collocation makes of the
    pieces (see `chassym.nonlinear.collocation`). It keeps undamped deviations undamped, as all Gauss methods
    do: their multipliers stay on the unit circle (Hairer, Lubich and Wanner, Geometric Numerical Integration,
    2nd ed., section IV.2).
    """
    pieces = orbit if isinstance(orbit, PiecewiseOrbit) else in_pieces(orbit, first_boundaries(orbit), POINTS)
    boundaries = cut(knot_phases(pieces), pieces.boundaries, np.ones(len(pieces.starts)))
    return Linearisation(in_pieces(orbit, boundaries, max(pieces.points, POINTS))).monodromy


def multipliers(orbit: PeriodicOrbit) -> np.ndarray:
    """Eigenvalues of the monodromy matrix, largest magnitude first, shape (2 n,).

    An orbit is stable if all magnitudes are below one.
    """
    found = np.linalg.eigvals(monodromy(orbit))
    return np.asarray(found[np.argsort(-np.abs(found))])
