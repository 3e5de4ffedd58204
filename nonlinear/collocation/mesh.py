"""Where a periodic orbit is cut in pieces: where it passes knots, and as often between as it needs."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import ExcitationError
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit

Array = np.ndarray

FULL_TURN = 2 * np.pi

MOST_PIECES = 4000
"""Pieces beyond which a motion is too rough, or too slow, to be followed."""

_FEWEST = 12
"""Pieces of a turn that knows no faster motion than its own."""

_PER_PIECE = 6.0
"""Radians that the fastest natural motion goes through in a piece at most. The collocation of an undamped
motion by four points grows from 6.15 on, and in a long test every piece multiplies that.
"""

_SPARE = 0.15
"""Part of a piece by which the others between two knots grow rather than that one more is made."""


def first_boundaries(orbit: PeriodicOrbit) -> Array:
    """Equal pieces, short enough for the fastest natural motion at the design position, (pieces + 1,).

    Raises
    ------
    ExcitationError
        If the test is so slow that there would be more than `MOST_PIECES`.
    """
    rate = fastest_rate(orbit.model)
    pieces = rate * orbit.period_s / _PER_PIECE
    if pieces > MOST_PIECES:
        slowest_hz = orbit.subharmonic * rate / (_PER_PIECE * MOST_PIECES)
        raise ExcitationError(
            f"frequency: {orbit.excitation.frequency_hz:g} Hz received; {slowest_hz:.2g} Hz or more needed "
            f"to follow the model's fastest motion ({rate:.3g} rad/s) all the way"
        )
    return np.linspace(0, FULL_TURN, max(_FEWEST, int(np.ceil(pieces))) + 1)


@lru_cache(maxsize=16)
def fastest_rate(model: Model) -> float:
    """Bound of the natural motions' rates (rad/s): undamped frequencies, and decays by dampers alone."""
    n, function = model.size, model.residual_jacobian
    at_rest = function.matrix(np.zeros(model.argument_count), (n, 3 * n))
    stiffness, damping, mass = np.split(at_rest, 3, axis=1)
    by_springs, by_dampers = np.linalg.eigvals(np.linalg.solve(mass, np.stack([stiffness, damping])))
    return float(max(np.sqrt(np.abs(by_springs).max()), np.abs(by_dampers).max()))


def cut(knots: Array, boundaries: Array, wanted: Array) -> Array:
    """Boundaries at knots, and between them as close as wanted.

    Parameters
    ----------
    knots
        Phases from 0 to 2 pi, ascending.
    boundaries
        Those of the last mesh, shape (pieces + 1,).
    wanted
        Into how many pieces each of its pieces is to be cut, shape (pieces,).

    Returns
    -------
    numpy.ndarray
        Ascending over 2 pi, shape (pieces + 1,).
    """
    grown = np.concatenate([[0.0], np.cumsum(wanted)])
    start = boundaries[0]

    def pieces_until(phases: Array) -> Array:
        turns = np.floor((phases - start) / FULL_TURN)
        return turns * grown[-1] + np.interp(phases - turns * FULL_TURN, boundaries, grown)

    def phase_of(pieces: Array) -> Array:
        turns = np.floor(pieces / grown[-1])
        return turns * FULL_TURN + np.interp(pieces - turns * grown[-1], grown, boundaries)

    fixed = knots if len(knots) else np.mod(boundaries[:1], FULL_TURN)
    around = np.append(fixed, fixed[0] + FULL_TURN)
    until = pieces_until(around)
    counts = np.maximum(1, np.ceil(np.diff(until) - _SPARE)).astype(int)
    interval = np.repeat(np.arange(len(fixed)), counts)
    number = np.arange(len(interval)) - np.repeat(np.cumsum(counts) - counts, counts)
    phases = phase_of(until[interval] + number * (np.diff(until) / counts)[interval])
    phases[number == 0] = fixed
    return np.append(phases, around[-1])
