"""What is typed on the command line: read and, where it cannot be meant, refused before slow work starts."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from chassym.derivation.schema import Domain
    from chassym.linear.slope_rule import SlopeRule

FREQUENCY_BAND_HZ = 1e-4, 1e6
"""Frequencies of a linear response: beyond them rounding takes over."""

CONVENTIONS = ("displacements_and_rates", "rates", "accelerations", "displacements")
"""Input conventions of a plant, by the names of their functions in `chassym.linear.input_conventions`."""

MOST_POINTS = 10_000
"""Most frequencies that are asked for at once."""

_MOST_DIGITS = 640
"""Of a whole number: those that Python reads however low its own limit is set."""


class ArgumentError(ValueError):
    """An argument that cannot be accepted; the message tells what was received and what would be accepted."""

    def __init__(self, name: str, received: str, expected: str) -> None:
        super().__init__(f"{name}: received {received}, expected {expected}")


def choice(name: str, received: str, accepted: Collection[str]) -> str:
    """One of a few words.

    Raises
    ------
    ArgumentError
        If it is another one.
    """
    if received not in accepted:
        raise ArgumentError(name, repr(received), f"one of {', '.join(accepted)}")
    return received


def changes(assignments: Sequence[str]) -> dict[str, str]:
    """Parameter changes, text by name, from a sequence of ``NAME=VALUE``.

    Raises
    ------
    ParameterError
        If one is not of this form.
    ArgumentError
        If a name occurs twice.
    """
    if not assignments:
        return {}
    from chassym.derivation.parameters import parse_assignment

    found: dict[str, str] = {}
    for assignment in assignments:
        name, value = parse_assignment(assignment)
        if name in found:
            raise ArgumentError("--set", f"{name} twice, {found[name]!r} and {value!r}", "one value for it")
        found[name] = value
    return found


def whole(name: str, text: str) -> int:
    """A whole number of either sign; what is too small or too large is for the caller to say.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if not re.fullmatch(rf"-?\d{{1,{_MOST_DIGITS}}}", text, re.ASCII):
        raise ArgumentError(name, repr(text), "a whole number")
    return int(text)


def positive(name: str, text: str, unit: str) -> float:
    """A number greater than zero in SI, from text with or without a unit.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    from chassym.derivation.schema import POSITIVE

    return _number(name, text, unit, POSITIVE)


def finite(name: str, text: str, unit: str) -> float:
    """A finite number in SI, from text with or without a unit; refused as by `positive`."""
    from chassym.derivation.schema import ANY

    return _number(name, text, unit, ANY)


def amplitude(name: str, text: str) -> tuple[float, str]:
    """An amplitude of displacement, velocity or acceleration and its SI unit; refused as by `positive`."""
    from chassym.derivation.schema import ParameterError

    for unit in ("m/s", "m/s^2"):
        try:
            if not re.fullmatch(r"[-+.\d\seE]*", text):
                return positive(name, text, unit), unit
        except ParameterError:
            continue
    return positive(name, text, "m"), "m"


def frequency_hz(name: str, text: str) -> float:
    """A frequency, from a number of Hz or text with a unit such as ``kHz``; refused as by `positive`.

    Hertz and radians per second have the same dimension: the unit is therefore taken by its name.

    Raises
    ------
    ArgumentError
        If its unit is of the dimension of a frequency and yet not hertz.
    """
    number = positive(name, text, "Hz")
    if not re.fullmatch(r"[-+.\d\seE]*(\w*(hz|hertz))?\s*", text, re.IGNORECASE):
        raise ArgumentError(name, repr(text), "a number of Hz")
    return number


def frequencies_hz(lowest: tuple[str, str], highest: tuple[str, str], points: tuple[str, str]) -> np.ndarray:
    """Frequencies at equal ratios, from names and texts of their ends and number; refused as by `positive`.

    Raises
    ------
    ArgumentError
        If there are fewer than two or too many, they do not increase, or they lie outside
        `FREQUENCY_BAND_HZ`.
    """
    count = whole(*points)
    if not 2 <= count <= MOST_POINTS:
        raise ArgumentError(points[0], repr(points[1]), f"a whole number from 2 to {MOST_POINTS}")
    low, high = _in_band(*lowest), _in_band(*highest)
    if not high > low:
        raise ArgumentError(highest[0], repr(highest[1]), f"a frequency above {low:g} Hz")
    import numpy as np

    return np.geomspace(low, high, count)


def slope_rule(name: str, text: str) -> SlopeRule:
    """A rule for the slopes of tables.

    Raises
    ------
    ArgumentError
        If there is no such rule.
    """
    from chassym.linear.slope_rule import EXPECTED, SlopeRuleError, find_slope_rule

    try:
        return find_slope_rule(text)
    except SlopeRuleError:
        expected = f"{EXPECTED}; a number in SI, not zero, and above zero except for secant"
        raise ArgumentError(name, repr(text), expected) from None


def new_file(name: str, path: str, *suffixes: str) -> Path:
    """A file to write, in a folder that exists.

    Raises
    ------
    ArgumentError
        If its name does not end in one of the suffixes, or it cannot be written.
    """
    file = Path(path)
    if file.suffix not in suffixes:
        raise ArgumentError(name, repr(path), f"a name that ends in {' or '.join(suffixes)}")
    if os.path.isdir(file) or not _is_writable_folder(file.parent):
        raise ArgumentError(name, repr(path), "a file in an existing folder that can be written to")
    return file


def new_folder(name: str, path: str) -> Path:
    """A folder to write to, whether it exists already or can be made.

    Raises
    ------
    ArgumentError
        If it is no folder, or cannot be made or written to.
    """
    if not path:
        raise ArgumentError(name, "''", "the name of a folder")
    folder = Path(path)
    nearest = next(each for each in (folder.absolute(), *folder.absolute().parents) if os.path.exists(each))
    if not _is_writable_folder(nearest):
        raise ArgumentError(name, repr(path), f"a folder that can be written to; {str(nearest)!r} cannot")
    return folder


def _in_band(name: str, text: str) -> float:
    number, (lowest, highest) = frequency_hz(name, text), FREQUENCY_BAND_HZ
    if not lowest <= number <= highest:
        raise ArgumentError(name, repr(text), f"a frequency from {lowest:g} to {highest:g} Hz")
    return number


def _number(name: str, text: str, unit: str, domain: Domain) -> float:
    from chassym.derivation.quantity import parse_quantity
    from chassym.derivation.schema import ParameterDefinition

    value = parse_quantity(ParameterDefinition(name, unit, domain), text, "command line")
    assert isinstance(value, float)
    return value


def _is_writable_folder(folder: Path) -> bool:
    """Whether a file can be made there: permissions alone do not tell, above all not to the superuser."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
