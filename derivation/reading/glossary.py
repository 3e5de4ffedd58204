"""The glossary: for every symbol of the equations its typeset form, unit and description."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy

from chassym.derivation.body import Body, Input
from chassym.derivation.element import ForceElement
from chassym.derivation.joint import Step
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.parameters import Parameters
from chassym.derivation.reading.element_symbols import ElementSymbols, element_symbols
from chassym.derivation.reading.letters import coordinate_glyph, input_glyph, named_glyph, parameter_glyph
from chassym.derivation.reading.typography import Glyph, typeset

if TYPE_CHECKING:
    from chassym.derivation.equations_of_motion import EquationsOfMotion

ORDERS = (("", ""), ("rate of ", "/s"), ("acceleration of ", "/s^2"))
FORCES = {"N": "force", "N*m": "torque"}
MOTIONS = {"m": "displacement", "rad": "angle"}


@dataclass(frozen=True)
class Entry:
    """What a symbol stands for.

    Attributes
    ----------
    symbol
        As it stands in the expressions.
    latex
        Typeset, for mathematics; no two symbols of a system share it.
    unit
        SI unit, "1" without dimension; empty for parameters of which nothing is known.
    description
        In words.
    """

    symbol: sympy.Symbol
    latex: str
    unit: str
    description: str


@dataclass(frozen=True)
class _Item:
    """An entry before its typeset form has been made unlike all others."""

    symbol: sympy.Symbol
    glyph: Glyph
    order: int
    unit: str
    description: str


def glossary(equations: EquationsOfMotion, parameters: Parameters | None = None) -> dict[sympy.Symbol, Entry]:
    r"""An entry for every symbol of the equations and for what is named when they are printed.

    Coordinates with rates and accelerations, inputs with rates, parameters, preloads, slopes, and the
    deflection, rate and force of every element, in this order. Without a parameter set the units of
    parameters are empty.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> entries = load_model("half_car").glossary
    >>> entries[sympy.Symbol("pitch_rate", real=True)].latex
    '\\dot{\\theta}'
    >>> entry = entries[sympy.Symbol("tyre.front.stiffness", real=True)]
    >>> print(entry.latex, entry.unit, entry.description, sep="; ")
    k_{\text{tyre front}}; N/m; vertical stiffness of one front contact patch
    """
    items = [
        *_coordinates(equations),
        *_inputs(equations),
        *_constants(equations, parameters),
        *_element_items(equations, element_symbols(equations)),
    ]
    names = typeset([item.glyph for item in items])
    return {
        item.symbol: Entry(item.symbol, names[item.glyph].at(item.order), item.unit, item.description)
        for item in items
    }


def _coordinates(equations: EquationsOfMotion) -> Iterator[_Item]:
    steps, texts = {}, {}
    if isinstance(equations.system, Mechanism):
        for body in equations.system.bodies:
            for place, step in enumerate(body.joint.steps):
                steps[step.coordinate] = step
                texts[step.coordinate] = _motion(body, step, body.joint.steps[:place])
    glyphs = {each: coordinate_glyph(each, steps.get(each)) for each in equations.coordinates}
    for order, (prefix, per_time) in enumerate(ORDERS):
        for coordinate, glyph in glyphs.items():
            name = _words(coordinate.name)
            symbol = (coordinate.position, coordinate.rate, coordinate.acceleration)[order]
            text = f"{prefix}{name}" if order else texts.get(coordinate, f"generalised coordinate {name}")
            yield _Item(symbol, glyph, order, _per_time(coordinate.unit, per_time), text)


def _motion(body: Body, step: Step, before: tuple[Step, ...]) -> str:
    """A joint's step in words."""
    parent = "the ground" if body.parent is None else body.parent.name
    kind, way = ("rotation", "about") if step.is_rotation else ("displacement", "along")
    turned = [_words(each.coordinate.name) for each in before if each.is_rotation]
    after = f", after {' and '.join(turned)}" if turned else ""
    return f"{kind} of {body.name} relative to {parent} {way} {_axis(step)}{after}"


def _axis(step: Step) -> str:
    for name, place in zip("xyz", range(3), strict=True):
        rest = [component for i, component in enumerate(step.axis) if i != place]
        if not any(rest) and step.axis[place] in (1, -1):
            return name if step.axis[place] == 1 else f"-{name}"
    return f"({', '.join(map(str, step.axis))})"


def _inputs(equations: EquationsOfMotion) -> Iterator[_Item]:
    glyphs = {each: input_glyph(each) for each in equations.system.inputs}
    for order, (prefix, per_time) in enumerate(ORDERS[:2]):
        for prescribed, glyph in glyphs.items():
            symbol = (prescribed.position, prescribed.rate)[order]
            text = prescribed.description or _prescribed(prescribed)
            yield _Item(symbol, glyph, order, _per_time(prescribed.unit, per_time), f"{prefix}{text}")


def _prescribed(given: Input) -> str:
    what = (FORCES | MOTIONS).get(given.unit, "input")
    return f"prescribed {what} of {_words(given.name)}"


def _constants(equations: EquationsOfMotion, parameters: Parameters | None) -> Iterator[_Item]:
    """Parameters, preloads and slopes."""
    symbols = {symbol.name: symbol for symbol in _unexplained(equations)}
    elements = _elements(equations)
    preloads = {
        f"{name}.preload": element for name, element in elements.items() if element.preload is not None
    }
    slopes = {symbol.name: name for name, symbol in equations.system.slopes.items()}
    ordered = [] if parameters is None else [name for name in parameters.flat() if name in symbols]
    for name in [*ordered, *sorted(symbols.keys() - set(ordered) - preloads.keys() - slopes.keys())]:
        yield _parameter(symbols[name], parameters)
    for element in preloads.values():
        glyph = named_glyph("p", element.name)
        text = f"preload of {_words(element.name)}: its force at rest in the design position"
        yield _Item(element.preload, glyph, 0, element.unit, text)
    for symbol in equations.system.slopes.values():
        element = elements[slopes[symbol.name]]
        rate = equations.system.knotted[element.name].argument(sympy.S.Zero, sympy.S.One) == 1
        per, what = ("*s", "rate") if rate else ("", "deflection")
        unit = f"{element.unit}{per}/{element.port.unit}"
        text = f"slope of the force of {_words(element.name)} over its {what}"
        yield _Item(symbol, named_glyph("F'", element.name), 0, unit, text)


def _unexplained(equations: EquationsOfMotion) -> list[sympy.Symbol]:
    """Every symbol that is neither an argument nor a name of the program."""
    program, energies = equations.program, equations.energies
    results = [energies.kinetic, energies.potential, energies.dissipation, *energies.applied]
    results += [*equations.bias, *equations.generalized_forces, *equations.outputs.values()]
    results += [entry for row in equations.mass_matrix for entry in row]
    expressions = [*program.definitions.values(), *results]
    mentioned = set().union(*(expression.free_symbols for expression in expressions))
    mentioned |= {*equations.system.preloads, *equations.system.slopes.values()}
    asked = {*equations.motion.values(), *equations.change.values(), *equations.sides}
    return list(mentioned - set(program.definitions) - set(equations.arguments) - asked)


def _parameter(symbol: sympy.Symbol, parameters: Parameters | None) -> _Item:
    table, bracket, index = symbol.name.partition("[")
    unit, text = "", "parameter"
    if parameters is not None and table in parameters:
        parameter = parameters[table]
        unit = parameter.unit
        text = parameter.description or text
        text += f", entry {index.rstrip(']')}" if bracket else ""
    return _Item(symbol, parameter_glyph(symbol.name, unit), 0, unit, text)


def _element_items(equations: EquationsOfMotion, symbols: ElementSymbols) -> Iterator[_Item]:
    """What the elements' deflections, rates and forces are called where equations are printed."""
    for name, element in _elements(equations).items():
        what = _words(name)
        shift, force = named_glyph("s", name), named_glyph("F", name)
        unit = element.port.unit
        yield _Item(symbols.deflections[name], shift, 0, unit, f"deflection of {what}")
        yield _Item(symbols.rates[name], shift, 1, _per_time(unit, "/s"), f"rate of the deflection of {what}")
        yield _Item(symbols.forces[name], force, 0, element.unit, f"force with which {what} resists")


def _elements(equations: EquationsOfMotion) -> Mapping[str, ForceElement]:
    system = equations.system
    return {each.name: each for each in system.elements} if isinstance(system, Mechanism) else {}


def _per_time(unit: str, per_time: str) -> str:
    return f"{unit}{per_time}" if unit else ""


def _words(name: str) -> str:
    return name.replace("_", " ")
