"""The result of a derivation: M(q, p) q'' + h(q, q', p) = Q(q, q', u, u', p) with outputs, on one program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import sympy

from chassym.derivation.joint import Coordinate
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.program import Program
from chassym.derivation.solve import solve_tree


@dataclass(frozen=True, eq=False)
class EquationsOfMotion:
    """Equations of motion of a mechanism.

    Attributes
    ----------
    mechanism
        What they were derived from.
    program
        The straight-line program whose names the expressions use.
    mass_matrix
        M, shape (n, n), symmetric.
    bias
        h: Coriolis, centrifugal and gravity terms, length n.
    generalized_forces
        Q of the force elements, length n.
    element_forces, element_rates
        Resisting force and rate of deflection of every force element, by its name.
    outputs
        Every output by its name, in coordinates, rates, accelerations, inputs and input rates.
    derivation_s
        Time that M, h and Q took (s).
    """

    mechanism: Mechanism
    program: Program
    mass_matrix: tuple[tuple[sympy.Expr, ...], ...]
    bias: tuple[sympy.Expr, ...]
    generalized_forces: tuple[sympy.Expr, ...]
    element_forces: Mapping[str, sympy.Symbol]
    element_rates: Mapping[str, sympy.Symbol]
    outputs: Mapping[str, sympy.Expr]
    derivation_s: float

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalised coordinates, in order."""
        return self.mechanism.coordinates

    @cached_property
    def arguments(self) -> tuple[sympy.Symbol, ...]:
        """Coordinates, rates, accelerations, inputs and input rates, in this order."""
        coordinates, inputs = self.coordinates, self.mechanism.inputs
        return (
            *(c.position for c in coordinates),
            *(c.rate for c in coordinates),
            *(c.acceleration for c in coordinates),
            *(u.position for u in inputs),
            *(u.rate for u in inputs),
        )

    @cached_property
    def residual(self) -> tuple[sympy.Expr, ...]:
        """M q'' + h - Q, length n: zero along a motion."""
        accelerations = [c.acceleration for c in self.coordinates]
        rows = zip(self.mass_matrix, self.bias, self.generalized_forces, strict=True)
        return tuple(
            self.program.let(sympy.Add(h, -q, *(m * a for m, a in zip(row, accelerations, strict=True))))
            for row, h, q in rows
        )

    @cached_property
    def accelerations(self) -> tuple[sympy.Expr, ...]:
        """q'' = M^-1 (Q - h), solved on the program by the tree's sparse factorisation."""
        right = [self.program.let(q - h) for q, h in zip(self.generalized_forces, self.bias, strict=True)]
        return tuple(solve_tree(self.program, self.mass_matrix, right))

    @cached_property
    def residual_jacobian(self) -> list[list[sympy.Expr]]:
        """Exact derivatives of the residual by coordinates, rates and accelerations, shape (n, 3 n)."""
        return self.program.differentiate(self.residual, self.arguments[: 3 * len(self.coordinates)])

    @cached_property
    def linearisation(self) -> list[list[sympy.Expr]]:
        """Exact derivatives of residual and outputs, shape (n + outputs, arguments).

        A characteristic with knots enters by a symbol for its slope, `Mechanism.slopes`: which slope it has
        at a knot is a choice to be made with the numbers.
        """
        stated = {
            self.element_forces[name]: {self.element_rates[name]: slope}
            for name, slope in self.mechanism.slopes.items()
        }
        results = [*self.residual, *self.outputs.values()]
        return self.program.differentiate(results, self.arguments, stated)

    @cached_property
    def knot_distances(self) -> list[sympy.Expr]:
        """Rate less knot, for every knot of every element: a sign change is a corner of its force."""
        return [
            self.program.let(self.element_rates[name] - knot)
            for name, characteristic in self.mechanism.knotted.items()
            for knot in characteristic.knots
        ]

    @property
    def operations(self) -> dict[str, int]:
        """Arithmetic operations of M and h together, and of the whole right-hand side."""
        upper = [self.mass_matrix[i][j] for i in range(len(self.bias)) for j in range(i, len(self.bias))]
        return {
            "mass_matrix_and_bias": self.program.operations([*upper, *self.bias]),
            "right_hand_side": self.program.operations(self.accelerations),
        }
