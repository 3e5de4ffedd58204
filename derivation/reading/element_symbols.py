"""Symbols for the deflection, rate and force of every element, which stand for them in printed equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy

if TYPE_CHECKING:
    from chassym.derivation.equations_of_motion import EquationsOfMotion
    from chassym.derivation.program import Program


@dataclass(frozen=True)
class ElementSymbols:
    """The symbols s_..., v_... and F_... of elements.

    Elements at one deflection have one name for it on the program; the symbol of one of them stands for it,
    one whose force depends on it if there is any. A known number, such as the deflection of a port that
    cannot move, is printed as that number and not by a symbol.

    Attributes
    ----------
    deflections, rates, forces
        Symbols by the name of the element.
    printed_deflections, printed_rates, printed_forces
        The symbol to print for a name of the program that is no known number.
    """

    deflections: Mapping[str, sympy.Symbol]
    rates: Mapping[str, sympy.Symbol]
    forces: Mapping[str, sympy.Symbol]
    printed_deflections: Mapping[sympy.Symbol, sympy.Symbol]
    printed_rates: Mapping[sympy.Symbol, sympy.Symbol]
    printed_forces: Mapping[sympy.Symbol, sympy.Symbol]

    @property
    def printed(self) -> dict[sympy.Symbol, sympy.Symbol]:
        """The symbols to print for all three."""
        return {**self.printed_deflections, **self.printed_rates, **self.printed_forces}


def element_symbols(equations: EquationsOfMotion) -> ElementSymbols:
    """Symbols for the elements, unlike all others that the equations mention."""
    program, elements = equations.program, equations.elements
    taken = {s.name for e in program.definitions.values() for s in e.free_symbols}
    taken |= {symbol.name for symbol in (*equations.arguments, *equations.system.slopes.values())}
    known = _known_numbers(program)

    def named(letter: str) -> dict[str, sympy.Symbol]:
        return {name: _symbol(f"{letter}_{name}", taken) for name in elements}

    def printed(
        symbols: Mapping[str, sympy.Symbol], names: Mapping[str, sympy.Symbol]
    ) -> dict[sympy.Symbol, sympy.Symbol]:
        found: dict[sympy.Symbol, sympy.Symbol] = {}
        ordered = sorted(elements, key=lambda element: names[element] not in needed[element])
        for element in ordered:
            found.setdefault(names[element], symbols[element])
        return {name: found[name] for name in names.values() if name not in known}

    needed = {name: program.required([answer.force]) for name, answer in elements.items()}
    shifts, rates, forces = named("s"), named("v"), named("F")
    return ElementSymbols(
        shifts,
        rates,
        forces,
        printed(shifts, {name: answer.deflection for name, answer in elements.items()}),
        printed(rates, {name: answer.rate for name, answer in elements.items()}),
        printed(forces, {name: answer.force for name, answer in elements.items()}),
    )


def _symbol(name: str, taken: set[str]) -> sympy.Symbol:
    """A symbol of that name, or the like where it is taken; its name is taken from then on."""
    while name in taken:
        name += "_"
    taken.add(name)
    return sympy.Symbol(name, real=True)


def _known_numbers(program: Program) -> set[sympy.Symbol]:
    """The names of a program that depend on no symbol."""
    known: set[sympy.Symbol] = set()
    for name, expression in program.definitions.items():
        if expression.free_symbols <= known:
            known.add(name)
    return known
