"""What a part of a mechanism is made of, and what it refers to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass

import sympy

from chassym.derivation.body import Body, Input
from chassym.derivation.element import ForceElement
from chassym.derivation.joint import Coordinate


def contents(part: object) -> Iterable[object]:
    """What stands immediately inside: the values of fields, of a mapping or of a sequence."""
    if is_dataclass(part):
        return [getattr(part, f.name) for f in fields(part)]
    if isinstance(part, Mapping):
        return part.values()
    return part if isinstance(part, Iterable) and not isinstance(part, str | sympy.Basic) else ()


def references(part: object) -> Iterator[Body | Coordinate | Input | ForceElement]:
    """Bodies, coordinates, inputs and force elements that a part mentions, at any depth."""
    if isinstance(part, Body | Coordinate | Input | ForceElement):
        yield part
    if not isinstance(part, Body | Coordinate | Input):
        for each in contents(part):
            yield from references(each)
