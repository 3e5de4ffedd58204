"""The modal assurance criterion: how alike the mode shapes of two models or of two tests are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.modes import Mode, damped_modes

if TYPE_CHECKING:
    import xarray as xr

Array = np.ndarray


def modal_assurance(
    first_shapes: ArrayLike, second_shapes: ArrayLike, weight: ArrayLike | None = None
) -> Array:
    """|a^H W b|^2 / ((a^H W a) (b^H W b)) of every shape a with every shape b.

    1 for shapes that are proportional, also by a complex factor; 0 for shapes that are orthogonal with
    respect to W. Allemang & Brown 1982, A correlation coefficient for modal vector analysis, 1st
    International Modal Analysis Conference; Allemang 2003, Sound and Vibration 37 (8).

    Parameters
    ----------
    first_shapes, second_shapes
        A mode in every column, real or complex, shapes (coordinates, first) and (coordinates, second).
    weight
        W, symmetric and positive definite, shape (coordinates, coordinates); by default the unit matrix,
        which compares metres with radians where coordinates are of both kinds. With the mass matrix the
        undamped modes of one model are orthogonal.

    Returns
    -------
    numpy.ndarray
        Real, shape (first, second).

    Raises
    ------
    LinearisationError
        If the shapes do not fit together, or one is zero.

    Examples
    --------
    >>> modal_assurance([[1, 1], [1, -1]], [[2j], [2j]]).round(12)
    array([[1.], [0.]])
    """
    first, second = np.atleast_2d(first_shapes), np.atleast_2d(second_shapes)
    matrix = np.eye(len(first)) if weight is None else np.asarray(weight)
    if len(first) != len(second) or matrix.shape != (len(first), len(first)):
        raise LinearisationError(
            f"shapes {first.shape} and {second.shape} and weight {matrix.shape} do not fit together; modes "
            "are columns over the same coordinates, and the weight is square over these"
        )
    own = [np.einsum("ik,ij,jk->k", shapes.conj(), matrix, shapes).real for shapes in (first, second)]
    if not all((size > 0).all() for size in own):
        raise LinearisationError(
            "a shape has a squared size of zero or less; shapes other than zero and a positive definite "
            "weight are needed"
        )
    return np.abs(first.conj().T @ matrix @ second) ** 2 / np.outer(*own)


def compare_modes(
    first: LinearModel,
    second: LinearModel,
    *,
    modes_of: Callable[[LinearModel], Sequence[Mode]] = damped_modes,
    weight: ArrayLike | None = None,
) -> xr.DataArray:
    """The modal assurance of the modes of two models, by the coordinates that both have.

    Parameters
    ----------
    first, second
        The linear models; coordinates are the same if they have the same name.
    modes_of
        The modes compared.
    weight
        Weight over `common_coordinates`; by default the mass matrix of the model with fewer coordinates.

    Returns
    -------
    xarray.DataArray
        Over ``first_mode`` and ``second_mode``, by name, with their frequencies.

    Raises
    ------
    LinearisationError
        If the models have no coordinate in common, or a mode does not move any of them.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> flexible, rigid = (linearise(load_model(name)) for name in ("sedan", "rigid_sedan"))
    >>> float(compare_modes(flexible, rigid).sel(first_mode="bounce", second_mode="bounce")) > 0.999
    True
    """
    import xarray as xr  # it takes a second to import: only for those who ask for it

    names = common_coordinates(first, second)
    smaller = min(second, first, key=lambda linear: len(linear.coordinates))
    places = [smaller.coordinates.index(name) for name in names]
    matrix = smaller.mass[np.ix_(places, places)] if weight is None else weight
    modes = modes_of(first), modes_of(second)
    shapes = (_restricted(first, modes[0], names), _restricted(second, modes[1], names))
    coordinates: dict[str, object] = {}
    for label, own in zip(("first", "second"), modes, strict=True):
        dimension = f"{label}_mode"
        coordinates[dimension] = [mode.name for mode in own]
        coordinates[f"{label}_frequency_hz"] = (dimension, [mode.frequency_hz for mode in own])
    return xr.DataArray(
        modal_assurance(*shapes, matrix),
        dims=("first_mode", "second_mode"),
        coords=coordinates,
        name="modal_assurance",
    )


def common_coordinates(first: LinearModel, second: LinearModel) -> tuple[str, ...]:
    """Names of the coordinates that both models have, in the first one's order.

    Raises
    ------
    LinearisationError
        If there is none.
    """
    common = tuple(name for name in first.coordinates if name in second.coordinates)
    if not common:
        raise LinearisationError(
            f"{first.name!r} with coordinates {', '.join(first.coordinates)} and {second.name!r} with "
            f"{', '.join(second.coordinates)} have none in common by which to compare modes"
        )
    return common


def _restricted(linear: LinearModel, modes: Sequence[Mode], names: Sequence[str]) -> Array:
    rows = [linear.coordinates.index(name) for name in names]
    for mode in modes:
        if not mode.shape[rows].any():
            raise LinearisationError(
                f"mode {mode.name!r} of {linear.name!r} moves none of the common coordinates "
                f"{', '.join(names)}; compare modes that move some of them"
            )
    return np.array([mode.shape[rows] for mode in modes]).T
