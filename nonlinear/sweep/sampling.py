"""Points of a sweep as data: grids, one at a time, Latin hypercubes, random samples and given tables.

A point sets parameters of a model and fields of an excitation. What is varied has one of these names:

- a parameter, ``body.front.mass``, or one entry of a list, ``suspension.front.damper.force[0]``: it is set to
  the numbers, in SI;
- a list or a group of parameters, ``tyre`` or ``suspension.front.damper.force``: it is multiplied by them;
- a field of the excitation, ``frequency_hz``, ``amplitude_m`` or ``lag_s``: it is set to them;
- several of one kind joined by ``+``: they are set, or multiplied, together.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from chassym.derivation import Model

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

FIELD_UNITS = {"hz": "Hz", "m": "m", "s": "s"}
"""Units of the fields of an excitation, by the last word of their names; others are plain numbers."""

NOMINAL = "nominal"
"""What is varied at a point where nothing is."""


class SamplingError(ValueError):
    """Points that cannot be made; the message tells what was received and what would be accepted."""


@dataclass(frozen=True, eq=False)
class Coordinate:
    """Numbers or words along some dimensions of the points, with their unit."""

    dimensions: tuple[str, ...]
    values: Array
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Points:
    """Where a sweep looks.

    Attributes
    ----------
    numbers
        What every point sets, in SI, by the name of a parameter's number or of an excitation's field; shape
        (count,). Not a number: the point leaves it as it is.
    units
        Their units, by the same names.
    shape
        Sizes of the dimensions by name; points are in C order, neighbours along the last dimension.
    coordinates
        What labels the results, by name.
    follows
        Whether a point is a neighbour of the one before, along the last dimension of a grid; shape (count,).
    """

    numbers: Mapping[str, Array]
    units: Mapping[str, str]
    shape: Mapping[str, int]
    coordinates: Mapping[str, Coordinate]
    follows: Array

    def __len__(self) -> int:
        return int(np.prod(list(self.shape.values())))

    def settings(self, number: int) -> dict[str, float]:
        """What one point sets, by name."""
        found = {name: float(values[number]) for name, values in self.numbers.items()}
        return {name: value for name, value in found.items() if not np.isnan(value)}

    def labelled(self, name: str, word: str) -> Points:
        """The same points with one more coordinate, a word that all of them have."""
        added = Coordinate(tuple(self.shape), np.full(tuple(self.shape.values()), word, dtype=object))
        return replace(self, coordinates={name: added} | dict(self.coordinates))

    def renamed(self, old: str, new: str) -> Points:
        """The same points with another name for a coordinate, and for the dimension of that name."""

        def name(each: str) -> str:
            return new if each == old else each

        coordinates = {
            name(key): replace(each, dimensions=tuple(map(name, each.dimensions)))
            for key, each in self.coordinates.items()
        }
        shape = {name(dimension): size for dimension, size in self.shape.items()}
        return replace(self, shape=shape, coordinates=coordinates)

    def to_xarray(self) -> xarray.Dataset:
        """What every point sets as variables with units, beside the coordinates of the results."""
        import xarray

        shape = tuple(self.shape.values())
        settings = {
            f"set {name}": (tuple(self.shape), values.reshape(shape), {"units": self.units[name]})
            for name, values in self.numbers.items()
        }
        labels = {
            name: (each.dimensions, each.values, {"units": each.unit} if each.unit else {})
            for name, each in self.coordinates.items()
        }
        return xarray.Dataset(settings, labels)


def unit_of(model: Model, name: str) -> str:
    """SI unit of the numbers of what is varied; 1 for factors.

    Raises
    ------
    SamplingError
        If what is varied together is of several units.
    ParameterError
        If the model has no such parameter.
    """
    return _resolved(model, {name: np.ones(1)})[2][name]


def grid(model: Model, axes: Mapping[str, ArrayLike]) -> Points:
    """Every combination of the values of some quantities; the last one varies fastest.

    Raises
    ------
    SamplingError
        If there is no axis, or one is empty, not finite, or of several dimensions.
    ParameterError
        If the model has no such parameter.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> points = grid(load_model("quarter_car"), {"sprung.mass": [350, 400], "frequency_hz": [1, 2, 3]})
    >>> len(points), dict(points.shape)
    (6, {'sprung.mass': 2, 'frequency_hz': 3})
    >>> points.settings(4)
    {'sprung.mass': 400.0, 'frequency_hz': 2.0}
    """
    values = {name: _finite(name, given) for name, given in axes.items()}
    if not values:
        raise SamplingError("grid: no axis received, at least one is needed")
    meshes = np.meshgrid(*values.values(), indexing="ij")
    columns = {name: mesh.ravel() for name, mesh in zip(values, meshes, strict=True)}
    numbers, units, labels = _resolved(model, columns)
    coordinates = {name: Coordinate((name,), axis, labels[name]) for name, axis in values.items()}
    shape = {name: len(axis) for name, axis in values.items()}
    follows = np.indices(tuple(shape.values()))[-1].ravel() > 0
    return Points(numbers, units, shape, coordinates, follows)


def table(model: Model, columns: Mapping[str, ArrayLike]) -> Points:
    """Given points, one in every row; not a number leaves a quantity as it is.

    Raises
    ------
    SamplingError
        If there are no rows, or the columns are not equally long.
    ParameterError
        If the model has no such parameter.
    """
    values = {name: _one_dimensional(name, given) for name, given in columns.items()}
    if len({len(column) for column in values.values()}) != 1:
        sizes = {name: len(column) for name, column in values.items()}
        raise SamplingError(f"table: columns of {sizes} rows received; all have to be of one length")
    numbers, units, labels = _resolved(model, values)
    coordinates = {name: Coordinate(("point",), column, labels[name]) for name, column in values.items()}
    count = len(next(iter(values.values())))
    return Points(numbers, units, {"point": count}, coordinates, np.zeros(count, dtype=bool))


def latin_hypercube(
    model: Model,
    count: int,
    ranges: Mapping[str, tuple[float, float]],
    *,
    logarithmic: Collection[str] = (),
    seed: int = 0,
) -> Points:
    """Points that have one value in each of ``count`` equal parts of every range.

    Source: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979), 239-245.

    Parameters
    ----------
    ranges
        Lowest and highest value by the name of what is varied.
    logarithmic
        Names of which the logarithm is spread evenly.
    seed
        The same seed gives the same points.

    Raises
    ------
    SamplingError
        If the count or a range is impossible.
    ParameterError
        If the model has no such parameter.
    """
    from scipy.stats import qmc  # it takes long to import

    _check_sample(count, ranges, logarithmic)
    unit_cube = qmc.LatinHypercube(len(ranges), seed=seed).random(count)
    return table(model, _spread(unit_cube, ranges, logarithmic))


def random_sample(
    model: Model,
    count: int,
    ranges: Mapping[str, tuple[float, float]],
    *,
    logarithmic: Collection[str] = (),
    seed: int = 0,
) -> Points:
    """Independent, evenly distributed points; arguments and errors are those of `latin_hypercube`."""
    _check_sample(count, ranges, logarithmic)
    unit_cube = np.random.default_rng(seed).random((count, len(ranges)))
    return table(model, _spread(unit_cube, ranges, logarithmic))


def one_at_a_time(
    model: Model, change: float = 0.25, groups: Mapping[str, Sequence[str]] | None = None
) -> Points:
    """The nominal point, then every group of parameters multiplied by 1 - change and 1 + change.

    The points are labelled ``varied`` and ``factor``.

    Parameters
    ----------
    change
        Between 0 and 1.
    groups
        Names of parameters or groups that are multiplied together, by a name for them; every parameter by
        itself by default. A parameter that is zero stays zero and is left out.

    Raises
    ------
    SamplingError
        If the change is impossible, or a group is of zeros alone.
    ParameterError
        If the model has no such parameter.
    """
    if not 0 < change < 1:
        raise SamplingError(f"change: {change!r} received; a number between 0 and 1 is needed")
    chosen = groups if groups is not None else {name: (name,) for name in _changeable(model)}
    every = [_labelled({}, {}, NOMINAL, 1.0)]
    for group, names in chosen.items():
        for factor in (1 - change, 1 + change):
            numbers, units = _multiplied(model, names, np.array([factor]))
            if not numbers:
                raise SamplingError(f"group {group!r}: all its parameters are zero; a factor changes nothing")
            every.append(_labelled(numbers, units, group, factor))
    return joined(every)


def parameter_groups(model: Model) -> list[str]:
    """Names of the groups of a model's parameters that are not of zeros alone."""
    groups = sorted(model.parameters.schema.groups)
    return [group for group in groups if _multiplied(model, (group,), np.ones(1))[0]]


def joined(parts: Sequence[Points]) -> Points:
    """Points one after the other along ``point``; what a part does not vary or label is left open there."""
    if not parts:
        raise SamplingError("joined: no points received, at least one part is needed")
    units = {name: unit for part in parts for name, unit in part.units.items()}
    numbers = {
        name: np.concatenate([part.numbers.get(name, np.full(len(part), np.nan)) for part in parts])
        for name in units
    }
    names = dict.fromkeys(name for part in parts for name in part.coordinates)
    coordinates = {name: _joined_coordinate(parts, name) for name in names}
    follows = np.concatenate([part.follows for part in parts])
    return Points(numbers, units, {"point": len(follows)}, coordinates, follows)


def _joined_coordinate(parts: Sequence[Points], name: str) -> Coordinate:
    found = [part.coordinates[name] for part in parts if name in part.coordinates]
    is_number = all(each.values.dtype.kind == "f" for each in found)
    fill = np.nan if is_number else ""
    columns = [
        _along_points(part, name) if name in part.coordinates else np.full(len(part), fill, dtype=object)
        for part in parts
    ]
    values = np.concatenate(columns)
    return Coordinate(("point",), values.astype(float if is_number else object), found[0].unit)


def _along_points(part: Points, name: str) -> Array:
    """A coordinate at every point, shape (count,)."""
    coordinate, dimensions = part.coordinates[name], list(part.shape)
    places = [dimensions.index(each) for each in coordinate.dimensions]
    sizes = [size if place in places else 1 for place, size in enumerate(part.shape.values())]
    return np.broadcast_to(coordinate.values.reshape(sizes), tuple(part.shape.values())).ravel()


def _labelled(numbers: Mapping[str, Array], units: Mapping[str, str], varied: str, factor: float) -> Points:
    coordinates = {
        "varied": Coordinate(("point",), np.array([varied], dtype=object)),
        "factor": Coordinate(("point",), np.array([factor]), "1"),
    }
    return Points(numbers, units, {"point": 1}, coordinates, np.zeros(1, dtype=bool))


def _changeable(model: Model) -> list[str]:
    """Names of the parameters that a factor changes."""
    return [name for name, parameter in model.parameters.items() if np.any(parameter.value)]


def _resolved(
    model: Model, columns: Mapping[str, Array]
) -> tuple[dict[str, Array], dict[str, str], dict[str, str]]:
    """What the columns set: numbers and units by the names of what is set, units by those of the columns."""
    numbers: dict[str, Array] = {}
    units: dict[str, str] = {}
    labels: dict[str, str] = {}
    for name, column in columns.items():
        parts = [_meant(model, part.strip(), column) for part in name.split("+")]
        if len({label for _, _, label in parts}) > 1:
            raise SamplingError(
                f"{name}: quantities of {', '.join(label for *_, label in parts)} received; "
                "what is varied together has to be of one unit"
            )
        for found, own, label in parts:
            for twice in numbers.keys() & found.keys():
                raise SamplingError(f"{name}: {twice} is varied twice; it can be set once")
            numbers |= found
            units |= own
            labels[name] = label
    return numbers, units, labels


def _meant(model: Model, name: str, column: Array) -> tuple[dict[str, Array], dict[str, str], str]:
    """What one name stands for: numbers to set, their units, and the unit of the column."""
    base = name.partition("[")[0]
    if name in model.parameters.flat():
        unit = model.parameters[base].unit
        return {name: column}, {name: unit}, unit
    if name.isidentifier() and name not in {*model.parameters.schema.groups, *model.parameters}:
        unit = FIELD_UNITS.get(name.rpartition("_")[2], "1")
        return {name: column}, {name: unit}, unit
    return *_multiplied(model, (name,), column), "1"


def _multiplied(
    model: Model, names: Sequence[str], factors: Array
) -> tuple[dict[str, Array], dict[str, str]]:
    """Every number below some names times factors; zeros are left out."""
    numbers: dict[str, Array] = {}
    for name in names:
        below = {
            each: nominal
            for each, nominal in model.parameters.flat().items()
            if f"{each}.".startswith((f"{name}.", f"{name}["))
        }
        if not below:
            raise model.parameters.schema.unknown(name, "sweep")
        numbers |= {each: nominal * factors for each, nominal in below.items() if nominal}
    return numbers, {each: model.parameters[each.partition("[")[0]].unit for each in numbers}


def _one_dimensional(name: str, given: ArrayLike) -> Array:
    try:
        values = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise SamplingError(f"{name}: {given!r} received; numbers in SI are needed") from None
    if values.ndim != 1 or not values.size:
        raise SamplingError(f"{name}: shape {values.shape} received; one or more numbers in a row are needed")
    return values


def _finite(name: str, given: ArrayLike) -> Array:
    values = _one_dimensional(name, given)
    if not np.isfinite(values).all():
        raise SamplingError(f"{name}: {values[~np.isfinite(values)][0]} received; finite numbers are needed")
    return values


def _check_sample(
    count: int, ranges: Mapping[str, tuple[float, float]], logarithmic: Collection[str]
) -> None:
    if count < 1 or not ranges:
        raise SamplingError(
            f"sample: {count} points of {len(ranges)} quantities; at least one of each needed"
        )
    for name, (low, high) in ranges.items():
        if not (np.isfinite([low, high]).all() and low < high):
            raise SamplingError(f"{name}: range {low} to {high} received; two increasing numbers are needed")
        if name in logarithmic and low <= 0:
            raise SamplingError(f"{name}: range from {low} received; a logarithmic one lies above zero")
    for name in logarithmic:
        if name not in ranges:
            raise SamplingError(f"logarithmic: {name!r} received; one of {', '.join(ranges)} is needed")


def _spread(
    unit_cube: Array, ranges: Mapping[str, tuple[float, float]], logarithmic: Collection[str]
) -> dict[str, Array]:
    """Columns of a sample of the unit cube, shape (count, quantities), stretched to the ranges."""
    return {
        name: low * (high / low) ** column if name in logarithmic else low + (high - low) * column
        for column, (name, (low, high)) in zip(unit_cube.T, ranges.items(), strict=True)
    }
