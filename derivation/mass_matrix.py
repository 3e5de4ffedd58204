"""The mass matrix by composite bodies: what a unit acceleration of each coordinate asks of the tree.

Source: the composite-rigid-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008, section
6.2), written with ordinary vectors.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate, Step
from chassym.derivation.kinematics import Kinematics
from chassym.derivation.program import Program
from chassym.derivation.vector import ZERO, SymmetricTensor, Vector, add, cross, scale
from chassym.derivation.wrench import Wrench, component, to_parent

MassMatrix = tuple[tuple[sympy.Expr, ...], ...]


@dataclass(frozen=True)
class Composite:
    """Mass, first moment and inertia about a frame's origin of all that hangs on the frame."""

    mass: sympy.Expr
    first: Vector
    inertia: SymmetricTensor

    def plus(self, program: Program, other: Composite) -> Composite:
        """Two sets of bodies together."""
        return Composite(
            program.let(self.mass + other.mass),
            add(program, self.first, other.first),
            self.inertia.plus(program, other.inertia),
        )


def mass_matrix(kinematics: Kinematics) -> MassMatrix:
    """M, shape (n, n), on the program of the kinematics.

    Raises
    ------
    MechanismError
        If a coordinate moves no mass.
    """
    composites = _composites(kinematics)
    entries: dict[tuple[Coordinate, Coordinate], sympy.Expr] = {}
    for index, link in enumerate(kinematics.links):
        if link.step is None:
            continue
        own = link.step.coordinate
        for coordinate, value in _column(kinematics, index, link.step, composites[index]).items():
            entries[own, coordinate] = entries[coordinate, own] = value
        if entries[own, own] == 0:
            raise MechanismError(f"coordinate {own.name!r} moves no mass; give its body a mass or inertia")
    order = [link.step.coordinate for link in kinematics.links if link.step is not None]
    return tuple(tuple(entries.get((row, column), sympy.S.Zero) for column in order) for row in order)


def _composites(kinematics: Kinematics) -> list[Composite]:
    """For every link all that hangs on it, itself included."""
    found = [_own(kinematics, index) for index in range(len(kinematics.links))]
    for index in reversed(range(len(found))):
        parent = kinematics.links[index].parent
        if parent is not None:
            seen = _seen_from_parent(kinematics, index, found[index])
            found[parent] = found[parent].plus(kinematics.program, seen)
    return found


def _own(kinematics: Kinematics, index: int) -> Composite:
    """Mass properties of one link's body about the link's origin."""
    program, mass, centre = kinematics.program, kinematics.mass(index), kinematics.mass_centre(index)
    first = scale(program, mass, centre)
    steiner = parallel_axes(program, centre, ZERO, first)
    return Composite(mass, first, kinematics.inertia(index).plus(program, steiner))


def _seen_from_parent(kinematics: Kinematics, index: int, composite: Composite) -> Composite:
    """The same bodies about the origin, and in the axes, of the link's parent."""
    link, program = kinematics.links[index], kinematics.program
    first, inertia = composite.first, composite.inertia
    if link.rotation is not None:
        first = link.rotation.to_parent(program, first)
        inertia = link.rotation.tensor_to_parent(program, inertia)
    r = kinematics.displacement(link)
    shifted = add(program, first, scale(program, composite.mass, r))
    return Composite(
        composite.mass, shifted, inertia.plus(program, parallel_axes(program, r, first, shifted))
    )


def parallel_axes(program: Program, r: Vector, old: Vector, new: Vector) -> SymmetricTensor:
    """Inertia that a shift of the origin by -r adds, first moments before and after given.

    The second moments grow by r old^T + old r^T + m r r^T = r old^T + new r^T.
    """
    let = program.let
    xx, yy, zz = (let(r[i] * let(old[i] + new[i])) for i in range(3))
    products = [let(-let(r[i] * old[j]) - let(new[i] * r[j])) for i, j in ((0, 1), (0, 2), (1, 2))]
    return SymmetricTensor(let(yy + zz), let(xx + zz), let(xx + yy), *products)


def _column(
    kinematics: Kinematics, index: int, step: Step, composite: Composite
) -> dict[Coordinate, sympy.Expr]:
    """Entries of one coordinate with itself and with every coordinate between it and the ground."""
    program, axis = kinematics.program, step.axis
    if step.is_rotation:
        wrench = Wrench(cross(program, axis, composite.first), composite.inertia.times(program, axis))
    else:
        wrench = Wrench(scale(program, composite.mass, axis), cross(program, composite.first, axis))
    entries: dict[Coordinate, sympy.Expr] = {}
    for link in kinematics.to_ground(index):
        if link.step is not None:
            entries[link.step.coordinate] = program.let(component(link.step, wrench))
        wrench = to_parent(kinematics, link, wrench)
    return entries
