"""Solving with a tree's mass matrix: the solution, and no operation on what the branches leave zero."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy

from chassym.derivation import Model, Program
from chassym.derivation.solve import factorise_tree

CHAIN = [-1, 0, 1, 2, 3, 4]
STAR = [-1, 0, 0, 0, 0, 0]
CAR = [-1, 0, 1, 2, 3, 4, 5, 5, 6, 6, 7, 7]
"""The parent of every coordinate: six of the body, two end sections on it, two arms on each of them."""

TREES = pytest.mark.parametrize("parents", [CHAIN, STAR, CAR], ids=["chain", "star", "car"])


def ancestors(parents: list[int], k: int) -> list[int]:
    return [] if parents[k] < 0 else [parents[k], *ancestors(parents, parents[k])]


def mass_matrix(parents: list[int]) -> list[list[sympy.Expr]]:
    """A symbol for every entry that a coordinate has in common with one that it hangs on."""
    n = len(parents)
    rows = [[sympy.S.Zero] * n for _ in range(n)]
    for k in range(n):
        for i in (k, *ancestors(parents, k)):
            rows[k][i] = rows[i][k] = sympy.Symbol(f"m{k}_{i}", real=True)
    return rows


@TREES
def test_solution(parents: list[int], lambdified: Callable) -> None:
    n, random = len(parents), np.random.default_rng(1)
    matrix, right = mass_matrix(parents), list(sympy.symbols(f"b:{n}", real=True))
    program = Program()
    solution = factorise_tree(program, matrix).solve(program, right)
    entries = sorted(set().union(*matrix) - {0}, key=str)
    lower = np.array([[float(matrix[i][j] != 0 and j <= i) for j in range(n)] for i in range(n)])
    # L^T L has the zeros that the tree's mass matrix has.
    factor = lower * random.normal(size=(n, n)) + 3 * np.eye(n)
    numbers, given = factor.T @ factor, random.normal(size=n)
    values = {matrix[i][j]: numbers[i, j] for i in range(n) for j in range(n) if matrix[i][j] != 0}
    found = lambdified(program, [*entries, *right], solution)(*(values[e] for e in entries), *given)
    assert found == pytest.approx(np.linalg.solve(numbers, given), rel=1e-12)


@TREES
def test_operations_are_those_of_the_branches(parents: list[int]) -> None:
    """A coordinate with d others below it costs d (d + 1) operations and 5 d + 2 more."""
    n, program = len(parents), Program()
    right = list(sympy.symbols(f"b:{n}", real=True))
    solution = factorise_tree(program, mass_matrix(parents)).solve(program, right)
    depths = [len(ancestors(parents, k)) for k in range(n)]
    assert program.operations(solution) <= sum(d * (d + 1) + 5 * d + 2 for d in depths)


def test_zeros_on_the_right_cost_nothing() -> None:
    """The acceleration of one branch of a star by its own force, with the others at rest."""
    program = Program()
    factors = factorise_tree(program, mass_matrix(STAR))
    before = len(program.definitions)
    solution = factors.solve(program, [sympy.S.Zero] * 5 + [sympy.Symbol("b", real=True)])
    # Down: a product and its opposite. Up: one product for the base, then two and a sum for each branch.
    assert len(program.definitions) - before <= 1 + 1 + 4 + 4
    assert all(each != 0 for each in solution)


def test_the_reference_car_s_solve_uses_its_tree(sedan: Model) -> None:
    """What the accelerations cost beyond forces, bias and mass matrix."""
    equations = sedan.equations
    right = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    entries = [entry for row in equations.mass_matrix for entry in row]
    count = equations.program.operations
    depths = [len(ancestors(CAR, k)) for k in range(len(CAR))]
    dense = [len(CAR[:k]) for k in range(len(CAR))]
    cost = count(equations.accelerations) - count([*right, *entries])
    most, without_the_tree = (sum(d * (d + 1) + 5 * d + 2 for d in each) for each in (depths, dense))
    assert cost <= most < 0.8 * without_the_tree


def test_the_jacobian_costs_a_few_times_the_right_hand_side(sedan: Model) -> None:
    """24 columns, a difference quotient's 24 evaluations, for the price of less than eight."""
    equations = sedan.equations
    entries = [entry for row in equations.right_hand_side_jacobian for entry in row]
    count = equations.program.operations
    assert count(entries) < 8 * count(equations.right_hand_side)
