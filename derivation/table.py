"""Piecewise-linear tables of force: dampers over their rate, springs over their deflection."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import sympy

from chassym.derivation.characteristic import Characteristic, Potential, Unilateral
from chassym.derivation.errors import MechanismError
from chassym.derivation.program import Program
from chassym.derivation.validation import scalar

OuterSlopes = tuple[sympy.Expr | float, sympy.Expr | float]

HELD: OuterSlopes = (0, 0)
"""Outer slopes with which the end forces are held beyond the ends of a table."""


@dataclass(frozen=True)
class Table:
    """A continuous function, linear between its points.

    Parameters
    ----------
    places, forces
        The points; places increase. At least two.
    factor
        Multiplies every force and slope.
    outer_slopes
        Slopes before the first and after the last point; None continues the end segments.

    Raises
    ------
    MechanismError
        If there are fewer than two points, not as many forces as places, or places that do not increase.
    """

    places: Sequence[sympy.Expr | float]
    forces: Sequence[sympy.Expr | float]
    factor: sympy.Expr | float = 1
    outer_slopes: OuterSlopes | None = None

    def __post_init__(self) -> None:
        if len(self.places) < 2 or len(self.places) != len(self.forces):
            raise MechanismError(
                f"table of {len(self.places)} places and {len(self.forces)} forces: expected as many of "
                "both, at least two"
            )
        for number in (*self.places, *self.forces, self.factor, *(self.outer_slopes or ())):
            scalar("table", number)
        for before, after in pairwise(self.places):
            if sympy.sympify(after - before).is_nonpositive:
                raise MechanismError(f"table: place {after} follows {before}; expected increasing places")

    @property
    def knots(self) -> Sequence[sympy.Expr | float]:
        """Where the slope jumps."""
        return self.places[1:-1] if self.outer_slopes is None else self.places

    @cached_property
    def slopes(self) -> list[sympy.Expr]:
        """The slope before the first knot, between each two, and after the last."""
        points = pairwise(zip(self.places, self.forces, strict=True))
        inner = [(f2 - f1) / (x2 - x1) for (x1, f1), (x2, f2) in points]
        before, after = ([], []) if self.outer_slopes is None else ([s] for s in self.outer_slopes)
        return [sympy.sympify(self.factor * slope) for slope in (*before, *inner, *after)]

    def line(self, slopes: Sequence[sympy.Expr]) -> sympy.Expr:
        """Force at zero of the line before the first knot."""
        return self.factor * self.forces[0] - slopes[0] * self.places[0]

    def force(self, program: Program, x: sympy.Expr) -> sympy.Expr:
        """The force without branches: a line, and a change of slope beyond each knot."""
        slopes = [program.let(slope) for slope in self.slopes]
        bends = [
            program.let(program.let(after - before) * program.let(sympy.Max(x - knot, 0)))
            for knot, (before, after) in zip(self.knots, pairwise(slopes), strict=True)
        ]
        return program.let(sympy.Add(program.let(self.line(slopes)), program.let(slopes[0] * x), *bends))

    def numbers(self, program: Program) -> tuple[sympy.Expr, ...]:
        """Knots, then slopes, then the distances between places, as names of a program."""
        spacings = [after - before for before, after in pairwise(self.places)]
        return tuple(map(program.absorb, (*self.knots, *self.slopes, *spacings)))

    def integral(self, x: sympy.Expr) -> sympy.Expr:
        """Integral of the force from zero, up to a constant."""
        slopes = self.slopes
        bends = [
            (after - before) * sympy.Max(x - knot, 0) ** 2 / 2
            for knot, (before, after) in zip(self.knots, pairwise(slopes), strict=True)
        ]
        return sympy.Add(self.line(slopes) * x, slopes[0] * x**2 / 2, *bends)


class Knotted(Potential):
    """A table over the deflection or the rate: a linear analysis has to choose a slope at its knots."""

    def __post_init__(self) -> None:
        _ = self.table

    @property
    @abstractmethod
    def table(self) -> Table:
        """The table."""

    @property
    def knots(self) -> Sequence[sympy.Expr | float]:
        """Where the slope jumps."""
        return self.table.knots

    @staticmethod
    @abstractmethod
    def argument(deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        """The one of both that the table is over."""

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The resisting force (N or N m)."""
        return program.let(self.value(program, deflection, rate) + preload)

    def value(self, program: Program, deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Symbol:
        """What the table states (N or N m), by its name on the program."""
        return program.assign(self.table.force(program, self.argument(deflection, rate)))


@dataclass(frozen=True)
class DamperTable(Knotted):
    """Force over rate, linear between the points of a table.

    Parameters
    ----------
    velocities, forces
        The points, as parameters; velocities increase. At least two.
    factor
        Multiplies every force: one over a lever ratio squared, say.
    outer_slopes
        Slopes beyond the table's ends (N s/m) before the factor; None continues the end segments, `HELD`
        holds the end forces.
    """

    velocities: Sequence[sympy.Expr | float]
    forces: Sequence[sympy.Expr | float]
    factor: sympy.Expr | float = 1
    outer_slopes: OuterSlopes | None = None

    @cached_property
    def table(self) -> Table:
        """The table over the rate."""
        return Table(self.velocities, self.forces, self.factor, self.outer_slopes)

    @staticmethod
    def argument(deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        """The rate."""
        return rate

    def dissipation(self, rate: sympy.Expr) -> sympy.Expr:
        """Integral of the force over the rate (W)."""
        return self.table.integral(rate)


@dataclass(frozen=True)
class SpringTable(Knotted):
    """Force over deflection, linear between the points of a table: a progressive spring, a bump stop.

    Parameters
    ----------
    deflections, forces
        The points, as parameters; deflections increase. At least two.
    factor
        Multiplies every force.
    outer_slopes
        Slopes beyond the table's ends (N/m) before the factor; None continues the end segments, `HELD` holds
        the end forces.
    """

    deflections: Sequence[sympy.Expr | float]
    forces: Sequence[sympy.Expr | float]
    factor: sympy.Expr | float = 1
    outer_slopes: OuterSlopes | None = None

    @cached_property
    def table(self) -> Table:
        """The table over the deflection."""
        return Table(self.deflections, self.forces, self.factor, self.outer_slopes)

    @staticmethod
    def argument(deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        """The deflection."""
        return deflection

    def potential(self, deflection: sympy.Expr, preload: sympy.Expr) -> sympy.Expr:
        """Integral of the force over the deflection (J)."""
        return self.table.integral(deflection) + preload * deflection


def knotted_part(law: Characteristic) -> Knotted | None:
    """The table in a law, be it the law itself or inside one that can only push."""
    while isinstance(law, Unilateral):
        law = law.law
    return law if isinstance(law, Knotted) else None
