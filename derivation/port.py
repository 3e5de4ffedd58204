"""Ports: where a force element attaches, as a deflection, its rate and the work that a force does there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import sympy

from chassym.derivation.body import Body, Input, Point
from chassym.derivation.direction import Direction, unit_vector
from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate
from chassym.derivation.kinematics import Kinematics
from chassym.derivation.loads import Loads
from chassym.derivation.validation import expect, scalar
from chassym.derivation.vector import Vector, dot, negative, scale, subtract


class Port(ABC):
    """A deflection s(q, u), zero at the design position, with its rate.

    A resisting force F does the virtual work -F ds, so its generalised force is -F ds/dq.
    """

    @property
    @abstractmethod
    def unit(self) -> str:
        """SI unit of the deflection."""

    @abstractmethod
    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The deflection s (m or rad)."""

    @abstractmethod
    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its time derivative."""

    @abstractmethod
    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """Put a resisting force on the bodies."""

    def less(self, motion: Input) -> Port:
        """This deflection less a prescribed one: a tyre on a pad that moves.

        Raises
        ------
        MechanismError
            If it is no input, or one in another unit.
        """
        prescribed = PrescribedPort(motion)
        if prescribed.unit != self.unit:
            raise MechanismError(
                f"input {motion.name!r} is in {motion.unit}; expected {self.unit}, as the deflection that it "
                "is taken from"
            )
        return CombinedPort(((self, 1), (prescribed, -1)))


@dataclass(frozen=True, eq=False)
class TravelPort(Port):
    """Travel of a point along an axis fixed in the frame of a body.

    The reaction acts on the frame's body at the place where the point is, so that action and reaction do
    exactly the work -F ds.
    """

    point: Point
    frame: Body
    axis: Direction

    def __post_init__(self) -> None:
        expect("travel: point", self.point, Point)
        expect(f"travel of point {self.point.name!r}: frame", self.frame, Body)
        _ = self._direction

    @property
    def _direction(self) -> Vector:
        return unit_vector(self.axis, f"travel of point {self.point.name!r}: axis")

    @property
    def unit(self) -> str:
        """Metres."""
        return "m"

    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The deflection (m)."""
        axis, program = self._direction, kinematics.program
        design = subtract(program, self.point.position, self.frame.origin)
        travel = program.let(dot(axis, kinematics.position(self.point, self.frame)))
        return program.let(travel - program.let(dot(axis, design)))

    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its time derivative (m/s)."""
        velocity = kinematics.velocity(self.point, self.frame)
        return kinematics.program.let(dot(self._direction, velocity))

    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """Pull the point back against a positive deflection."""
        pull = scale(loads.kinematics.program, -force, self._direction)
        loads.add_force_between(self.point, self.frame, pull)


@dataclass(frozen=True, eq=False)
class LineOfSightPort(Port):
    """Distance between two points less its design value: positive when they are further apart.

    Raises
    ------
    MechanismError
        If the points coincide at the design position: the line between them has no direction there.
    """

    first: Point
    second: Point

    def __post_init__(self) -> None:
        for point in (self.first, self.second):
            expect("line of sight: end", point, Point)
        if self._design_length().is_zero:
            raise MechanismError(
                f"points {self.first.name!r} and {self.second.name!r} coincide at the design position; a "
                "line of sight needs two places"
            )

    @property
    def unit(self) -> str:
        """Metres."""
        return "m"

    def _design_length(self) -> sympy.Expr:
        apart = [a - b for a, b in zip(self.first.position, self.second.position, strict=True)]
        return sympy.sqrt(sympy.Add(*(component**2 for component in apart)))

    def _span(self, kinematics: Kinematics) -> Vector:
        """From the second point to the first, in the axes of the second one's body."""
        place = kinematics.position(self.first, self.second.body)
        return subtract(kinematics.program, place, kinematics.arm(self.second))

    def _length(self, kinematics: Kinematics) -> sympy.Expr:
        span = self._span(kinematics)
        return kinematics.program.let(sympy.sqrt(kinematics.program.let(dot(span, span))))

    def _sight(self, kinematics: Kinematics) -> Vector:
        """Unit vector from the second point to the first."""
        reciprocal = kinematics.program.let(1 / self._length(kinematics))
        return scale(kinematics.program, reciprocal, self._span(kinematics))

    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The deflection (m)."""
        let = kinematics.program.let
        return let(self._length(kinematics) - let(self._design_length()))

    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its time derivative (m/s): the relative velocity along the line."""
        velocity = kinematics.velocity(self.first, self.second.body)
        return kinematics.program.let(dot(self._sight(kinematics), velocity))

    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """Pull the points together against a positive deflection."""
        pull = scale(loads.kinematics.program, -force, self._sight(loads.kinematics))
        loads.add_force(self.first, self.second.body, pull)
        loads.add_force(self.second, self.second.body, negative(pull))


@dataclass(frozen=True, eq=False)
class JointPort(Port):
    """A joint's own coordinate as deflection: torsional springs, springs on a slider."""

    coordinate: Coordinate

    def __post_init__(self) -> None:
        expect("joint port", self.coordinate, Coordinate, hint="mechanism.coordinate(name) gives one")

    @property
    def unit(self) -> str:
        """Unit of the coordinate."""
        return self.coordinate.unit

    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The coordinate."""
        return self.coordinate.position

    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its rate."""
        return self.coordinate.rate

    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """A generalised force against the coordinate."""
        loads.add_generalized_force(self.coordinate, -force)


@dataclass(frozen=True, eq=False)
class PrescribedPort(Port):
    """A prescribed motion: its deflection is given, and a force there acts on nothing that moves freely."""

    motion: Input

    def __post_init__(self) -> None:
        expect("prescribed motion", self.motion, Input, hint="mechanism.add_input gives one")

    @property
    def unit(self) -> str:
        """Unit of the motion."""
        return self.motion.unit

    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The prescribed displacement."""
        return self.motion.position

    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its rate."""
        return self.motion.rate

    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """Nothing: whatever moves it holds against any force."""


@dataclass(frozen=True, eq=False)
class CombinedPort(Port):
    """A linear combination of deflections: an anti-roll bar feels one wheel's travel less the other's.

    Raises
    ------
    MechanismError
        If there are no terms.
    """

    terms: tuple[tuple[Port, sympy.Expr | float], ...]

    def __post_init__(self) -> None:
        if not self.terms:
            raise MechanismError(
                "a combination of no deflections; expected pairs of a port and its coefficient"
            )
        for term in self.terms:
            if not isinstance(term, tuple) or len(term) != 2:
                raise MechanismError("combination: expected pairs of a port and its coefficient")
            expect("combination: port", term[0], Port)
            scalar("combination: coefficient", term[1])

    @property
    def unit(self) -> str:
        """Unit of the first deflection; the coefficients bring the others to it."""
        return self.terms[0][0].unit

    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The combination of deflections."""
        return kinematics.program.let(sympy.Add(*(c * port.deflection(kinematics) for port, c in self.terms)))

    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """The combination of rates."""
        return kinematics.program.let(sympy.Add(*(c * port.rate(kinematics) for port, c in self.terms)))

    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """The force, shared out by the coefficients."""
        for port, coefficient in self.terms:
            port.resist(loads, coefficient * force)
