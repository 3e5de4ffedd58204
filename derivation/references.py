"""What a part of a mechanism refers to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass

from chassym.derivation.body import Body, Input
from chassym.derivation.element import ForceElement
from chassym.derivation.joint import Coordinate


def references(part: object) -> Iterator[Body | Coordinate | Input | ForceElement]:
    """Bodies, coordinates, inputs and force elements that a part mentions, at any depth."""
    if isinstance(part, Body | Coordinate | Input):
        yield part
        return
    if isinstance(part, ForceElement):
        yield part
    if is_dataclass(part):
        inside: Iterator[object] = (getattr(part, f.name) for f in fields(part))
    elif isinstance(part, tuple | list):
        inside = iter(part)
    elif isinstance(part, Mapping):
        inside = iter(part.values())
    else:
        return
    for each in inside:
        yield from references(each)
