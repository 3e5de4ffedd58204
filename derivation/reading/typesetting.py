"""Expressions as LaTeX: parameters before coordinates, positive terms first, and lines that fit a page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

import sympy
from sympy.printing.latex import LatexPrinter

WIDEST = 92
"""Most letters in a line of an A4 page at 10 points."""

SUBSCRIPT, OPERATOR = 0.75, 2.5
"""Widths of a subscript's letter, and of an operator with the space around it, in letters."""

_SUBSCRIPT = r"_\{((?:[^{}]|\{[^{}]*\})*)\}"

LINE_BREAK = r" \\" + "\n" + r"& \qquad {}"


DIGITS = 6
"""Most significant digits of a floating-point number."""


class _Printer(LatexPrinter):
    """Sums begin with a positive term where they have one; floating-point numbers are rounded."""

    def _print_Float(self, expr: sympy.Float) -> str:
        return str(super()._print_Float(sympy.Float(expr, DIGITS)))

    def _as_ordered_terms(self, expr: sympy.Expr, order: str | None = None) -> list[sympy.Expr]:
        terms = super()._as_ordered_terms(expr, order=order)
        return sorted(terms, key=lambda term: bool(term.could_extract_minus_sign()))


class Typesetter:
    r"""Prints expressions with given LaTeX names; symbols stand in products in the order of the names.

    Examples
    --------
    >>> z, m = sympy.symbols("z_rate mass")
    >>> typesetter = Typesetter({m: "m", z: r"\dot{z}"})
    >>> print(typesetter.latex(z**2 * m / 2))
    \frac{m\,\dot{z}^{2}}{2}
    """

    def __init__(self, names: Mapping[sympy.Symbol, str]) -> None:
        # sympy sorts symbols by their names, so that numbers take their places
        self._numbered = {symbol: sympy.Symbol(f"{i:06d}", real=True) for i, symbol in enumerate(names)}
        printed = {self._numbered[symbol]: name for symbol, name in names.items()}
        self._printer = _Printer({"symbol_names": printed, "mul_symbol": r"\,"})

    def latex(self, expression: sympy.Expr) -> str:
        """An expression in one piece."""
        return str(self._printer.doprint(expression.xreplace(self._numbered)))

    def terms(self, expression: sympy.Expr) -> list[str]:
        """A sum in pieces that begin with their signs; products too long for a line are multiplied out."""
        return list(self._signed(expression.xreplace(self._numbered), is_first=True))

    def _signed(self, expression: sympy.Expr, *, is_first: bool) -> Iterator[str]:
        for term in self._printer._as_ordered_terms(expression):
            negative = term.could_extract_minus_sign()
            text = self._printer.doprint(-term if negative else term)
            if width(text) > WIDEST and (spread := _multiplied_out(term)) is not None:
                yield from self._signed(spread, is_first=is_first)
            else:
                if (-term if negative else term).is_Add:
                    text = rf"\left({text}\right)"
                yield f"- {text}" if negative else text if is_first else f"+ {text}"
            is_first = False


def _multiplied_out(product: sympy.Expr) -> sympy.Expr | None:
    """A product by the terms of its longest sum; None if it has none."""
    sums = [factor for factor in sympy.Mul.make_args(product) if factor.is_Add]
    if not sums:
        return None
    longest = max(sums, key=sympy.count_ops)
    rest = sympy.Mul(*(factor for factor in sympy.Mul.make_args(product) if factor is not longest))
    return sympy.Add(*(rest * term for term in longest.args))


def filled(pieces: Iterable[str]) -> str:
    """Pieces in lines that fit a page, for an aligned environment."""
    lines: list[list[str]] = [[]]
    for piece in pieces:
        if lines[-1] and width(" ".join([*lines[-1], piece])) > WIDEST:
            lines.append([])
        lines[-1].append(piece)
    return "& " + LINE_BREAK.join(" ".join(line) for line in lines)


def width(latex: str) -> float:
    r"""About how many letters wide a formula is when typeset.

    >>> width(r"\dot{z}_{\text{wheel}} + k") == 1 + SUBSCRIPT * 5 + OPERATOR + 1
    True
    """
    subscripts = re.findall(_SUBSCRIPT, latex)
    flat = re.sub(_SUBSCRIPT, "", latex)
    flat = re.sub(
        r"\\left|\\right|\\text|\\d?dot|\\q?quad|\\,|\s", "", re.sub(r"\^\{([^{}]*)\}", r"\1", flat)
    )
    flat = re.sub(r"\\(sin|cos|tan|max|min|log|exp)\b", "fun", flat)
    flat = re.sub(r"\\(?!frac)[A-Za-z]+", "x", flat)
    flat = re.sub(r"(?<!\})\{([^{}]*)\}(?!\{)", r"\1", flat)
    while (simpler := re.sub(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", _wider, flat)) != flat:
        flat = simpler
    operators = len(re.findall(r"[-+=]", flat))
    letters = len(re.sub(r"[-+={}\\]|frac", "", flat))
    return letters + OPERATOR * operators + SUBSCRIPT * sum(map(_letters, subscripts))


def _wider(fraction: re.Match[str]) -> str:
    return max(fraction[1], fraction[2], key=len)


def _letters(subscript: str) -> int:
    return len(re.sub(r"\\text|[{}]", "", subscript))
