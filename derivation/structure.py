"""A mechanism in words: a text that is equal for equal structures, whatever the parameters' values."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.mechanism import ForceElement, Mechanism


def describe(mechanism: Mechanism) -> tuple[str, set[type]]:
    """The structure as text, and the classes whose code gives it its meaning."""
    classes: set[type] = set()
    parts = [*mechanism.bodies, *mechanism.elements, *mechanism.inputs, *mechanism.outputs]
    lines = [f"gravity {mechanism.gravity}", *(_fields(part, classes) for part in parts)]
    return "\n".join(lines), classes


def _fields(part: object, classes: set[type]) -> str:
    """A part by its class and fields; other parts inside it by name, points by name, body and place."""
    classes.add(type(part))
    listed = ", ".join(f"{f.name}={_value(getattr(part, f.name), classes)}" for f in fields(part))  # type: ignore[arg-type]
    return f"{type(part).__module__}.{type(part).__qualname__}({listed})"


def _value(value: object, classes: set[type]) -> str:
    if isinstance(value, Body | ForceElement):
        return value.name
    if isinstance(value, Point):
        return f"{value.name}@{value.body.name}{value.position}"
    if isinstance(value, sympy.Basic):
        return sympy.srepr(value)
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_value(item, classes) for item in value) + "]"
    if is_dataclass(value):
        return _fields(value, classes)
    return repr(value)
