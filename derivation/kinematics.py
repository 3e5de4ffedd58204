"""Where things are and how they move: recursions along the tree of elementary joint steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.joint import Coordinate, MechanismError, Step
from chassym.derivation.program import Program
from chassym.derivation.vector import (
    ZERO,
    AxisRotation,
    Vector,
    add,
    cross,
    matrix_times,
    negative,
    scale,
    unit,
    vector,
)


@dataclass(frozen=True)
class Link:
    """One elementary step of the tree, a frame of its own; only the last of a joint carries the body."""

    parent: int | None
    offset: Vector
    step: Step | None
    rotation: AxisRotation | None
    body: Body | None


@dataclass(frozen=True)
class Acceleration:
    """Acceleration of a frame, in its own axes: of its origin, and the tensor that adds what an offset adds.

    A point at r from the origin accelerates with ``origin + tensor r``,
    ``tensor r = alpha x r + omega x (omega x r)``.
    """

    angular: Vector
    origin: Vector
    tensor: tuple[Vector, Vector, Vector]

    def of_point(self, program: Program, r: Vector) -> Vector:
        """Acceleration of the point at r."""
        return add(program, self.origin, matrix_times(program, self.tensor, r))


class Kinematics:
    """The tree of a mechanism's frames on a straight-line program.

    Vectors stand in the axes of the frame they belong to. Source of the recursions: relative motion of rigid
    bodies, e.g. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 4, written with ordinary
    vectors.
    """

    def __init__(self, program: Program, bodies: Sequence[Body]) -> None:
        self.program = program
        self.links: list[Link] = []
        self._last: dict[Body, int] = {}
        for body in bodies:
            self._append(body)
        self.angular_velocity: list[Vector] = []
        for link in self.links:
            self.angular_velocity.append(self._angular_velocity(link))

    def _append(self, body: Body) -> None:
        """The links of one body's joint."""
        parent = self._last.get(body.parent) if body.parent is not None else None
        start = body.parent.origin if parent is not None and body.parent is not None else ZERO
        offset = vector([self.program.let(a - b) for a, b in zip(body.origin, start, strict=True)])
        steps: list[Step | None] = list(body.joint.steps) or [None]
        for step in steps:
            owner = body if step is steps[-1] else None
            self.links.append(Link(parent, offset, step, self._rotation(step), owner))
            parent, offset = len(self.links) - 1, ZERO
        self._last[body] = len(self.links) - 1

    def _rotation(self, step: Step | None) -> AxisRotation | None:
        if step is None or not step.is_rotation:
            return None
        angle = step.coordinate.position
        return AxisRotation(step.axis, self.program.let(sympy.cos(angle)), self.program.let(sympy.sin(angle)))

    def _angular_velocity(self, link: Link) -> Vector:
        inherited = self.to_child(link, ZERO if link.parent is None else self.angular_velocity[link.parent])
        if link.rotation is None or link.step is None:
            return inherited
        return add(self.program, inherited, self._along(link.step, link.step.coordinate.rate))

    def _along(self, step: Step, amount: sympy.Expr) -> Vector:
        return scale(self.program, amount, unit(step.axis))

    def link_of(self, body: Body) -> int | None:
        """The last link of a body; None for the ground.

        Raises
        ------
        MechanismError
            If the body belongs to another mechanism.
        """
        if body.parent is None:
            return None
        if body not in self._last:
            raise MechanismError(f"body {body.name!r} is not in this mechanism; add it, or use one that is")
        return self._last[body]

    def to_child(self, link: Link, a: Vector) -> Vector:
        """A vector of the parent's axes in the link's own."""
        return a if link.rotation is None else link.rotation.to_child(self.program, a)

    def to_parent(self, link: Link, a: Vector) -> Vector:
        """A vector of the link's own axes in its parent's."""
        return a if link.rotation is None else link.rotation.to_parent(self.program, a)

    def displacement(self, link: Link) -> Vector:
        """Position of the link's origin in its parent's frame."""
        if link.step is None or link.step.is_rotation:
            return link.offset
        return add(self.program, link.offset, self._along(link.step, link.step.coordinate.position))

    def path(self, body: Body, frame: Body) -> list[Link]:
        """The links from a body up to, and without, those of a frame's body.

        Raises
        ------
        MechanismError
            If the frame is neither the ground nor an ancestor of the body.
        """
        stop, index = self.link_of(frame), self.link_of(body)
        links = []
        while index != stop:
            if index is None:
                raise MechanismError(
                    f"motion of {body.name!r} seen from {frame.name!r}: the frame must be the ground or a "
                    f"body that {body.name!r} is jointed to, directly or through others"
                )
            links.append(self.links[index])
            index = self.links[index].parent
        return links

    def rotated(self, a: Vector, body: Body, frame: Body) -> Vector:
        """A vector of a body's axes in those of a frame that the body is jointed to."""
        for link in self.path(body, frame):
            a = self.to_parent(link, a)
        return a

    def rotated_back(self, a: Vector, frame: Body, body: Body) -> Vector:
        """A vector of a frame's axes in those of a body jointed to it."""
        for link in reversed(self.path(body, frame)):
            a = self.to_child(link, a)
        return a

    def to_ground(self, index: int | None) -> Iterator[Link]:
        """A link and all between it and the ground."""
        while index is not None:
            yield self.links[index]
            index = self.links[index].parent

    def mass_centre(self, index: int) -> Vector:
        """Mass centre of a link's body in the link's frame; the origin for a link without a body."""
        body = self.links[index].body
        if body is None:
            return ZERO
        pairs = zip(body.mass_centre, body.origin, strict=True)
        return vector([self.program.let(a - b) for a, b in pairs])

    def arm(self, point: Point) -> Vector:
        """Position of a point in its own body's frame."""
        pairs = zip(point.position, point.body.origin, strict=True)
        return vector([self.program.let(a - b) for a, b in pairs])

    def position(self, point: Point, frame: Body) -> Vector:
        """Position of a point in the frame of a body its own body is jointed to."""
        return self._seen_from(point, frame)[0]

    def velocity(self, point: Point, frame: Body) -> Vector:
        """Velocity of a point as an observer on that frame sees it."""
        return self._seen_from(point, frame)[1]

    def _seen_from(self, point: Point, frame: Body) -> tuple[Vector, Vector]:
        program, position, velocity = self.program, self.arm(point), ZERO
        for link in self.path(point.body, frame):
            position, velocity = self.to_parent(link, position), self.to_parent(link, velocity)
            if link.step is not None:
                rate = self._along(link.step, link.step.coordinate.rate)
                own = cross(program, rate, position) if link.step.is_rotation else rate
                velocity = add(program, velocity, own)
            position = add(program, position, self.displacement(link))
        return position, velocity

    def accelerations(
        self, second_derivative: Callable[[Coordinate], sympy.Expr], base: Vector
    ) -> list[Acceleration]:
        """Acceleration of every link's frame.

        Parameters
        ----------
        second_derivative
            What stands for a coordinate's acceleration: its symbol, or zero for the velocity-dependent part
            alone.
        base
            Acceleration given to the ground (m/s^2): minus gravity's makes weights appear as inertial forces.
        """
        found: list[Acceleration] = []
        still = Acceleration(ZERO, base, (ZERO, ZERO, ZERO))
        for index, link in enumerate(self.links):
            parent = still if link.parent is None else found[link.parent]
            found.append(self._acceleration(index, link, parent, second_derivative))
        return found

    def _acceleration(
        self,
        index: int,
        link: Link,
        parent: Acceleration,
        second_derivative: Callable[[Coordinate], sympy.Expr],
    ) -> Acceleration:
        program = self.program
        angular = self.to_child(link, parent.angular)
        origin = parent.of_point(program, self.displacement(link))
        if link.step is not None:
            rate = self._along(link.step, link.step.coordinate.rate)
            own = self._along(link.step, second_derivative(link.step.coordinate))
            if link.step.is_rotation:
                # The axis is fixed in both frames, so the frame's own spin adds nothing to this product.
                angular = add(program, angular, cross(program, self.angular_velocity[index], rate), own)
            else:
                twice = scale(program, sympy.Integer(2), cross(program, self.angular_velocity[index], rate))
                origin = add(program, origin, twice, own)
        return Acceleration(angular, self.to_child(link, origin), self._tensor(index, angular))

    def _tensor(self, index: int, alpha: Vector) -> tuple[Vector, Vector, Vector]:
        """The matrix [alpha x] + [omega x]^2."""
        let, (x, y, z) = self.program.let, self.angular_velocity[index]
        xx, yy, zz = let(x * x), let(y * y), let(z * z)
        xy, xz, yz = let(x * y), let(x * z), let(y * z)
        return (
            vector([let(-yy - zz), let(xy - alpha[2]), let(xz + alpha[1])]),
            vector([let(xy + alpha[2]), let(-xx - zz), let(yz - alpha[0])]),
            vector([let(xz - alpha[1]), let(yz + alpha[0]), let(-xx - yy)]),
        )


@dataclass(frozen=True)
class Wrench:
    """A force and a moment about a frame's origin, in the frame's axes."""

    force: Vector
    moment: Vector

    def plus(self, program: Program, other: Wrench) -> Wrench:
        """Sum of two wrenches on one frame."""
        return Wrench(add(program, self.force, other.force), add(program, self.moment, other.moment))


NO_WRENCH = Wrench(ZERO, ZERO)


def at(program: Program, position: Vector, force: Vector) -> Wrench:
    """The wrench of a force that acts at a position."""
    return Wrench(force, cross(program, position, force))


def to_parent(kinematics: Kinematics, link: Link, wrench: Wrench) -> Wrench:
    """The same wrench about the origin, and in the axes, of the link's parent."""
    program = kinematics.program
    force = kinematics.to_parent(link, wrench.force)
    moment = kinematics.to_parent(link, wrench.moment)
    shifted = cross(program, kinematics.displacement(link), force)
    return Wrench(force, add(program, moment, shifted))


def component(step: Step, wrench: Wrench) -> sympy.Expr:
    """What a wrench on a link's frame does to the link's own coordinate."""
    chosen = wrench.moment if step.is_rotation else wrench.force
    return sympy.Add(*(a * b for a, b in zip(unit(step.axis), chosen, strict=True)))


def opposite(wrench: Wrench) -> Wrench:
    """The reaction."""
    return Wrench(negative(wrench.force), negative(wrench.moment))
