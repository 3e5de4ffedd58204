"""What a model expects of its parameters: names, SI units, and what is physically possible."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


class ParameterError(ValueError):
    """A parameter, or a file of parameters, that cannot be accepted; the message is one line."""

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.splitlines()))


def refusal(origin: str, name: str, received: str, expected: str) -> ParameterError:
    """The error for something received from somewhere: a file, or an option of the command line."""
    return ParameterError(f"{origin}: {name}: received {received}, expected {expected}")


@dataclass(frozen=True)
class Domain:
    """What is physically possible for a value in SI: a description and the test of its numbers.

    The test takes the numbers of one value, shape (numbers,), or those of many, shape (numbers, values), and
    says for each value whether it is possible.
    """

    description: str
    admits: Callable[[np.ndarray], np.ndarray]


def _any(numbers: np.ndarray) -> np.ndarray:
    return np.ones(numbers.shape[1:], dtype=bool)


def _positive(numbers: np.ndarray) -> np.ndarray:
    return np.all(numbers > 0, axis=0)


def _nonnegative(numbers: np.ndarray) -> np.ndarray:
    return np.all(numbers >= 0, axis=0)


def _increasing(numbers: np.ndarray) -> np.ndarray:
    return np.all(np.diff(numbers, axis=0) > 0, axis=0)


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

    def admits(self, numbers: ArrayLike) -> np.ndarray:
        """Whether SI numbers are as many as expected, finite and inside the domain.

        Parameters
        ----------
        numbers
            Those of one value, shape (numbers,), or of many, shape (numbers, values).

        Returns
        -------
        numpy.ndarray
            The truth, shape () or (values,).
        """
        given = np.asarray(numbers, dtype=float)
        if not (len(given) >= 2 if self.is_table else len(given) == (self.length or 1)):
            return np.zeros(given.shape[1:], dtype=bool)
        return np.isfinite(given).all(axis=0) & self.domain.admits(given)


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
