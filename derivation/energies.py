"""Kinetic and potential energy and Rayleigh's dissipation function: the terms of Lagrange's equations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy

from chassym.derivation.body import GROUND, Body, Point
from chassym.derivation.element import ElementAnswer
from chassym.derivation.kinematics import Kinematics
from chassym.derivation.vector import ZERO, Vector, add, cross, dot

if TYPE_CHECKING:
    from chassym.derivation.mechanism import Mechanism


@dataclass(frozen=True)
class Energies:
    """The terms of d/dt(dT/dq') - dT/dq + dV/dq + dD/dq' = Q, on a program.

    Attributes
    ----------
    kinetic, potential
        T and V (J). V is that of the weights and of the force elements that have one.
    dissipation
        D (W), of the force elements that have one.
    applied
        Q: generalised forces of everything else, length n (N or N m).
    """

    kinetic: sympy.Expr
    potential: sympy.Expr
    dissipation: sympy.Expr
    applied: tuple[sympy.Expr, ...]


def tree_energies(
    kinematics: Kinematics,
    mechanism: Mechanism,
    answers: Mapping[str, ElementAnswer],
    applied: Sequence[sympy.Expr],
) -> Energies:
    """T, V and D of a mechanism, summed over its bodies and force elements."""
    program = kinematics.program
    potential, dissipation = [], []
    for body in mechanism.bodies:
        potential.append(_weight_energy(kinematics, body, sympy.sympify(mechanism.gravity)))
    for element in mechanism.elements:
        answer, law = answers[element.name], element.characteristic
        potential.append(program.absorb(law.potential(answer.deflection, element.constant_force)))
        dissipation.append(program.absorb(law.dissipation(answer.rate)))
    return Energies(
        program.let(sympy.Add(*_kinetic_energies(kinematics))),
        program.let(sympy.Add(*potential)),
        program.let(sympy.Add(*dissipation)),
        tuple(applied),
    )


def _weight_energy(kinematics: Kinematics, body: Body, gravity: sympy.Expr) -> sympy.Expr:
    """Mass times gravity times height of the mass centre."""
    if body.mass == 0 or gravity == 0:
        return sympy.S.Zero
    centre = Point(f"{body.name}.mass_centre", body, body.mass_centre)
    height = kinematics.position(centre, GROUND)[2]
    return kinematics.program.let(kinematics.program.absorb(body.mass) * gravity * height)


def _kinetic_energies(kinematics: Kinematics) -> list[sympy.Expr]:
    """(m v.v + w.I w) / 2 of every body that has mass or inertia, in its own axes."""
    program = kinematics.program
    energies, origins = [], _origin_velocities(kinematics)
    for index, link in enumerate(kinematics.links):
        if link.body is None:
            continue
        spin = kinematics.angular_velocity[index]
        velocity = add(program, origins[index], cross(program, spin, kinematics.mass_centre(index)))
        straight = program.let(kinematics.mass(index) * program.let(dot(velocity, velocity)))
        turning = program.let(dot(spin, kinematics.inertia(index).times(program, spin)))
        energies.append(program.let((straight + turning) / 2))
    return energies


def _origin_velocities(kinematics: Kinematics) -> list[Vector]:
    """Velocity of every link's origin in its own axes."""
    program = kinematics.program
    found: list[Vector] = []
    for link in kinematics.links:
        velocity = ZERO
        if link.parent is not None:
            spin = kinematics.angular_velocity[link.parent]
            carried = cross(program, spin, kinematics.displacement(link))
            velocity = add(program, found[link.parent], carried)
        found.append(kinematics.to_child(link, add(program, velocity, kinematics.own_velocity(link, ZERO))))
    return found
