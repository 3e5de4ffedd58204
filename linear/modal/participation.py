"""Participation: which coordinates a mode consists of, what excites it and what sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import svd

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.free_motion import free_motion
from chassym.linear.modal.modes import Mode, mode_coordinates
from chassym.linear.modal.motion import motion_of_coordinates
from chassym.linear.modal.spectrum import EQUAL, equal_groups

if TYPE_CHECKING:
    import xarray as xr

Array = np.ndarray


def participation(linear: LinearModel, modes: Sequence[Mode]) -> xr.DataArray:
    """How much every coordinate, with its rate, takes part in every mode.

    The participation factor of a state is the product of its entries in the right and the left eigenvector of
    the first-order system, w_ki v_ki with w_i^T v_i = 1. It does not depend on units, tells how far the
    eigenvalue moves with a feedback of that state to itself, and adds up to 1 over all states (Perez-Arriaga,
    Verghese & Schweppe 1982, Selective modal analysis, IEEE Transactions on Power Apparatus and Systems
    PAS-101 (9), equations 9 to 14). With eigenvectors x, y of the second-order problem,
    (l^2 M + l C + K) x = 0 and its transpose for y, coordinate k and its rate have together

        x_k ((2 l M + C)^T y)_k / (y^T (2 l M + C) x).

    A rigid-body mode in free flight has a double eigenvalue zero and counts as the limit of a slow
    oscillation, x_k (M^T y)_k / (y^T M x).

    Parameters
    ----------
    linear
        The linear model.
    modes
        Modes of it.

    Returns
    -------
    xarray.DataArray
        Complex, over ``coordinate`` and ``mode``; the sum of a mode is 1.

    Raises
    ------
    LinearisationError
        If a mode is critically damped: two eigenvalues are equal, with one shape between them.
    """
    import xarray as xr  # it takes a second to import: only for those who ask for it

    shapes, weighted = _right_and_left(linear, modes)[:2]
    return xr.DataArray(
        shapes * weighted,
        dims=("coordinate", "mode"),
        coords={"coordinate": list(linear.coordinates), **mode_coordinates(modes)},
        name="participation",
    )


def participation_table(linear: LinearModel, modes: Sequence[Mode]) -> xr.DataArray:
    """Size of the participation of what moves in every mode: `participation` summed by words for coordinates.

    Returns
    -------
    xarray.DataArray
        Real, over ``mode`` and ``motion``; ``table.to_pandas()`` prints it. The sizes of complex numbers
        whose sum is 1 may add up to more.

    Raises
    ------
    LinearisationError
        See `participation`.
    """
    import xarray as xr  # it takes a second to import: only for those who ask for it

    factors = participation(linear, modes)
    words = motion_of_coordinates(linear)
    motions = list(dict.fromkeys(words))
    members = np.array([[word == motion for word in words] for motion in motions])
    return xr.DataArray(
        np.abs(members @ factors.values).T,
        dims=("mode", "motion"),
        coords={**mode_coordinates(modes), "motion": motions},
        name="participation",
    )


def input_output_participation(linear: LinearModel, modes: Sequence[Mode]) -> xr.Dataset:
    """How strongly every input excites every mode, and how clearly every output sees it.

    The transfer function is a sum over all eigenvalues l, those of `modes` and the conjugates of the complex
    ones, of the residue over s - l, besides what passes directly. The residue is the product of both, with
    y^T (2 l M + C) x = 1:

        excitation  y^T (B_u + l B_u')          observation  (C_q + l C_q' + l^2 C_q'') x

    Here x has unit modal mass. An oscillation in resonance answers by about |residue| / |Re l|.

    Parameters
    ----------
    linear
        The linear model.
    modes
        Modes of it.

    Returns
    -------
    xarray.Dataset
        Complex: ``excitation`` over ``input`` and ``mode``, ``observation`` over ``output`` and ``mode``,
        ``residue`` over ``output``, ``input`` and ``mode`` (output unit per input unit and second), with
        ``input_unit`` and ``output_unit``.

    Raises
    ------
    LinearisationError
        If a mode is critically damped, or a rigid-body one in free flight: its residue is infinite.
    """
    import xarray as xr  # it takes a second to import: only for those who ask for it

    shapes, _, left = _right_and_left(linear, modes)
    free = [mode.name for mode, y in zip(modes, left.T, strict=True) if not np.isfinite(y).all()]
    if free:
        raise LinearisationError(
            f"mode {free[0]!r} of {linear.name!r} is in free flight: a constant force moves it without "
            "bound; leave it out of modes"
        )
    values = np.array([mode.eigenvalue for mode in modes])
    excitation = linear.input_stiffness.T @ left + values * (linear.input_damping.T @ left)
    observation = (
        linear.output_by_coordinates @ shapes
        + values * (linear.output_by_rates @ shapes)
        + values**2 * (linear.output_by_accelerations @ shapes)
    )
    return xr.Dataset(
        {
            "excitation": (("input", "mode"), excitation),
            "observation": (("output", "mode"), observation),
            "residue": (("output", "input", "mode"), observation[:, None] * excitation),
        },
        coords={
            "input": list(linear.inputs),
            "output": list(linear.outputs),
            "input_unit": ("input", list(linear.input_units)),
            "output_unit": ("output", list(linear.output_units)),
            **mode_coordinates(modes),
        },
    )


def _right_and_left(linear: LinearModel, modes: Sequence[Mode]) -> tuple[Array, Array, Array]:
    """Shapes x, (2 l M + C)^T y and y with y^T (2 l M + C) x = 1, each in columns, shape (n, modes).

    In free flight y is infinite; (2 l M + C)^T y is then M^T y / (y^T M x).
    """
    shapes = np.array([mode.shape for mode in modes], dtype=complex).T
    values = np.array([mode.eigenvalue for mode in modes])
    weighted, left = np.empty_like(shapes), np.empty_like(shapes)
    for group in equal_groups(values):
        x, value = shapes[:, group], values[group].mean()
        y = _left_shapes(linear, value, len(group))
        metric = 2 * value * linear.mass + linear.damping
        free = value == 0 and not _is_regular(y.T @ metric @ x, free_motion(linear).rate)
        if free:
            metric = linear.mass
        elif not _is_regular(y.T @ metric @ x, abs(value)):
            raise LinearisationError(
                f"mode {modes[group[0]].name!r} of {linear.name!r} is critically damped: two eigenvalues are "
                "equal and have one shape between them; change the damping a little"
            )
        y = np.linalg.solve((y.T @ metric @ x).T, y.T).T
        weighted[:, group] = metric.T @ y
        left[:, group] = np.inf if free else y
    return shapes, weighted, left


def _left_shapes(linear: LinearModel, value: complex, count: int) -> Array:
    """Vectors y with y^T (l^2 M + l C + K) = 0, in columns of unit length for unit inertias."""
    size = 1 / np.sqrt(np.diag(linear.mass))
    dynamic = value**2 * linear.mass + value * linear.damping + linear.stiffness
    directions = svd((size[:, None] * dynamic * size).T)[2]
    return size[:, None] * directions[len(size) - count :].conj().T


def _is_regular(product: Array, rate: float) -> bool:
    """Whether y^T (2 l M + C) x is clearly not singular beside a rate (1/s)."""
    return bool(svd(product, compute_uv=False)[-1] > EQUAL * rate)
