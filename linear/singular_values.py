"""Singular values of a frequency response between signals of one unit, or scaled ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from chassym.linear.frequency_response import FrequencyResponse, index_of
from chassym.linear.linear_model import LinearisationError

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

NO_SCALES: Mapping[str, float] = MappingProxyType({})
"""Signals are taken in their SI units."""


def singular_values(
    response: FrequencyResponse,
    outputs: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
    scales: Mapping[str, float] = NO_SCALES,
) -> xarray.DataArray:
    """Singular values of the response at every frequency, largest first.

    The largest one is the greatest length of the outputs for inputs of length one, and a length adds squares:
    all outputs must have one unit, and all inputs, or else a scale for each.

    Parameters
    ----------
    response
        From `frequency_response`.
    outputs, inputs
        Names of those that count; by default all.
    scales
        Size of one unit on a signal's axis, in its SI unit, by the signal's name: with 0.01 for a pad that
        moves (m) and 2 for an acceleration (m/s^2), gains are in multiples of 2 m/s^2 per 10 mm. For all of
        the outputs or none, and likewise the inputs. A name that is both an output's and an input's scales
        both.

    Returns
    -------
    xarray.DataArray
        Dimensions ``frequency_hz`` and ``order`` (from 1); the attribute ``units`` is the outputs' over the
        inputs', 1 where scaled; ``description`` tells the slopes used.

    Raises
    ------
    LinearisationError
        If a name is unknown, units differ without scales, or a scale is not positive, or is missing.

    Notes
    -----
    S. Skogestad and I. Postlethwaite, Multivariable Feedback Control, 2nd ed., 2005, sections 1.4 (scaling)
    and 3.3 (singular values).

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import frequency_response, linearise
    >>> response = frequency_response(linearise(load_model("quarter_car")), [0.0, 1.0])
    >>> travels = ("body_displacement", "wheel_displacement")
    >>> values = singular_values(response, travels)
    >>> float(values.sel(frequency_hz=0.0, order=1))  # both move one to one: the square root of 2
    1.41421...
    """
    import xarray  # with pandas it takes half a second to import: only for those who ask for it

    rows = _positions("output", outputs, response.outputs)
    columns = _positions("input", inputs, response.inputs)
    _check_scales(scales, [response.outputs[i] for i in rows] + [response.inputs[i] for i in columns])
    output_scales, output_unit = _side("output", rows, response.outputs, response.output_units, scales)
    input_scales, input_unit = _side("input", columns, response.inputs, response.input_units, scales)
    chosen = response.response[np.ix_(rows, columns)]
    scaled = chosen / output_scales[:, None, None] * input_scales[:, None]
    values = np.linalg.svd(np.moveaxis(scaled, -1, 0), compute_uv=False)
    return xarray.DataArray(
        values,
        coords={
            "frequency_hz": ("frequency_hz", response.frequencies_hz, {"units": "Hz"}),
            "order": np.arange(1, values.shape[1] + 1),
        },
        dims=("frequency_hz", "order"),
        name="singular_value",
        attrs={"units": unit_ratio(output_unit, input_unit), "description": response.description},
    )


def unit_ratio(numerator: str, denominator: str) -> str:
    """The unit of a ratio.

    Examples
    --------
    >>> unit_ratio("m/s^2", "m"), unit_ratio("N", "1"), unit_ratio("1", "1")
    ('(m/s^2)/m', 'N', '1')
    """
    if denominator == "1":
        return numerator
    return "/".join(f"({unit})" if "/" in unit or "*" in unit else unit for unit in (numerator, denominator))


def _positions(kind: str, wanted: Sequence[str] | None, names: tuple[str, ...]) -> list[int]:
    if wanted is None:
        return list(range(len(names)))
    if isinstance(wanted, str) or not wanted:
        raise LinearisationError(f"{kind}s {wanted!r} received; a sequence of {kind} names is needed")
    return [index_of(kind, name, names) for name in wanted]


def _check_scales(scales: Mapping[str, float], used: Sequence[str]) -> None:
    for name, scale in scales.items():
        if name not in used:
            raise LinearisationError(
                f"scale of {name!r}: no such signal is used; there are {', '.join(used)}"
            )
        if not (np.isfinite(scale) and scale > 0):
            raise LinearisationError(f"scale of {name!r} is {scale!r}; a positive finite number is needed")


def _side(
    kind: str, places: Sequence[int], names: Sequence[str], units: Sequence[str], scales: Mapping[str, float]
) -> tuple[Array, str]:
    """The scales of the outputs, or of the inputs, and the unit that they have then."""
    chosen = {names[i]: units[i] for i in places}
    unscaled = [name for name in chosen if name not in scales]
    if not unscaled:
        return np.array([scales[names[i]] for i in places], dtype=float), "1"
    if len(unscaled) < len(chosen):
        raise LinearisationError(
            f"scales are missing for the {kind}s {', '.join(unscaled)}; give one for every {kind} or for none"
        )
    first = names[places[0]]
    for name, unit in chosen.items():
        if unit != chosen[first]:
            raise LinearisationError(
                f"{kind}s {first!r} ({chosen[first]}) and {name!r} ({unit}) have different units; select "
                f"{kind}s of one unit or give a scale for every {kind}"
            )
    return np.ones(len(places)), chosen[first]
