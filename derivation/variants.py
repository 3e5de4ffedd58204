"""Many parameter sets of one model as arrays: checked, balanced and evaluated together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from chassym.derivation.equilibrium import solve_preloads
from chassym.derivation.model import Model
from chassym.derivation.parameters import Parameters, is_possible_inertia
from chassym.derivation.quantity import shown
from chassym.derivation.schema import ParameterError, refusal
from chassym.derivation.table_numbers import TableNumbers, table_numbers

Array = np.ndarray

_ORIGIN = "variants"


@dataclass(frozen=True, eq=False)
class Variants:
    """Parameter sets of a model that differ in some parameters.

    Attributes
    ----------
    model
        What they are variants of.
    changes
        The parameters that differ, by the name of every number (`Parameters.flat`), shape (count,).
    count
        How many there are.
    start
        Number of the first one, where they are part of others.
    """

    model: Model
    changes: Mapping[str, Array]
    count: int
    start: int = 0

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, part: slice) -> Variants:
        """Some of them."""
        changes = {name: numbers[part] for name, numbers in self.changes.items()}
        chosen = range(*part.indices(self.count))
        return replace(self, changes=changes, count=len(chosen), start=self.start + chosen.start)

    @cached_property
    def numbers(self) -> dict[str, Array | float]:
        """Every parameter: a number that all have, or an array of shape (count,)."""
        return self.model.parameters.flat() | dict(self.changes)

    @cached_property
    def preloads(self) -> Mapping[str, Array | float]:
        """Preload of every preloaded element (N or N m), by the preload's name.

        Raises
        ------
        EquilibriumError
            If no preloads hold the design position.
        """
        if self.model.given_preloads is not None:
            return self.model.given_preloads
        return solve_preloads(self.model.compiled, self.numbers, self.count)

    @cached_property
    def tables(self) -> dict[str, TableNumbers]:
        """Knots and slopes of every table, by its element's name.

        Raises
        ------
        MechanismError
            If the places of a table do not increase.
        """
        return table_numbers(self.model.compiled, self.numbers, self.count)

    @cached_property
    def values(self) -> dict[str, Array | float]:
        """Every number that the equations mention, by name."""
        return self.numbers | dict(self.preloads)

    def one(self, index: int) -> Model:
        """One of them as a model.

        Raises
        ------
        IndexError
            If there are not so many.
        """
        return self.model.with_parameters(_gathered(self, index))


def variants(model: Model, changes: Mapping[str, ArrayLike]) -> Variants:
    """Parameter sets of a model.

    Parameters
    ----------
    model
        What they are variants of.
    changes
        By parameter name: numbers in SI, shape (count,); of a list shape (count, entries), or shape (count,)
        for one entry of it by a name such as ``"suspension.front.damper.force[0]"``.

    Raises
    ------
    ParameterError
        If a name is unknown, the numbers are not as many as the others, or one of them is impossible.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> heavier = variants(load_model("quarter_car"), {"sprung.mass": [350.0, 400.0, 450.0]})
    >>> heavier.count, heavier.one(2).parameters["sprung.mass"].value
    (3, 450.0)
    """
    if not isinstance(model, Model):
        raise TypeError(f"{type(model).__name__} received; a Model is needed")
    if not changes:
        raise ParameterError(f"{_ORIGIN}: received none, expected the numbers of at least one parameter")
    flat: dict[str, Array] = {}
    for name, numbers in changes.items():
        found = _flattened(model.parameters, name, numbers)
        for entry in flat.keys() & found.keys():
            raise refusal(_ORIGIN, entry, "numbers twice", "them once, for the list or for its entry")
        flat |= found
    counts = {name: len(numbers) for name, numbers in flat.items()}
    if len(set(counts.values())) != 1 or 0 in counts.values():
        raise ParameterError(
            f"{_ORIGIN}: received numbers of variants {counts}, expected one and the same, not zero"
        )
    every = Variants(model, flat, next(iter(counts.values())))
    _check(every)
    return every


def _flattened(parameters: Parameters, name: str, given: ArrayLike) -> dict[str, Array]:
    """The arrays of a parameter's numbers, one for every entry of a list."""
    base, is_entry, _ = name.partition("[")
    definition = parameters.schema.by_name.get(base)
    if definition is None or (is_entry and name not in parameters.flat()):
        raise parameters.schema.unknown(name, _ORIGIN)
    try:
        numbers = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise refusal(_ORIGIN, name, shown(given), "an array of numbers in SI") from None
    if not definition.is_list or is_entry:
        entries, columns = [name], numbers[:, None] if numbers.ndim == 1 else numbers
    else:
        entries, columns = [f"{name}[{i}]" for i in range(np.size(parameters[name].value))], numbers
    if columns.ndim != 2 or columns.shape[1] != len(entries):
        expected = "(count,)" if len(entries) == 1 else f"(count, {len(entries)})"
        raise refusal(_ORIGIN, name, f"an array of shape {numbers.shape}", f"one of shape {expected}")
    return {entry: np.ascontiguousarray(column) for entry, column in zip(entries, columns.T, strict=True)}


def _check(found: Variants) -> None:
    """Refuse the first variant that is impossible, in the words for a model by itself."""
    schema = found.model.parameters.schema
    changed = {name.partition("[")[0] for name in found.changes}
    possible = np.ones(found.count, dtype=bool)
    for name in changed:
        possible &= schema.by_name[name].admits(_entries(found, name))
    for prefix in schema.inertias:
        moments = [f"{prefix}.{axes}" for axes in ("xx", "yy", "zz")]
        if changed.intersection(moments):
            possible &= is_possible_inertia([_entries(found, name)[0] for name in moments])
    if not possible.all():
        first = int(possible.argmin())
        try:
            found.one(first)
        except ParameterError as error:
            raise ParameterError(f"variant {first}: {error}") from None


def _entries(found: Variants, name: str) -> Array:
    """The numbers of a parameter, shape (entries, count)."""
    size = np.shape(found.model.parameters[name].value)
    names = [f"{name}[{i}]" for i in range(size[0])] if size else [name]
    return np.array([np.broadcast_to(found.numbers[entry], found.count) for entry in names])


def _gathered(found: Variants, index: int) -> dict[str, float | list[float]]:
    """The changed parameters of one variant, lists whole."""
    changed = dict.fromkeys(name.partition("[")[0] for name in found.changes)
    numbers = {name: _entries(found, name)[:, index].tolist() for name in changed}
    is_list = found.model.parameters.schema.by_name
    return {name: each if is_list[name].is_list else each[0] for name, each in numbers.items()}
