"""Measured motions from CSV files: a header of names with units, then numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from chassym.derivation.quantity import coherent_unit, si_value
from chassym.derivation.schema import ParameterDefinition, ParameterError
from chassym.nonlinear.excitation.excitation import Array, ExcitationError
from chassym.nonlinear.excitation.time_series import TimeSeries

TIME = "time"

_Line = tuple[int, Sequence[str]]
"""Number of a line in its file, and its cells."""

_HEADING = re.compile(r"\s*(?P<name>.*?)\s*[(\[](?P<unit>[^()\[\]]*(?:\([^()]*\)[^()\[\]]*)*)[)\]]\s*")


def read_time_series(path: str | Path, columns: Mapping[str, str] | None = None) -> TimeSeries:
    """Read a measured excitation.

    Parameters
    ----------
    path
        A CSV file in UTF-8. Its first row names the columns with their units, ``time (s)`` or
        ``front_left_pad_z [mm]``; all further ones hold numbers. Empty lines are passed over.
    columns
        Column of every moving input, by the input's name, and perhaps of "time". By default every column
        but "time" is of the input that has its name.

    Returns
    -------
    TimeSeries
        In SI units.

    Raises
    ------
    ExcitationError
        If a column is missing or named twice, a unit or a number is not understood, or the time series is
        impossible; the message begins with the file's name.
    OSError
        If the file cannot be read.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            lines = [(reader.line_num, row) for row in reader if row]
        return _time_series(lines, columns)
    except (ExcitationError, ParameterError, UnicodeDecodeError, csv.Error) as error:
        raise ExcitationError(f"{path.name}: {error}") from error


def _time_series(lines: Sequence[_Line], columns: Mapping[str, str] | None) -> TimeSeries:
    headings = _headings(lines[0][1] if lines else ())
    chosen = {name: name for name in headings if name != TIME} if columns is None else dict(columns)
    chosen.setdefault(TIME, TIME)
    values, units = {}, {}
    for name, column in chosen.items():
        if column not in headings:
            raise ExcitationError(f"column {column!r} is missing; there are {', '.join(headings) or 'none'}")
        place, unit = headings[column]
        values[name], units[name] = _in_si(column, unit, _numbers(lines[1:], place, column))
    if units.pop(TIME) != "s":
        raise ExcitationError(f"column {chosen[TIME]!r}: the unit of a time is needed, such as s or ms")
    return TimeSeries(values.pop(TIME), values, units)


def _headings(row: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Place and unit of every column, by its name."""
    found: dict[str, tuple[int, str]] = {}
    for place, text in enumerate(row):
        match = _HEADING.fullmatch(text)
        if match is None:
            raise ExcitationError(f"column {text!r}: a name with a unit is needed, such as 'time (s)'")
        if match["name"] in found:
            raise ExcitationError(f"column {match['name']!r}: named twice")
        found[match["name"]] = place, match["unit"].strip()
    return found


def _numbers(lines: Sequence[_Line], place: int, column: str) -> Array:
    numbers = np.empty(len(lines))
    for index, (line, row) in enumerate(lines):
        try:
            numbers[index] = float(row[place])
        except (IndexError, ValueError) as error:
            given = repr(row[place]) if place < len(row) else "nothing"
            raise ExcitationError(
                f"column {column!r}: {given} received in line {line}; a number is needed"
            ) from error
    return numbers


def _in_si(column: str, unit: str, numbers: Array) -> tuple[Array, str]:
    """Numbers in SI, and their unit."""
    definition = ParameterDefinition(column, "1")
    coherent = coherent_unit(definition, f"1 {unit}", "unit")
    zero, one = (si_value(ParameterDefinition(column, coherent), n, unit, "unit") for n in (0.0, 1.0))
    return numbers * (np.subtract(one, zero)) + zero, coherent
