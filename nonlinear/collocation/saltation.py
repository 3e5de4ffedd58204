"""What a force that jumps at a knot does to small deviations: they pass it earlier or later."""

from __future__ import annotations

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

Array = np.ndarray

_BESIDE = 1e-4
"""Part of a piece before and behind a boundary at which accelerations are compared."""

_JUMP = 1e-2
"""Change of an acceleration there, relative to the largest, that is taken for a jump."""

_SMALL = 1e-3
"""Part of the largest acceleration below which that of a coordinate does not count by itself."""

_STEP = 1e-6
"""Change of a coordinate (m or rad) or rate that the gradient of a distance from a knot is taken over."""


def saltations(orbit: PiecewiseOrbit) -> Array | None:
    """Maps of deviations from before the start of every piece to behind it, shape (pieces, 2 n, 2 n).

    A deviation d passes the knot h = 0 earlier by grad h . d / h', h' the rate before, and is accelerated by
    the jump da for so much longer: d + (0, da) grad h . d / h' (Leine and Nijmeijer, Dynamics and
    Bifurcations of Non-Smooth Mechanical Systems, 2004).

    Returns
    -------
    numpy.ndarray or None
        None if no acceleration jumps.
    """
    n, pieces = orbit.model.size, len(orbit.starts)
    if not len(orbit.model.knot_distances.rows):
        return None
    behind = np.arange(pieces)
    ahead, elapsed = np.roll(behind, 1), _BESIDE * np.roll(orbit.durations_s, 1)
    missed = np.roll(orbit.jumps, 1, axis=0).T  # an orbit that is not quite one does not jump by that
    earlier, before = (_arguments(orbit, ahead, 1 - part * _BESIDE, missed) for part in (2, 1))
    after = _arguments(orbit, behind, _BESIDE, 0.0)
    change = np.abs(after - before)[2 * n : 3 * n]
    largest = np.abs(before[2 * n : 3 * n]).max(axis=1, keepdims=True)
    jumps = change > _JUMP * np.maximum(largest, _SMALL * largest.max())
    if not jumps.any():
        return None
    maps = np.tile(np.eye(2 * n), (pieces, 1, 1))
    for piece in np.flatnonzero(jumps.any(axis=0)):
        sides = earlier[:, piece], before[:, piece], after[:, piece]
        maps[piece, n:] += _by_jumps(orbit.model, *sides, elapsed[piece])
    return maps


def _arguments(orbit: PiecewiseOrbit, pieces: Array, place: float, missed: Array | float) -> Array:
    """The equations' arguments at one place of some pieces, accelerations those that the motion asks for."""
    moved = orbit.motion_in(pieces, np.full(len(pieces), place))[: 2 * orbit.model.size] - missed
    phases = orbit.boundaries[pieces] + place * np.diff(orbit.boundaries)[pieces]
    return orbit.with_accelerations(moved, orbit.inputs_at(phases))


def _by_jumps(model: Model, earlier: Array, before: Array, after: Array, elapsed_s: float) -> Array:
    """What jumps add to the rates of a deviation, by coordinates and rates, shape (n, 2 n)."""
    n, distances = model.size, model.knot_distances
    sides = distances(np.stack([earlier, before, after], axis=1))
    added = np.zeros((n, 2 * n))
    for knot in np.flatnonzero(sides[:, 1] * sides[:, 2] < 0):
        moves = np.zeros((len(before), 2 * n))
        moves[: 2 * n] = _STEP * np.eye(2 * n)
        there, back = (distances(before[:, None] + sign * moves)[knot] for sign in (1, -1))
        gradient = (there - back) / (2 * _STEP)
        if not gradient.any():  # inputs alone pass it, and deviations with them
            continue
        beyond = before.copy()
        beyond[: 2 * n] -= 2 * sides[knot, 1] * gradient / (gradient @ gradient)
        jump = model.accelerations(beyond[:, None])[:, 0] - before[2 * n : 3 * n]
        added += np.outer(jump, gradient) * elapsed_s / (sides[knot, 1] - sides[knot, 0])
    return added
