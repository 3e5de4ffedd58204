"""Where things are and how they move: recursions along the tree of elementary joint steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate, Step
from chassym.derivation.program import Program
from chassym.derivation.rotation import Rotation, rotation
from chassym.derivation.vector import (
    ZERO,
    SymmetricTensor,
    Vector,
    add,
    cross,
    diagonal,
    matrix_times,
    scale,
    subtract,
    vector,
)


@dataclass(frozen=True)
class Link:
    """One elementary step of the tree, a frame of its own; only the last of a joint carries the body."""

    parent: int | None
    offset: Vector
    step: Step | None
    rotation: Rotation | None
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
        self._seen: dict[tuple[Point, Body], tuple[Vector, Vector]] = {}
        for body in bodies:
            self._append(body)
        self.angular_velocity: list[Vector] = []
        for link in self.links:
            self.angular_velocity.append(self._angular_velocity(link))

    def _append(self, body: Body) -> None:
        """The links of one body's joint."""
        parent = self._last.get(body.parent) if body.parent is not None else None
        start = body.parent.origin if parent is not None and body.parent is not None else ZERO
        offset = self._between(start, body.origin)
        steps: list[Step | None] = list(body.joint.steps) or [None]
        for step in steps:
            owner = body if step is steps[-1] else None
            self.links.append(Link(parent, offset, step, self._rotation(step), owner))
            parent, offset = len(self.links) - 1, ZERO
        self._last[body] = len(self.links) - 1

    def _rotation(self, step: Step | None) -> Rotation | None:
        if step is None or not step.is_rotation:
            return None
        return rotation(self.program, step.axis, step.coordinate.position)

    def _angular_velocity(self, link: Link) -> Vector:
        inherited = self.to_child(link, ZERO if link.parent is None else self.angular_velocity[link.parent])
        if link.rotation is None or link.step is None:
            return inherited
        return add(self.program, inherited, self._along(link.step, link.step.coordinate.rate))

    def _along(self, step: Step, amount: sympy.Expr) -> Vector:
        return scale(self.program, amount, step.axis)

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

    def path(self, body: Body, frame: Body) -> tuple[list[Link], list[Link]]:
        """The links from a body up to where its way to the ground meets a frame's, and down to the frame.

        Raises
        ------
        MechanismError
            If the body or the frame belongs to another mechanism.
        """
        down = self._indices(frame)
        up = [index for index in self._indices(body) if index not in down]
        met = self.links[up[-1]].parent if up else self.link_of(body)
        down = down[: down.index(met)] if met is not None else down
        return [self.links[index] for index in up], [self.links[index] for index in reversed(down)]

    def _indices(self, body: Body) -> list[int]:
        """The links between a body and the ground, its own first."""
        found, index = [], self.link_of(body)
        while index is not None:
            found.append(index)
            index = self.links[index].parent
        return found

    def rotated(self, a: Vector, body: Body, frame: Body) -> Vector:
        """A vector of a body's axes in those of a frame."""
        up, down = self.path(body, frame)
        for link in up:
            a = self.to_parent(link, a)
        for link in down:
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
        return ZERO if body is None else self._between(body.origin, body.mass_centre)

    def _between(self, start: Vector, end: Vector) -> Vector:
        """From one design position to another: expressions of parameters, of which bodies may share parts."""
        absorb = self.program.absorb
        return subtract(self.program, vector(map(absorb, end)), vector(map(absorb, start)))

    def mass(self, index: int) -> sympy.Expr:
        """Mass of a link's body; zero for a link without a body."""
        body = self.links[index].body
        return sympy.S.Zero if body is None else self.program.absorb(body.mass)

    def inertia(self, index: int) -> SymmetricTensor:
        """Inertia of a link's body about its mass centre; zero for a link without a body."""
        body = self.links[index].body
        components = diagonal(*ZERO).components() if body is None else body.inertia.components()
        return SymmetricTensor(*map(self.program.absorb, components))

    def arm(self, point: Point) -> Vector:
        """Position of a point in its own body's frame."""
        return self._between(point.body.origin, point.position)

    def position(self, point: Point, frame: Body) -> Vector:
        """Position of a point in the frame of a body."""
        return self._seen_from(point, frame)[0]

    def velocity(self, point: Point, frame: Body) -> Vector:
        """Velocity of a point as an observer on that frame sees it."""
        return self._seen_from(point, frame)[1]

    def _seen_from(self, point: Point, frame: Body) -> tuple[Vector, Vector]:
        if (point, frame) not in self._seen:
            self._seen[point, frame] = self._position_and_velocity(point, frame)
        return self._seen[point, frame]

    def _position_and_velocity(self, point: Point, frame: Body) -> tuple[Vector, Vector]:
        program, position, velocity = self.program, self.arm(point), ZERO
        up, down = self.path(point.body, frame)
        for link in up:
            position, velocity = self.to_parent(link, position), self.to_parent(link, velocity)
            velocity = add(program, velocity, self.own_velocity(link, position))
            position = add(program, position, self.displacement(link))
        for link in down:
            position = subtract(program, position, self.displacement(link))
            velocity = subtract(program, velocity, self.own_velocity(link, position))
            position, velocity = self.to_child(link, position), self.to_child(link, velocity)
        return position, velocity

    def own_velocity(self, link: Link, arm: Vector) -> Vector:
        """What a link's own step adds to the velocity of a point at an arm, in the parent's axes."""
        if link.step is None:
            return ZERO
        rate = self._along(link.step, link.step.coordinate.rate)
        return cross(self.program, rate, arm) if link.step.is_rotation else rate

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
