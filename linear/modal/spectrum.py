"""The distinct eigenvalues of a linear model with their spectral projectors, also where they are multiple."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, inv, schur
from scipy.sparse.csgraph import connected_components

from chassym.linear.linear_model import LinearModel
from chassym.linear.modal.free_motion import FreeMotion, free_motion

Array = np.ndarray

EQUAL = 1e-6
"""Eigenvalues nearer to each other than this part of their size count as equal.

Rounding moves a double eigenvalue with a single eigenvector by some 1e-8.
"""


@dataclass(frozen=True, eq=False)
class Eigenvalue:
    """A distinct eigenvalue, of two complex conjugates the upper one, with its projector V W.

    Attributes
    ----------
    value
        In units of the motion's rate.
    right, left
        V, which spans the invariant subspace, and W, with W V = 1: shapes (2 n, multiplicity) and
        (multiplicity, 2 n).
    """

    value: complex
    right: Array
    left: Array

    @property
    def dimensions(self) -> int:
        """Of the real invariant subspace: that of a complex eigenvalue contains its conjugate's, too."""
        return self.right.shape[1] * (2 if self.value.imag else 1)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The distinct eigenvalues of a free motion."""

    motion: FreeMotion
    eigenvalues: tuple[Eigenvalue, ...]


def spectrum(linear: LinearModel) -> Spectrum:
    """The distinct eigenvalues of a linear model.

    Raises
    ------
    LinearisationError
        If M is singular.
    """
    motion = free_motion(linear)
    values, vectors = eig(motion.matrix)
    values[np.abs(values).argsort()[: motion.zero_eigenvalues]] = 0
    vectors = vectors.astype(complex)
    groups = equal_groups(values)
    means = [_mean(values[group]) for group in groups]
    for group, mean in zip(groups, means, strict=True):
        if len(group) > 1:
            vectors[:, group] = _invariant_subspace(motion.matrix, mean, len(group))
    left = inv(vectors)
    found = zip(groups, means, strict=True)
    upper = (Eigenvalue(mean, vectors[:, group], left[group]) for group, mean in found if mean.imag >= 0)
    return Spectrum(motion, tuple(upper))


def equal_groups(values: Array) -> list[Array]:
    """Indices of the eigenvalues in groups of equal ones."""
    sizes = np.abs(values)
    near = np.abs(values[:, None] - values) <= EQUAL * np.maximum.outer(sizes, sizes)
    count, labels = connected_components(near)
    return [np.flatnonzero(labels == label) for label in range(count)]


def _mean(values: Array) -> complex:
    """Mean of equal eigenvalues; conjugates that are equal are real."""
    mean = complex(values.mean())
    conjugates = len(values) > 1 and abs(mean.imag) <= EQUAL * abs(mean)
    return complex(mean.real) if conjugates else mean


def _invariant_subspace(matrix: Array, value: complex, size: int) -> Array:
    """Orthonormal basis of the subspace of the eigenvalues nearest to a value, shape (2 n, size).

    Eigenvectors would not do: those of a multiple eigenvalue may be parallel.
    """
    distances = np.sort(np.abs(np.diag(schur(matrix, output="complex")[0]) - value))
    reach = distances[size - 1 : size + 1].mean()
    return schur(matrix, output="complex", sort=lambda found: abs(found - value) <= reach)[1][:, :size]
