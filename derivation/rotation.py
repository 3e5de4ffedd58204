"""Rotations from a parent frame to a child frame, on a straight-line program."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import sympy

from chassym.derivation.program import Program
from chassym.derivation.vector import SymmetricTensor, Vector, dot, matrix_times, vector


class Rotation(ABC):
    """A rotation of a child frame relative to its parent."""

    @abstractmethod
    def to_child(self, program: Program, a: Vector) -> Vector:
        """Components in the child frame of a vector given in the parent frame."""

    @abstractmethod
    def to_parent(self, program: Program, a: Vector) -> Vector:
        """Components in the parent frame of a vector given in the child frame."""

    @abstractmethod
    def tensor_to_parent(self, program: Program, tensor: SymmetricTensor) -> SymmetricTensor:
        """Components in the parent frame of a symmetric tensor given in the child frame."""


def rotation(program: Program, axis: Vector, angle: sympy.Expr) -> Rotation:
    """Rotation by an angle (rad) about a unit vector: cheap about a coordinate axis, of either sense."""
    cosine, sine = program.let(sympy.cos(angle)), program.let(sympy.sin(angle))
    moving = [i for i, component in enumerate(axis) if component != 0]
    if len(moving) == 1:
        return AxisRotation(moving[0], cosine, axis[moving[0]] * sine)
    return ObliqueRotation(_rodrigues(program, axis, cosine, sine))


def _rodrigues(
    program: Program, axis: Vector, cosine: sympy.Expr, sine: sympy.Expr
) -> tuple[Vector, Vector, Vector]:
    """The matrix c E + s [a x] + (1 - c) a a^T (Rodrigues' formula), by rows."""
    let = program.let
    a = vector([let(component) for component in axis])
    versine = let(1 - cosine)
    along = [let(component * versine) for component in a]
    across = [let(component * sine) for component in a]

    def entry(i: int, j: int) -> sympy.Expr:
        product = along[i] * a[j]
        if i == j:
            return let(let(product) + cosine)
        k = 3 - i - j
        return let(let(along[min(i, j)] * a[max(i, j)]) + (-1 if (j - i) % 3 == 1 else 1) * across[k])

    first, second, third = (vector([entry(i, j) for j in range(3)]) for i in range(3))
    return first, second, third


@dataclass(frozen=True)
class AxisRotation(Rotation):
    """Rotation about a coordinate axis, by its number."""

    axis: int
    cosine: sympy.Expr
    sine: sympy.Expr

    def _others(self) -> tuple[int, int, int]:
        return self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3

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


@dataclass(frozen=True)
class ObliqueRotation(Rotation):
    """Rotation about any axis, by its matrix from the child's components to the parent's."""

    matrix: tuple[Vector, Vector, Vector]

    @property
    def _columns(self) -> tuple[Vector, Vector, Vector]:
        first, second, third = zip(*self.matrix, strict=True)
        return first, second, third

    def to_child(self, program: Program, a: Vector) -> Vector:
        """Components in the child frame of a vector given in the parent frame."""
        return matrix_times(program, self._columns, a)

    def to_parent(self, program: Program, a: Vector) -> Vector:
        """Components in the parent frame of a vector given in the child frame."""
        return matrix_times(program, self.matrix, a)

    def tensor_to_parent(self, program: Program, tensor: SymmetricTensor) -> SymmetricTensor:
        """Components in the parent frame of a symmetric tensor given in the child frame."""
        half = [matrix_times(program, tensor.rows(), row) for row in self.matrix]
        places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        return SymmetricTensor(*(program.let(dot(self.matrix[i], half[j])) for i, j in places))
