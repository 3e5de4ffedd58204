"""Modes as pairs of eigenvalues, which stay together when an oscillation becomes two decays.

A mode of n coupled oscillators is a pair of eigenvalues of the first-order system, l_1 l_2 = w^2 and
l_1 + l_2 = -2 zeta w: two complex conjugates or, overdamped, two real ones. At the damping ratio 1 the two
eigenvectors become parallel and turn abruptly, but the plane that they span changes smoothly: an invariant
subspace of dimension two (Kato 1980, Perturbation Theory for Linear Operators, section II.1). A mode is
followed by its plane, therefore. Planes are compared by the spectral projectors P_i onto them along all
others: tr(P_i Q_j) / 2 is 1 for the same mode and 0 for another one, in any coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, eigh, inv, qr, svd
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components

from chassym.linear.linear_model import LinearModel
from chassym.linear.modal.free_motion import ZERO_TOLERANCE, free_motion
from chassym.linear.modal.spectrum import EQUAL, Eigenvalue, Spectrum

Array = np.ndarray

UNAMBIGUOUS = 0.25
"""Largest departure of the matched overlaps from 1, and of all others from 0."""


@dataclass(frozen=True, eq=False)
class ModePairs:
    """The n pairs of eigenvalues of a linear model.

    Attributes
    ----------
    planes
        Two real states (q, q') that span each pair's invariant subspace X_i, shape (n, 2 n, 2).
    actions
        The state matrix on them, A X_i = X_i B_i (1/s), shape (n, 2, 2).
    rate
        The size of eigenvalues beside which others are zero (1/s).
    """

    planes: Array
    actions: Array
    rate: float

    def taken(self, order: Array) -> ModePairs:
        """The same pairs in another order."""
        return replace(self, planes=self.planes[order], actions=self.actions[order])

    @property
    def products(self) -> Array:
        """l_1 l_2 = w^2 (1/s^2), length n; negative if one motion grows and one decays."""
        products = np.linalg.det(self.actions)
        return np.where(np.abs(products) <= ZERO_TOLERANCE * self.rate**2, 0.0, products)

    @property
    def sums(self) -> Array:
        """l_1 + l_2 = -2 zeta w (1/s), length n."""
        sums = np.trace(self.actions, axis1=1, axis2=2)
        return np.where((self.products == 0) & (np.abs(sums) <= ZERO_TOLERANCE * self.rate), 0.0, sums)

    @property
    def eigenvalues(self) -> Array:
        """Complex, shape (n, 2) (1/s); of conjugates the upper one comes first, of decays the slower one."""
        half = self.sums / 2
        root = np.sqrt(half**2 - self.products + 0j)
        far = np.where(half > 0, half + root, half - root)
        near = self.products / np.where(far == 0, 1, far)
        return np.where(root.imag > 0, [half + root, half - root], [near.real, far.real]).T

    @property
    def shapes(self) -> Array:
        """Amplitudes of the coordinates in the motion of the first eigenvalue, complex, shape (n, n)."""
        shifted = self.actions - self.eigenvalues[:, :1, None] * np.eye(2)
        weights = np.linalg.svd(shifted)[2][:, -1].conj()
        return np.einsum("ijk,ik->ij", self.planes[:, : len(self.planes)], weights)


def undamped_pairs(linear: LinearModel) -> ModePairs:
    """The pairs without damping, and with the symmetric part of K only, in ascending order of frequency.

    Where frequencies are equal, the shapes are those that a little of the damping would single out.

    Raises
    ------
    LinearisationError
        If M is singular.
    """
    rate = free_motion(linear).rate
    squares, shapes = eigh((linear.stiffness + linear.stiffness.T) / 2, linear.mass)
    squares = np.where(np.abs(squares) <= ZERO_TOLERANCE * np.abs(squares).max(), 0.0, squares)
    apart = np.flatnonzero(np.diff(squares) > EQUAL * np.abs(squares[1:])) + 1
    for group in np.split(np.arange(len(squares)), apart):
        resistance = shapes[:, group].T @ (linear.damping + linear.damping.T) @ shapes[:, group]
        shapes[:, group] = shapes[:, group] @ eigh(resistance)[1]
    planes = [block_diag(shape[:, None], rate * shape[:, None]) for shape in shapes.T]
    actions = [[[0, rate], [-square / rate, 0]] for square in squares]
    return ModePairs(np.array(planes), np.array(actions), rate)


def conjugate_pairs(found: Spectrum) -> ModePairs | None:
    """Every pair of conjugates and, if there are just two real eigenvalues, these; None if there are more."""
    decays = [e for e in found.eigenvalues if not e.value.imag]
    oscillations = [e for e in found.eigenvalues if e.value.imag]
    if sum(e.dimensions for e in decays) > 2 or any(e.dimensions > 2 for e in oscillations):
        return None
    planes = [qr(np.hstack([e.right.real, e.right.imag]), mode="economic")[0] for e in oscillations]
    if decays:
        # A real eigenvalue's states may carry a complex factor.
        states = [svd(np.hstack([e.right.real, e.right.imag]))[0][:, : e.dimensions] for e in decays]
        planes.append(qr(np.hstack(states), mode="economic")[0])
    pairs = _pairs(planes, found)
    return pairs.taken(np.argsort(np.abs(pairs.products), kind="stable"))


def continuation(pairs: ModePairs, found: Spectrum) -> ModePairs | tuple[int, ...]:
    """The given pairs among the eigenvalues of another model, or the indices of those that leave a doubt.

    Pairs with equal eigenvalues share their invariant subspace in the parts that are nearest to their planes.
    """
    motion, n = found.motion, len(pairs.planes)
    states = np.concatenate(list(pairs.planes / motion.scale[:, None]), axis=1)
    overlaps = _overlaps(states, found.eigenvalues)
    owned = _owned(overlaps, found.eigenvalues)
    complex_values = np.array([e.value.imag > 0 for e in found.eigenvalues])
    # Of two conjugates a pair has both or none.
    doubtful = _doubtful(overlaps, owned) | (owned[:, complex_values] % 2 == 1).any(axis=1)
    if doubtful.any():
        return tuple(np.flatnonzero(doubtful).tolist())
    planes = [_plane(states[:, 2 * i : 2 * i + 2], found.eigenvalues, owned[i]) for i in range(n)]
    reached = _pairs(planes, found)
    left = motion.matrix @ np.array(planes) - planes @ (reached.actions / motion.rate)
    sizes = np.linalg.norm(reached.actions, axis=(1, 2)) / motion.rate
    torn = np.linalg.norm(left, axis=(1, 2)) > 10 * EQUAL * sizes
    return tuple(np.flatnonzero(torn).tolist()) if torn.any() else reached


def _pairs(planes: list[Array], found: Spectrum) -> ModePairs:
    """The pairs of given planes in scaled states."""
    motion, n = found.motion, len(planes)
    basis = np.concatenate(planes, axis=1)
    actions = np.linalg.solve(basis, motion.matrix @ basis).reshape(n, 2, n, 2)[range(n), :, range(n)]
    return ModePairs(np.array(planes) * motion.scale[:, None], motion.rate * actions, motion.rate)


def _overlaps(states: Array, eigenvalues: tuple[Eigenvalue, ...]) -> Array:
    """tr(P_i R_u) of pair i and eigenvalue u, shape (n, eigenvalues); of the latter the real subspace.

    With P_i = X_i Y_i and R_u = V_u W_u it is tr(Y_i V_u W_u X_i).
    """
    dual = inv(states)
    by_state = [
        ((dual @ found.right) * (found.left @ states).T).real.sum(axis=1) * (2 if found.value.imag else 1)
        for found in eigenvalues
    ]
    return np.array(by_state).reshape(len(eigenvalues), -1, 2).sum(axis=2).T


def _owned(overlaps: Array, eigenvalues: tuple[Eigenvalue, ...]) -> Array:
    """How many of an eigenvalue's dimensions a pair has: two in all, so that the overlaps are largest."""
    dimensions = [found.dimensions for found in eigenvalues]
    seats = np.repeat(np.arange(len(eigenvalues)), dimensions)
    per_dimension = np.repeat(overlaps / dimensions, 2, axis=0)[:, seats]
    taken = seats[linear_sum_assignment(per_dimension, maximize=True)[1]].reshape(-1, 2)
    return (taken[:, :, None] == np.arange(len(eigenvalues))).sum(axis=1)


def _doubtful(overlaps: Array, owned: Array) -> Array:
    """Whether a pair, or those with which it shares an eigenvalue, are not clearly what they were."""
    count, labels = connected_components(owned @ owned.T)
    members = labels == np.arange(count)[:, None]
    # Of pairs that share eigenvalues only the sum of the overlaps with all of them means something.
    together = members @ overlaps @ (members @ owned > 0).T / (2 * members.sum(axis=1)[:, None])
    unclear = (np.abs(together - np.eye(count)) > UNAMBIGUOUS).any(axis=1)
    return unclear[labels]


def _plane(states: Array, eigenvalues: tuple[Eigenvalue, ...], owned: Array) -> Array:
    """Orthonormal real basis of a pair's part of the invariant subspaces that it owns, shape (2 n, 2)."""
    columns = []
    for found, dimensions in zip(eigenvalues, owned, strict=True):
        if dimensions:
            projected = found.right @ (found.left @ states)
            if found.value.imag:
                nearest = svd(projected, full_matrices=False)[0][:, 0]
                columns += [nearest.real, nearest.imag]
            else:
                columns += list(svd(projected.real, full_matrices=False)[0][:, :dimensions].T)
    return qr(np.array(columns).T, mode="economic")[0]
