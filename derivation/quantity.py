"""Quantities: numbers with their units, and text such as ``200 N*m/deg``, converted to SI."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterable, Sequence
from numbers import Real
from typing import TYPE_CHECKING, TypeAlias

from chassym.derivation.schema import ParameterDefinition, refusal

if TYPE_CHECKING:
    import pint

Value: TypeAlias = float | tuple[float, ...]

_NUMBER = r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|(?:nan|inf)\b)"
_QUANTITY = re.compile(rf"\s*(?:({_NUMBER})|\[([^\[\]]*)\])\s*(.*?)\s*")
_NAME = re.compile(r"[A-Za-zµμΩ°%]\w*")
_NAMED = ("N", "J", "W", "Pa", "V", "ohm", "F", "H", "T")  # SI units with names of their own
# Only names, "1" and powers with a small whole exponent reach pint, which would try to evaluate m**9**9**9.
_UNIT = re.compile(
    r"(?:[A-Za-zµμΩ°%]\w*+|1(?!\w)|(?:\*\*|\^)\s*-?\d{1,2}+(?!\w|\s*(?:\^|\*\*|\d))|[\s*/.()])++", re.ASCII
)


def parse_quantity(
    definition: ParameterDefinition, given: float | Sequence[float] | str, origin: str
) -> Value:
    """A value in SI, from numbers in SI or from text with a unit, which is SI without one.

    Raises
    ------
    ParameterError
        If the definition does not admit the value; the message begins with ``origin``.

    Examples
    --------
    >>> parse_quantity(ParameterDefinition("travel", "m"), "25 mm", "text")
    0.025
    >>> parse_quantity(ParameterDefinition("velocities", "m/s", length=3), "[-150, 0, 100] mm/s", "text")
    (-0.15, 0.0, 0.1)
    """
    raw, unit = _split_quantity(definition, given, origin) if isinstance(given, str) else (given, "")
    return si_value(definition, raw, unit or definition.unit, origin)


def si_value(definition: ParameterDefinition, raw: object, unit: str, origin: str) -> Value:
    """A value of a given unit, in SI, if the definition admits it.

    Raises
    ------
    ParameterError
        If it does not; the message begins with ``origin``.
    """
    numbers = _numbers(raw if definition.is_list else [raw])
    values = () if numbers is None else _converted(numbers, unit, definition, origin)
    if not definition.admits(values):
        received = shown(raw) if unit == "1" else f"{shown(raw)} {unit}"
        raise refusal(origin, definition.name, received, definition.expected)
    return values if definition.is_list else values[0]


def shown(value: object) -> str:
    """A value as Python writes it, cut to a readable length."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python does not print whole numbers of thousands of digits
        return "a value too long to print"
    return text if len(text) <= 80 else f"{text[:77]}..."


def coherent_unit(definition: ParameterDefinition, text: str, origin: str) -> str:
    """The unit of a text with the SI unit of its dimension for every name in it: N/mm gives N/m.

    Raises
    ------
    ParameterError
        If the text is no quantity, or its unit none.
    """
    unit = _split_quantity(definition, text, origin)[1]
    try:
        coherent = _NAME.sub(lambda name: _coherent(name[0], alone=name[0] == unit), unit)
        if unit and (not _UNIT.fullmatch(unit) or _unit_registry().parse_units(unit) is None):
            raise ValueError("not a product of powers of units")
    except Exception as error:  # pint's parser lets all kinds through
        received = f"the unit {shown(unit)} ({error})"
        raise refusal(origin, definition.name, received, "a unit such as N/mm") from error
    return coherent or "1"


def _coherent(name: str, *, alone: bool) -> str:
    """The SI unit of the same dimension as a unit of one name; in brackets if it is no name and not alone."""
    registry = _unit_registry()
    given = registry.parse_units(name)
    if "number_meter" in str(given):
        raise ValueError("known as a count of yarn, in m/g; a moment is N*m")
    for named in _NAMED:
        if registry.parse_units(named).dimensionality == given.dimensionality:
            return named
    base = f"{registry.Quantity(1, given).to_base_units().units:~C}".replace("**", "^") or "1"
    return base if alone or base.isalnum() else f"({base})"


def _split_quantity(
    definition: ParameterDefinition, text: str, origin: str
) -> tuple[float | list[float], str]:
    """Number or list, and unit, of text such as ``200 N*m/deg`` or ``[-1, 0.5] m/s``."""
    match = _QUANTITY.fullmatch(text)
    entries = [] if match is None or match[2] is None else [entry.strip() for entry in match[2].split(",")]
    if match is None or not all(re.fullmatch(_NUMBER, entry) for entry in entries):
        example = "'[-1, 0, 1] m/s'" if definition.is_list else "'200 N*m/deg'"
        raise refusal(origin, definition.name, shown(text), f"{definition.expected}, written like {example}")
    return [float(entry) for entry in entries] if match[1] is None else float(match[1]), match[3]


def _numbers(raw: object) -> tuple[float, ...] | None:
    """The numbers of a list; None if it is anything else. Whole numbers beyond all floats become infinite."""
    if not isinstance(raw, Sequence) or not all(
        isinstance(one, Real) and not isinstance(one, bool) for one in raw
    ):
        return None
    try:
        return tuple(map(float, raw))
    except OverflowError:
        return (math.inf,) * len(raw)


def _converted(
    numbers: Iterable[float], unit: str, definition: ParameterDefinition, origin: str
) -> tuple[float, ...]:
    """Numbers of some unit in the definition's SI unit."""
    if unit == definition.unit:
        return tuple(numbers)
    received, expected = f"the unit {shown(unit)}", f"one of the same dimension as {definition.unit}"
    if not _UNIT.fullmatch(unit):
        raise refusal(origin, definition.name, received, expected)
    registry = _unit_registry()
    try:
        given, wanted = registry.parse_units(unit), registry.parse_units(definition.unit)
        compatible = given.dimensionality == wanted.dimensionality
        converted = [registry.Quantity(one, given).to(wanted) for one in numbers] if compatible else []
    except Exception as error:  # pint's parser lets all kinds through, from tokenize.TokenError to TypeError
        raise refusal(origin, definition.name, f"{received} ({error})", expected) from error
    if not compatible:
        raise refusal(origin, definition.name, f"{received} of dimension {given.dimensionality}", expected)
    return tuple(float(one.magnitude) for one in converted)


@functools.cache
def _unit_registry() -> pint.UnitRegistry[float]:
    """The units pint knows, on its own registry: definitions a user adds elsewhere change no vehicle file.

    Importing pint and building the registry are slow; files in SI never need them. Pint's own cache on disk
    is left off: it fails without a writable home directory and when several processes start at once.
    """
    import pint

    return pint.UnitRegistry()
