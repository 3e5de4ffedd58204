"""The numbers of tables for parameter values: where they bend, and their slopes between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chassym.derivation.compilation.numeric import CompiledEquations
from chassym.derivation.errors import MechanismError


@dataclass(frozen=True, eq=False)
class TableNumbers:
    """A piecewise-linear function, or one for each of many parameter sets.

    Attributes
    ----------
    knots
        Where the slope jumps, ascending, shape (knots, sets).
    slopes
        The slope before the first knot, between each two, and after the last, shape (knots + 1, sets).
    """

    knots: np.ndarray
    slopes: np.ndarray


def table_numbers(
    compiled: CompiledEquations, values: Mapping[str, np.ndarray | float], sets: int
) -> dict[str, TableNumbers]:
    """Every table of a system for parameter sets, by its element's name.

    Parameters
    ----------
    compiled
        The system.
    values
        By parameter name: a number, or an array of shape (sets,).
    sets
        Number of parameter sets.

    Raises
    ------
    MechanismError
        If the places of a table do not increase.
    """
    laws = compiled.system.knotted
    if not laws:
        return {}
    numbers = compiled.tables.of_variants(values, np.zeros((compiled.argument_count, sets)))
    ends = np.cumsum([2 * len(law.knots) + len(law.table.places) for law in laws.values()])
    tables = {}
    for name, rows in zip(laws, np.split(numbers, ends[:-1]), strict=True):
        knots, slopes, spacings = np.split(rows, [len(laws[name].knots), 2 * len(laws[name].knots) + 1])
        if not (spacings > 0).all():
            raise MechanismError(
                f"element {name!r}: a place of its table follows the one before it by {spacings.min():g}; "
                "expected increasing places"
            )
        for part in (knots, slopes):
            part.flags.writeable = False
        tables[name] = TableNumbers(knots, slopes)
    return tables
