"""The result of a derivation: M(q, p) q'' + h(q, q', p) = Q(q, q', u, u', p) with outputs, on one program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import sympy

from chassym.derivation.element import ElementAnswer
from chassym.derivation.energies import Energies
from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate
from chassym.derivation.kinks import Kink, held, kink_of, switches
from chassym.derivation.program import Program
from chassym.derivation.reading.lagrange_form import lagrange_equations, written_out
from chassym.derivation.reading.latex import displayed
from chassym.derivation.solve import TreeFactors, factorise_tree
from chassym.derivation.system import System


@dataclass(frozen=True, eq=False, repr=False)
class EquationsOfMotion:
    """Equations of motion of a mechanism.

    Attributes
    ----------
    system
        What they were derived from: its coordinates, inputs and outputs.
    program
        The straight-line program whose names the expressions use.
    mass_matrix
        M, shape (n, n), symmetric.
    bias
        h: Coriolis, centrifugal and gravity terms, length n.
    generalized_forces
        Q of the force elements, length n.
    elements
        Deflection, rate and resisting force of every force element, by its name.
    outputs
        Every output by its name, in coordinates, rates, accelerations, inputs and input rates.
    energies
        T, V and D of Lagrange's equations.
    singularities
        Signed distance from the singularity of its rotation sequence, -1 to 1, of every body on three
        rotations in a row, by its name.
    derivation_s
        Time that M, h and Q took (s).
    """

    system: System
    program: Program
    mass_matrix: tuple[tuple[sympy.Expr, ...], ...]
    bias: tuple[sympy.Expr, ...]
    generalized_forces: tuple[sympy.Expr, ...]
    elements: Mapping[str, ElementAnswer]
    outputs: Mapping[str, sympy.Expr]
    energies: Energies
    singularities: Mapping[str, sympy.Expr]
    derivation_s: float

    def __repr__(self) -> str:
        return f"<EquationsOfMotion of {self.system.name!r}: {len(self.bias)} degrees of freedom>"

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalised coordinates, in order."""
        return self.system.coordinates

    @cached_property
    def arguments(self) -> tuple[sympy.Symbol, ...]:
        """Coordinates, rates, accelerations, inputs and input rates, in this order."""
        coordinates, inputs = self.coordinates, self.system.inputs
        return (
            *(c.position for c in coordinates),
            *(c.rate for c in coordinates),
            *(c.acceleration for c in coordinates),
            *(u.position for u in inputs),
            *(u.rate for u in inputs),
        )

    @cached_property
    def residual(self) -> tuple[sympy.Expr, ...]:
        """M q'' + h - Q, length n: zero along a motion."""
        accelerations = [c.acceleration for c in self.coordinates]
        rows = zip(self.mass_matrix, self.bias, self.generalized_forces, strict=True)
        return tuple(
            self.program.let(sympy.Add(h, -q, *(m * a for m, a in zip(row, accelerations, strict=True))))
            for row, h, q in rows
        )

    @cached_property
    def _factors(self) -> TreeFactors:
        return factorise_tree(self.program, self.mass_matrix)

    @cached_property
    def accelerations(self) -> tuple[sympy.Expr, ...]:
        """q'' = M^-1 (Q - h), solved on the program by the tree's sparse factorisation."""
        right = [self.program.let(q - h) for q, h in zip(self.generalized_forces, self.bias, strict=True)]
        return tuple(self._factors.solve(self.program, right))

    @property
    def state_arguments(self) -> tuple[sympy.Symbol, ...]:
        """Coordinates, rates, inputs and input rates: the arguments but for the accelerations."""
        n = len(self.coordinates)
        return (*self.arguments[: 2 * n], *self.arguments[3 * n :])

    @property
    def right_hand_side(self) -> tuple[sympy.Expr, ...]:
        """Rates of the state (q, q'), length 2 n: q', then the accelerations."""
        return (*(c.rate for c in self.coordinates), *self.accelerations)

    @cached_property
    def right_hand_side_jacobian(self) -> list[list[sympy.Expr]]:
        """Exact derivatives of the right-hand side by the state, shape (2 n, 2 n).

        The residual r(q, q', q'') is zero along a motion, so that dq'' = -M^-1 (dr/dq dq + dr/dq' dq'), at
        the accelerations of the state; the factors of M are those that the accelerations are solved with.
        """
        program, n = self.program, len(self.coordinates)
        motion = {c.acceleration: a for c, a in zip(self.coordinates, self.accelerations, strict=True)}
        entries = [entry for row in self.residual_jacobian for entry in row[: 2 * n]]
        there = program.substitute([-entry for entry in entries], motion)
        columns = [self._factors.solve(program, there[j :: 2 * n]) for j in range(2 * n)]
        upper = [[sympy.S(int(j == n + i)) for j in range(2 * n)] for i in range(n)]
        return [*upper, *(list(row) for row in zip(*columns, strict=True))]

    @cached_property
    def residual_jacobian(self) -> list[list[sympy.Expr]]:
        """Exact derivatives of the residual by coordinates, rates and accelerations, shape (n, 3 n)."""
        return self.program.differentiate(self.residual, self.arguments[: 3 * len(self.coordinates)])

    @cached_property
    def preload_action(self) -> list[list[sympy.Expr]]:
        """Exact derivatives of the residual by the preloads, shape (n, preloads)."""
        return self.program.differentiate(self.residual, self.system.preloads)

    @cached_property
    def linearisation(self) -> list[list[sympy.Expr]]:
        """Exact derivatives of residual and outputs, shape (n + outputs, arguments).

        A characteristic with knots enters by a symbol for its slope, `slopes` of the system: which slope it
        has at a knot is a choice to be made with the numbers.
        """
        return self.program.differentiate(self._results, self.arguments, self._stated_slopes)

    @cached_property
    def linearisation_change(self) -> list[sympy.Expr]:
        """How the linearisation, applied to a motion, changes with everything, length n + outputs.

        With J the linearisation, d the symbols of `motion` and e those of `change`, it is the derivative of
        J d along e: a second directional derivative, which holds every sensitivity of a linear model.
        """
        applied = self.program.differentiate_along(self._results, self.motion, self._stated_slopes)
        return self.program.differentiate_along(applied, self.change)

    @cached_property
    def statics_change(self) -> list[sympy.Expr]:
        """How what a linearisation starts from changes along e, the symbols of `change`.

        These are the residual, length n, the variable of every table, and the numbers of all tables: knots,
        slopes and spacings, one table after the other.
        """
        statics = [*self.residual, *self.table_variables.values(), *self.table_numbers]
        return self.program.differentiate_along(statics, self.change)

    @cached_property
    def table_numbers(self) -> list[sympy.Expr]:
        """Knots, slopes and spacings of every table, one table after the other."""
        laws = self.system.knotted.values()
        return [number for law in laws for number in law.table.numbers(self.program)]

    @cached_property
    def motion(self) -> Mapping[sympy.Symbol, sympy.Symbol]:
        """A symbol for the amplitude of every argument."""
        return {each: sympy.Symbol(f"_{each.name}.amplitude", real=True) for each in self.arguments}

    @cached_property
    def change(self) -> Mapping[sympy.Symbol, sympy.Symbol]:
        """A symbol for the change of every argument, parameter, preload and slope."""
        changing = (*self.arguments, *self.parameters, *self.system.slopes.values())
        return {each: sympy.Symbol(f"_{each.name}.change", real=True) for each in changing}

    @property
    def _stated_slopes(self) -> dict[sympy.Symbol, dict[sympy.Symbol, sympy.Expr]]:
        """The symbol that stands for the slope of every tabulated force by its variable."""
        variables = self.table_variables
        return {
            self.elements[name].tabulated: {variables[name]: slope}
            for name, slope in self.system.slopes.items()
        }

    @cached_property
    def table_variables(self) -> dict[str, sympy.Expr]:
        """Deflection or rate that a table is over, by its element's name."""
        found = {}
        for name, law in self.system.knotted.items():
            answer = self.elements[name]
            found[name] = law.argument(answer.deflection, answer.rate)
        return found

    def jacobian(self, variables: Sequence[sympy.Symbol]) -> list[list[sympy.Expr]]:
        """Exact derivatives of residual and outputs, shape (n + outputs, variables), by any symbols.

        The symbols are arguments or parameters. Where a force bends, the derivative is the mean of both
        sides' for Max, Min and Abs, and that of the piece which holds there for a Piecewise.

        Raises
        ------
        ValueError
            If a symbol is neither.
        """
        known = {*self.arguments, *self.parameters}
        for variable in variables:
            if variable not in known:
                raise ValueError(f"variables: {variable!r} is no argument or parameter of the equations")
        return self.program.differentiate(self._results, variables)

    @property
    def _results(self) -> list[sympy.Expr]:
        return [*self.residual, *self.outputs.values()]

    @cached_property
    def parameters(self) -> tuple[sympy.Symbol, ...]:
        """Every symbol of residual and outputs that is no argument, by name: parameters and preloads."""
        program = self.program
        definitions = program.required(self._results)
        mentioned = set().union(*(e.free_symbols for e in (*definitions.values(), *self._results)))
        rest = sorted(mentioned - set(definitions) - set(self.arguments), key=lambda symbol: str(symbol.name))
        for one, other in pairwise(rest):
            if one.name == other.name:
                raise MechanismError(
                    f"{self.system.name!r}: {one.name!r} stands for two symbols of different assumptions; "
                    "use one"
                )
        return tuple(rest)

    @cached_property
    def _switches(self) -> tuple[sympy.Expr, ...]:
        """What a change of sign of makes the residual jump or bend, as the program's assignments have it."""
        moving, found = set(self.arguments), dict[sympy.Expr, None]()
        for symbol, expression in self.program.required(self.residual).items():
            if expression.free_symbols & moving:
                moving.add(symbol)
                found |= dict.fromkeys(s for s in switches(expression) if s.free_symbols & moving)
        return tuple(found)

    @cached_property
    def knot_distances(self) -> list[sympy.Expr]:
        """Expressions whose change of sign along a motion makes the residual jump or bend."""
        return [self.program.let(each) for each in self._switches]

    @cached_property
    def kinks(self) -> tuple[Kink, ...]:
        """What happens where each of the knot distances changes its sign."""
        pushes = [
            self.program.definitions.get(answer.force, answer.force) for answer in self.elements.values()
        ]
        pushes = [self.program.definitions.get(push, push) for push in pushes]
        return tuple(max(kink_of(s, push) for push in (sympy.S.Zero, *pushes)) for s in self._switches)

    @cached_property
    def sides(self) -> tuple[sympy.Symbol, ...]:
        """A symbol for the side of every knot: 1 where its distance is positive, 0 where it is negative."""
        return tuple(sympy.Symbol(f"_side.{i}", real=True) for i in range(len(self._switches)))

    @cached_property
    def held_right_hand_side(self) -> tuple[sympy.Expr, ...]:
        """The right-hand side whose laws go on smoothly beyond their knots, as `sides` say."""
        sides = dict(zip(self._switches, self.sides, strict=True))
        replaced: dict[sympy.Symbol, sympy.Expr] = {}
        for symbol, expression in self.program.required(self.accelerations).items():
            smooth = held(expression, sides).xreplace(replaced)
            if smooth != expression:
                replaced[symbol] = self.program.let(smooth)
        return tuple(sympy.sympify(each).xreplace(replaced) for each in self.right_hand_side)

    @property
    def operations(self) -> dict[str, int]:
        """Arithmetic operations of M and h together, and of the whole right-hand side."""
        upper = [self.mass_matrix[i][j] for i in range(len(self.bias)) for j in range(i, len(self.bias))]
        return {
            "mass_matrix_and_bias": self.program.operations([*upper, *self.bias]),
            "right_hand_side": self.program.operations(self.accelerations),
        }

    @cached_property
    def kinetic_energy(self) -> sympy.Expr:
        """T, written out (J); refused with a MechanismError, as all that follow, if too long to read."""
        return written_out(self, [self.energies.kinetic])[0]

    @cached_property
    def potential_energy(self) -> sympy.Expr:
        """V, written out (J)."""
        return written_out(self, [self.energies.potential])[0]

    @cached_property
    def dissipation(self) -> sympy.Expr:
        """Rayleigh's dissipation function D, written out (W)."""
        return written_out(self, [self.energies.dissipation])[0]

    @property
    def lagrangian(self) -> sympy.Expr:
        """L = T - V, written out (J)."""
        return self.kinetic_energy - self.potential_energy

    @cached_property
    def lagrange_equations(self) -> tuple[sympy.Eq, ...]:
        """d/dt(dT/dq') - dT/dq + dV/dq + dD/dq' = Q of every coordinate, written out."""
        return lagrange_equations(self)

    def _repr_latex_(self) -> str:
        return displayed(self)
