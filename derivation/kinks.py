"""Kinks: where a function of an expression jumps or bends, as sign changes."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from itertools import combinations

import sympy
from sympy.core.relational import Relational

_OF_SIGN = (sympy.Abs, sympy.sign, sympy.Heaviside)
_OF_ORDER = (sympy.Max, sympy.Min)


class Kink(IntEnum):
    """What happens where a switch changes its sign."""

    KNOT = 0
    """A law bends or jumps."""

    CONTACT_ABOVE = 1
    """A law that can only push does so at positive values."""

    CONTACT_BELOW = 2
    """It does so at negative ones."""


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
        found += [a - b for a, b in combinations(_ordered(each), 2)]
    for each in expression.atoms(sympy.Piecewise):
        found += [condition.lhs - condition.rhs for condition in each.atoms(Relational)]
    return sorted(set(found), key=sympy.default_sort_key)


def kink_of(switch: sympy.Expr, push: sympy.Expr) -> Kink:
    """What a switch decides, where the force of a law that can only push is the smaller of zero and another.

    Examples
    --------
    >>> f = sympy.Symbol("f", real=True)
    >>> kink_of(f, sympy.Min(0, f)).name, kink_of(-f, sympy.Min(0, f)).name, kink_of(f, sympy.Min(1, f)).name
    ('CONTACT_BELOW', 'CONTACT_ABOVE', 'KNOT')
    """
    if isinstance(push, sympy.Min) and len(push.args) == 2 and sympy.S.Zero in push.args:
        force = sympy.Add(*push.args)
        if switch in (force, -force):
            return Kink.CONTACT_BELOW if switch == force else Kink.CONTACT_ABOVE
    return Kink.KNOT


def held(expression: sympy.Expr, sides: Mapping[sympy.Expr, sympy.Expr]) -> sympy.Expr:
    """The smooth continuation of one piece of an expression, to both sides of its kinks.

    Parameters
    ----------
    expression
        With kinks.
    sides
        For switches of it: 1 to continue the piece of positive values, 0 to continue that of negative ones.
        Kinks with other switches stay.

    Examples
    --------
    >>> v, v1, side = sympy.symbols("v v1 side", real=True)
    >>> held(3 * sympy.Max(v - v1, 0), {v - v1: side})
    3*side*(v - v1)
    """
    if expression.is_Atom or not expression.atoms(*_OF_SIGN, *_OF_ORDER, sympy.Piecewise):
        return expression
    arguments = [held(each, sides) if isinstance(each, sympy.Expr) else each for each in expression.args]
    if isinstance(expression, _OF_SIGN):
        side = sides.get(expression.args[0])
        if side is not None:
            parts = {sympy.Abs: (2 * side - 1) * arguments[0], sympy.sign: 2 * side - 1}
            return parts.get(expression.func, side)
    if isinstance(expression, _OF_ORDER):
        return _held_extreme(expression, sides)
    if isinstance(expression, sympy.Piecewise):
        return sympy.Piecewise(
            *((held(value, sides), _held_condition(condition, sides)) for value, condition in expression.args)
        )
    return expression.func(*arguments)


def _ordered(extreme: sympy.Expr) -> list[sympy.Expr]:
    """What a Max or Min is of, in the order of which switches are differences."""
    return sorted(extreme.args, key=sympy.default_sort_key, reverse=True)


def _held_extreme(extreme: sympy.Expr, sides: Mapping[sympy.Expr, sympy.Expr]) -> sympy.Expr:
    """A sum over the arguments of a Max or Min, each times what is 1 if it beats all others and else 0."""
    arguments = _ordered(extreme)
    factors = dict.fromkeys(arguments, sympy.S.One)
    for a, b in combinations(arguments, 2):
        if a - b not in sides:
            return extreme.func(*(held(each, sides) for each in arguments))
        above = sides[a - b] if isinstance(extreme, sympy.Max) else 1 - sides[a - b]
        factors[a], factors[b] = factors[a] * above, factors[b] * (1 - above)
    return sympy.Add(*(factor * held(each, sides) for each, factor in factors.items()))


def _held_condition(condition: sympy.Basic, sides: Mapping[sympy.Expr, sympy.Expr]) -> sympy.Basic:
    """A condition with comparisons of sides for comparisons that switch."""
    half = sympy.Rational(1, 2)
    comparisons = {each: sides.get(each.lhs - each.rhs) for each in condition.atoms(Relational)}
    found = {each: each.func(side, half) for each, side in comparisons.items() if side is not None}
    return condition.xreplace(found)
