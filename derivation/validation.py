"""What is handed to a mechanism's parts: of the right kind, or refused by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy

from chassym.derivation.errors import MechanismError
from chassym.derivation.vector import Vector, vector


def expect(what: str, value: object, *kinds: type, hint: str = "") -> None:
    """Refuse what is of none of the kinds.

    Raises
    ------
    MechanismError
        Naming what it is for, what was received, and the first kind.
    """
    if not isinstance(value, kinds):
        remedy = f"; {hint}" if hint else ""
        raise MechanismError(f"{what}: received {_shown(value)}, expected a {kinds[0].__name__}{remedy}")


def scalar(what: str, value: Any) -> sympy.Expr:
    """A number or expression as sympy has it.

    Raises
    ------
    MechanismError
        If it is neither, or a number that is not real and finite.
    """
    if isinstance(value, bool | str) or value is None:
        raise MechanismError(f"{what}: received {_shown(value)}, expected a number or a sympy expression")
    try:
        found = sympy.sympify(value)
    except (sympy.SympifyError, TypeError) as error:
        received = _shown(value)
        raise MechanismError(
            f"{what}: received {received}, expected a number or a sympy expression"
        ) from error
    if not isinstance(found, sympy.Expr) or found.is_number and not (found.is_real and found.is_finite):
        raise MechanismError(
            f"{what}: received {_shown(value)}, expected a finite real number or an expression"
        )
    return found


def place(what: str, components: Any) -> Vector:
    """A design position, or another vector, from three numbers or expressions.

    Raises
    ------
    MechanismError
        If they are not three.
    """
    if not isinstance(components, Sequence | np.ndarray | sympy.MatrixBase) or isinstance(components, str):
        raise MechanismError(f"{what}: received {_shown(components)}, expected three numbers or expressions")
    if len(components) != 3:
        raise MechanismError(f"{what}: {len(components)} components received, expected three")
    return vector([scalar(what, component) for component in components])


def _shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
