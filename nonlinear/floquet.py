"""Floquet multipliers: whether small deviations from a periodic orbit die out."""

from __future__ import annotations

import numpy as np

from chassym.nonlinear.orbit import Orbit

FEWEST_STEPS, MOST_STEPS = 256, 8192
"""Steps of one period; between them there are as many as radians that the fastest mode goes through."""


def monodromy(orbit: Orbit) -> np.ndarray:
    """The map of small deviations from phase zero over one period, shape (2 n, 2 n).

    The variational equation x' = A(t) x is integrated by the implicit midpoint rule, x+ = (1 - hA/2)^-1 (1 +
    hA/2) x, which keeps undamped deviations undamped: their multipliers stay on the unit circle at any step
    (Hairer, Lubich and Wanner, Geometric Numerical Integration, 2nd ed., section VI.4).
    """
    fastest = np.abs(np.linalg.eigvals(_variational(orbit, FEWEST_STEPS).mean(axis=0))).max()
    steps = int(np.clip(fastest * orbit.excitation.period_s, FEWEST_STEPS, MOST_STEPS))
    system = _variational(orbit, steps)
    half = 0.5 * orbit.excitation.period_s / steps
    identity = np.eye(2 * orbit.model.size)
    maps = np.linalg.solve(identity - half * system, identity + half * system)
    while len(maps) > 1:
        maps = np.concatenate([maps[1::2] @ maps[: len(maps) // 2 * 2 : 2], maps[len(maps) // 2 * 2 :]])
    return np.asarray(maps[0])


def _variational(orbit: Orbit, steps: int) -> np.ndarray:
    """A(t) in the middle of every step, shape (steps, 2 n, 2 n)."""
    n, function = orbit.model.size, orbit.model.residual_jacobian
    midpoints = 2 * np.pi * (np.arange(steps) + 0.5) / steps
    full = np.zeros((steps, n, 3 * n))
    full[:, function.rows, function.columns] = function(orbit.arguments_at(midpoints)).T
    stiffness, damping, mass = np.split(full, 3, axis=2)
    system = np.zeros((steps, 2 * n, 2 * n))
    system[:, :n, n:] = np.eye(n)
    system[:, n:] = -np.linalg.solve(mass, np.concatenate([stiffness, damping], axis=2))
    return system


def multipliers(orbit: Orbit) -> np.ndarray:
    """Eigenvalues of the monodromy matrix, largest magnitude first, shape (2 n,).

    An orbit is stable if all magnitudes are below one.
    """
    found = np.linalg.eigvals(monodromy(orbit))
    return np.asarray(found[np.argsort(-np.abs(found))])
