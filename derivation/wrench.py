"""Wrenches: a force and a moment together, moved along the tree of frames."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from chassym.derivation.joint import Step
from chassym.derivation.kinematics import Kinematics, Link
from chassym.derivation.program import Program
from chassym.derivation.vector import ZERO, Vector, add, cross, dot, negative


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
    return dot(step.axis, wrench.moment if step.is_rotation else wrench.force)


def opposite(wrench: Wrench) -> Wrench:
    """The reaction."""
    return Wrench(negative(wrench.force), negative(wrench.moment))
