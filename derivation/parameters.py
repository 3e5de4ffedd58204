"""Parameters of a vehicle: read from a TOML file, converted to SI, checked against what its model declares.

A file holds ``model``, ``description`` and nested tables; a parameter is named by its dotted path::

    [body.front]
    mass = { value = 475.0, unit = "kg", description = "mass of the front section", source = "weighed" }

A ``reading`` may be added where a source is ambiguous: what it was taken to mean, and why.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from itertools import pairwise
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import pint

Value: TypeAlias = float | tuple[float, ...]

_TEXT_FIELDS = ("unit", "description", "source")
_FIELDS = ("value", *_TEXT_FIELDS, "reading")
_LEAF = "a table { value, unit, description, source }"
_TRIANGLE_TOLERANCE = 1e-12  # a flat plate has zz = xx + yy, up to the rounding of its conversion to SI

_NUMBER = r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|(?:nan|inf)\b)"
_QUANTITY = re.compile(rf"\s*(?:({_NUMBER})|\[([^\[\]]*)\])\s*(.*?)\s*")
# Only names, "1" and powers with a small whole exponent reach pint, which would try to evaluate m**9**9**9.
_UNIT = re.compile(
    r"(?:[A-Za-zµμΩ°%]\w*+|1(?!\w)|(?:\*\*|\^)\s*-?\d{1,2}+(?!\w|\s*(?:\^|\*\*|\d))|[\s*/.()])++", re.ASCII
)


class ParameterError(ValueError):
    """A parameter, or a file of parameters, that cannot be accepted; the message is one line."""

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.splitlines()))


@dataclass(frozen=True)
class Domain:
    """What is physically possible for a value in SI: a description and the test of the numbers."""

    description: str
    admits: Callable[[Sequence[float]], bool]


def _any(values: Sequence[float]) -> bool:
    return True


def _positive(values: Sequence[float]) -> bool:
    return all(value > 0 for value in values)


def _nonnegative(values: Sequence[float]) -> bool:
    return all(value >= 0 for value in values)


def _increasing(values: Sequence[float]) -> bool:
    return all(first < second for first, second in pairwise(values))


ANY = Domain("finite", _any)
POSITIVE = Domain("greater than zero", _positive)
NONNEGATIVE = Domain("zero or greater", _nonnegative)
INCREASING = Domain("strictly increasing", _increasing)


@dataclass(frozen=True)
class ParameterDefinition:
    """What a model expects of one parameter.

    Parameters
    ----------
    name
        Dotted path, such as ``body.front.mass``.
    unit
        SI unit, ``"1"`` if dimensionless.
    domain
        What is physically possible.
    length
        Number of entries of a list; None for a scalar, or for a table of any length from two.
    same_length_as
        Name of the table that has as many entries as this one.
    """

    name: str
    unit: str
    domain: Domain = ANY
    length: int | None = None
    same_length_as: str | None = None

    @property
    def is_table(self) -> bool:
        """Whether the value is a list of any length from two: increasing, or as long as another table."""
        return self.length is None and (self.domain == INCREASING or self.same_length_as is not None)

    @property
    def is_list(self) -> bool:
        """Whether the value is a list at all."""
        return self.is_table or self.length is not None

    @property
    def expected(self) -> str:
        """What is accepted, in words."""
        size = "at least 2" if self.is_table else self.length
        what = f"a list of {size} finite numbers" if self.is_list else "one finite number"
        restriction = "" if self.domain == ANY else f", {self.domain.description}"
        return f"{what}{restriction}, in {'unit 1 (dimensionless)' if self.unit == '1' else self.unit}"

    def admits(self, values: Sequence[float]) -> bool:
        """Whether SI numbers are as many as expected, finite and inside the domain."""
        enough = len(values) >= 2 if self.is_table else len(values) == (self.length or 1)
        return enough and all(map(math.isfinite, values)) and self.domain.admits(values)


@dataclass(frozen=True)
class Schema:
    """All parameters of a model.

    Parameters
    ----------
    model
        The name a file gives in its key ``model``.
    definitions
        What is expected of each parameter.
    inertias
        Prefixes whose ``.xx .yy .zz`` are principal moments of inertia of a body.
    """

    model: str
    definitions: tuple[ParameterDefinition, ...]
    inertias: tuple[str, ...] = ()

    @functools.cached_property
    def by_name(self) -> Mapping[str, ParameterDefinition]:
        """The definitions by name, in their order."""
        return {definition.name: definition for definition in self.definitions}

    @functools.cached_property
    def groups(self) -> frozenset[str]:
        """Every proper prefix of a name: ``body`` and ``body.front`` of ``body.front.mass``."""
        parts = [name.split(".") for name in self.by_name]
        return frozenset(".".join(names[:depth]) for names in parts for depth in range(1, len(names)))

    def unknown(self, name: str, origin: str) -> ParameterError:
        """The error for a name that this model does not have, with the nearest ones it has."""
        nearest = difflib.get_close_matches(
            name[:100], [*self.by_name, *sorted(self.groups)], n=3, cutoff=0.0
        )
        return _refusal(origin, name, "an unknown name", f"one such as {', '.join(nearest)}")


@dataclass(frozen=True)
class Parameter:
    """A value in SI with its provenance; ``reading`` tells how an ambiguous source was understood."""

    name: str
    value: Value
    unit: str
    description: str
    source: str
    reading: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Parameters(Mapping[str, Parameter]):
    """The complete, checked parameters of a vehicle in the order of its schema; immutable.

    Made by `load_parameters` and `parse_parameters`. Two sets are equal if all their parameters are.
    """

    schema: Schema
    description: str
    parameters: tuple[Parameter, ...]

    @functools.cached_property
    def _by_name(self) -> dict[str, Parameter]:
        return {parameter.name: parameter for parameter in self.parameters}

    def __getitem__(self, name: str) -> Parameter:
        return self._by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self.parameters)

    def __hash__(self) -> int:
        return hash(frozenset(self.parameters))

    def __repr__(self) -> str:
        return f"<Parameters of {self.schema.model}: {self.description}>"

    def value(self, name: str) -> Value:
        """The value of a parameter in SI.

        Raises
        ------
        ParameterError
            If there is no such parameter.
        """
        if name not in self:
            raise self.schema.unknown(name, "parameters")
        return self[name].value

    def flat(self) -> dict[str, float]:
        """Every number in SI by name, in the order of the schema; a list has ``name[0]``, ``name[1]``, ..."""
        numbers: dict[str, float] = {}
        for name, parameter in self.items():
            if isinstance(parameter.value, tuple):
                numbers |= {f"{name}[{index}]": number for index, number in enumerate(parameter.value)}
            else:
                numbers[name] = parameter.value
        return numbers

    def replace(
        self, changes: Mapping[str, float | Sequence[float] | str], *, origin: str = "override"
    ) -> Parameters:
        """A new set with other values, checked in full again.

        Parameters
        ----------
        changes
            New values by name: numbers in SI, or text with a unit such as ``"200 N*m/deg"`` or
            ``"[-2400, 0, 1100] N"`` (in SI without one).
        origin
            Where the values come from: begins error messages and becomes the source of the new values.

        Raises
        ------
        ParameterError
            For an unknown name, or a value that the schema does not admit.
        """
        replaced = dict(self._by_name)
        for name, given in changes.items():
            definition = self.schema.by_name.get(name)
            if definition is None:
                raise self.schema.unknown(name, origin)
            raw, unit = _split_quantity(given, name, origin) if isinstance(given, str) else (given, "")
            value = _si_value(definition, raw, unit or definition.unit, origin)
            replaced[name] = dataclasses.replace(self[name], value=value, source=origin, reading="")
        return _checked(dataclasses.replace(self, parameters=tuple(replaced.values())), origin)

    def scaled(self, *names: str, factor: float) -> Parameters:
        """A new set with values multiplied by a factor, checked in full again.

        Parameters
        ----------
        *names
            Names, or prefixes of names: ``tyre`` and ``tyre.front.stiffness`` stand for all parameters below.
        factor
            Multiplies every value once, and all entries of a list.

        Raises
        ------
        ParameterError
            For a name that is neither, or a product that the schema does not admit.
        """
        origin = f"scaled by {factor}"
        changes: dict[str, float | Sequence[float] | str] = {}
        for prefix in names:
            below = [name for name in self if f"{name}.".startswith(f"{prefix}.")]
            if not below:
                raise self.schema.unknown(prefix, origin)
            changes |= {name: _times(factor, self[name].value) for name in below}
        return self.replace(changes, origin=origin)


def load_parameters(path: str | Path | Traversable, schema: Schema, *alternatives: Schema) -> Parameters:
    """Read a vehicle file.

    Parameters
    ----------
    path
        A TOML file, or one among the resources of a package.
    schema, *alternatives
        What the models declare; the one that the file names as its ``model`` is used.

    Raises
    ------
    ParameterError
        If the file cannot be read or its contents cannot be accepted.
    """
    file = Path(path) if isinstance(path, str) else path
    try:
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise _refusal(str(path), "file", f"an error ({error.strerror})", "a readable TOML file") from error
    except ValueError as error:  # bytes that are not UTF-8, or a path with a null character
        raise _refusal(str(path), "file", f"an error ({error})", "a TOML file in UTF-8") from error
    return parse_parameters(text, schema, *alternatives, origin=str(path))


def parse_parameters(text: str, schema: Schema, *alternatives: Schema, origin: str = "text") -> Parameters:
    """Read the text of a vehicle file; ``origin`` begins error messages. See `load_parameters`.

    Examples
    --------
    >>> schema = Schema("point", (ParameterDefinition("body.mass", "kg", POSITIVE),))
    >>> point = parse_parameters('''
    ...     model = "point"
    ...     description = "a point mass"
    ...     [body]
    ...     mass = { value = 475e3, unit = "g", description = "mass", source = "weighed" }
    ... ''', schema)
    >>> point.value("body.mass"), point["body.mass"].unit
    (475.0, 'kg')
    >>> point.replace({"body.mass": "0.5 t"}).value("body.mass")
    500.0
    """
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise _refusal(origin, "file", f"text that is not TOML ({error})", "a vehicle in TOML") from error
    models = {candidate.model: candidate for candidate in (schema, *alternatives)}
    model = _text(document, "model", "model", origin, expected=f"one of {', '.join(models)}")
    if model not in models:
        raise _refusal(origin, "model", _shown(model), f"one of {', '.join(models)}")
    description = _text(document, "description", "description", origin)
    tables = {key: entry for key, entry in document.items() if key not in ("model", "description")}
    leaves = dict(_leaves(tables, models[model], origin))
    found = (_read(each, leaves.get(each.name), origin) for each in models[model].definitions)
    return _checked(Parameters(models[model], description, tuple(found)), origin)


def parse_assignment(text: str, *, origin: str = "--set") -> tuple[str, str]:
    """Split ``NAME=VALUE`` of the command line into name and text for `Parameters.replace`.

    Raises
    ------
    ParameterError
        If either half is missing.

    Examples
    --------
    >>> parse_assignment("body.front.mass = 480 kg")
    ('body.front.mass', '480 kg')
    """
    name, _, value = (part.strip() for part in text.partition("="))
    if not name or not value:
        raise ParameterError(
            f"{origin}: received {_shown(text)}, expected NAME=VALUE, such as body.front.mass='480 kg'"
        )
    return name, value


def _refusal(origin: str, name: str, received: str, expected: str) -> ParameterError:
    return ParameterError(f"{origin}: {name}: received {received}, expected {expected}")


def _shown(value: object) -> str:
    """A value as Python writes it, cut to a readable length."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python does not print whole numbers of thousands of digits
        return "a value too long to print"
    return text if len(text) <= 80 else f"{text[:77]}..."


def _text(table: Mapping[str, Any], field: str, name: str, origin: str, expected: str = "text") -> str:
    """A field that must be there and say something."""
    text = table.get(field)
    if not isinstance(text, str) or not text.strip():
        raise _refusal(origin, name, _shown(text) if field in table else "nothing", expected)
    return text


def _leaves(
    table: Mapping[str, Any], schema: Schema, origin: str, prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """The entries that stand where the schema has parameters, by name; every other entry is refused."""
    for key, entry in table.items():
        name = prefix + (f'"{key}"' if "." in key else key)  # a quoted key with a dot is not a path
        if name in schema.by_name:
            yield name, entry
        elif name not in schema.groups:
            raise schema.unknown(name, origin)
        elif not isinstance(entry, dict):
            raise _refusal(origin, name, _shown(entry), f"a table of parameters {name}.*")
        else:
            yield from _leaves(entry, schema, origin, f"{name}.")


def _read(definition: ParameterDefinition, leaf: object, origin: str) -> Parameter:
    """One parameter from its inline table."""
    name = definition.name
    if not isinstance(leaf, dict):
        raise _refusal(
            origin, name, "nothing" if leaf is None else _shown(leaf), f"{_LEAF}: {definition.expected}"
        )
    for field in leaf:
        if field not in _FIELDS:
            raise _refusal(origin, f"{name}.{field}", "an unknown field", f"one of {', '.join(_FIELDS)}")
    if "value" not in leaf:
        raise _refusal(origin, f"{name}.value", "nothing", definition.expected)
    unit, description, source = (_text(leaf, field, f"{name}.{field}", origin) for field in _TEXT_FIELDS)
    reading = _text(leaf, "reading", f"{name}.reading", origin) if "reading" in leaf else ""
    value = _si_value(definition, leaf["value"], unit, origin)
    return Parameter(name, value, definition.unit, description, source, reading)


def _si_value(definition: ParameterDefinition, raw: object, unit: str, origin: str) -> Value:
    """A value as received, in SI, if the definition admits it."""
    numbers = _numbers(raw if definition.is_list else [raw])
    values = () if numbers is None else _converted(numbers, unit, definition, origin)
    if not definition.admits(values):
        raise _refusal(origin, definition.name, f"{_shown(raw)} {unit}", definition.expected)
    return values if definition.is_list else values[0]


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
    received, expected = f"the unit {_shown(unit)}", f"one of the same dimension as {definition.unit}"
    if not _UNIT.fullmatch(unit):
        raise _refusal(origin, definition.name, received, expected)
    registry = _unit_registry()
    try:
        given, wanted = registry.parse_units(unit), registry.parse_units(definition.unit)
        compatible = given.dimensionality == wanted.dimensionality
        converted = [registry.Quantity(one, given).to(wanted) for one in numbers] if compatible else []
    except Exception as error:  # pint's parser lets all kinds through, from tokenize.TokenError to TypeError
        raise _refusal(origin, definition.name, f"{received} ({error})", expected) from error
    if not compatible:
        raise _refusal(origin, definition.name, f"{received} of dimension {given.dimensionality}", expected)
    return tuple(float(one.magnitude) for one in converted)


@functools.cache
def _unit_registry() -> pint.UnitRegistry[float]:
    """The units pint knows, on its own registry: definitions a user adds elsewhere change no vehicle file.

    Importing pint and building the registry are slow; files in SI never need them. Pint's own cache on disk
    is left off: it fails without a writable home directory and when several processes start at once.
    """
    import pint

    return pint.UnitRegistry()


def _split_quantity(text: str, name: str, origin: str) -> tuple[float | list[float], str]:
    """Number or list, and unit, of text such as ``200 N*m/deg`` or ``[-1, 0.5] m/s``."""
    match = _QUANTITY.fullmatch(text)
    entries = [] if match is None or match[2] is None else [entry.strip() for entry in match[2].split(",")]
    if match is None or not all(re.fullmatch(_NUMBER, entry) for entry in entries):
        raise _refusal(
            origin, name, _shown(text), "a number or a [list], and a unit: '200 N*m/deg', '[-1, 0, 1] m/s'"
        )
    return [float(entry) for entry in entries] if match[1] is None else float(match[1]), match[3]


def _times(factor: float, value: Value) -> Value:
    return tuple(factor * number for number in value) if isinstance(value, tuple) else factor * value


def _checked(parameters: Parameters, origin: str) -> Parameters:
    """The same set, once what joins several parameters has been checked."""
    for definition in parameters.schema.definitions:
        if definition.same_length_as is not None:
            _check_length(parameters, definition.name, definition.same_length_as, origin)
    numbers = parameters.flat()
    for prefix in parameters.schema.inertias:
        _check_inertia(prefix, [numbers[f"{prefix}.{axes}"] for axes in ("xx", "yy", "zz")], origin)
    return parameters


def _check_length(parameters: Parameters, name: str, other: str, origin: str) -> None:
    own, expected = (parameters[each].value for each in (name, other))
    if isinstance(own, tuple) and isinstance(expected, tuple) and len(own) != len(expected):
        raise _refusal(origin, name, f"{len(own)} values", f"as many as {other} has: {len(expected)}")


def _check_inertia(prefix: str, moments: Sequence[float], origin: str) -> None:
    """No principal moment of a rigid body exceeds the sum of the other two: 2 max <= xx + yy + zz."""
    if 2 * max(moments) > sum(moments) * (1 + _TRIANGLE_TOLERANCE):
        received = "xx = {:g}, yy = {:g}, zz = {:g} kg*m^2".format(*moments)
        raise _refusal(origin, prefix, received, "each at most the sum of the other two")
