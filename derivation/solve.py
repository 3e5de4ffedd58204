"""Solution of M x = b on a straight-line program, without fill-in for the mass matrix of a tree."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from chassym.derivation.program import Program


def solve_tree(
    program: Program, matrix: Sequence[Sequence[sympy.Expr]], right: Sequence[sympy.Expr]
) -> list[sympy.Expr]:
    """Solve M x = b for a symmetric positive definite M by the factorisation M = L^T D L.

    Elimination runs from the last coordinate, a leaf of the tree, to the first: the zeros that the branches
    leave in the mass matrix stay zeros (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.5). No
    pivoting is needed.
    """
    n = len(right)
    rows = [list(row) for row in matrix]
    x = list(right)
    pivots = [sympy.S.Zero] * n
    factors: list[dict[int, sympy.Expr]] = [{}] * n
    for k in reversed(range(n)):
        pivots[k] = program.let(1 / rows[k][k])
        coupled = {i: rows[k][i] for i in range(k) if rows[k][i] != 0}
        factors[k] = {i: program.let(entry * pivots[k]) for i, entry in coupled.items()}
        for i, factor in factors[k].items():
            for j in (j for j in coupled if j <= i):
                rows[i][j] = program.let(rows[i][j] - program.let(factor * coupled[j]))
            x[i] = program.let(x[i] - program.let(factor * x[k]))
    for k in range(n):
        terms = [-program.let(factor * x[i]) for i, factor in factors[k].items()]
        x[k] = program.let(sympy.Add(program.let(x[k] * pivots[k]), *terms))
    return x
