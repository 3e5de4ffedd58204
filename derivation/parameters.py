"""Parameters of a vehicle: read from a TOML file, converted to SI, checked against what its model declares.

A file holds ``model``, ``description`` and nested tables; a parameter is named by its dotted path::

    [body.front]
    mass = { value = 475.0, unit = "kg", description = "mass of the front section", source = "weighed" }

A ``reading`` may be added where a source is ambiguous: what it was taken to mean, and why.
"""

from __future__ import annotations

import dataclasses
import functools
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from chassym.derivation.quantity import Value, parse_quantity, shown, si_value
from chassym.derivation.schema import ParameterDefinition, ParameterError, Schema, refusal

_TEXT_FIELDS = ("unit", "description", "source")
_FIELDS = ("value", *_TEXT_FIELDS, "reading")
_LEAF = "a table { value, unit, description, source }"
_TRIANGLE_TOLERANCE = 1e-12  # a flat plate has zz = xx + yy, up to the rounding of its conversion to SI


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
            value = parse_quantity(definition, given, origin)
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
        raise refusal(str(path), "file", f"an error ({error.strerror})", "a readable TOML file") from error
    except ValueError as error:  # bytes that are not UTF-8, or a path with a null character
        raise refusal(str(path), "file", f"an error ({error})", "a TOML file in UTF-8") from error
    return parse_parameters(text, schema, *alternatives, origin=str(path))


def parse_parameters(text: str, schema: Schema, *alternatives: Schema, origin: str = "text") -> Parameters:
    """Read the text of a vehicle file; ``origin`` begins error messages. See `load_parameters`.

    Examples
    --------
    >>> from chassym.derivation.schema import POSITIVE
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
        raise refusal(origin, "file", f"text that is not TOML ({error})", "a vehicle in TOML") from error
    models = {candidate.model: candidate for candidate in (schema, *alternatives)}
    model = _text(document, "model", "model", origin, expected=f"one of {', '.join(models)}")
    if model not in models:
        raise refusal(origin, "model", shown(model), f"one of {', '.join(models)}")
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
            f"{origin}: received {shown(text)}, expected NAME=VALUE, such as body.front.mass='480 kg'"
        )
    return name, value


def _text(table: Mapping[str, Any], field: str, name: str, origin: str, expected: str = "text") -> str:
    """A field that must be there and say something."""
    text = table.get(field)
    if not isinstance(text, str) or not text.strip():
        raise refusal(origin, name, shown(text) if field in table else "nothing", expected)
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
            raise refusal(origin, name, shown(entry), f"a table of parameters {name}.*")
        else:
            yield from _leaves(entry, schema, origin, f"{name}.")


def _read(definition: ParameterDefinition, leaf: object, origin: str) -> Parameter:
    """One parameter from its inline table."""
    name = definition.name
    if not isinstance(leaf, dict):
        raise refusal(
            origin, name, "nothing" if leaf is None else shown(leaf), f"{_LEAF}: {definition.expected}"
        )
    for field in leaf:
        if field not in _FIELDS:
            raise refusal(origin, f"{name}.{field}", "an unknown field", f"one of {', '.join(_FIELDS)}")
    if "value" not in leaf:
        raise refusal(origin, f"{name}.value", "nothing", definition.expected)
    unit, description, source = (_text(leaf, field, f"{name}.{field}", origin) for field in _TEXT_FIELDS)
    reading = _text(leaf, "reading", f"{name}.reading", origin) if "reading" in leaf else ""
    value = si_value(definition, leaf["value"], unit, origin)
    return Parameter(name, value, definition.unit, description, source, reading)


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
        raise refusal(origin, name, f"{len(own)} values", f"as many as {other} has: {len(expected)}")


def _check_inertia(prefix: str, moments: Sequence[float], origin: str) -> None:
    if not is_possible_inertia(moments):
        received = "xx = {:g}, yy = {:g}, zz = {:g} kg*m^2".format(*moments)
        raise refusal(origin, prefix, received, "each at most the sum of the other two")


def is_possible_inertia(moments: ArrayLike) -> np.ndarray:
    """Whether no principal moment of a rigid body exceeds the sum of the other two: 2 max <= xx + yy + zz.

    Parameters
    ----------
    moments
        Shape (3,), or (3, bodies) for many.
    """
    given = np.asarray(moments)
    return np.asarray(2 * given.max(axis=0) <= given.sum(axis=0) * (1 + _TRIANGLE_TOLERANCE))
