"""A mechanism's equations by sympy.physics.mechanics, from the data of its bodies and joints alone.

Frames, points and rigid bodies are laid out from the mechanism's design positions, masses, inertias and joint
steps; nothing of the package's kinematics is used. `by_kane` and `by_lagrange` are two ways from there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import sympy
from sympy.physics import mechanics
from sympy.physics.mechanics import (
    Dyadic,
    KanesMethod,
    LagrangesMethod,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
)

from chassym.derivation import Body, Mechanism

Vector = mechanics.Vector
Place = Sequence[float | sympy.Expr]
Tensor = Sequence[Sequence[float | sympy.Expr]]
Load = tuple[mechanics.Point | ReferenceFrame, Vector]


@dataclass(frozen=True)
class Textbook:
    """M q'' = forcing in plain symbols named as in the package, so that forcing is its Q - h."""

    mass_matrix: sympy.Matrix
    forcing: sympy.Matrix


@dataclass(frozen=True)
class Layout:
    """A mechanism in sympy's frames and points, filled body by body.

    Attributes
    ----------
    gravity
        Acceleration of free fall, along -Z.
    frames, origins, designs
        Frame of every body by its name, the ground included, its origin and the origin's design position.
    bodies
        The rigid bodies, in order.
    coordinates, rates
        Functions of time; a rate is a function of its own or the derivative of its coordinate.
    """

    gravity: sympy.Expr
    frames: dict[str, ReferenceFrame] = field(default_factory=dict)
    origins: dict[str, mechanics.Point] = field(default_factory=dict)
    designs: dict[str, Place] = field(default_factory=dict)
    bodies: list[RigidBody] = field(default_factory=list)
    coordinates: list[sympy.Expr] = field(default_factory=list)
    rates: list[sympy.Expr] = field(default_factory=list)

    @property
    def ground(self) -> ReferenceFrame:
        """The inertial frame."""
        return self.frames["ground"]

    @property
    def kinetic_energy(self) -> sympy.Expr:
        """T of all bodies."""
        return sum(body.kinetic_energy(self.ground) for body in self.bodies)

    @property
    def weight_energy(self) -> sympy.Expr:
        """Potential energy of the weights."""
        heights = [self.place(body.masscenter).dot(self.ground.z) for body in self.bodies]
        return sum(b.mass * self.gravity * z for b, z in zip(self.bodies, heights, strict=True))

    def place(self, point: mechanics.Point) -> Vector:
        """Give the position of a point from the ground's origin."""
        return point.pos_from(self.origins["ground"])

    def point(self, body: str, design: Place) -> mechanics.Point:
        """Give the point of a body at a design position, with its velocity in the ground frame."""
        arm = along(self.frames[body], [a - b for a, b in zip(design, self.designs[body], strict=True)])
        return fixed_point(f"{body}{tuple(design)}", self.origins[body], arm, self.frames[body], self.ground)


def along(frame: ReferenceFrame, components: Place) -> Vector:
    """Give a vector by its components in a frame."""
    return sum((c * axis for c, axis in zip(components, frame, strict=True)), 0 * frame.x)


def fixed_point(
    name: str, origin: mechanics.Point, arm: Vector, frame: ReferenceFrame, ground: ReferenceFrame
) -> mechanics.Point:
    """Give a point fixed in a frame: v = v_origin + omega x arm."""
    point = origin.locatenew(name, arm)
    point.set_vel(ground, origin.vel(ground) + frame.ang_vel_in(ground).cross(arm))
    return point


def dyadic(frame: ReferenceFrame, tensor: Tensor) -> Dyadic:
    """Give an inertia tensor, by rows in the axes of a frame, as sympy's dyadic."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = tensor
    return mechanics.inertia(frame, xx, yy, zz, ixy=xy, iyz=yz, izx=xz)


def lay_out(
    mechanism: Mechanism,
    *,
    own_rates: bool,
    inertias: Mapping[str, tuple[Tensor, Place]] | None = None,
) -> Layout:
    """Lay a mechanism out.

    Parameters
    ----------
    own_rates
        Whether rates are functions of time of their own, as Kane's method wants them, or derivatives.
    inertias
        For some bodies, by name, an inertia tensor and the design position that it is about, to use instead
        of the one about the mass centre; sympy shifts it by the parallel-axis theorem.
    """
    layout, ground = Layout(mechanism.gravity), ReferenceFrame("ground")
    layout.frames["ground"], layout.designs["ground"] = ground, (0, 0, 0)
    layout.origins["ground"] = mechanics.Point("ground")
    layout.origins["ground"].set_vel(ground, 0)
    for body in mechanism.bodies:
        _step_along(layout, body, own_rates)
        tensor, about = (inertias or {}).get(body.name, (body.inertia.rows(), body.mass_centre))
        layout.bodies.append(_rigid_body(layout, body, tensor, about))
    return layout


def _step_along(layout: Layout, body: Body, own_rates: bool) -> None:
    """Add the frame and the origin of a body: the parent's, moved by the steps of the joint."""
    ground, parent = layout.ground, body.parent.name
    frame, origin = layout.frames[parent], layout.point(parent, body.origin)
    for step in body.joint.steps:
        name = step.coordinate.name
        q = dynamicsymbols(name)
        rate = dynamicsymbols(f"{name}_rate") if own_rates else q.diff()
        layout.coordinates.append(q)
        layout.rates.append(rate)
        axis = along(frame, [_short(c) for c in step.axis])
        if step.is_rotation:
            turned = ReferenceFrame(name)
            turned.orient_axis(frame, axis, q)
            turned.set_ang_vel(frame, rate * axis)
            frame = turned
        else:
            slid = fixed_point(name, origin, q * axis, frame, ground)
            slid.set_vel(ground, slid.vel(ground) + rate * axis)
            origin = slid
    # In the body's own axes the expressions stay short.
    frame.set_ang_vel(ground, frame.ang_vel_in(ground).express(frame))
    origin.set_vel(ground, origin.vel(ground).express(frame))
    layout.frames[body.name], layout.origins[body.name] = frame, origin
    layout.designs[body.name] = body.origin


def _short(component: sympy.Expr) -> sympy.Expr:
    """A component of a unit vector without nested roots."""
    return component if component.is_Integer else component.evalf()


def _rigid_body(layout: Layout, body: Body, tensor: Tensor, about: Place) -> RigidBody:
    frame, centre = layout.frames[body.name], layout.point(body.name, body.mass_centre)
    arm = along(frame, [a - b for a, b in zip(about, body.mass_centre, strict=True)])
    inertia = dyadic(frame, tensor), centre.locatenew(f"{body.name}_inertia", arm)
    return RigidBody(body.name, centre, frame, body.mass, inertia)


def by_lagrange(layout: Layout, potential: sympy.Expr = sympy.S.Zero, loads: Sequence[Load] = ()) -> Textbook:
    """Form d/dt(dL/dq') - dL/dq = Q with a further potential energy and with loads on points and frames."""
    lagrangian = layout.kinetic_energy - layout.weight_energy - potential
    method = LagrangesMethod(lagrangian, layout.coordinates, forcelist=list(loads), frame=layout.ground)
    method.form_lagranges_equations()
    plain = plain_symbols(layout)
    return Textbook(method.mass_matrix.xreplace(plain), method.forcing.xreplace(plain))


def by_kane(layout: Layout, potential: sympy.Expr = sympy.S.Zero, loads: Sequence[Load] = ()) -> Textbook:
    """Form F_r + F_r* = 0 with u = q'; the potential energies give -dV/dq."""
    kinematic = [rate - q.diff() for q, rate in zip(layout.coordinates, layout.rates, strict=True)]
    method = KanesMethod(layout.ground, layout.coordinates, layout.rates, kd_eqs=kinematic)
    method.kanes_equations(layout.bodies, list(loads) or None)
    energy = sympy.Matrix([layout.weight_energy + potential])
    forcing = method.forcing - energy.jacobian(layout.coordinates).T
    plain = plain_symbols(layout)
    return Textbook(method.mass_matrix.xreplace(plain), forcing.xreplace(plain))


def plain_symbols(layout: Layout) -> dict[sympy.Expr, sympy.Symbol]:
    """Give the package's symbols for coordinates and rates, which are functions of time here."""
    names = [q.func.__name__ for q in layout.coordinates]
    positions = {q: sympy.Symbol(name, real=True) for q, name in zip(layout.coordinates, names, strict=True)}
    rates = {v: sympy.Symbol(f"{name}_rate", real=True) for v, name in zip(layout.rates, names, strict=True)}
    return rates | positions
