"""Rigid bodies, points fixed to them and prescribed motions: the nouns of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy

from chassym.derivation.joint import Joint
from chassym.derivation.vector import SymmetricTensor, Vector


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
    parent: Body | None
    joint: Joint
    origin: Vector
    mass: sympy.Expr
    mass_centre: Vector
    inertia: SymmetricTensor


@dataclass(frozen=True, eq=False)
class Point:
    """A point fixed to a body, by its design position (m)."""

    name: str
    body: Body
    position: Vector


@dataclass(frozen=True)
class Input:
    """A prescribed motion with its rate; both act."""

    name: str
    unit: str

    @cached_property
    def position(self) -> sympy.Symbol:
        """The prescribed displacement."""
        return sympy.Symbol(self.name, real=True)

    @cached_property
    def rate(self) -> sympy.Symbol:
        """Its time derivative."""
        return sympy.Symbol(f"{self.name}_rate", real=True)
