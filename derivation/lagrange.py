"""Lagrange's equations of a mechanism, body by body on a straight-line program.

For a rigid body with partial velocities v_i = dv/dq_i' and w_i = dw/dq_i', Lagrange's d/dt(dT/dq_i') -
dT/dq_i equals v_i . m a + w_i . (I alpha + w x I w) (Kane and Levinson, Dynamics: Theory and Applications,
1985, section 5.7). What multiplies the second derivatives is the mass matrix; the rest, with the weights, is
the bias h. Both are summed over the bodies down the tree, so nothing is expanded and nothing differentiated.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import singledispatch

import sympy

from chassym.derivation.body import AppliedForce, Body, rotation_sequence
from chassym.derivation.element import ElementAnswer, ForceElement
from chassym.derivation.energies import tree_energies
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.kinematics import Acceleration, Kinematics
from chassym.derivation.loads import Loads, project
from chassym.derivation.mass_matrix import mass_matrix
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import Measured
from chassym.derivation.program import Program
from chassym.derivation.rotation import rotation
from chassym.derivation.system import System
from chassym.derivation.table import knotted_part
from chassym.derivation.vector import (
    ZERO,
    SymmetricTensor,
    Vector,
    add,
    cross,
    dot,
    scale,
    vector,
)
from chassym.derivation.wrench import NO_WRENCH, Wrench


@singledispatch
def derive(system: System) -> EquationsOfMotion:
    """Derive M(q, p) q'' + h(q, q', p) = Q(q, q', u, u', p) of a mechanism or a Lagrangian.

    Raises
    ------
    MechanismError
        If a body at the end of the tree has no mass, or a coordinate moves none.
    TypeError
        If it is nothing that has equations of motion.
    """
    raise TypeError(
        f"{type(system).__qualname__} has no equations of motion; expected a Mechanism or a Lagrangian"
    )


@derive.register
def _of_mechanism(mechanism: Mechanism) -> EquationsOfMotion:
    """The equations of a tree of bodies."""
    mechanism = mechanism.snapshot()
    mechanism.check()
    start = time.perf_counter()
    program = Program()
    kinematics = Kinematics(program, mechanism.bodies)
    weight = vector([0, 0, mechanism.gravity])
    matrix = mass_matrix(kinematics)
    drift = kinematics.accelerations(lambda coordinate: sympy.S.Zero, weight)
    bias = project(kinematics, [_inertial_wrench(kinematics, i, a) for i, a in enumerate(drift)])
    answers = {element.name: _answer(kinematics, element) for element in mechanism.elements}
    acting = {element: answers[element.name].force for element in mechanism.elements}
    generalized_forces = _generalized_forces(kinematics, mechanism, acting)
    duration = time.perf_counter() - start
    forces = {name: answer.force for name, answer in answers.items()}
    motion = kinematics.accelerations(lambda coordinate: coordinate.acceleration, ZERO)
    measured = Measured(kinematics, motion, forces)
    return EquationsOfMotion(
        system=mechanism,
        program=program,
        mass_matrix=matrix,
        bias=tuple(program.let(h) for h in bias.values()),
        generalized_forces=tuple(generalized_forces),
        elements=answers,
        outputs={output.name: program.let(output.expression(measured)) for output in mechanism.outputs},
        energies=tree_energies(
            kinematics, mechanism, answers, _remaining_forces(kinematics, mechanism, answers)
        ),
        singularities=_singularities(kinematics, mechanism.bodies),
        derivation_s=duration,
    )


def _answer(kinematics: Kinematics, element: ForceElement) -> ElementAnswer:
    """Deflection, rate and force of an element, each under a name of the program."""
    program, preload = kinematics.program, element.constant_force
    deflection = program.assign(element.port.deflection(kinematics))
    rate = program.assign(element.port.rate(kinematics))
    force = program.assign(element.characteristic.force(program, deflection, rate, preload))
    law = knotted_part(element.characteristic)
    tabulated = force if law is None else law.value(program, deflection, rate)
    return ElementAnswer(deflection, rate, force, tabulated)


def _generalized_forces(
    kinematics: Kinematics, mechanism: Mechanism, forces: Mapping[ForceElement, sympy.Expr]
) -> list[sympy.Expr]:
    """Generalised forces of the applied loads and of some resisting forces of elements."""
    loads = Loads(kinematics)
    for element, force in forces.items():
        element.port.resist(loads, force)
    for load in mechanism.applied:
        vector_of_load = scale(kinematics.program, load.input.position, load.axis)
        if isinstance(load, AppliedForce):
            loads.add_force(load.point, load.axes, vector_of_load)
        else:
            loads.add_torque(load.body, load.axes, vector_of_load)
    return loads.generalized_forces()


def _remaining_forces(
    kinematics: Kinematics, mechanism: Mechanism, answers: Mapping[str, ElementAnswer]
) -> list[sympy.Expr]:
    """Generalised forces of what has neither an energy nor a dissipation function."""
    remaining = {}
    for element in mechanism.elements:
        answer, law = answers[element.name], element.characteristic
        rest = law.remainder(kinematics.program, answer.deflection, answer.rate, element.constant_force)
        if rest != 0:
            remaining[element] = rest
    return _generalized_forces(kinematics, mechanism, remaining)


def _singularities(kinematics: Kinematics, bodies: Sequence[Body]) -> dict[str, sympy.Expr]:
    """For every body on three rotations in a row how far they are from losing a degree of freedom.

    The determinant of their axes, a1 x a2 . R2 a3 with R2 the second rotation: -1 to 1, zero where they are
    singular; the cosine of the second angle, or its sine, where the axes are those of the frame.
    """
    program, found = kinematics.program, {}
    for body in bodies:
        if sequence := rotation_sequence(body):
            first, second, third = sequence
            turned = rotation(program, second.axis, second.coordinate.position).to_parent(program, third.axis)
            normal = cross(program, first.axis, second.axis)
            found[body.name] = program.let(dot(normal, turned))
    return found


def _inertial_wrench(kinematics: Kinematics, index: int, motion: Acceleration) -> Wrench:
    """What the accelerations of one body ask for: force, and moment about its frame's origin.

    The moment about the mass centre is the integral of r x (D r) dm with D the acceleration's tensor, so it
    follows from D times the second moments of mass J = tr(I)/2 - I.
    """
    program, mass, inertia = kinematics.program, kinematics.mass(index), kinematics.inertia(index)
    if not any((mass, *inertia.components())):
        return NO_WRENCH
    centre = kinematics.mass_centre(index)
    force = scale(program, mass, motion.of_point(program, centre))
    second = _second_moments(program, inertia)
    spin = [
        [sympy.Add(*(d * j for d, j in zip(row, column, strict=True))) for column in second]
        for row in motion.tensor
    ]
    moment = vector([program.let(spin[k][j] - spin[j][k]) for j, k in ((1, 2), (2, 0), (0, 1))])
    return Wrench(force, add(program, moment, cross(program, centre, force)))


def _second_moments(program: Program, inertia: SymmetricTensor) -> tuple[Vector, Vector, Vector]:
    """J = tr(I)/2 - I, by rows."""
    half_trace = program.let((inertia.xx + inertia.yy + inertia.zz) / 2)
    rows = inertia.rows()
    first, second, third = (
        vector([program.let((half_trace if i == j else 0) - rows[i][j]) for j in range(3)]) for i in range(3)
    )
    return first, second, third
