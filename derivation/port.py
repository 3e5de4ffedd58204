"""Ports: where a force element attaches, as a deflection, its rate and the work that a force does there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.body import Body, Input, Point
from chassym.derivation.joint import Coordinate
from chassym.derivation.kinematics import Kinematics
from chassym.derivation.loads import Loads
from chassym.derivation.vector import AXES, scale, unit


class Port(ABC):
    """A deflection s(q, u), zero at the design position, with its rate.

    A resisting force F does the virtual work -F ds, so its generalised force is -F ds/dq.
    """

    unit: str

    @abstractmethod
    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The deflection s (m or rad)."""

    @abstractmethod
    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its time derivative."""

    @abstractmethod
    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """Put a resisting force on the bodies."""


@dataclass(frozen=True, eq=False)
class TravelPort(Port):
    """Travel of a point along an axis of a frame, less the prescribed travel of what it is attached to.

    The frame is the ground or a body that the point's body is jointed to. The reaction acts on the frame's
    body at the place where the point is, so that action and reaction do exactly the work -F ds.
    """

    point: Point
    frame: Body
    axis: str
    input: Input | None = None
    unit = "m"

    def deflection(self, kinematics: Kinematics) -> sympy.Expr:
        """The deflection (m)."""
        i = AXES[self.axis]
        design = self.point.position[i] - self.frame.origin[i]
        moved = kinematics.program.let(
            kinematics.position(self.point, self.frame)[i] - kinematics.program.let(design)
        )
        return moved if self.input is None else kinematics.program.let(moved - self.input.position)

    def rate(self, kinematics: Kinematics) -> sympy.Expr:
        """Its time derivative (m/s)."""
        moved = kinematics.velocity(self.point, self.frame)[AXES[self.axis]]
        return moved if self.input is None else kinematics.program.let(moved - self.input.rate)

    def resist(self, loads: Loads, force: sympy.Expr) -> None:
        """Pull the point back against a positive deflection."""
        loads.add_force(self.point, self.frame, scale(loads.kinematics.program, -force, unit(self.axis)))


@dataclass(frozen=True, eq=False)
class JointPort(Port):
    """A joint's own coordinate as deflection: torsional springs, springs on a slider."""

    coordinate: Coordinate

    @property
    def unit(self) -> str:  # type: ignore[override]
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
class CombinedPort(Port):
    """A linear combination of deflections: the anti-roll bar feels one wheel's travel less the other's."""

    terms: Sequence[tuple[Port, sympy.Expr | int]]

    @property
    def unit(self) -> str:  # type: ignore[override]
        """Unit of the first deflection."""
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
