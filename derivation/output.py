"""Outputs: what is measured on a mechanism, each with its name and unit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.kinematics import Acceleration, Kinematics
from chassym.derivation.port import Port
from chassym.derivation.vector import AXES


@dataclass(frozen=True)
class Measured:
    """What outputs may be read from: the motion of the frames and the force of every element by name."""

    kinematics: Kinematics
    accelerations: Sequence[Acceleration]
    forces: Mapping[str, sympy.Expr]


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


@dataclass(frozen=True, eq=False)
class PointDisplacement(Output):
    """Displacement of a point from its design position along a ground axis."""

    point: Point
    axis: str
    ground: Body
    unit = "m"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The displacement (m)."""
        position = measured.kinematics.position(self.point, self.ground)
        return position[AXES[self.axis]] - self.point.position[AXES[self.axis]]


@dataclass(frozen=True, eq=False)
class PointAcceleration(Output):
    """Acceleration of a point relative to the ground, in the axes of the ground or of its body."""

    point: Point
    axis: str
    frame: Body
    unit = "m/s^2"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The acceleration (m/s^2)."""
        kinematics = measured.kinematics
        index = kinematics.link_of(self.point.body)
        if index is None:
            return sympy.S.Zero
        own = measured.accelerations[index].of_point(kinematics.program, kinematics.arm(self.point))
        return kinematics.rotated(own, self.point.body, self.frame)[AXES[self.axis]]


@dataclass(frozen=True, eq=False)
class AngularVelocity(Output):
    """Angular velocity of a body relative to the ground, in the axes of the ground or its own."""

    body: Body
    axis: str
    frame: Body
    unit = "rad/s"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The angular velocity (rad/s)."""
        kinematics = measured.kinematics
        index = kinematics.link_of(self.body)
        if index is None:
            return sympy.S.Zero
        return kinematics.rotated(kinematics.angular_velocity[index], self.body, self.frame)[AXES[self.axis]]


@dataclass(frozen=True, eq=False)
class Deflection(Output):
    """Deflection of a port."""

    port: Port

    @property
    def unit(self) -> str:
        """Unit of the port's deflection."""
        return self.port.unit

    def expression(self, measured: Measured) -> sympy.Expr:
        """The deflection (m or rad)."""
        return self.port.deflection(measured.kinematics)


@dataclass(frozen=True, eq=False)
class ContactForce(Output):
    """Force of a support on an element's point: the opposite of the element's resisting force."""

    element: str
    unit = "N"

    def expression(self, measured: Measured) -> sympy.Expr:
        """The force (N)."""
        return -measured.forces[self.element]
