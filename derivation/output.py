"""Outputs: what is measured on a mechanism, each with its name and unit.

An axis is "x", "y", "z" or three components, in the axes of the body named `axes` (or `frame`). An observer
is the body from which the motion is seen.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import sympy

from chassym.derivation.body import GROUND, Body, Point
from chassym.derivation.direction import Direction, unit_vector
from chassym.derivation.element import ForceElement
from chassym.derivation.kinematics import Acceleration, Kinematics
from chassym.derivation.port import Port
from chassym.derivation.validation import expect
from chassym.derivation.vector import ZERO, Vector, add, cross, dot, scale, subtract


@dataclass(frozen=True)
class Measured:
    """What outputs may be read from: the motion of the frames and the force of every element by name."""

    kinematics: Kinematics
    accelerations: Sequence[Acceleration]
    forces: Mapping[str, sympy.Expr]

    def angular_velocity(self, body: Body) -> Vector:
        """Angular velocity of a body relative to the ground, in its own axes."""
        index = self.kinematics.link_of(body)
        return ZERO if index is None else self.kinematics.angular_velocity[index]

    def angular_acceleration(self, body: Body) -> Vector:
        """Angular acceleration of a body relative to the ground, in its own axes."""
        index = self.kinematics.link_of(body)
        return ZERO if index is None else self.accelerations[index].angular

    def acceleration(self, body: Body, place: Vector) -> Vector:
        """Acceleration relative to the ground, in a body's axes, of what is fixed to it at a place."""
        index = self.kinematics.link_of(body)
        return ZERO if index is None else self.accelerations[index].of_point(self.kinematics.program, place)

    def seen(self, own: Vector, body: Body, carried: Vector, observer: Body, axes: Body) -> Vector:
        """A body's own vector less the one its observer carries, both in the axes of a third body."""
        rotated = self.kinematics.rotated
        return subtract(self.kinematics.program, rotated(own, body, axes), rotated(carried, observer, axes))


@dataclass(frozen=True, eq=False)
class Output(ABC):
    """A measured quantity with its name and unit."""

    name: str

    @property
    @abstractmethod
    def unit(self) -> str:
        """SI unit."""

    @abstractmethod
    def expression(self, measured: Measured) -> sympy.Expr:
        """The quantity in the program's names."""

    def of_elements(self, changed: Mapping[ForceElement, ForceElement]) -> Output:
        """The same quantity where other elements take the place of some."""
        return self


class Directed(Output):
    """A component of a vector along the output's field `axis`."""

    axis: Direction

    def __post_init__(self) -> None:
        _ = self.direction
        kinds = {"point": Point, "body": Body, "frame": Body, "axes": Body, "observer": Body}
        for name in kinds.keys() & vars(self).keys():
            expect(f"output {self.name!r}: {name}", getattr(self, name), kinds[name])

    @property
    def direction(self) -> Vector:
        """Unit vector of the axis."""
        return unit_vector(self.axis, f"output {self.name!r}: axis")


@dataclass(frozen=True, eq=False)
class PointPosition(Directed):
    """Position of a point along an axis of a frame, from the frame's origin."""

    point: Point
    axis: Direction
    frame: Body
    unit = "m"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The position (m)."""
        return dot(self.direction, measured.kinematics.position(self.point, self.frame))


@dataclass(frozen=True, eq=False)
class PointDisplacement(Directed):
    """Displacement of a point from its design position along an axis of a frame."""

    point: Point
    axis: Direction
    frame: Body
    unit = "m"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The displacement (m)."""
        kinematics = measured.kinematics
        design = subtract(kinematics.program, self.point.position, self.frame.origin)
        moved = subtract(kinematics.program, kinematics.position(self.point, self.frame), design)
        return dot(self.direction, moved)


@dataclass(frozen=True, eq=False)
class PointVelocity(Directed):
    """Velocity of a point as an observer sees it, in the axes of a body."""

    point: Point
    axis: Direction
    axes: Body
    observer: Body = GROUND
    unit = "m/s"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The velocity (m/s)."""
        kinematics = measured.kinematics
        seen = kinematics.velocity(self.point, self.observer)
        return dot(self.direction, kinematics.rotated(seen, self.observer, self.axes))


@dataclass(frozen=True, eq=False)
class PointAcceleration(Directed):
    """Acceleration of a point as an observer sees it, in the axes of a body, without gravity."""

    point: Point
    axis: Direction
    axes: Body
    observer: Body = GROUND
    unit = "m/s^2"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The acceleration (m/s^2)."""
        own = measured.acceleration(self.point.body, measured.kinematics.arm(self.point))
        carried = self._carried(measured, self.observer)
        return dot(self.direction, measured.seen(own, self.point.body, carried, self.observer, self.axes))

    def _carried(self, measured: Measured, observer: Body) -> Vector:
        """What the observer's own motion adds: of the place where the point is, and Coriolis' part."""
        kinematics, program = measured.kinematics, measured.kinematics.program
        place = measured.acceleration(observer, kinematics.position(self.point, observer))
        spin, seen = measured.angular_velocity(observer), kinematics.velocity(self.point, observer)
        return add(program, place, scale(program, sympy.Integer(2), cross(program, spin, seen)))


@dataclass(frozen=True, eq=False)
class AngularVelocity(Directed):
    """Angular velocity of a body as an observer sees it, in the axes of a body."""

    body: Body
    axis: Direction
    axes: Body
    observer: Body = GROUND
    unit = "rad/s"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The angular velocity (rad/s)."""
        own, carried = measured.angular_velocity(self.body), measured.angular_velocity(self.observer)
        return dot(self.direction, measured.seen(own, self.body, carried, self.observer, self.axes))


@dataclass(frozen=True, eq=False)
class AngularAcceleration(Directed):
    """Angular acceleration of a body as an observer sees it, in the axes of a body."""

    body: Body
    axis: Direction
    axes: Body
    observer: Body = GROUND
    unit = "rad/s^2"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The angular acceleration (rad/s^2)."""
        own, carried = measured.angular_acceleration(self.body), self._carried(measured, self.observer)
        return dot(self.direction, measured.seen(own, self.body, carried, self.observer, self.axes))

    def _carried(self, measured: Measured, observer: Body) -> Vector:
        """The observer's own angular acceleration, and what its spin adds to the body's."""
        program, spin = measured.kinematics.program, measured.angular_velocity(observer)
        total = measured.kinematics.rotated(measured.angular_velocity(self.body), self.body, observer)
        turning = cross(program, spin, total)
        return add(program, measured.angular_acceleration(observer), turning)


@dataclass(frozen=True, eq=False)
class Deflection(Output):
    """Deflection of a port."""

    port: Port

    def __post_init__(self) -> None:
        expect(f"output {self.name!r}: port", self.port, Port)

    @property
    def unit(self) -> str:
        """Unit of the port's deflection."""
        return self.port.unit

    def expression(self, measured: Measured) -> sympy.Expr:
        """The deflection (m or rad)."""
        return self.port.deflection(measured.kinematics)


@dataclass(frozen=True, eq=False)
class DeflectionRate(Deflection):
    """Rate of a port's deflection."""

    @property
    def unit(self) -> str:
        """Unit of the deflection, over seconds."""
        return f"{self.port.unit}/s"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The rate (m/s or rad/s)."""
        return self.port.rate(measured.kinematics)


@dataclass(frozen=True, eq=False)
class ElementForce(Output):
    """Resisting force of an element: positive when it acts against a positive deflection."""

    element: ForceElement

    def __post_init__(self) -> None:
        expect(f"output {self.name!r}: element", self.element, ForceElement)

    @property
    def unit(self) -> str:
        """Unit of the force that works on the deflection."""
        return self.element.unit

    def expression(self, measured: Measured) -> sympy.Expr:
        """The force (N or N m)."""
        return measured.forces[self.element.name]

    def of_elements(self, changed: Mapping[ForceElement, ForceElement]) -> Output:
        """The force of the element that takes this one's place."""
        return replace(self, element=changed.get(self.element, self.element))


@dataclass(frozen=True, eq=False)
class ContactForce(ElementForce):
    """Force of a support on an element's point: the opposite of the element's resisting force."""

    def expression(self, measured: Measured) -> sympy.Expr:
        """The force (N)."""
        return -super().expression(measured)


@dataclass(frozen=True, eq=False)
class UserOutput(Output):
    """Any sympy expression of the mechanism's symbols, and of other outputs under symbols of one's own.

    Parameters
    ----------
    si_unit
        SI unit of the formula.
    formula
        In coordinates, rates, accelerations, inputs, parameters and the symbols of `quantities`.
    quantities
        What else it mentions: an output, added to the mechanism or not, by its symbol.
    """

    si_unit: str
    formula: sympy.Expr
    quantities: Mapping[sympy.Symbol, Output] = field(default_factory=dict)

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.si_unit

    def of_elements(self, changed: Mapping[ForceElement, ForceElement]) -> Output:
        """The same formula of the other elements' quantities."""
        quantities = {symbol: output.of_elements(changed) for symbol, output in self.quantities.items()}
        return replace(self, quantities=quantities)

    def expression(self, measured: Measured) -> sympy.Expr:
        """The expression in the program's names."""
        program = measured.kinematics.program
        values = {s: program.let(output.expression(measured)) for s, output in self.quantities.items()}
        return program.absorb(sympy.sympify(self.formula).xreplace(values))
