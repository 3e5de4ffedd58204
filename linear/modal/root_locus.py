"""Eigenvalues over a parameter: the root locus."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from chassym.derivation import Model
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.linearisation import linearise
from chassym.linear.modal.modes import damped_modes

if TYPE_CHECKING:
    import xarray

Array = np.ndarray


def root_locus(
    linear_at: Callable[[float], LinearModel], values: ArrayLike, parameter: str, unit: str
) -> xarray.DataArray:
    """Eigenvalues of the state matrix over a parameter, in branches that are continuous.

    From one value to the next, every eigenvalue is paired with the one that is nearest to where the secant
    through its last two places leads, so that the sum of these distances is smallest. Branches pass through
    crossings where values lie close enough together. Where a complex pair meets on the real axis and parts
    there, which of the two continues which has no meaning.

    Parameters
    ----------
    linear_at
        Gives the linear model for a value of the parameter, always with the same coordinates.
    values
        Values of the parameter, increasing, shape (values,).
    parameter, unit
        The parameter's name and SI unit.

    Returns
    -------
    xarray.DataArray
        Complex eigenvalues (1/s) with dimensions ``value`` and ``branch`` (two for every coordinate). The
        coordinate ``mode`` names the mode to which a branch belongs at the first value. Attributes:
        ``units``, ``parameter``, ``parameter_units``, and ``description``, what was linearised where.

    Raises
    ------
    LinearisationError
        If the values do not increase, the models have different numbers of coordinates, or a mass matrix is
        singular.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> car = load_model("quarter_car")
    >>> def with_rate(rate):
    ...     return linearise(car.with_parameters({"spring.rate": rate}))
    >>> locus = root_locus(with_rate, [1e4, 2e4], "spring rate", "N/m")
    >>> dict(locus.sizes)
    {'value': 2, 'branch': 4}
    """
    import xarray  # with pandas it takes half a second to import: only for those who ask for it

    places = _increasing(values)
    first = linear_at(float(places[0]))
    roots = [_eigenvalues(first)]
    for place in places[1:]:
        roots.append(_eigenvalues(linear_at(float(place))))
        if len(roots[-1]) != len(roots[0]):
            raise LinearisationError(
                f"linear_at gave {len(roots[0])} eigenvalues at {places[0]:g} and {len(roots[-1])} at "
                f"{place:g}; the same coordinates are needed at every value"
            )
    return xarray.DataArray(
        _branches(places, roots),
        coords={
            "value": ("value", places, {"long_name": parameter, "units": unit}),
            "mode": ("branch", _names(first, roots[0])),
        },
        dims=("value", "branch"),
        name="eigenvalue",
        attrs={
            "units": "1/s",
            "parameter": parameter,
            "parameter_units": unit,
            "description": f"{first.name} linearised {first.operating_point.description}",
        },
    )


def parameter_root_locus(
    model: Model,
    parameter: str,
    values: ArrayLike,
    linearisation: Callable[[Model], LinearModel] = linearise,
) -> xarray.DataArray:
    """Root locus of a model against one of its parameters.

    Parameters
    ----------
    model
        The model.
    parameter
        Name of a parameter with a single value.
    values
        Its values in SI units, increasing, shape (values,).
    linearisation
        Linearises a variant: with other slopes, say, than by default.

    Returns
    -------
    xarray.DataArray
        As of `root_locus`.

    Raises
    ------
    ParameterError
        If the parameter is unknown or cannot have one of the values.
    LinearisationError
        As for `root_locus`.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> locus = parameter_root_locus(load_model("quarter_car"), "tyre.stiffness", [1e5, 2e5, 3e5])
    >>> locus.attrs["parameter"], locus.attrs["parameter_units"]
    ('tyre.stiffness', 'N/m')
    """
    places = _increasing(values)

    def linear_at(value: float) -> LinearModel:
        return linearisation(model.with_parameters({parameter: value}))

    model.with_parameters({parameter: float(places[0])})  # says which names there are, if this is none
    return root_locus(linear_at, places, parameter, model.parameters[parameter].unit)


def _increasing(values: ArrayLike) -> Array:
    places = np.array(values, dtype=float)
    if places.ndim != 1 or not len(places):
        raise LinearisationError(f"values has shape {places.shape}; one dimension with a value is needed")
    if not np.isfinite(places).all() or (np.diff(places) <= 0).any():
        raise LinearisationError(f"values {places} received; finite values that increase are needed")
    return places


def _eigenvalues(linear: LinearModel) -> Array:
    """Ascending in size, of a complex pair the one with positive imaginary part first."""
    roots = np.linalg.eigvals(displacements_and_rates(linear).A)
    return roots[np.lexsort((-roots.imag, np.abs(roots)))]


def _branches(places: Array, roots: Sequence[Array]) -> Array:
    """The roots in the order of their branches, shape (values, branches)."""
    branches = np.array(roots)
    for k in range(1, len(places)):
        expected = branches[k - 1]
        if k > 1:
            step = (places[k] - places[k - 1]) / (places[k - 1] - places[k - 2])
            expected = expected + step * (branches[k - 1] - branches[k - 2])
        _, order = linear_sum_assignment(np.abs(expected[:, None] - branches[k]))
        branches[k] = branches[k, order]
    return branches


def _names(linear: LinearModel, roots: Array) -> list[str]:
    """For every root the name of the mode to which it belongs."""
    modes = damped_modes(linear)
    values = np.array([mode.eigenvalue for mode in modes])
    upper = roots.real + 1j * np.abs(roots.imag)
    return [modes[i].name for i in np.abs(upper[:, None] - values).argmin(axis=1)]
