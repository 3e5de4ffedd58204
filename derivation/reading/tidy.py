"""Light simplification for reading: squares of sine and cosine are added, rounding errors left out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import sympy

MOST_TERMS = 200
"""Sums that multiply out to more terms than this stay as they are."""

ROUNDING = sympy.Float("1e-14")
"""Floating-point coefficients below this part of the largest one of their sum are rounding errors."""


def tidied(expression: sympy.Expr) -> sympy.Expr:
    """The same value with sin^2 + cos^2 = 1 used in every sum that gets shorter by it, inside out.

    Examples
    --------
    >>> a, m, v, w = sympy.symbols("a m v w")
    >>> tidied(m * ((v * sympy.sin(a)) ** 2 + (v * sympy.cos(a)) ** 2) / 2 + m * (v + w) ** 2)
    m*v**2/2 + m*(v + w)**2
    """
    return _tidied(sympy.sympify(expression), {})


def _tidied(expression: sympy.Expr, known: dict[sympy.Expr, sympy.Expr]) -> sympy.Expr:
    if not expression.args:
        return expression
    if expression not in known:
        rebuilt = expression.func(*(_tidied(each, known) for each in expression.args))
        known[expression] = _shortest(rebuilt) if rebuilt.is_Add else _numbers_first(rebuilt)
    return known[expression]


def without_rounding(total: sympy.Expr, beside: Iterable[sympy.Expr] = ()) -> sympy.Expr:
    """A sum without the terms that rounding has left where exact numbers would have cancelled.

    What stands beside it in the same equation, in the same unit, tells what is small but stays as it is.

    Examples
    --------
    >>> a, b = sympy.symbols("a b")
    >>> without_rounding(0.5 * a + (0.1 + 0.2 - 0.3) * b)
    0.5*a
    """
    if not total.atoms(sympy.Float):
        return total
    sizes = {term: _coefficient(term) for term in sympy.Add.make_args(total)}
    least = ROUNDING * max([*sizes.values(), *map(_coefficient, beside)])
    return sympy.Add(*(term for term, size in sizes.items() if size >= least or not term.atoms(sympy.Float)))


def _coefficient(expression: sympy.Expr) -> sympy.Expr:
    """The size of the largest numerical coefficient of an expression."""
    if expression.is_Number:
        return abs(expression)
    if expression.is_Add:
        return max(map(_coefficient, expression.args))
    return sympy.Mul(*map(_coefficient, expression.args)) if expression.is_Mul else sympy.S.One


def _numbers_first(product: sympy.Expr) -> sympy.Expr:
    """k (2 a - 2 b)/2, as derivatives of squares come, becomes k (a - b)."""
    if not product.is_Mul:
        return product
    parts = [factor.primitive() if factor.is_Add else (sympy.S.One, factor) for factor in product.args]
    return sympy.Mul(*(number for number, _ in parts), *(factor for _, factor in parts))


def sorted_by(
    expression: sympy.Expr, factors: Sequence[sympy.Symbol], common: Sequence[sympy.Symbol]
) -> sympy.Expr:
    """A polynomial in some symbols by its monomials, if that is shorter; coefficients by common factors.

    Examples
    --------
    >>> a, l, m, n, v = sympy.symbols("a l m n v")
    >>> sorted_by(v * (v * m * l - 3 * m) + m * v + n * v**2 * a, [v], [m, n])
    -2*m*v + v**2*(a*n + l*m)
    """
    if _terms(expression) > MOST_TERMS:
        return expression
    coefficients: dict[sympy.Expr, sympy.Expr] = {}
    for term in sympy.Add.make_args(_spread(expression)):
        coefficient, monomial = term.as_independent(*factors, as_Add=False)
        coefficients[monomial] = coefficients.get(monomial, sympy.S.Zero) + coefficient
    gathered = [
        sympy.collect(_spread(coefficient), common, sympy.factor_terms) * monomial
        for monomial, coefficient in coefficients.items()
    ]
    return min((expression, sympy.Add(*gathered)), key=sympy.count_ops)


def _shortest(total: sympy.Add) -> sympy.Expr:
    """A sum, or what it is when multiplied out, whichever is shorter."""
    total = without_rounding(total)
    if not _angles(total) or _terms(total) > MOST_TERMS:
        return total
    spread = without_rounding(_spread(total), beside=[total])
    candidates = (total, spread, sympy.factor_terms(spread))
    return min(candidates, key=lambda each: (sympy.count_ops(each), candidates.index(each)))


def _spread(expression: sympy.Expr) -> sympy.Expr:
    """Multiplied out, with sin^2 + cos^2 = 1 or with every sin^2 as 1 - cos^2, whichever is shorter."""
    squares = {sympy.sin(each) ** 2: 1 - sympy.cos(each) ** 2 for each in _angles(expression)}
    spread = sympy.expand(expression)
    if not squares:
        return spread
    return min(_paired(spread), sympy.expand(spread.subs(squares)), key=sympy.count_ops)


def _paired(spread: sympy.Expr) -> sympy.Expr:
    """A sum of products in which a sin^2 + a cos^2 has become a, for every a."""
    numbers = dict(spread.as_coefficients_dict())
    for angle in sorted(_angles(spread), key=str):
        sine, cosine = sympy.sin(angle) ** 2, sympy.cos(angle) ** 2
        for product in [each for each in numbers if sine in sympy.Mul.make_args(each)]:
            if product not in numbers:  # it was the partner of one before
                continue
            rest = product / sine
            partner = rest * cosine
            if numbers.get(partner) == numbers[product]:
                numbers[rest] = numbers.get(rest, sympy.S.Zero) + numbers.pop(product)
                del numbers[partner]
    return sympy.Add(*(number * product for product, number in numbers.items()))


def _angles(expression: sympy.Expr) -> set[sympy.Expr]:
    """Everything of which both sine and cosine occur."""
    sines, cosines = ({each.args[0] for each in expression.atoms(kind)} for kind in (sympy.sin, sympy.cos))
    return sines & cosines


def _terms(expression: sympy.Expr) -> int:
    """Number of terms of an expression once it is multiplied out."""
    if expression.is_Add:
        return sum(map(_terms, expression.args))
    if expression.is_Mul:
        return math.prod(map(_terms, expression.args))
    if expression.is_Pow and expression.exp.is_Integer and 0 < expression.exp < 10:
        return math.comb(_terms(expression.base) + int(expression.exp) - 1, int(expression.exp))
    return 1
