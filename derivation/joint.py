"""Joints: what a body may do relative to its parent, step by step along and about single axes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy

from chassym.derivation.vector import AXES


class MechanismError(ValueError):
    """A mechanism that cannot be: the message names the part and what would be accepted."""


@dataclass(frozen=True)
class Coordinate:
    """A generalised coordinate with its rate and its second derivative as independent sympy symbols."""

    name: str
    unit: str

    @cached_property
    def position(self) -> sympy.Symbol:
        """The coordinate itself, zero at the design position."""
        return sympy.Symbol(self.name, real=True)

    @cached_property
    def rate(self) -> sympy.Symbol:
        """Its time derivative."""
        return sympy.Symbol(f"{self.name}_rate", real=True)

    @cached_property
    def acceleration(self) -> sympy.Symbol:
        """Its second time derivative."""
        return sympy.Symbol(f"{self.name}_acceleration", real=True)


@dataclass(frozen=True)
class Step:
    """One degree of freedom: translation along, or rotation about, an axis of the frame reached so far."""

    coordinate: Coordinate
    axis: str
    is_rotation: bool

    def __post_init__(self) -> None:
        if self.axis not in AXES:
            raise MechanismError(
                f"joint axis of {self.coordinate.name!r}: {self.axis!r} is not one of 'x', 'y', 'z'"
            )


@dataclass(frozen=True)
class Joint:
    """A sequence of elementary steps from the parent's frame to the body's frame."""

    steps: tuple[Step, ...]

    def then(self, other: Joint) -> Joint:
        """This joint followed by another one at the same place."""
        return Joint(self.steps + other.steps)


def weld() -> Joint:
    """No relative motion."""
    return Joint(())


def revolute(coordinate: str, axis: str) -> Joint:
    """Rotation in rad about one axis."""
    return Joint((Step(Coordinate(coordinate, "rad"), axis, is_rotation=True),))


def prismatic(coordinate: str, axis: str) -> Joint:
    """Translation in m along one axis."""
    return Joint((Step(Coordinate(coordinate, "m"), axis, is_rotation=False),))


def free() -> Joint:
    """Six degrees of freedom: x, y, z in the parent's axes, then yaw about z, pitch about y, roll about x.

    The rotation sequence z-y-x is singular at a pitch of 90 degrees.
    """
    translations = Joint(tuple(step for axis in "xyz" for step in prismatic(axis, axis).steps))
    return translations.then(revolute("yaw", "z")).then(revolute("pitch", "y")).then(revolute("roll", "x"))
