"""Static equilibrium: where a model settles under loads, and the preloads that hold it where it should be."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from chassym.derivation import Model
from chassym.linear.operating_point import OperatingPoint, OperatingPointError, by_name
from chassym.linear.statics.static_balance import (
    BALANCED,
    Balance,
    check_finite,
    is_balanced,
    settled,
    solved,
)
from chassym.linear.statics.static_stability import find_divergence

Array = np.ndarray
Changes = Mapping[str, float | Sequence[float] | str]

_NEAR = 1.0
"""Angle (rad) beyond which a search may have gone round to another equilibrium."""

_RELUCTANCE = 1e-5
"""What a change of preloads counts in the first search, relative to a force that is left."""


def find_equilibrium(
    model: Model,
    *,
    changes: Changes | None = None,
    loads: Mapping[str, float] | None = None,
    inputs: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None,
) -> OperatingPoint:
    """Where a model comes to rest: with other parameters, under loads, with its inputs moved.

    The preloads stay those that the given model has, so that a heavier car sinks. A preload is the force at
    the design position: another spring rate alone moves nothing.

    The position is sought by least squares from the start. If that leads to none, to one that falls over or
    far round, the model moves from the start as slowly as in thick oil until it settles, and the search goes
    on there.

    Parameters
    ----------
    model
        The model.
    changes
        Parameter values to change, as for `Model.with_parameters`.
    loads
        Constant generalised forces (N or N m), by the coordinate's name.
    inputs
        Prescribed displacements or forces that are not zero, by name (SI).
    start
        Coordinates to start from that are not zero, by name (SI).

    Raises
    ------
    ParameterError
        If a change is unknown or impossible.
    OperatingPointError
        If a name is unknown; no equilibrium is found; the one that is found is statically unstable; or forces
        are not finite or a rotation sequence is singular there.

    Examples
    --------
    A quarter car with 40 kg more sinks by m g / k of suspension and tyre in series:

    >>> from chassym.derivation import load_model
    >>> car = load_model("quarter_car")
    >>> loaded = find_equilibrium(car, changes={"sprung.mass": car.values["sprung.mass"] + 40})
    >>> expected = -40 * 9.81 * (1 / car.values["spring.rate"] + 1 / car.values["tyre.stiffness"])
    >>> bool(np.isclose(loaded.coordinates[0], expected))
    True
    >>> print(loaded)
    quarter_car at body_bounce = -0.0276... m, wheel_bounce = -0.0026... m: residual ...
    """
    begin = _start(model, changes, loads, inputs, by_name("start: coordinate", start, _names(model)))
    everything = np.arange(model.size)
    found = begin if _is_exact(begin) else solved(Balance(begin, everything))
    if found is not begin and not (_is_accepted(found) and _is_near(found, begin)):
        other = solved(Balance(settled(begin), everything))
        if _is_accepted(other) or is_balanced(other) > is_balanced(found):
            found = other
    _check(found, "lessen the loads, have it held by an element that is stiff there, or start elsewhere")
    return found


def hold_position(
    model: Model,
    held: Mapping[str, float],
    adjusted: Sequence[str],
    *,
    changes: Changes | None = None,
    loads: Mapping[str, float] | None = None,
    inputs: Mapping[str, float] | None = None,
) -> OperatingPoint:
    """Preloads that hold some coordinates where they are wanted: a ride height set by the springs' seats.

    Of several solutions the one with the smallest change of preloads is taken, to eight digits of the change.

    Parameters
    ----------
    model
        The model.
    held
        The coordinates that are wanted, by name (SI); the others come to rest where they do.
    adjusted
        Names of the elements whose preloads may change; the others keep those of the given model.
    changes, loads, inputs
        As for `find_equilibrium`.

    Returns
    -------
    OperatingPoint
        Its model has the new preloads.

    Raises
    ------
    ParameterError, OperatingPointError
        As for `find_equilibrium`, or if an adjusted element has no preload.
    TypeError
        If the adjusted elements are one string.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> car = load_model("quarter_car")
    >>> low = hold_position(car, {"body_bounce": -0.02}, ["spring"])
    >>> [round(float(value), 12) for value in low.coordinates]
    [-0.02, 0.0]
    >>> lowered = car.preloads["spring.preload"] - low.model.preloads["spring.preload"]
    >>> bool(np.isclose(lowered, 0.02 * car.values["spring.rate"]))
    True
    """
    names = _names(model)
    begin = _start(model, changes, loads, inputs, by_name("held: coordinate", held, names))
    free = np.array([i for i, name in enumerate(names) if name not in held], dtype=int)
    balance = Balance(begin, free, _preloads(model, adjusted))
    found = solved(replace(balance, begin=solved(balance, _RELUCTANCE)))
    _check(found, "adjust more elements, or hold fewer coordinates")
    return found


def _start(
    model: Model,
    changes: Changes | None,
    loads: Mapping[str, float] | None,
    inputs: Mapping[str, float] | None,
    coordinates: Array,
) -> OperatingPoint:
    """A position that need be no equilibrium, of the changed model with the preloads it had before."""
    system = model.system
    kept = replace(model, given_preloads=dict(model.preloads)).with_parameters(changes or {})
    point = OperatingPoint(
        kept,
        coordinates,
        by_name("inputs: input", inputs, [each.name for each in system.inputs]),
        by_name("loads: coordinate", loads, _names(model)),
    )
    check_finite(point, np.column_stack([point.residual, point.stiffness]))
    return point


def _names(model: Model) -> list[str]:
    return [each.name for each in model.system.coordinates]


def _preloads(model: Model, elements: Sequence[str]) -> tuple[str, ...]:
    """Names of the preloads of elements."""
    if isinstance(elements, str):
        raise TypeError(f"adjusted: a sequence of names is needed; the string {elements!r} received")
    known = [symbol.name.removesuffix(".preload") for symbol in model.system.preloads]
    for name in elements:
        if name not in known:
            near = ", ".join(difflib.get_close_matches(name, known, cutoff=0)) or "none"
            raise OperatingPointError(
                f"adjusted: element {name!r} has no preload in {model.system.name!r}; there are {near}"
            )
    return tuple(f"{name}.preload" for name in dict.fromkeys(elements))


def _is_exact(point: OperatingPoint) -> bool:
    return bool(np.abs(point.residual).max() <= BALANCED * point.largest_force)


def _is_accepted(point: OperatingPoint) -> bool:
    return is_balanced(point) and find_divergence(point) is None


def _is_near(point: OperatingPoint, begin: OperatingPoint) -> bool:
    """Whether nothing has turned so far that there may be an equilibrium on the way."""
    turning = [coordinate.unit == "rad" for coordinate in point.model.system.coordinates]
    return bool((np.abs(point.coordinates - begin.coordinates)[turning] <= _NEAR).all())


def _check(point: OperatingPoint, remedy: str) -> None:
    """Refuse what is no equilibrium, cannot be told or falls over."""
    name = point.model.system.name
    if not is_balanced(point):
        raise OperatingPointError(f"no equilibrium of {name!r} found: {point.left} is left; {remedy}")
    point.check()
    divergence = find_divergence(point)
    if divergence is not None:
        raise OperatingPointError(
            f"{name!r} {point.description} is in equilibrium but falls over along {divergence.coordinate!r}, "
            f"e-fold in {1 / divergence.rate:.3g} s; start elsewhere, or use position if it is meant"
        )
