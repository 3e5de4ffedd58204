"""Characteristics: the force that answers a deflection and its rate at a port, and its slope."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import sympy

from chassym.derivation.program import Program

SlopeRule = Callable[[float, float], float]


class Characteristic(ABC):
    """A force law. The force resists: it is positive when it acts against a positive deflection."""

    @abstractmethod
    def force(self, program: Program, deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        """The resisting force (N or N m) as an expression of deflection and rate."""


class Knotted(Characteristic):
    """A force law of the rate alone whose slope jumps: a linear analysis has to choose one."""

    @property
    @abstractmethod
    def knots(self) -> Sequence[sympy.Expr]:
        """The rates at which the slope jumps."""

    @abstractmethod
    def slope(self, rate: float, values: Mapping[str, float], rule: SlopeRule) -> float:
        """Slope (N s/m) at a rate, for parameter values by name, by a rule for the two sides of a knot."""


@dataclass(frozen=True)
class Linear(Characteristic):
    """Spring and viscous damper side by side: stiffness times deflection plus damping times rate."""

    stiffness: sympy.Expr = sympy.S.Zero
    damping: sympy.Expr = sympy.S.Zero

    def force(self, program: Program, deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        """The resisting force (N or N m)."""
        return program.let(program.let(self.stiffness) * deflection + program.let(self.damping) * rate)


@dataclass(frozen=True)
class DamperTable(Knotted):
    """Force against rate, linear between the points of a table and extrapolated linearly beyond its ends.

    Parameters
    ----------
    velocities, forces
        The points, as parameters; velocities increase. At least two.
    factor
        Multiplies every force: one over a lever ratio squared, say.
    """

    velocities: Sequence[sympy.Expr]
    forces: Sequence[sympy.Expr]
    factor: sympy.Expr = sympy.S.One

    def force(self, program: Program, deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        """The resisting force (N) without branches: a line, and a change of slope beyond each inner knot."""
        slopes = [
            program.let(self.factor * (f2 - f1) / (v2 - v1))
            for (v1, f1), (v2, f2) in pairwise(zip(self.velocities, self.forces, strict=True))
        ]
        intercept = program.let(self.factor * self.forces[0] - slopes[0] * self.velocities[0])
        knots = zip(self.velocities[1:-1], pairwise(slopes), strict=True)
        bends = [
            program.let(program.let(after - before) * program.let(sympy.Max(rate - velocity, 0)))
            for velocity, (before, after) in knots
        ]
        return program.let(sympy.Add(intercept, program.let(slopes[0] * rate), *bends))

    @property
    def knots(self) -> Sequence[sympy.Expr]:
        """The inner points of the table."""
        return self.velocities[1:-1]

    def slope(self, rate: float, values: Mapping[str, float], rule: SlopeRule) -> float:
        """Slope (N s/m): the rule combines the slopes just left and just right of the rate."""
        velocities, forces = (
            np.array([_number(e, values) for e in v]) for v in (self.velocities, self.forces)
        )
        slopes = _number(self.factor, values) * np.diff(forces) / np.diff(velocities)
        left, right = (np.searchsorted(velocities[1:-1], rate, side=side) for side in ("left", "right"))
        return rule(float(slopes[left]), float(slopes[right]))


def _number(expression: sympy.Expr, values: Mapping[str, float]) -> float:
    """An expression of parameters for given values."""
    expression = sympy.sympify(expression)
    numbers = {symbol: sympy.Float(values[symbol.name]) for symbol in expression.free_symbols}
    return float(expression.xreplace(numbers))


def mean_slope(left: float, right: float) -> float:
    """The mean of the slopes on both sides: the default rule at a knot."""
    return 0.5 * (left + right)
