"""Natural modes: frequencies, damping and shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, eigh, solve_triangular

from chassym.linear.motion import energy_shares, mode_names
from chassym.linear.state_space import LinearisationError, LinearModel

Array = np.ndarray

ZERO_TOLERANCE = 1e-11
"""Squared natural frequencies below this part of the largest one are those of a rigid-body mode."""


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of the damped system.

    Attributes
    ----------
    frequency_hz
        |eigenvalue| / (2 pi): for an oscillation its undamped natural frequency (Hz).
    damping_ratio
        -Re(eigenvalue) / |eigenvalue|: below 1 an oscillation, 1 a decay without oscillation, negative if it
        grows. Zero for a rigid-body mode.
    name
        What moves.
    eigenvalue
        1/s; of a complex pair the one with positive imaginary part.
    shape
        Complex amplitudes of the coordinates, length n, with shape^H M shape = 1 and the largest entry real
        and positive.
    energy
        Share of the kinetic energy by what moves, see `energy_shares`; the sum is 1.
    """

    frequency_hz: float
    damping_ratio: float
    name: str
    eigenvalue: complex
    shape: Array
    energy: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class UndampedModes:
    """Modes of M q'' + K q = 0.

    Attributes
    ----------
    frequencies_hz
        Ascending, length n; zero for a rigid-body mode.
    shapes
        A mode in every column, shape (n, n), with shapes^T M shapes = 1 and the largest entry of each
        positive.
    names
        What moves.
    energy
        Share of the kinetic energy by what moves, a mapping for every mode.
    """

    frequencies_hz: Array
    shapes: Array
    names: tuple[str, ...]
    energy: tuple[Mapping[str, float], ...]


def undamped_modes(linear: LinearModel) -> UndampedModes:
    """Modes without damping.

    Raises
    ------
    LinearisationError
        If M is singular, or K is not symmetric or has a direction in which the model falls over.
    """
    squared, shapes = _principal_axes(linear)
    if squared[0] < 0:
        falls = mode_names(linear, [shapes[:, 0]], [False])[0]
        raise LinearisationError(
            f"{linear.name!r} falls over in {falls!r}: its stiffness there is negative; stiffen its springs, "
            "or use damped_modes"
        )
    columns = [_normalised(linear, shape) for shape in shapes.T]
    names = mode_names(linear, columns, [True] * len(columns))
    energy = tuple(energy_shares(linear, shape) for shape in columns)
    return UndampedModes(np.sqrt(squared) / (2 * np.pi), np.array(columns).T, names, energy)


def damped_modes(linear: LinearModel) -> tuple[Mode, ...]:
    """Modes with damping, in ascending order of frequency.

    Of a complex pair of eigenvalues the one with positive imaginary part makes a mode. Every real eigenvalue
    makes a mode of its own: an overdamped oscillation has two, a fast and a slow decay. A direction without
    stiffness makes one mode of frequency zero, whether its eigenvalue zero is double (free flight) or single
    (a dashpot to the ground, whose decay is a further mode).

    Raises
    ------
    LinearisationError
        If M is singular or K not symmetric.
    """
    squared, axes = _principal_axes(linear)
    rigid = axes[:, squared == 0]
    values, vectors = eig(linear.state_matrices().A)
    flexible = np.argsort(np.abs(values))[_zero_eigenvalues(linear, axes, rigid) :]
    found = [(0j, shape) for shape in rigid.T]
    found += [(values[i], vectors[: len(axes), i]) for i in flexible if values[i].imag >= 0]
    found.sort(key=lambda pair: abs(pair[0]))
    shapes = [_normalised(linear, shape) for _, shape in found]
    names = mode_names(linear, shapes, [value.imag > 0 or value == 0 for value, _ in found])
    named = zip(names, found, shapes, strict=True)
    return tuple(_mode(linear, name, value, shape) for name, (value, _), shape in named)


def _principal_axes(linear: LinearModel) -> tuple[Array, Array]:
    """Squared circular frequencies, ascending, with rounding taken off zeros, and mass-normalised shapes."""
    stiffness = linear.stiffness
    if np.abs(stiffness - stiffness.T).max() > 1e-9 * np.abs(stiffness).max():
        raise LinearisationError(
            f"stiffness of {linear.name!r} is not symmetric: its forces at rest have no potential"
        )
    factor, lower = linear.mass_factor
    half = solve_triangular(factor, stiffness, trans="T", lower=lower)
    squared, vectors = eigh(solve_triangular(factor, half.T, trans="T", lower=lower))
    shapes = solve_triangular(factor, vectors, lower=lower)
    return np.where(np.abs(squared) <= ZERO_TOLERANCE * np.abs(squared).max(), 0.0, squared), shapes


def _zero_eigenvalues(linear: LinearModel, axes: Array, rigid: Array) -> int:
    """How many eigenvalues are zero: one for every rigid direction, and another if no damper resists it."""
    scale = np.abs(axes.T @ linear.damping @ axes).max()
    resisted = np.linalg.matrix_rank(rigid.T @ linear.damping @ rigid, tol=ZERO_TOLERANCE * scale)
    return 2 * rigid.shape[1] - int(resisted)


def _mode(linear: LinearModel, name: str, value: complex, shape: Array) -> Mode:
    size = abs(value)
    ratio = float(-value.real / size) if size else 0.0
    return Mode(float(size / (2 * np.pi)), ratio, name, complex(value), shape, energy_shares(linear, shape))


def _normalised(linear: LinearModel, shape: Array) -> Array:
    """Unit modal mass, and the largest entry real and positive."""
    peak = shape[np.abs(shape).argmax()]
    return shape * (np.abs(peak) / peak / np.sqrt((shape.conj() @ linear.mass @ shape).real))
