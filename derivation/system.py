"""What a derivation starts from, be it a mechanism or somebody's Lagrangian."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import sympy

from chassym.derivation.body import Input
from chassym.derivation.joint import Coordinate
from chassym.derivation.table import Knotted


class Measurement(Protocol):
    """A measured quantity."""

    @property
    def name(self) -> str:
        """Unique in its system."""

    @property
    def unit(self) -> str:
        """SI unit."""


class System(Protocol):
    """Coordinates, inputs and outputs, and the force laws that a linear analysis has to ask for a slope."""

    @property
    def name(self) -> str:
        """For reading."""

    def snapshot(self) -> System:
        """The system as it is now, which nothing can change."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalised coordinates, in order."""

    @property
    def inputs(self) -> Sequence[Input]:
        """What is prescribed, in order."""

    @property
    def outputs(self) -> Sequence[Measurement]:
        """What is measured, in order."""

    @property
    def rotation_sequences(self) -> Sequence[str]:
        """Bodies on three rotations in a row, in order."""

    @property
    def preloads(self) -> Sequence[sympy.Symbol]:
        """Constant forces that are found from the equilibrium of the design position."""

    @property
    def slopes(self) -> Mapping[str, sympy.Symbol]:
        """A symbol for the slope of every element with knots, by the element's name."""

    @property
    def knotted(self) -> Mapping[str, Knotted]:
        """Every characteristic with knots, by its element's name."""
