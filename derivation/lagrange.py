"""Lagrange's equations of a mechanism, body by body on a straight-line program.

For a rigid body with partial velocities v_i = dv/dq_i' and w_i = dw/dq_i', Lagrange's d/dt(dT/dq_i') -
dT/dq_i equals v_i . m a + w_i . (I alpha + w x I w) (Kane and Levinson, Dynamics: Theory and Applications,
1985, section 5.7). What multiplies the second derivatives is the mass matrix; the rest, with the weights, is
the bias h. Both are summed over the bodies down the tree, so nothing is expanded and nothing differentiated.
"""

from __future__ import annotations

import time

import sympy

from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.kinematics import NO_WRENCH, Acceleration, Kinematics, Wrench
from chassym.derivation.loads import Loads, project
from chassym.derivation.mass_matrix import mass_matrix
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import Measured
from chassym.derivation.program import Program
from chassym.derivation.vector import (
    ZERO,
    SymmetricTensor,
    Vector,
    add,
    cross,
    scale,
    vector,
)


def derive(mechanism: Mechanism) -> EquationsOfMotion:
    """Derive M(q, p) q'' + h(q, q', p) = Q(q, q', u, u', p).

    Raises
    ------
    MechanismError
        If a coordinate moves no mass.
    """
    start = time.perf_counter()
    program = Program()
    kinematics = Kinematics(program, mechanism.bodies)
    weight = vector([0, 0, mechanism.gravity])
    matrix = mass_matrix(kinematics)
    drift = kinematics.accelerations(lambda coordinate: sympy.S.Zero, weight)
    bias = project(kinematics, [_inertial_wrench(kinematics, i, a) for i, a in enumerate(drift)])
    loads, forces, rates = Loads(kinematics), {}, {}
    for element in mechanism.elements:
        deflection = element.port.deflection(kinematics)
        rates[element.name] = program.assign(element.port.rate(kinematics))
        law = element.characteristic.force(program, deflection, rates[element.name])
        forces[element.name] = program.assign(law + (element.preload or 0))
        element.port.resist(loads, forces[element.name])
    generalized_forces = loads.generalized_forces()
    duration = time.perf_counter() - start
    motion = kinematics.accelerations(lambda coordinate: coordinate.acceleration, ZERO)
    measured = Measured(kinematics, motion, forces)
    return EquationsOfMotion(
        mechanism=mechanism,
        program=program,
        mass_matrix=matrix,
        bias=tuple(program.let(h) for h in bias.values()),
        generalized_forces=tuple(generalized_forces),
        element_forces=forces,
        element_rates=rates,
        outputs={output.name: program.let(output.expression(measured)) for output in mechanism.outputs},
        derivation_s=duration,
    )


def _inertial_wrench(kinematics: Kinematics, index: int, motion: Acceleration) -> Wrench:
    """What the accelerations of one body ask for: force, and moment about its frame's origin.

    The moment about the mass centre is the integral of r x (D r) dm with D the acceleration's tensor, so it
    follows from D times the second moments of mass J = tr(I)/2 - I.
    """
    body = kinematics.links[index].body
    if body is None or not any((body.mass, *body.inertia.components())):
        return NO_WRENCH
    program = kinematics.program
    centre = kinematics.mass_centre(index)
    force = scale(program, body.mass, motion.of_point(program, centre))
    second = _second_moments(program, body.inertia)
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
