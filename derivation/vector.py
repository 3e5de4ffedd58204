"""Three-vectors, rotations about a coordinate axis and symmetric tensors on a straight-line program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.program import Program

Vector = tuple[sympy.Expr, sympy.Expr, sympy.Expr]

AXES = {"x": 0, "y": 1, "z": 2}
ZERO: Vector = (sympy.S.Zero, sympy.S.Zero, sympy.S.Zero)


def vector(components: Sequence[sympy.Expr | float | int]) -> Vector:
    """Three sympy expressions from any three numbers or expressions."""
    first, second, third = (sympy.sympify(c) for c in components)
    return first, second, third


def unit(axis: str) -> Vector:
    """Unit vector of the axis "x", "y" or "z"."""
    return vector([int(i == AXES[axis]) for i in range(3)])


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


@dataclass(frozen=True)
class AxisRotation:
    """Rotation by an angle about one coordinate axis, from a parent frame to a child frame."""

    axis: str
    cosine: sympy.Expr
    sine: sympy.Expr

    def _others(self) -> tuple[int, int, int]:
        i = AXES[self.axis]
        return i, (i + 1) % 3, (i + 2) % 3

    def to_child(self, program: Program, a: Vector) -> Vector:
        """Components in the child frame of a vector given in the parent frame."""
        return self._turn(program, a, self.sine)

    def to_parent(self, program: Program, a: Vector) -> Vector:
        """Components in the parent frame of a vector given in the child frame."""
        return self._turn(program, a, -self.sine)

    def _turn(self, program: Program, a: Vector, sine: sympy.Expr) -> Vector:
        i, j, k = self._others()
        turned = [a[i]] * 3
        turned[j] = program.let(self.cosine * a[j] + sine * a[k])
        turned[k] = program.let(self.cosine * a[k] - sine * a[j])
        return vector(turned)

    def tensor_to_parent(self, program: Program, tensor: SymmetricTensor) -> SymmetricTensor:
        """Components in the parent frame of a symmetric tensor given in the child frame.

        For the axis i and the other two j, k let h = s (T_kk - T_jj) - 2 c T_jk. Then T_jj' = T_jj + s h,
        T_kk' = T_kk - s h and T_jk' = -T_jk - c h, by the double-angle formulas; (T_ij, T_ik) turns as a
        vector.
        """
        i, j, k = self._others()
        t = tensor.rows()
        c, s = self.cosine, self.sine
        difference = program.let(t[k][k] - t[j][j])
        half_turn = program.let(difference * s - 2 * c * t[j][k])
        change = program.let(s * half_turn)
        rows = [list(row) for row in t]
        rows[j][j] = program.let(t[j][j] + change)
        rows[k][k] = program.let(t[k][k] - change)
        rows[j][k] = rows[k][j] = program.let(-t[j][k] - c * half_turn)
        rows[i][j] = rows[j][i] = program.let(c * t[i][j] - s * t[i][k])
        rows[i][k] = rows[k][i] = program.let(c * t[i][k] + s * t[i][j])
        return SymmetricTensor(rows[0][0], rows[1][1], rows[2][2], rows[0][1], rows[0][2], rows[1][2])
