"""Kinks: where a function of an expression jumps or bends, as sign changes."""

from __future__ import annotations

from itertools import combinations

import sympy
from sympy.core.relational import Relational

_OF_SIGN = (sympy.Abs, sympy.sign, sympy.Heaviside)
_OF_ORDER = (sympy.Max, sympy.Min)


def switches(expression: sympy.Expr) -> list[sympy.Expr]:
    """Expressions whose change of sign makes this one jump or bend.

    Examples
    --------
    >>> v, v1 = sympy.symbols("v v1", real=True)
    >>> switches(abs(v) + 3 * sympy.Max(v - v1, 0))
    [v, v - v1]
    """
    found = [each.args[0] for each in expression.atoms(*_OF_SIGN)]
    for each in expression.atoms(*_OF_ORDER):
        found += [
            a - b for a, b in combinations(sorted(each.args, key=sympy.default_sort_key, reverse=True), 2)
        ]
    for each in expression.atoms(sympy.Piecewise):
        found += [condition.lhs - condition.rhs for condition in each.atoms(Relational)]
    return sorted(set(found), key=sympy.default_sort_key)
