"""Lagrange's equations of a mechanism, body by body on a straight-line program.

For a rigid body with partial velocities v_i = dv/dq_i' and w_i = dw/dq_i', Lagrange's d/dt(dT/dq_i') - dT/dq_i equals
v_i . m a + w_i . (I alpha + w x I w) (Kane and Levinson, Dynamics: Theory and Applications, 1985, section 5.7). What
multiplies the second derivatives is the mass matrix; the rest, with the weights, is the bias h. Both are summed over the
bodies down the tree, so nothing is expanded and nothing differentiated.
"""

from __future__ import annotations

import time

import sympy

from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.joint import MechanismError
from chassym.derivation.kinematics import NO_WRENCH, Acceleration, Kinematics, Wrench, component, to_parent
from chassym.derivation.loads import Loads, project
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import Measured
from chassym.derivation.program import Program
from chassym.derivation.vector import (
    ZERO,
    SymmetricTensor,
    Vector,
    add,
    cross,
    diagonal,
    scale,
    unit,
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
    mass_matrix = _mass_matrix(kinematics)
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
        mass_matrix=mass_matrix,
        bias=tuple(program.let(h) for h in bias.values()),
        generalized_forces=tuple(generalized_forces),
        element_forces=forces,
        element_rates=rates,
        outputs={output.name: program.let(output.expression(measured)) for output in mechanism.outputs},
        derivation_s=duration,
    )


def _inertial_wrench(kinematics: Kinematics, index: int, motion: Acceleration) -> Wrench:
    """What the accelerations of one body ask for: force, and moment about its frame's origin.

    The moment about the mass centre is the integral of r x (D r) dm with D the acceleration's tensor, so it follows
    from D times the second moments of mass J = tr(I)/2 - I.
    """
    body = kinematics.links[index].body
    if body is None or body.mass == 0:
        return NO_WRENCH
    program = kinematics.program
    centre = _mass_centre(kinematics, index)
    force = scale(program, body.mass, motion.of_point(program, centre))
    second = _second_moments(program, body.inertia)
    spin = [[sympy.Add(*(d * j for d, j in zip(row, column, strict=True))) for column in second] for row in motion.tensor]
    moment = vector([program.let(spin[k][j] - spin[j][k]) for j, k in ((1, 2), (2, 0), (0, 1))])
    return Wrench(force, add(program, moment, cross(program, centre, force)))


def _mass_centre(kinematics: Kinematics, index: int) -> Vector:
    body = kinematics.links[index].body
    if body is None:
        return ZERO
    return vector([kinematics.program.let(a - b) for a, b in zip(body.mass_centre, body.origin, strict=True)])


def _second_moments(program: Program, inertia: SymmetricTensor) -> tuple[Vector, Vector, Vector]:
    """J = tr(I)/2 - I, by rows."""
    half_trace = program.let((inertia.xx + inertia.yy + inertia.zz) / 2)
    rows = inertia.rows()
    return tuple(
        vector([program.let((half_trace if i == j else 0) - rows[i][j]) for j in range(3)]) for i in range(3)
    )  # type: ignore[return-value]


class _Composite:
    """Mass, first moment and inertia about a frame's origin of all that hangs on the frame."""

    def __init__(self, mass: sympy.Expr, first: Vector, inertia: SymmetricTensor) -> None:
        self.mass, self.first, self.inertia = mass, first, inertia

    def plus(self, program: Program, other: _Composite) -> _Composite:
        """Two sets of bodies together."""
        return _Composite(
            program.let(self.mass + other.mass),
            add(program, self.first, other.first),
            self.inertia.plus(program, other.inertia),
        )

    def seen_from_parent(self, kinematics: Kinematics, index: int) -> _Composite:
        """The same bodies about the origin, and in the axes, of the link's parent."""
        link, program = kinematics.links[index], kinematics.program
        first, inertia = self.first, self.inertia
        if link.rotation is not None:
            first = link.rotation.to_parent(program, first)
            inertia = link.rotation.tensor_to_parent(program, inertia)
        r = kinematics.displacement(link)
        shifted = add(program, first, scale(program, self.mass, r))
        # Parallel axes: the product of inertia with a shifted origin is linear in the old and the new first moment.
        steiner = _parallel_axes(program, r, first, shifted)
        return _Composite(self.mass, shifted, inertia.plus(program, steiner))


def _parallel_axes(program: Program, r: Vector, old: Vector, new: Vector) -> SymmetricTensor:
    """Inertia that a shift of the origin by -r adds, first moments before and after given.

    The second moments grow by r old^T + old r^T + m r r^T = r old^T + new r^T.
    """
    let = program.let
    xx, yy, zz = (let(r[i] * let(old[i] + new[i])) for i in range(3))
    products = [let(-let(r[i] * old[j]) - let(new[i] * r[j])) for i, j in ((0, 1), (0, 2), (1, 2))]
    return SymmetricTensor(let(yy + zz), let(xx + zz), let(xx + yy), *products)


def _mass_matrix(kinematics: Kinematics) -> tuple[tuple[sympy.Expr, ...], ...]:
    """Composite bodies up the tree, then the wrench of a unit acceleration of each coordinate down its path."""
    program, links = kinematics.program, kinematics.links
    composites = [_own(kinematics, i) for i in range(len(links))]
    for index in reversed(range(len(links))):
        parent = links[index].parent
        if parent is not None:
            composites[parent] = composites[parent].plus(program, composites[index].seen_from_parent(kinematics, index))
    order = {link.step.coordinate: i for i, link in enumerate(l for l in links if l.step is not None)}  # type: ignore[union-attr]
    entries = {}
    for index, link in enumerate(links):
        if link.step is not None:
            for coordinate, value in _column(kinematics, index, composites[index]).items():
                i, j = order[link.step.coordinate], order[coordinate]
                entries[i, j] = entries[j, i] = value
            if entries[i, i] == 0:
                raise MechanismError(f"coordinate {link.step.coordinate.name!r} moves no mass; give its body a mass or inertia")
    n = len(order)
    return tuple(tuple(entries.get((i, j), sympy.S.Zero) for j in range(n)) for i in range(n))


def _own(kinematics: Kinematics, index: int) -> _Composite:
    """Mass properties of one link's body about the link's origin."""
    body, program = kinematics.links[index].body, kinematics.program
    if body is None:
        return _Composite(sympy.S.Zero, ZERO, diagonal(*ZERO))
    centre = _mass_centre(kinematics, index)
    first = scale(program, body.mass, centre)
    return _Composite(body.mass, first, body.inertia.plus(program, _parallel_axes(program, centre, ZERO, first)))


def _column(kinematics: Kinematics, index: int, composite: _Composite) -> dict:
    """Mass-matrix entries of one coordinate with itself and with every coordinate below it in the tree."""
    link, program = kinematics.links[index], kinematics.program
    assert link.step is not None
    axis = unit(link.step.axis)
    if link.step.is_rotation:
        wrench = Wrench(cross(program, axis, composite.first), composite.inertia.times(program, axis))
    else:
        wrench = Wrench(scale(program, composite.mass, axis), cross(program, composite.first, axis))
    entries = {}
    while True:
        if link.step is not None:
            entries[link.step.coordinate] = program.let(component(link.step, wrench))
        if link.parent is None:
            return entries
        wrench = to_parent(kinematics, link, wrench)
        link = kinematics.links[link.parent]
