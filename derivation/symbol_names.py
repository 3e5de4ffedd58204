"""Whether every symbol of a mechanism means one thing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import sympy

from chassym.derivation.body import Body, Input
from chassym.derivation.characteristic import ForceLaw
from chassym.derivation.element import ForceElement
from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate
from chassym.derivation.output import UserOutput
from chassym.derivation.references import contents

if TYPE_CHECKING:
    from chassym.derivation.mechanism import Mechanism


def check_symbols(mechanism: Mechanism) -> None:
    """Refuse parameters that bear the name of something else, or of each other.

    Raises
    ------
    MechanismError
        If a parameter is named as a coordinate, input, preload or slope, or as an intermediate result; if
        two symbols of one name differ in their assumptions; or if a formula mentions such a one in place of
        the coordinate.
    """
    own = {symbol.name: symbol for symbol in _own_symbols(mechanism)}
    parts = [*mechanism.bodies, *mechanism.elements, *mechanism.applied, *mechanism.outputs]
    seen = dict(own)
    for part in parts:
        placed: set[sympy.Symbol] = set()
        formulas: set[sympy.Symbol] = set()
        _collect(part, placed, formulas)
        for symbol in sorted(placed | formulas, key=lambda each: str(each.name)):
            known = seen.setdefault(symbol.name, symbol)
            if symbol.name.startswith("_"):
                _refuse(part, symbol, "begins with an underscore, which is kept for intermediate results")
            if symbol in placed and symbol.name in own:
                _refuse(
                    part, symbol, "is that of a coordinate, input, preload or slope; rename the parameter"
                )
            if known != symbol and symbol.name in own:
                _refuse(part, symbol, "is a coordinate's or input's; use its own symbol, such as `.position`")
            if known != symbol:
                _refuse(part, symbol, "stands for two symbols of different assumptions; use one")


def _own_symbols(mechanism: Mechanism) -> Iterator[sympy.Symbol]:
    for coordinate in mechanism.coordinates:
        yield from (coordinate.position, coordinate.rate, coordinate.acceleration)
    for prescribed in mechanism.inputs:
        yield from (prescribed.position, prescribed.rate)
    yield from mechanism.preloads
    yield from mechanism.slopes.values()


def _refuse(part: object, symbol: sympy.Symbol, why: str) -> None:
    raise MechanismError(
        f"{getattr(part, 'name', 'applied load')!r}: the name of symbol {symbol.name!r} {why}"
    )


def _collect(value: object, placed: set[sympy.Symbol], formulas: set[sympy.Symbol]) -> None:
    """The symbols in a part: parameters, and what formulas mention, which may be the motion itself."""
    if isinstance(value, ForceLaw):
        formulas |= value.expression.free_symbols - {value.deflection, value.rate}
    elif isinstance(value, UserOutput):
        formulas |= sympy.sympify(value.formula).free_symbols - set(value.quantities)
    elif isinstance(value, sympy.Basic):
        placed |= value.free_symbols
    elif isinstance(value, ForceElement):
        _collect((value.port, value.characteristic), placed, formulas)
    else:
        for inside in contents(value):
            if not isinstance(inside, Body | Coordinate | Input | ForceElement):  # looked at themselves
                _collect(inside, placed, formulas)
