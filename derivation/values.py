"""Numbers for equations of motion: a model from a mechanism, or a Lagrangian, and its parameters' values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import sympy

from chassym.derivation.compilation.numeric import CompiledEquations
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.lagrangian import Lagrangian
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.model import Model
from chassym.derivation.parameters import Parameter, Parameters
from chassym.derivation.quantity import coherent_unit, parse_quantity, shown
from chassym.derivation.schema import (
    ANY,
    NONNEGATIVE,
    POSITIVE,
    Domain,
    ParameterDefinition,
    ParameterError,
    Schema,
    refusal,
)
from chassym.derivation.system import System

Quantity: TypeAlias = float | str
"""A number in SI, or text with a unit such as "20 N/mm"."""

_ORIGIN = "values"


def build_model(
    source: System | EquationsOfMotion,
    values: Mapping[sympy.Symbol | str, Quantity | tuple[Quantity, str]],
    description: str = "",
) -> Model:
    """Give the parameters of a mechanism, or of equations of motion, their values.

    Parameters
    ----------
    source
        A mechanism, or equations of motion.
    values
        By symbol or name, for every parameter that the equations mention: a number in SI, text with a unit,
        or a pair of one of them and a description. Text settles the parameter's unit, against which later
        changes by text are checked; a bare number has no unit that could be known, and "1" is recorded. The
        value of a symbol declared positive or nonnegative has to be so. Preloads are not given but found.
    description
        What these values are of; the system's name by default.

    Raises
    ------
    ParameterError
        If a value is missing, unknown, given twice, not a finite number, or outside what its symbol admits.

    Examples
    --------
    >>> from chassym.derivation import Linear, JointPort, Mechanism, prismatic
    >>> m, k = sympy.symbols("m k", positive=True)
    >>> oscillator = Mechanism("oscillator", gravity=0)
    >>> mass = oscillator.add_body("mass", oscillator.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    >>> spring = JointPort(oscillator.coordinate("z"))
    >>> element = oscillator.add_force_element("spring", spring, Linear(k))
    >>> model = build_model(oscillator, {m: 2.0, k: ("20 N/mm", "rate of the spring")})
    >>> model.parameters["k"].value, model.parameters["k"].unit
    (20000.0, 'N/m')
    >>> model.with_parameters({"k": "25 N/mm"}).values["k"]
    25000.0
    """
    if not isinstance(source, Mechanism | Lagrangian | EquationsOfMotion):
        raise TypeError(
            f"{type(source).__name__} received; expected a mechanism, a Lagrangian or equations of motion"
        )
    system = source.system if isinstance(source, EquationsOfMotion) else source
    compiled = CompiledEquations(source)
    equations = source if isinstance(source, EquationsOfMotion) else compiled.equations
    given, symbols = _by_name(values), _symbols(equations)
    _check_complete(equations, symbols, given)
    found = [_parameter(symbols[name], *quantity) for name, quantity in given.items()]
    schema = Schema(system.name, tuple(definition for definition, _ in found))
    parameters = Parameters(schema, description or system.name, tuple(parameter for _, parameter in found))
    return Model(parameters, compiled)


def _by_name(
    values: Mapping[sympy.Symbol | str, Quantity | tuple[Quantity, str]],
) -> dict[str, tuple[Quantity, str]]:
    """Every value with its description, by the name of its parameter."""
    found: dict[str, tuple[Quantity, str]] = {}
    for key, given in values.items():
        name = key.name if isinstance(key, sympy.Symbol) else key
        if not isinstance(name, str):
            raise ParameterError(f"{_ORIGIN}: key {key!r} received; expected a symbol or a name")
        if name in found:
            raise refusal(_ORIGIN, name, "two values", "one, by the symbol or by its name")
        pair = given if isinstance(given, tuple) else (given, "")
        if len(pair) != 2 or not isinstance(pair[1], str):
            raise refusal(_ORIGIN, name, shown(given), "a value, or a pair of a value and its description")
        found[name] = pair
    return found


def _symbols(equations: EquationsOfMotion) -> dict[str, list[sympy.Symbol]]:
    """What may have a value, by name: all symbols of equations, outputs and energies, preloads left out."""
    program, energies = equations.program, equations.energies
    terms = [energies.kinetic, energies.potential, energies.dissipation, *energies.applied]
    definitions = program.required(terms)
    mentioned = set(equations.parameters).union(*(e.free_symbols for e in (*terms, *definitions.values())))
    mentioned -= {*program.definitions, *equations.arguments, *equations.system.preloads}
    found: dict[str, list[sympy.Symbol]] = {}
    for symbol in sorted(mentioned, key=lambda each: str(each.name)):
        found.setdefault(symbol.name, []).append(symbol)
    return found


def _check_complete(
    equations: EquationsOfMotion, symbols: Mapping[str, object], given: Mapping[str, object]
) -> None:
    """Refuse unknown names, and missing values of what the equations mention."""
    for name in given:
        if not symbols:
            raise refusal(_ORIGIN, name, "an unknown name", "no values: the equations have no parameters")
        if name not in symbols:
            possible = tuple(ParameterDefinition(each, "1") for each in symbols)
            raise Schema(equations.system.name, possible).unknown(name, _ORIGIN)
    unneeded = {symbol.name for symbol in equations.system.preloads} | given.keys()
    missing = dict.fromkeys(s.name for s in equations.parameters if s.name not in unneeded)
    if missing:
        raise refusal(
            _ORIGIN, ", ".join(missing), "nothing", "a number in SI, or text as '20 N/mm', for each"
        )


def _parameter(
    symbols: list[sympy.Symbol], given: Quantity, description: str
) -> tuple[ParameterDefinition, Parameter]:
    """A definition that suits a symbol and its value, and the parameter."""
    name, domain = symbols[0].name, _domain(symbols)
    draft = ParameterDefinition(name, "1", domain)
    unit = coherent_unit(draft, given, _ORIGIN) if isinstance(given, str) else draft.unit
    definition = ParameterDefinition(name, unit, domain)
    value = parse_quantity(definition, given, _ORIGIN)
    return definition, Parameter(name, value, unit, description or name, _ORIGIN)


def _domain(symbols: list[sympy.Symbol]) -> Domain:
    """What the assumptions of a symbol admit."""
    if any(symbol.is_positive for symbol in symbols):
        return POSITIVE
    return NONNEGATIVE if any(symbol.is_nonnegative for symbol in symbols) else ANY
