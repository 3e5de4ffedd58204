"""Rigid bodies, points fixed to them and what comes from outside: the nouns of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, SupportsIndex

import sympy

from chassym.derivation.joint import Joint, Step, weld
from chassym.derivation.vector import ZERO, SymmetricTensor, Vector, diagonal


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body. All frames are parallel to the ground and all coordinates zero at the design position.

    Parameters
    ----------
    name
        Unique in its mechanism.
    parent
        The body it is jointed to; None for the ground.
    joint
        What it may do relative to its parent.
    origin
        Design position of the joint, the origin of the body's frame (m).
    mass, mass_centre, inertia
        Mass (kg), design position of the mass centre (m), inertia about the mass centre (kg m^2).
    """

    name: str
    parent: Body | None = field(repr=False)
    joint: Joint
    origin: Vector
    mass: sympy.Expr
    mass_centre: Vector
    inertia: SymmetricTensor

    @property
    def is_massless(self) -> bool:
        """Whether it has neither mass nor inertia."""
        return self.mass == 0 and not any(self.inertia.components())

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[Any, ...]:
        """The ground is one object of a process: it is pickled by its name."""
        return "GROUND" if self is GROUND else super().__reduce_ex__(protocol)


GROUND = Body("ground", None, weld(), ZERO, sympy.S.Zero, ZERO, diagonal(*ZERO))
"""The inertial frame, Z up."""


def rotation_sequence(body: Body) -> tuple[Step, ...]:
    """The three rotations that a body stands on, which are singular in some position.

    Slides between them turn nothing, and a parent without mass is a part of the joint: a gimbal. Empty if
    there are fewer or more than three.
    """
    steps, carrier = body.joint.steps, body.parent
    while carrier is not None and carrier is not GROUND and carrier.is_massless:
        steps, carrier = carrier.joint.steps + steps, carrier.parent
    rotations = tuple(step for step in steps if step.is_rotation)
    return rotations if len(rotations) == 3 and not body.is_massless else ()


@dataclass(frozen=True, eq=False)
class Point:
    """A point fixed to a body, by its design position (m)."""

    name: str
    body: Body
    position: Vector


@dataclass(frozen=True)
class Input:
    """A prescribed motion with its rate, or a prescribed force: what comes from outside."""

    name: str
    unit: str
    description: str = ""

    @cached_property
    def position(self) -> sympy.Symbol:
        """The prescribed displacement or force."""
        return sympy.Symbol(self.name, real=True)

    @cached_property
    def rate(self) -> sympy.Symbol:
        """Its time derivative."""
        return sympy.Symbol(f"{self.name}_rate", real=True)


@dataclass(frozen=True, eq=False)
class AppliedForce:
    """A prescribed force on a point along an axis fixed in the frame of a body, without a reaction."""

    input: Input
    point: Point
    axis: Vector
    axes: Body


@dataclass(frozen=True, eq=False)
class AppliedTorque:
    """A prescribed torque on a body about an axis fixed in the frame of a body, without a reaction."""

    input: Input
    body: Body
    axis: Vector
    axes: Body
