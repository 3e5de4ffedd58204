"""A system in words: a text that is equal for equal structures, whatever the parameters' values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property

import numpy as np
import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.element import ForceElement
from chassym.derivation.system import System


def describe(system: System) -> tuple[str, set[type]]:
    """The structure as text, and the classes whose code gives it its meaning.

    Raises
    ------
    TypeError
        If a part is no dataclass, or its fields do not tell all that it is made of.
    """
    classes: set[type] = set()
    lines = [type(system).__qualname__]
    for public in (f for f in fields(system) if not f.name.startswith("_")):  # type: ignore[arg-type]
        value = getattr(system, public.name)
        parts = (
            [_fields(each, classes) for each in value]
            if isinstance(value, list)
            else [_value(value, classes)]
        )
        lines += [public.name, *parts]
    return "\n".join(lines), classes


def _fields(part: object, classes: set[type]) -> str:
    """A part by its class and fields; other parts inside it by name, points by name, body and place."""
    _check_told_by_fields(part)
    classes.update(each for each in type(part).__mro__ if each.__module__ != "builtins")
    listed = ", ".join(f"{f.name}={_value(getattr(part, f.name), classes)}" for f in fields(part))  # type: ignore[arg-type]
    return f"{type(part).__module__}.{type(part).__qualname__}({listed})"


def _value(value: object, classes: set[type]) -> str:
    if isinstance(value, Body | ForceElement):
        return value.name
    if isinstance(value, Point):
        return f"{value.name}@{value.body.name}{value.position}"
    if isinstance(value, sympy.Basic):
        return sympy.srepr(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_value(k, classes)}: {_value(v, classes)}" for k, v in value.items()) + "}"
    if isinstance(value, np.ndarray | sympy.MatrixBase):
        return _value(value.tolist(), classes)
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_value(item, classes) for item in value) + "]"
    if is_dataclass(value):
        return _fields(value, classes)
    if value is None or isinstance(value, str | int | float):
        return repr(value)
    raise TypeError(f"{type(value).__qualname__} in a mechanism cannot be described; make it a dataclass")


def _check_told_by_fields(part: object) -> None:
    """Refuse a part whose fields do not tell what it does.

    Raises
    ------
    TypeError
        If its class is no dataclass of its own or stands inside a function, or it has other attributes.
    """
    kind = type(part)
    computed = {
        name for each in kind.__mro__ for name, v in vars(each).items() if isinstance(v, cached_property)
    }
    extra = vars(part).keys() - {f.name for f in fields(part)} - computed  # type: ignore[arg-type]
    if "__dataclass_fields__" not in vars(kind) or "<locals>" in kind.__qualname__ or extra:
        raise TypeError(
            f"{kind.__qualname__} cannot be described by its fields; make it a dataclass of a module"
        )
