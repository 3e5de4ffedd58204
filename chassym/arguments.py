"""What is typed on the command line: read and, where it cannot be meant, refused before slow work starts."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chassym.derivation.schema import Domain


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
    """A whole number.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if not re.fullmatch(r"\d{1,6}", text, re.ASCII):
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


def new_file(name: str, path: str, suffix: str) -> Path:
    """A file to write, in a folder that exists.

    Raises
    ------
    ArgumentError
        If its name does not end in the suffix, or it cannot be written.
    """
    file = Path(path)
    if file.suffix != suffix:
        raise ArgumentError(name, repr(path), f"a name that ends in {suffix}")
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


def _number(name: str, text: str, unit: str, domain: Domain) -> float:
    from chassym.derivation.quantity import parse_quantity
    from chassym.derivation.schema import ParameterDefinition

    value = parse_quantity(ParameterDefinition(name, unit, domain), text, "test")
    assert isinstance(value, float)
    return value


def _is_writable_folder(folder: Path) -> bool:
    """Whether a file can be made there: permissions alone do not tell, above all not to the superuser."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
