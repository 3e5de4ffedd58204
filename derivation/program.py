"""A straight-line program of shared subexpressions: symbolic quantities that stay small."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy
from sympy.logic.boolalg import Boolean

Tangent = dict[sympy.Symbol, sympy.Expr]


class Program:
    """An ordered list of assignments ``symbol = expression`` in which equal expressions are stated once.

    A quantity of a large model, written out in its coordinates, has hundreds of thousands of terms. Here
    every intermediate result gets a name, and what is built from it mentions that name only. Expressions
    remain ordinary sympy objects; `expand` writes them out again where they are small enough to read. Names
    begin with an underscore, which a mechanism refuses for its parts.

    Examples
    --------
    >>> x, y = sympy.symbols("x y")
    >>> program = Program()
    >>> product = program.let(x * y)
    >>> program.let(sympy.sin(product) - 2 * product), program.let(-3 * x * y)
    (_1, -3*_0)
    >>> program.expand([program.let(1 - x * y)])
    [-x*y + 1]
    """

    def __init__(self) -> None:
        self._definitions: dict[sympy.Symbol, sympy.Expr] = {}
        self._names: dict[sympy.Expr, sympy.Symbol] = {}
        self._absorbed: dict[sympy.Expr, sympy.Expr] = {}
        self._sums: set[frozenset[sympy.Symbol]] = set()

    @property
    def definitions(self) -> Mapping[sympy.Symbol, sympy.Expr]:
        """Every assignment, in the order of evaluation."""
        return self._definitions

    def let(self, expression: sympy.Expr | int) -> sympy.Expr:
        """Name an expression and return its name; atoms and multiples of a name stay as they are."""
        expression = sympy.sympify(expression)
        coefficient, rest = expression.as_coeff_Mul()
        if rest.is_Atom:
            return expression
        if rest.is_Add and rest not in self._names and self._has_opposite(rest):
            coefficient, rest = -coefficient, -rest
        return coefficient * self._name(rest)

    def _has_opposite(self, total: sympy.Expr) -> bool:
        """Whether the opposite of a sum has a name; sums of other symbols are told apart without negating."""
        return frozenset(total.free_symbols) in self._sums and -total in self._names

    def absorb(self, expression: sympy.Expr) -> sympy.Expr:
        """Name every part of an expression, inside out, and return the name of the whole."""
        expression = sympy.sympify(expression)
        if expression.is_Atom or isinstance(expression, Boolean):
            return expression
        if expression not in self._absorbed:
            rebuilt = expression.func(*map(self.absorb, expression.args))
            self._absorbed[expression] = self.let(rebuilt) if isinstance(rebuilt, sympy.Expr) else rebuilt
        return self._absorbed[expression]

    def assign(self, expression: sympy.Expr) -> sympy.Symbol:
        """Name an expression by a symbol of its own, even where it is an atom or a multiple of one."""
        return self._name(sympy.sympify(expression))

    def _name(self, expression: sympy.Expr) -> sympy.Symbol:
        if expression not in self._names:
            symbol = sympy.Symbol(f"_{len(self._definitions)}", real=True)
            self._names[expression] = symbol
            if expression.is_Add:
                self._sums.add(frozenset(expression.free_symbols))
            self._definitions[symbol] = expression
        return self._names[expression]

    def required(self, results: Iterable[sympy.Expr]) -> dict[sympy.Symbol, sympy.Expr]:
        """The assignments, in order, that the results depend on."""
        needed = set().union(*(expression.free_symbols for expression in results))
        kept = []
        for symbol in reversed(self._definitions):
            if symbol in needed:
                kept.append(symbol)
                needed |= self._definitions[symbol].free_symbols
        return {symbol: self._definitions[symbol] for symbol in reversed(kept)}

    def operations(self, results: Sequence[sympy.Expr]) -> int:
        """Number of arithmetic operations that evaluate the results, as `sympy.count_ops` counts them."""
        return int(sum(sympy.count_ops(e) for e in (*self.required(results).values(), *results)))

    def substitute(
        self, results: Sequence[sympy.Expr], values: Mapping[sympy.Symbol, sympy.Expr]
    ) -> list[sympy.Expr]:
        """The results with expressions of this program put in for symbols, as further assignments."""
        replaced = dict(values)
        for symbol, expression in self.required(results).items():
            if not replaced.keys().isdisjoint(expression.free_symbols):
                replaced[symbol] = self.let(expression.xreplace(replaced))
        return [self.let(expression.xreplace(replaced)) for expression in results]

    def expand(self, results: Sequence[sympy.Expr]) -> list[sympy.Expr]:
        """The results written out without intermediate names; for models small enough to read."""
        full: dict[sympy.Symbol, sympy.Expr] = {}
        for symbol, expression in self.required(results).items():
            full[symbol] = expression.xreplace(full)
        return [sympy.sympify(expression).xreplace(full) for expression in results]

    def differentiate(
        self,
        results: Sequence[sympy.Expr],
        variables: Sequence[sympy.Symbol],
        stated: Mapping[sympy.Symbol, Tangent] | None = None,
    ) -> list[list[sympy.Expr]]:
        """Exact derivatives of results by variables, as further assignments of this program.

        Forward accumulation (Griewank and Walther, Evaluating Derivatives, 2nd ed., section 3.1), with
        structural zeros left out.

        Parameters
        ----------
        results
            Expressions in this program's names, length m.
        variables
            Independent symbols, length n.
        stated
            Partial derivatives to use for a name instead of those of its definition: the slope that a
            characteristic states for itself.

        Returns
        -------
        list of list of sympy.Expr
            The Jacobian, shape (m, n).
        """
        rows = self._tangents(results, {v: {v: sympy.S.One} for v in variables}, stated or {})
        return [[row.get(v, sympy.S.Zero) for v in variables] for row in rows]

    def differentiate_along(
        self,
        results: Sequence[sympy.Expr],
        direction: Mapping[sympy.Symbol, sympy.Expr],
        stated: Mapping[sympy.Symbol, Tangent] | None = None,
    ) -> list[sympy.Expr]:
        """Exact directional derivatives: the Jacobian times a direction, without the Jacobian.

        Parameters
        ----------
        results
            Expressions in this program's names, length m.
        direction
            Component along every independent symbol.
        stated
            As for `differentiate`.

        Returns
        -------
        list of sympy.Expr
            Length m.
        """
        along = sympy.Dummy("along")
        rows = self._tangents(results, {v: {along: part} for v, part in direction.items()}, stated or {})
        return [row.get(along, sympy.S.Zero) for row in rows]

    def _tangents(
        self,
        results: Sequence[sympy.Expr],
        independent: Mapping[sympy.Symbol, Tangent],
        stated: Mapping[sympy.Symbol, Tangent],
    ) -> list[Tangent]:
        """Tangents of results, from those of the independent symbols."""
        tangents = dict(independent)
        for symbol, expression in self.required(results).items():
            partials = stated[symbol] if symbol in stated else self._partials(expression, tangents)
            tangents[symbol] = self._accumulate(partials, tangents)
        return [self._accumulate(self._partials(sympy.sympify(r), tangents), tangents) for r in results]

    def _partials(self, expression: sympy.Expr, tangents: Mapping[sympy.Symbol, Tangent]) -> Tangent:
        """Partial derivatives of one small expression by the names in it that vary."""
        varying = sorted((s for s in expression.free_symbols if tangents.get(s)), key=lambda s: s.name)
        return {s: self.let(_partial(expression, s)) for s in varying}

    def _accumulate(self, partials: Tangent, tangents: Mapping[sympy.Symbol, Tangent]) -> Tangent:
        """Chain rule: sum of partial derivatives times tangents."""
        terms: dict[sympy.Symbol, list[sympy.Expr]] = {}
        for symbol, partial in partials.items():
            for variable, tangent in tangents.get(symbol, {}).items():
                terms.setdefault(variable, []).append(partial * tangent)
        sums = {variable: self.let(sympy.Add(*products)) for variable, products in terms.items()}
        return {variable: value for variable, value in sums.items() if value != 0}


def _partial(expression: sympy.Expr, symbol: sympy.Symbol) -> sympy.Expr:
    """Partial derivative; sums and products, which most assignments are, without sympy's general dispatch."""
    if expression == symbol:
        return sympy.S.One
    if symbol not in expression.free_symbols:
        return sympy.S.Zero
    if expression.is_Add:
        return sympy.Add(*(_partial(term, symbol) for term in expression.args))
    if expression.is_Mul:
        factors = expression.args
        return sympy.Add(
            *(sympy.Mul(_partial(f, symbol), *factors[:i], *factors[i + 1 :]) for i, f in enumerate(factors))
        )
    return expression.diff(symbol)
