"""Solution of M x = b on a straight-line program, without fill-in for the mass matrix of a tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.program import Program


@dataclass(frozen=True)
class TreeFactors:
    """The factorisation M = L^T D L of the symmetric positive definite mass matrix of a tree.

    Elimination runs from the last coordinate, a leaf of the tree, to the first: the zeros that the branches
    leave in the mass matrix stay zeros (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.5). No
    pivoting is needed.

    Attributes
    ----------
    pivots
        Reciprocals of D, length n.
    factors
        Row by row, the entries of L left of the diagonal that are not zero, by column.
    """

    pivots: Sequence[sympy.Expr]
    factors: Sequence[dict[int, sympy.Expr]]

    def solve(self, program: Program, right: Sequence[sympy.Expr]) -> list[sympy.Expr]:
        """Solve M x = b; zeros of b that stay zeros cost nothing."""
        x = list(right)
        for k in reversed(range(len(x))):
            for i, factor in self.factors[k].items():
                x[i] = program.let(x[i] - program.let(factor * x[k]))
        for k, pivot in enumerate(self.pivots):
            terms = [-program.let(factor * x[i]) for i, factor in self.factors[k].items()]
            x[k] = program.let(sympy.Add(program.let(x[k] * pivot), *terms))
        return x


def factorise_tree(program: Program, matrix: Sequence[Sequence[sympy.Expr]]) -> TreeFactors:
    """Factorise a mass matrix on a program."""
    n = len(matrix)
    rows = [list(row) for row in matrix]
    pivots = [sympy.S.Zero] * n
    factors: list[dict[int, sympy.Expr]] = [{}] * n
    for k in reversed(range(n)):
        pivots[k] = program.let(1 / rows[k][k])
        coupled = {i: rows[k][i] for i in range(k) if rows[k][i] != 0}
        factors[k] = {i: program.let(entry * pivots[k]) for i, entry in coupled.items()}
        for i, factor in factors[k].items():
            for j in (j for j in coupled if j <= i):
                rows[i][j] = program.let(rows[i][j] - program.let(factor * coupled[j]))
    return TreeFactors(pivots, factors)
