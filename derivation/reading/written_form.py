"""The equations of motion as rows to be typeset: written out, or in straight-line form with named results."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy

from chassym.derivation.program import Program
from chassym.derivation.reading.element_symbols import element_symbols
from chassym.derivation.reading.lagrange_form import masses
from chassym.derivation.reading.tidy import sorted_by, tidied, without_rounding

if TYPE_CHECKING:
    from chassym.derivation.equations_of_motion import EquationsOfMotion


@dataclass(frozen=True)
class Row:
    """An equation: terms on the left, an expression on the right."""

    left: tuple[sympy.Expr | str, ...]
    right: sympy.Expr

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """Every symbol of both sides."""
        expressions = [self.right, *(each for each in self.left if not isinstance(each, str))]
        return set().union(*(expression.free_symbols for expression in expressions))


@dataclass(frozen=True)
class WrittenForm:
    """Everything written out, elements by their deflections s, rates and forces F.

    Attributes
    ----------
    energies
        T, V and D.
    elements
        Deflections, rates and forces of the elements that energies and equations mention.
    motion
        One equation per coordinate.
    """

    energies: tuple[Row, ...]
    elements: tuple[Row, ...]
    motion: tuple[Row, ...]


def written_form(equations: EquationsOfMotion) -> WrittenForm:
    """The equations of a small model, lightly tidied."""
    symbols, energies = element_symbols(equations), equations.energies
    forces = symbols.printed_forces
    states = {**symbols.printed_deflections, **symbols.printed_rates}
    stated = [energies.potential, energies.dissipation]
    values = [*expanded(equations.program, [energies.kinetic], {})]
    values += expanded(equations.program, stated, states)
    first = tuple(Row((name,), tidied(value)) for name, value in zip("TVD", values, strict=True))
    motion = tuple(_motion(equations, forces))
    elements = _elements(equations.program, forces, states, [*first, *motion])
    return WrittenForm(first, elements, motion)


def expanded(
    program: Program, results: Sequence[sympy.Expr], kept: Mapping[sympy.Symbol, sympy.Expr]
) -> list[sympy.Expr]:
    """Results written out, except that some names of the program are replaced by given symbols."""
    full = dict(kept)
    for symbol, expression in program.required(results).items():
        if symbol not in full:
            full[symbol] = expression.xreplace(full)
    return [sympy.sympify(result).xreplace(full) for result in results]


def _motion(equations: EquationsOfMotion, forces: Mapping[sympy.Symbol, sympy.Symbol]) -> Iterator[Row]:
    """M q'' + h = Q, a row for every coordinate."""
    coordinates = equations.coordinates
    rates = [coordinate.rate for coordinate in coordinates]
    bias = expanded(equations.program, equations.bias, {})
    applied = expanded(equations.program, equations.generalized_forces, forces)
    for row, h, q in zip(equations.mass_matrix, bias, applied, strict=True):
        factors = map(tidied, expanded(equations.program, row, {}))
        inertia = [m * c.acceleration for m, c in zip(factors, coordinates, strict=True) if m != 0]
        rest = without_rounding(tidied(sorted_by(h, rates, masses(equations))), beside=inertia)
        right = tidied(sorted_by(q, list(forces.values()), []))
        yield Row((*inertia, *([] if rest == 0 else [rest])), right)


def _elements(
    program: Program,
    forces: Mapping[sympy.Symbol, sympy.Symbol],
    states: Mapping[sympy.Symbol, sympy.Symbol],
    rows: Sequence[Row],
) -> tuple[Row, ...]:
    """Rows for what other rows mention of the elements: deflections and rates, then forces."""
    mentioned = set().union(*(row.symbols for row in rows))
    laws = []
    for name, symbol in forces.items():
        if symbol in mentioned:
            laws.append(Row((symbol,), expanded(program, [program.definitions[name]], states)[0]))
    mentioned |= set().union(*(row.symbols for row in laws))
    motions = [
        Row((symbol,), tidied(program.expand([program.definitions[name]])[0]))
        for name, symbol in states.items()
        if symbol in mentioned
    ]
    return (*motions, *laws)


@dataclass(frozen=True)
class StraightLineForm:
    """Named intermediate results in the order of evaluation, then M, h, Q and the energies in terms of them.

    Attributes
    ----------
    names
        The symbols that intermediate results have here, with their numbers; elements keep their own.
    steps, results
        Rows of the intermediate results, and of the entries of M, h and Q, and of T, V and D.
    """

    names: Mapping[sympy.Symbol, int]
    steps: tuple[Row, ...]
    results: tuple[Row, ...]


def straight_line_form(equations: EquationsOfMotion) -> StraightLineForm:
    """The equations of a large model as they are evaluated."""
    symbols, program = element_symbols(equations), equations.program
    entries = list(_entries(equations))
    required = program.required([value for _, value in entries])
    kept: dict[sympy.Symbol, sympy.Symbol] = symbols.printed
    numbers = {name: number for number, name in enumerate((s for s in required if s not in kept), start=1)}
    steps = tuple(Row((kept.get(s, s),), e.xreplace(kept)) for s, e in required.items())
    results = tuple(Row((name,), value.xreplace(kept)) for name, value in entries)
    return StraightLineForm(numbers, steps, results)


def _entries(equations: EquationsOfMotion) -> Iterable[tuple[str, sympy.Expr]]:
    """The upper half of M without its zeros, h and Q, counted from 1, then T, V and D."""
    for i, row in enumerate(equations.mass_matrix, start=1):
        for j, entry in enumerate(row[i - 1 :], start=i):
            if entry != 0:
                yield f"M_{{{i},{j}}}", entry
    for letter, vector in (("h", equations.bias), ("Q", equations.generalized_forces)):
        for i, entry in enumerate(vector, start=1):
            yield f"{letter}_{{{i}}}", entry
    energies = equations.energies
    yield from (("T", energies.kinetic), ("V", energies.potential), ("D", energies.dissipation))
