"""The instants at which a periodic motion passes knots of tables, where forces bend."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.polynomial import legendre

from chassym.nonlinear.dips import possible_dips
from chassym.nonlinear.orbits.gauss_points import equidistant_places, interpolation, lobatto_series
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

Array = np.ndarray

_SAMPLES = 512
"""Instants of a period of the excitation between which sides are compared."""

_LOOKED = 13
"""Places of a piece at which they are."""

_STEPS = 2
"""Steps of the rule of false position that place a passing in its interval of a piece."""

_ZOOM = 1 / 8
"""Part of the spacing of places at which an extreme is looked at that may lie beyond a knot."""

_ROUNDING = 1e-12
"""Distance from a knot (m or m/s) that rounding makes."""

_TOGETHER = 1e-7
"""Share of the orbit below which two passings are taken for one."""


@singledispatch
def knot_phases(orbit: PeriodicOrbit) -> Array:
    """Phases at which the motion passes a knot, ascending from 0 to 2 pi, by interpolation between samples.

    An error e of them changes forces by no more than e for no longer than e, so the orbit by e^2.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.nonlinear import Harmonic, steady_state
    >>> orbit = steady_state(load_model("quarter_car"), Harmonic(1.5, {"road": 0.001})).orbit
    >>> len(knot_phases(orbit))
    2
    """
    distance, count = orbit.model.knot_distances, _SAMPLES * orbit.subharmonic
    if not len(distance.rows):
        return np.empty(0)
    far = _moving(distance(orbit.sampled_motion(count)))
    after = np.roll(far, -1, axis=1)
    knot, sample = np.nonzero((far >= 0) != (after >= 0))
    before = far[knot, sample]
    return _apart(2 * np.pi / count * (sample + before / (before - after[knot, sample])))


@knot_phases.register
def _between_places(orbit: PiecewiseOrbit) -> Array:
    """The same by polynomials of the pieces: in them, where two meet, and passed and passed back at once."""
    distance = orbit.model.knot_distances
    if not len(distance.rows):
        return np.empty(0)
    values = _moving(orbit.values_in_pieces(distance))
    places = equidistant_places(_LOOKED)
    looked = values @ interpolation(values.shape[2], places).T
    is_beyond = looked >= 0
    _, meeting = np.nonzero(is_beyond[:, :, -1] != np.roll(is_beyond[:, :, 0], -1, axis=1))
    found = [orbit.boundaries[meeting + 1]]
    for piece, place in (_passed(values, looked), _touched(values, looked)):
        found.append(orbit.boundaries[piece] + place * np.diff(orbit.boundaries)[piece])
    return _apart(np.concatenate(found))


def _moving(distances: Array) -> Array:
    """Those of what does not rest at a knot: only rounding passes it there and back."""
    return distances[np.abs(distances).reshape(len(distances), -1).max(axis=1) > _ROUNDING]


def _passed(values: Array, looked: Array) -> tuple[Array, Array]:
    """Piece and place of the zeros between equidistant places of different sides, by false position.

    Parameters
    ----------
    values, looked
        Distances at Lobatto and at equidistant places of the pieces, shape (knots, pieces, places).
    """
    is_beyond, places = looked >= 0, equidistant_places(looked.shape[2]).values
    knot, piece, interval = np.nonzero(is_beyond[:, :, :-1] != is_beyond[:, :, 1:])
    series = lobatto_series(values.shape[2]) @ values[knot, piece].T
    start, end = places[interval], places[interval + 1]
    first, last = looked[knot, piece, interval], looked[knot, piece, interval + 1]
    for _ in range(_STEPS):
        place = _zero_of_line(start, end, first, last)
        left = legendre.legval(2 * place - 1, series, tensor=False)
        before_knot = left * first > 0
        start, first = np.where(before_knot, place, start), np.where(before_knot, left, first)
        end, last = np.where(before_knot, end, place), np.where(before_knot, last, left)
    return piece, _zero_of_line(start, end, first, last)


def _touched(values: Array, looked: Array) -> tuple[Array, Array]:
    """The same of zeros in pairs between equidistant places of the same side, by a narrow parabola."""
    count, rows = looked.shape[2], looked.reshape(-1, looked.shape[2])
    low, high = rows.min(axis=1), rows.max(axis=1)
    near = np.flatnonzero(np.minimum(np.abs(low), np.abs(high)) <= high - low)
    row, sample = possible_dips(rows[near])
    if not len(row):
        return np.empty(0, dtype=int), np.empty(0)
    row = near[row]
    series = lobatto_series(values.shape[2]) @ values.reshape(-1, values.shape[2])[row].T
    width = _ZOOM / (count - 1)
    centre = np.clip(sample / (count - 1), width, 1 - width)
    narrow = centre + width * np.array([[-1.0], [0.0], [1.0]])
    before, here, after = legendre.legval(2 * narrow - 1, series[:, None, :], tensor=False)
    half_slope, second = (after - before) / 2, before - 2 * here + after
    nearest = rows[row, np.rint(sample).astype(int)]
    second = np.where(second * nearest > 0, second, np.inf)  # bent the other way, it does not pass zero
    beyond = half_slope**2 / second**2 - 2 * here / second
    is_passed = (beyond > 0) & (np.abs(half_slope) < np.abs(second) / _ZOOM)
    shift = np.stack([-1.0, 1.0])[:, None] * np.sqrt(np.where(is_passed, beyond, 0.0)) - half_slope / second
    place = (centre + width * shift)[:, is_passed]
    piece = np.tile((row % looked.shape[1])[is_passed], (2, 1))
    is_inside = (place > 0) & (place < 1)
    return piece[is_inside], place[is_inside]


def _zero_of_line(start: Array, end: Array, first: Array, last: Array) -> Array:
    """Where a line is zero that has two values at two places; the first place if both are zero already."""
    return np.asarray(start - first * (end - start) / np.where(last == first, 1.0, last - first))


def _apart(phases: Array) -> Array:
    """Passings from 0 to 2 pi in order, those that are taken for one named once."""
    found = np.sort(np.mod(phases, 2 * np.pi))
    return found[np.diff(found, prepend=-1.0) > _TOGETHER * 2 * np.pi]
