"""Inertia tensors as users give them, and as a rigid body can have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import sympy

from chassym.derivation.errors import MechanismError
from chassym.derivation.vector import SymmetricTensor, Vector, diagonal, dot, vector

Inertia: TypeAlias = Sequence[sympy.Expr | float] | Sequence[Sequence[sympy.Expr | float]] | sympy.MatrixBase
"""Principal moments about axes parallel to x, y and z, or the tensor by rows (kg m^2)."""

_TOLERANCE = 1e-9


def inertia_tensor(name: str, inertia: Inertia) -> SymmetricTensor:
    """The tensor of a body from its three principal moments or its three rows.

    The elements of the tensor off the diagonal are minus the products of inertia: xy is minus the integral
    of x y dm.

    Raises
    ------
    MechanismError
        If it is neither, or not symmetric.
    """
    if not isinstance(inertia, Sequence | np.ndarray | sympy.MatrixBase):
        raise MechanismError(
            f"body {name!r}: inertia {inertia}; expected three principal moments or three rows"
        )
    rows = inertia.tolist() if isinstance(inertia, sympy.MatrixBase) else list(inertia)
    if len(rows) == 3 and not any(isinstance(row, Sequence | np.ndarray) for row in rows):
        return diagonal(*vector(rows))
    if len(rows) != 3 or any(not isinstance(row, Sequence | np.ndarray) or len(row) != 3 for row in rows):
        raise MechanismError(
            f"body {name!r}: inertia of another shape; expected three principal moments or three rows of "
            "three"
        )
    t = [vector(row) for row in rows]
    off = [_facing(name, t[i][j], t[j][i], t[i][i] + t[j][j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    return SymmetricTensor(t[0][0], t[1][1], t[2][2], *off)


def _facing(name: str, above: sympy.Expr, below: sympy.Expr, scale: sympy.Expr) -> sympy.Expr:
    """The value of two elements that face each other; numbers may differ by the rounding of a rotation."""
    if above == below:
        return above
    if (above - below).is_number and abs(above - below) <= _TOLERANCE * abs(scale):
        return (above + below) / 2
    raise MechanismError(
        f"body {name!r}: inertia {above} and {below} face each other; expected a symmetric tensor"
    )


def about_mass_centre(tensor: SymmetricTensor, mass: sympy.Expr, offset: Vector) -> SymmetricTensor:
    """A tensor about the mass centre from that about a point at an offset from it: I - m (r.r E - r r^T)."""
    square, rows = dot(offset, offset), tensor.rows()

    def entry(i: int, j: int) -> sympy.Expr:
        return rows[i][j] - mass * ((square if i == j else 0) - offset[i] * offset[j])

    return SymmetricTensor(*(entry(i, j) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))))


def check_inertia(name: str, tensor: SymmetricTensor) -> None:
    """Refuse numbers that no body can have; symbols are left to whoever gives them values.

    That no moment exceeds the sum of the other two is not asked for: a planar model states one of them only.

    Raises
    ------
    MechanismError
        If one is not finite, or a principal moment is negative.
    """
    if not all(component.is_number for component in tensor.components()):
        return
    numbers = np.array(tensor.rows(), dtype=float)
    if not np.isfinite(numbers).all():
        raise MechanismError(f"body {name!r}: inertia {numbers.tolist()}; expected finite numbers")
    moments = np.linalg.eigvalsh(numbers)
    if moments[0] < -_TOLERANCE * np.abs(moments).max():
        listed = ", ".join(f"{moment:.6g}" for moment in moments)
        raise MechanismError(
            f"body {name!r}: principal moments of inertia {listed} about the mass centre; expected none "
            "negative"
        )
