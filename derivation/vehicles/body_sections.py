"""A body in n sections that twist against each other, from the three sections that its parameters describe.

Section i = 0 .. n - 1 stands at s = i / (n - 1) between the front section and the rear one. What the three
have is interpolated linearly over s, then scaled or shifted together, so that the rigid body keeps its mass,
mass centre and inertia tensor. The torsional compliance is spread evenly over each half of the body; a spring
has its interval's part of it, divided by

    alpha = 3 / (2 n (n - 1) sin^2(pi / 2n)).

A free chain of n inertias J / n on n - 1 springs k first twists at w^2 = 4 (n k / J) sin^2(pi / 2n). For two
equal halves of stiffness K, k = alpha (n - 1) K / 2 and w^2 = 3 K / J for every n, as for three sections.
With n = 3 all of this gives the parameters themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import sympy

from chassym.derivation.symbols import ParameterSymbols

PLACES = ("front", "middle", "rear")
ENDS = ("front", "rear")

Tensor = tuple[tuple[sympy.Expr, sympy.Expr, sympy.Expr], ...]

_ONES = sympy.ones(3, 1)


@dataclass(frozen=True)
class Section:
    """Mass (kg), mass centre (m), inertia about it by rows (kg m^2) and height of the torsion axis (m)."""

    mass: sympy.Expr
    mass_centre: tuple[sympy.Expr, sympy.Expr, sympy.Expr]
    inertia: Tensor
    axis_height: sympy.Expr


@dataclass(frozen=True)
class TorsionSpring:
    """Stiffness (N m/rad) and damping (N m s/rad) between two neighbours."""

    stiffness: sympy.Expr
    damping: sympy.Expr


@dataclass(frozen=True, eq=False)
class SectionedBody:
    """A body in ``count`` sections, as expressions of the parameters of its three."""

    symbols: ParameterSymbols
    count: int

    def sections(self) -> list[Section]:
        """The sections from front to rear."""
        centres = [(x, sympy.S.Zero, z) for x, z in zip(self._centres("x"), self._centres("z"), strict=True)]
        front, rear = (self.symbols(f"body.{end}.torsion_axis.z") for end in ENDS)
        heights = [(1 - s) * front + s * rear for s in self._stations]
        parts = zip(self._shares("mass"), centres, self._inertias(), heights, strict=True)
        return [Section(*part) for part in parts]

    def springs(self) -> list[TorsionSpring]:
        """The springs from front to rear, each between a section and the next."""
        return [self._spring(2 * s, 2 * t) for s, t in zip(self._stations, self._stations[1:], strict=False)]

    def _spring(self, start: sympy.Rational, end: sympy.Rational) -> TorsionSpring:
        """The spring of an interval; the front half reaches from 0 to 1, the rear half from 1 to 2."""
        n = self.count
        alpha = sympy.Rational(3, 2 * n * (n - 1)) / sympy.sin(sympy.pi / (2 * n)) ** 2
        k_front, k_rear = (self.symbols(f"body.{place}.torsional_stiffness") for place in ENDS)
        t_front, t_rear = (self.symbols(f"body.{place}.stiffness_proportional_damping") for place in ENDS)
        in_front = min(end, 1) - min(start, 1)
        # The compliance is (front + rear) / (k_front k_rear); without quotients a half may be loose.
        front, rear = in_front * k_rear, (end - start - in_front) * k_front
        stiffness = alpha * k_front * k_rear / (front + rear)
        return TorsionSpring(stiffness, stiffness * (front * t_front + rear * t_rear) / (front + rear))

    @cached_property
    def _stations(self) -> list[sympy.Rational]:
        return [sympy.Rational(i, self.count - 1) for i in range(self.count)]

    @cached_property
    def _weights(self) -> sympy.Matrix:
        """Linear interpolation between the three sections, shape (n, 3)."""
        return sympy.Matrix([[max(0, 1 - abs(2 * s - i)) for i in range(3)] for s in self._stations])

    def _three(self, name: str) -> sympy.Matrix:
        return sympy.Matrix([self.symbols(f"body.{place}.{name}") for place in PLACES])

    def _shares(self, name: str) -> list[sympy.Expr]:
        """A quantity of which the sections together have as much as the three."""
        three = self._three(name)
        interpolated = self._weights * three
        return list(interpolated * (_total(three) / _total(interpolated)))

    def _offsets(self, axis: str) -> sympy.Matrix:
        """Mass centres of the three sections, measured from that of the middle one."""
        places = self._three(f"mass_centre.{axis}")
        return places - _ONES * places[1]

    def _centres(self, axis: str) -> list[sympy.Expr]:
        """Mass centres, shifted together so that the body's own stays where it is."""
        offsets = self._offsets(axis)
        shift = self._three_masses.average(offsets) - self._interpolated_masses.average(offsets)
        base = self.symbols(f"body.middle.mass_centre.{axis}") + shift
        return [base + offset for offset in self._weights * offsets]

    def _inertias(self) -> Iterator[Tensor]:
        """Inertias; every section has an equal share of what n mass points lack to the inertia of three."""
        xx, zz, xz = (self._lack(*axes) / self.count for axes in ("xx", "zz", "xz"))
        moments = (self._shares(f"inertia.{moment}") for moment in ("xx", "yy", "zz"))
        o = sympy.S.Zero
        for roll, pitch, yaw in zip(*moments, strict=True):
            yield (roll + zz, o, -xz), (o, pitch + xx + zz, o), (-xz, o, yaw + xx)

    def _lack(self, first: str, second: str) -> sympy.Expr:
        """What the integral of a b dm of the mass points lacks, a and b from the mass centre."""
        offsets = self._offsets(first), self._offsets(second)
        three, interpolated = self._three_masses, self._interpolated_masses
        return _total(self._three("mass")) * (three.covariance(*offsets) - interpolated.covariance(*offsets))

    @cached_property
    def _three_masses(self) -> _MassPoints:
        return _MassPoints(sympy.eye(3), self._three("mass"))

    @cached_property
    def _interpolated_masses(self) -> _MassPoints:
        return _MassPoints(self._weights, self._three("mass"))


@dataclass(frozen=True, eq=False)
class _MassPoints:
    """Points whose masses, up to a factor, and coordinates are interpolated with the same weights."""

    weights: sympy.Matrix
    masses: sympy.Matrix

    def average(self, first: sympy.Matrix, second: sympy.Matrix = _ONES) -> sympy.Expr:
        """Average of the product of two coordinates, which are given at the three sections."""
        return self._sum(first, second) / self._sum(_ONES, _ONES)

    def covariance(self, first: sympy.Matrix, second: sympy.Matrix) -> sympy.Expr:
        """Average of the product, measured from the mass centre."""
        return self.average(first, second) - self.average(first) * self.average(second)

    def _sum(self, first: sympy.Matrix, second: sympy.Matrix) -> sympy.Expr:
        forms = (first.T * form * second for form in self._forms)
        return sympy.Add(*(mass * form[0] for mass, form in zip(self.masses, forms, strict=True)))

    @cached_property
    def _forms(self) -> list[sympy.Matrix]:
        """For each of the three masses k a quadratic form: w_k w_i w_j summed over the points."""
        columns = [list(self.weights[:, k]) for k in range(3)]

        def entry(*indices: int) -> sympy.Expr:
            return _total(sympy.prod(w) for w in zip(*(columns[i] for i in indices), strict=True))

        return [sympy.Matrix(3, 3, lambda i, j, k=k: entry(i, j, k)) for k in range(3)]


def _total(terms: Iterable[sympy.Expr]) -> sympy.Expr:
    return sympy.Add(*terms)
