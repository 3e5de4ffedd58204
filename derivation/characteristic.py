"""Characteristics: the force that answers a deflection and its rate at a port."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import sympy

from chassym.derivation.body import Input
from chassym.derivation.errors import MechanismError
from chassym.derivation.program import Program
from chassym.derivation.validation import expect, scalar


class Characteristic(ABC):
    """A force law. The force resists: it is positive when it acts against a positive deflection.

    What of it is the slope of an energy, or of a dissipation function, may be stated, so that it appears
    there in Lagrange's equations; the rest is a generalised force.
    """

    @abstractmethod
    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The resisting force (N or N m) with a constant preload, as an expression of deflection and rate."""

    def potential(self, deflection: sympy.Expr, preload: sympy.Expr) -> sympy.Expr:
        """Potential energy (J): its slope by the deflection is a part of the force."""
        return preload * deflection

    def dissipation(self, rate: sympy.Expr) -> sympy.Expr:
        """Rayleigh's dissipation function (W): its slope by the rate is a part of the force."""
        return sympy.S.Zero

    def remainder(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The part of the force (N or N m) that is a slope of neither."""
        return self.force(program, deflection, rate, sympy.S.Zero)


class Potential(Characteristic):
    """A force law that is the slope of its energy and its dissipation function and nothing else."""

    def remainder(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """Nothing."""
        return sympy.S.Zero


@dataclass(frozen=True)
class Linear(Potential):
    """Spring and viscous damper side by side, with a constant force on top.

    Parameters
    ----------
    stiffness, damping
        Force per deflection (N/m or N m/rad) and per rate (N s/m or N m s/rad).
    preload
        Force at rest in the design position (N or N m), where it is known.
    """

    stiffness: sympy.Expr | float = 0
    damping: sympy.Expr | float = 0
    preload: sympy.Expr | float = 0

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "preload"):
            scalar(f"linear law: {name}", getattr(self, name))

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The resisting force (N or N m)."""
        law = program.let(self.stiffness) * deflection + program.let(self.damping) * rate
        return program.let(program.let(law) + program.let(self.preload + preload))

    def potential(self, deflection: sympy.Expr, preload: sympy.Expr) -> sympy.Expr:
        """Potential energy (J)."""
        return sympy.sympify(self.stiffness) * deflection**2 / 2 + (self.preload + preload) * deflection

    def dissipation(self, rate: sympy.Expr) -> sympy.Expr:
        """Half the power that is lost (W)."""
        return sympy.sympify(self.damping) * rate**2 / 2


@dataclass(frozen=True)
class Polynomial(Potential):
    """Powers of deflection and rate: k1 s + k2 s^2 + ... + c1 v + c2 v^2 + ...

    Parameters
    ----------
    stiffness, damping
        Coefficients of the first, second, ... power.
    """

    stiffness: Sequence[sympy.Expr | float] = ()
    damping: Sequence[sympy.Expr | float] = ()

    def __post_init__(self) -> None:
        for coefficient in (*self.stiffness, *self.damping):
            scalar("polynomial: coefficient", coefficient)

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The resisting force (N or N m), by Horner's rule."""
        terms = [_horner(program, c, x) for c, x in ((self.stiffness, deflection), (self.damping, rate))]
        return program.let(sympy.Add(*terms, preload))

    def potential(self, deflection: sympy.Expr, preload: sympy.Expr) -> sympy.Expr:
        """Potential energy (J)."""
        return preload * deflection + _integral(self.stiffness, deflection)

    def dissipation(self, rate: sympy.Expr) -> sympy.Expr:
        """Integral of the damping force over the rate (W)."""
        return _integral(self.damping, rate)


def _horner(program: Program, coefficients: Sequence[sympy.Expr | float], x: sympy.Expr) -> sympy.Expr:
    value: sympy.Expr = sympy.S.Zero
    for coefficient in reversed(coefficients):
        value = program.let((value + program.let(coefficient)) * x)
    return value


def _integral(coefficients: Sequence[sympy.Expr | float], x: sympy.Expr) -> sympy.Expr:
    return sympy.Add(*(c * x ** (i + 1) / (i + 1) for i, c in enumerate(coefficients, start=1)))


@dataclass(frozen=True)
class ForceLaw(Characteristic):
    """Any sympy expression of deflection and rate.

    Examples
    --------
    A damper that resists with the square of its rate:

    >>> v, c = sympy.symbols("v c", real=True)
    >>> law = ForceLaw(c * v * abs(v), rate=v)
    >>> program = Program()
    >>> program.expand([law.force(program, sympy.S.Zero, sympy.Symbol("s_rate", real=True), sympy.S.Zero)])
    [c*s_rate*Abs(s_rate)]
    """

    expression: sympy.Expr
    deflection: sympy.Symbol | None = None
    rate: sympy.Symbol | None = None

    def __post_init__(self) -> None:
        scalar("force law", self.expression)
        for symbol in (self.deflection, self.rate):
            expect("force law: variable", symbol, sympy.Symbol, type(None))

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The resisting force (N or N m)."""
        given = {self.deflection: deflection, self.rate: rate}
        placed = self.expression.xreplace({symbol: e for symbol, e in given.items() if symbol is not None})
        return program.let(program.absorb(placed) + preload)


@dataclass(frozen=True)
class Unilateral(Characteristic):
    """A law that can push but not pull, its preload included: a tyre that can lift, a bump stop.

    A push is a negative resisting force, so the force is the smaller of zero and the law's.
    """

    law: Characteristic

    def __post_init__(self) -> None:
        expect("unilateral law", self.law, Characteristic)

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """The resisting force (N or N m), never positive."""
        return program.let(sympy.Min(0, self.law.force(program, deflection, rate, preload)))

    def potential(self, deflection: sympy.Expr, preload: sympy.Expr) -> sympy.Expr:
        """Zero: whether it acts depends on the rate, too."""
        return sympy.S.Zero

    def remainder(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """All of the force."""
        return self.force(program, deflection, rate, preload)


@dataclass(frozen=True)
class Actuator(Characteristic):
    """A prescribed force between the ends of a port, positive when it drives the deflection up.

    Raises
    ------
    MechanismError
        If the input is no force or torque.
    """

    command: Input

    def __post_init__(self) -> None:
        expect("actuator", self.command, Input, hint="mechanism.add_input gives one")
        if self.command.unit not in ("N", "N*m"):
            raise MechanismError(
                f"actuator: input {self.command.name!r} is in {self.command.unit}; expected 'N' or 'N*m'"
            )

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        """Minus the command, and the preload."""
        return program.let(preload - self.command.position)
