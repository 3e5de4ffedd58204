"""Three-vectors and symmetric tensors on a straight-line program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.program import Program

Vector = tuple[sympy.Expr, sympy.Expr, sympy.Expr]

ZERO: Vector = (sympy.S.Zero, sympy.S.Zero, sympy.S.Zero)


def vector(components: Iterable[sympy.Expr | float | int]) -> Vector:
    """Three sympy expressions from any three numbers or expressions."""
    first, second, third = (sympy.sympify(c) for c in components)
    return first, second, third


def dot(a: Vector, b: Vector) -> sympy.Expr:
    """Scalar product, not named on any program."""
    return sympy.Add(*(p * q for p, q in zip(a, b, strict=True)))


def subtract(program: Program, a: Vector, b: Vector) -> Vector:
    """Difference a - b."""
    return vector([program.let(p - q) for p, q in zip(a, b, strict=True)])


def add(program: Program, *vectors: Vector) -> Vector:
    """Sum of vectors."""
    return vector([program.let(sympy.Add(*components)) for components in zip(*vectors, strict=True)])


def scale(program: Program, factor: sympy.Expr, a: Vector) -> Vector:
    """A vector times a scalar."""
    return vector([program.let(factor * component) for component in a])


def negative(a: Vector) -> Vector:
    """The opposite vector."""
    return (-a[0], -a[1], -a[2])


def cross(program: Program, a: Vector, b: Vector) -> Vector:
    """Vector product a x b."""
    return vector(
        [
            program.let(a[1] * b[2] - a[2] * b[1]),
            program.let(a[2] * b[0] - a[0] * b[2]),
            program.let(a[0] * b[1] - a[1] * b[0]),
        ]
    )


@dataclass(frozen=True)
class SymmetricTensor:
    """A symmetric 3 x 3 tensor by its six components."""

    xx: sympy.Expr
    yy: sympy.Expr
    zz: sympy.Expr
    xy: sympy.Expr
    xz: sympy.Expr
    yz: sympy.Expr

    def rows(self) -> tuple[Vector, Vector, Vector]:
        """The tensor as three rows."""
        return ((self.xx, self.xy, self.xz), (self.xy, self.yy, self.yz), (self.xz, self.yz, self.zz))

    def times(self, program: Program, a: Vector) -> Vector:
        """Product of the tensor and a vector."""
        return matrix_times(program, self.rows(), a)

    def plus(self, program: Program, other: SymmetricTensor) -> SymmetricTensor:
        """Sum of two tensors."""
        pairs = zip(self.components(), other.components(), strict=True)
        return SymmetricTensor(*(program.let(a + b) for a, b in pairs))

    def components(self) -> tuple[sympy.Expr, ...]:
        """The components xx, yy, zz, xy, xz, yz."""
        return (self.xx, self.yy, self.zz, self.xy, self.xz, self.yz)


def diagonal(xx: sympy.Expr, yy: sympy.Expr, zz: sympy.Expr) -> SymmetricTensor:
    """A tensor without products of inertia."""
    return SymmetricTensor(xx, yy, zz, sympy.S.Zero, sympy.S.Zero, sympy.S.Zero)


def matrix_times(program: Program, rows: Sequence[Vector], a: Vector) -> Vector:
    """Product of a matrix, given by rows, and a vector."""
    return vector([program.let(sympy.Add(*(m * c for m, c in zip(row, a, strict=True)))) for row in rows])
