"""Modes along a parameter: each keeps its name through crossings, veerings and overdamping."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.mode_pairs import ModePairs, undamped_pairs
from chassym.linear.modal.modes import normalised
from chassym.linear.modal.motion import mode_names
from chassym.linear.modal.pair_following import PartnersLostError, followed, paired

if TYPE_CHECKING:
    import xarray as xr

Array = np.ndarray


def track_modes(
    linear_at: Callable[[float], LinearModel],
    values: ArrayLike,
    *,
    parameter: str = "value",
    unit: str = "",
    named_at: float | None = None,
) -> xr.Dataset:
    """The modes of a linear model along a parameter.

    A mode is a pair of eigenvalues: conjugates or, where several are real, those that an undamped mode
    becomes as damping grows to its size. From the first value on it is followed by its invariant subspace,
    which stays smooth where an oscillation becomes overdamped. Where modes cross, because nothing couples
    them, each goes its way; where they veer they exchange their shapes gradually. Between the values as many
    more are computed as it takes to tell the two apart. Eigenvalues nearer than 1e-6 of their size count as a
    crossing, and what happens and is undone between two neighbouring values may be missed. Modes that are
    equal at every value share their subspace and are followed in it as smoothly as possible.

    Parameters
    ----------
    linear_at
        The linear model at a value; for undamped modes see `without_damping`.
    values
        Finite values in the order in which they are visited, length 1 or more.
    parameter, unit
        What the values are; labels of the result.
    named_at
        The value at which modes are named by what moves; by default the first one.

    Returns
    -------
    xarray.Dataset
        Over ``value`` and ``mode``, in ascending order of frequency at the first value: ``frequency_hz``
        sqrt(l_1 l_2) / (2 pi) and ``damping_ratio`` -(l_1 + l_2) / (2 sqrt(l_1 l_2)) of the pair of
        eigenvalues, above 1 if overdamped; with ``pair`` also ``eigenvalue`` (1/s), of two conjugates the
        upper one first, of two real ones the slower one; with ``coordinate`` also ``shape``, complex
        amplitudes in the motion of the first eigenvalue, with unit modal mass and without jumps of sign. A
        pair of which one motion grows and the other decays has l_1 l_2 < 0 and the frequency of -l_1 l_2;
        one that decays without stiffness has frequency 0 and an infinite damping ratio. The attribute
        ``evaluations`` counts the linear models computed.

    Raises
    ------
    LinearisationError
        If there is no value or one is not finite, if the models' coordinates differ, or if two modes cannot
        be told apart: where eigenvalues of different modes become equal with a single shape between them,
        partners are exchanged and neither mode goes on.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> car = load_model("quarter_car")
    >>> found = track_modes(
    ...     lambda k: linearise(car.with_parameters({"tyre.stiffness": k})), [150e3, 200e3, 250e3]
    ... )
    >>> found["frequency_hz"].sel(mode="wheel hop").values.round(2)
    array([ 8.91, 10.28, 11.48])
    """
    places = _checked(values)
    sweep = _Sweep(linear_at, parameter, unit, {})
    stations = [sweep.start(places[0])]
    for begin, end in zip(places, places[1:], strict=False):
        stations.append(sweep.step(stations[-1], begin, end))
    named = places[0] if named_at is None else float(named_at)
    nearest = int(np.abs(np.array(places) - named).argmin())
    there = sweep.step(stations[nearest], places[nearest], named)
    names = _names(sweep.linear(named), there)
    found = _dataset([sweep.linear(place) for place in places], stations)
    found = found.assign_coords(value=places, mode=list(names))
    found["value"].attrs.update(long_name=parameter, units=unit)
    return found.assign_attrs(parameter=parameter, unit=unit, evaluations=len(sweep.models))


def without_damping(linear: LinearModel) -> LinearModel:
    """The same model with C = 0: its damped modes are its undamped ones."""
    return replace(linear, damping=np.zeros_like(linear.damping))


@dataclass(frozen=True, eq=False)
class _Sweep:
    """The linear models along a parameter, each computed once, and the words for it.

    Attributes
    ----------
    models
        Those computed so far, by value.
    """

    linear_at: Callable[[float], LinearModel]
    parameter: str
    unit: str
    models: dict[float, LinearModel]

    def linear(self, value: float) -> LinearModel:
        """The linear model at a value."""
        if value not in self.models:
            found = self.linear_at(value)
            expected = next(iter(self.models.values()), found).coordinates
            if found.coordinates != expected:
                raise LinearisationError(
                    f"linear_at gave coordinates {', '.join(found.coordinates)} at {self._at(value)} and "
                    f"{', '.join(expected)} before; modes are tracked in one set of coordinates"
                )
            self.models[value] = found
        return self.models[value]

    def start(self, value: float) -> ModePairs:
        """The pairs at the first value."""
        linear = self.linear(value)
        try:
            return paired(linear)
        except PartnersLostError as lost:
            raise LinearisationError(
                f"{_quoted(_names(linear, undamped_pairs(linear)), lost.pairs)} of {linear.name!r} cannot be "
                f"told apart at {self._at(value)}: as damping grows from zero they exchange eigenvalues at "
                f"{lost.value:.3g} of it; begin where there is less damping"
            ) from lost

    def step(self, pairs: ModePairs, begin: float, end: float) -> ModePairs:
        """What becomes of the pairs from one value to another."""
        try:
            return followed(self.linear, pairs, begin, end) if begin != end else pairs
        except PartnersLostError as lost:
            linear = self.linear(begin)
            raise LinearisationError(
                f"{_quoted(_names(linear, pairs), lost.pairs)} of {linear.name!r} cannot be told apart near "
                f"{self._at(lost.value)}: their eigenvalues become equal there and exchange partners; track "
                "modes on either side of that value by itself"
            ) from lost

    def _at(self, value: float) -> str:
        return f"{self.parameter} = {value:.6g} {self.unit}".rstrip()


def _checked(values: ArrayLike) -> list[float]:
    given = np.asarray(values, dtype=float)
    if given.ndim != 1 or not given.size or not np.isfinite(given).all():
        raise LinearisationError(f"values: received {values!r}, expected one or more finite numbers in a row")
    return [float(value) for value in given]


def _names(linear: LinearModel, pairs: ModePairs) -> tuple[str, ...]:
    return mode_names(linear, list(pairs.shapes), [True] * len(pairs.planes))


def _quoted(names: Sequence[str], chosen: Sequence[int]) -> str:
    return "modes " + " and ".join(repr(names[i]) for i in chosen)


def _dataset(models: Sequence[LinearModel], stations: Sequence[ModePairs]) -> xr.Dataset:
    import xarray as xr  # it takes a second to import: only for those who ask for it

    products = np.array([pairs.products for pairs in stations])
    sums = np.array([pairs.sums for pairs in stations])
    sizes = np.sqrt(np.abs(products))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(sums == 0, 0.0, -sums / (2 * sizes))
    return xr.Dataset(
        {
            "frequency_hz": (("value", "mode"), sizes / (2 * np.pi), {"units": "Hz"}),
            "damping_ratio": (("value", "mode"), ratios),
            "eigenvalue": (
                ("value", "mode", "pair"),
                np.array([pairs.eigenvalues for pairs in stations]),
                {"units": "1/s"},
            ),
            "shape": (("value", "mode", "coordinate"), _smooth_shapes(models, stations)),
        },
        coords={"coordinate": list(models[0].coordinates)},
    )


def _smooth_shapes(models: Sequence[LinearModel], stations: Sequence[ModePairs]) -> Array:
    """Normalised shapes, from the second station on with the phases that are nearest to those before."""
    found: list[Array] = []
    for linear, pairs in zip(models, stations, strict=True):
        shapes = np.array([normalised(linear, shape) for shape in pairs.shapes])
        if found:
            alike = np.einsum("ij,jk,ik->i", found[-1].conj(), linear.mass, shapes)
            shapes *= np.exp(-1j * np.angle(alike))[:, None]
        found.append(shapes)
    return np.array(found)
