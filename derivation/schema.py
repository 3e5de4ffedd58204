"""What a model expects of its parameters: names, SI units, and what is physically possible."""

from __future__ import annotations

import difflib
import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise


class ParameterError(ValueError):
    """A parameter, or a file of parameters, that cannot be accepted; the message is one line."""

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.splitlines()))


def refusal(origin: str, name: str, received: str, expected: str) -> ParameterError:
    """The error for something received from somewhere: a file, or an option of the command line."""
    return ParameterError(f"{origin}: {name}: received {received}, expected {expected}")


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
        return refusal(origin, name, "an unknown name", f"one such as {', '.join(nearest)}")
