"""Free motion M q'' + C q' + K q = 0 as a scaled first-order system, with its zero eigenvalues counted."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky, svd

from chassym.linear.linear_model import LinearModel

Array = np.ndarray

ZERO_TOLERANCE = 1e-11
"""Squared natural frequencies below this part of the largest one are those of a rigid-body mode."""


@dataclass(frozen=True, eq=False)
class FreeMotion:
    """The state (q, q') in units that give every coordinate unit inertia and the stiffest one unit stiffness.

    Attributes
    ----------
    matrix
        A in z' = rate A z, shape (2 n, 2 n).
    scale
        Physical states are this times z, length 2 n.
    rate
        Unit of the eigenvalues of A (1/s).
    """

    matrix: Array
    scale: Array
    rate: float

    @cached_property
    def zero_eigenvalues(self) -> int:
        """How often A has the eigenvalue zero: its null space is split off until none is left.

        A body in free flight has it twice for every direction, since it may also move at a constant speed;
        one with a dashpot to the ground has it once; follower forces, which have no potential, make longer
        chains. The computed eigenvalues do not tell: rounding moves a double zero by 1e-8.
        """
        left, count = self.matrix, 0
        while len(left):
            _, sizes, directions = svd(left)
            zeros = int((sizes <= ZERO_TOLERANCE).sum())
            if not zeros:
                break
            count += zeros
            others = directions[:-zeros]
            left = others @ left @ others.T
        return count


def free_motion(linear: LinearModel) -> FreeMotion:
    """The first-order system of a linear model.

    Raises
    ------
    LinearisationError
        If M is singular.
    """
    factor = linear.mass_factor
    size = 1 / np.sqrt(np.diag(linear.mass))
    stiffness = cho_solve(factor, linear.stiffness * size) / size[:, None]
    damping = cho_solve(factor, linear.damping * size) / size[:, None]
    rate = float(np.sqrt(np.abs(stiffness).max()) or np.abs(damping).max() or 1.0)
    n = len(size)
    forces = -np.hstack([stiffness / rate**2, damping / rate])
    return FreeMotion(np.vstack([np.eye(n, 2 * n, k=n), forces]), np.concatenate([size, rate * size]), rate)


def rigid_body_shapes(linear: LinearModel) -> Array:
    """Directions without stiffness, in columns with shapes^T M shapes = 1, shape (n, any number)."""
    size = 1 / np.sqrt(np.diag(linear.mass))
    _, sizes, directions = svd(size[:, None] * linear.stiffness * size)
    shapes = size[:, None] * directions[sizes <= ZERO_TOLERANCE * sizes[0]].T
    if not shapes.shape[1]:
        return shapes
    return np.linalg.solve(cholesky(shapes.T @ linear.mass @ shapes, lower=True), shapes.T).T
