"""Directions: a coordinate axis by its name, or any three components, as a unit vector."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy

from chassym.derivation.errors import MechanismError
from chassym.derivation.vector import Vector, dot, vector

Direction = str | Sequence[sympy.Expr | float]
"""An axis "x", "y" or "z", or three components of any length but zero."""

AXES = {"x": 0, "y": 1, "z": 2}


def unit_vector(direction: Direction, what: str = "axis") -> Vector:
    """The unit vector of a direction; `what` begins an error's message.

    Raises
    ------
    MechanismError
        If it is no axis and no three finite components, or of zero length.

    Examples
    --------
    >>> unit_vector("y"), unit_vector((0, 3, 4))
    ((0, 1, 0), (0, 3/5, 4/5))
    """
    if isinstance(direction, str):
        if direction not in AXES:
            raise MechanismError(f"{what} {direction!r}: expected 'x', 'y', 'z' or three components")
        return vector([int(i == AXES[direction]) for i in range(3)])
    if not isinstance(direction, Sequence | np.ndarray | sympy.MatrixBase):
        raise MechanismError(f"{what} {direction!r}: expected 'x', 'y', 'z' or three components")
    components = [sympy.sympify(c) for c in direction]
    if len(components) != 3 or any(c.is_number and not c.is_finite for c in components):
        raise MechanismError(f"{what} {tuple(direction)}: expected 'x', 'y', 'z' or three finite components")
    exact = vector([sympy.S.Zero if c.is_zero else c for c in components])
    length = sympy.sqrt(dot(exact, exact))
    if length.is_zero:
        raise MechanismError(f"{what} {tuple(direction)} has zero length; expected components not all zero")
    if sum(c != 0 for c in exact) == 1 and length.is_number:
        return vector([sympy.sign(c) for c in exact])
    return vector([c / length for c in exact])


def named(axis: Vector) -> str:
    """A unit vector for reading: the name of a coordinate axis, or components."""
    names = {unit_vector(name): name for name in AXES}
    return names.get(axis, f"({', '.join(str(sympy.N(c, 4)) for c in axis)})")
