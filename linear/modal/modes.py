"""Natural modes: frequencies, damping and shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eig, eigh

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.free_motion import ZERO_TOLERANCE, free_motion, rigid_body_shapes
from chassym.linear.modal.motion import dissipation_shares, energy_shares, mode_names, potential_shares
from chassym.linear.modal.pair_following import PartnersLostError, paired

if TYPE_CHECKING:
    import xarray as xr

Array = np.ndarray

GROWS = 1e-9
"""Least real part of an eigenvalue that grows, as a part of its size: less is rounding."""


SYMMETRIC = 1e-6
"""Difference of two entries of a shape, as a part of them, that is rounding."""


class ModeKind(StrEnum):
    """What a mode does when left to itself."""

    OSCILLATION = "oscillation"
    GROWING_OSCILLATION = "growing oscillation"
    DECAY = "decay"
    DIVERGENCE = "divergence"
    RIGID_BODY = "rigid body"


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of the damped system.

    Attributes
    ----------
    frequency_hz
        |eigenvalue| / (2 pi): for an oscillation its undamped natural frequency (Hz). For a decay or a
        divergence it is no frequency of anything; see `time_constant` and `pair_frequency_hz`.
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
    energy, potential_energy, dissipation
        Shares of the kinetic energy, the potential energy and the power lost by what moves, see
        `energy_shares`; the sums are 1, or 0 where there is none.
    partner
        The other eigenvalue of an overdamped oscillation (1/s). None for every other mode, and where damping
        has mixed several oscillations so that no two decays belong together.
    """

    frequency_hz: float
    damping_ratio: float
    name: str
    eigenvalue: complex
    shape: Array
    energy: Mapping[str, float]
    potential_energy: Mapping[str, float]
    dissipation: Mapping[str, float]
    partner: complex | None = None

    @property
    def kind(self) -> ModeKind:
        """What the mode does when left to itself."""
        grows = self.eigenvalue.real > GROWS * abs(self.eigenvalue)
        if self.eigenvalue == 0:
            return ModeKind.RIGID_BODY
        if self.eigenvalue.imag:
            return ModeKind.GROWING_OSCILLATION if grows else ModeKind.OSCILLATION
        return ModeKind.DIVERGENCE if grows else ModeKind.DECAY

    @property
    def time_constant(self) -> float:
        """Time in which the amplitude changes by the factor e (s), infinite if it does not."""
        rate = abs(self.eigenvalue.real)
        return 1 / rate if rate else np.inf

    @property
    def damped_frequency_hz(self) -> float:
        """Frequency with which it is seen to oscillate, Im(eigenvalue) / (2 pi) (Hz); zero if it does not."""
        return self.eigenvalue.imag / (2 * np.pi)

    @property
    def is_overdamped(self) -> bool:
        """Whether this is one of the two decays of an oscillation with a damping ratio of 1 or more."""
        return self.partner is not None

    @property
    def pair_frequency_hz(self) -> float:
        """Undamped frequency sqrt(l_1 l_2) / (2 pi) of the pair of eigenvalues it belongs to (Hz)."""
        return float(np.sqrt(abs(self.eigenvalue * self._other)) / (2 * np.pi))

    @property
    def pair_damping_ratio(self) -> float:
        """Damping ratio -(l_1 + l_2) / (2 sqrt(l_1 l_2)) of that pair: above 1 if overdamped."""
        size = np.sqrt(abs(self.eigenvalue * self._other))
        return float(-(self.eigenvalue + self._other).real / (2 * size)) if size else 0.0

    @property
    def _other(self) -> complex:
        return self.eigenvalue.conjugate() if self.partner is None else self.partner


@dataclass(frozen=True, eq=False)
class UndampedModes:
    """Modes of M q'' + K q = 0.

    Attributes
    ----------
    modes
        One by one, in ascending order of frequency.
    """

    modes: tuple[Mode, ...]

    @cached_property
    def frequencies_hz(self) -> Array:
        """Ascending, length n; zero for a rigid-body mode."""
        return np.array([mode.frequency_hz for mode in self.modes])

    @cached_property
    def shapes(self) -> Array:
        """A real mode in every column, shape (n, n), shapes^T M shapes = 1, the largest entry positive."""
        return np.array([mode.shape for mode in self.modes]).T

    @cached_property
    def names(self) -> tuple[str, ...]:
        """What moves."""
        return tuple(mode.name for mode in self.modes)

    @cached_property
    def energy(self) -> tuple[Mapping[str, float], ...]:
        """Share of the kinetic energy by what moves, a mapping for every mode."""
        return tuple(mode.energy for mode in self.modes)


def undamped_modes(linear: LinearModel) -> UndampedModes:
    """Modes without damping.

    Raises
    ------
    LinearisationError
        If M is singular, or K is not symmetric or has a direction in which the model falls over.
    """
    squares, shapes = _principal_axes(linear)
    if squares[0] < 0:
        falls = mode_names(linear, [shapes[:, 0]], [False])[0]
        raise LinearisationError(
            f"{linear.name!r} falls over in {falls!r}: its stiffness there is negative; stiffen its springs, "
            "or use damped_modes"
        )
    columns = [normalised(linear, shape) for shape in shapes.T]
    names = mode_names(linear, columns, [True] * len(columns))
    found = zip(names, np.sqrt(squares), columns, strict=True)
    return UndampedModes(tuple(_mode(linear, name, complex(0, w), shape) for name, w, shape in found))


def damped_modes(linear: LinearModel) -> tuple[Mode, ...]:
    """Modes with damping, in ascending order of the size of their eigenvalues.

    Of a complex pair of eigenvalues the one with positive imaginary part makes a mode. Every real eigenvalue
    makes a mode of its own: an overdamped oscillation has two, a slow and a fast decay, which are each
    other's `Mode.partner`. A direction without stiffness makes one mode of frequency zero, whether its
    eigenvalue zero is double (free flight) or single (a dashpot to the ground, whose decay is a further
    mode). The stiffness need not have a potential: follower forces may make oscillations grow.

    Raises
    ------
    LinearisationError
        If M is singular.
    """
    motion = free_motion(linear)
    values, vectors = eig(motion.matrix)
    values *= motion.rate
    n = len(values) // 2
    flexible = np.abs(values).argsort()[motion.zero_eigenvalues :]
    found = [(0j, shape) for shape in rigid_body_shapes(linear).T]
    found += [
        (complex(values[i]), motion.scale[:n] * vectors[:n, i]) for i in flexible if values[i].imag >= 0
    ]
    shapes = [normalised(linear, shape) for _, shape in found]
    names = mode_names(linear, shapes, [value.imag > 0 or value == 0 for value, _ in found])
    partners = _partners(linear, [value for value, _ in found])
    named = zip(names, found, shapes, partners, strict=True)
    return tuple(_mode(linear, name, value, shape, partner) for name, (value, _), shape, partner in named)


def energy_table(modes: Sequence[Mode]) -> xr.Dataset:
    """What moves in every mode: shares of the energies and of the power lost, as a labelled table.

    Returns
    -------
    xarray.Dataset
        ``kinetic``, ``potential`` and ``dissipation`` over ``mode`` and ``motion``, with the modes'
        ``frequency_hz``, ``damping_ratio`` and ``kind``; ``table["kinetic"].to_pandas()`` prints one.
    """
    import xarray as xr  # it takes a second to import: only for those who ask for it

    shares = {
        "kinetic": [mode.energy for mode in modes],
        "potential": [mode.potential_energy for mode in modes],
        "dissipation": [mode.dissipation for mode in modes],
    }
    motions = list(dict.fromkeys(motion for mode in modes for motion in mode.energy))
    variables = {
        name: (("mode", "motion"), np.array([[share[motion] for motion in motions] for share in rows]))
        for name, rows in shares.items()
    }
    return xr.Dataset(variables, coords={**mode_coordinates(modes), "motion": motions})


def mode_coordinates(modes: Sequence[Mode]) -> dict[str, object]:
    """What labels modes in a table: name, frequency, damping ratio, and what they do."""
    return {
        "mode": [mode.name for mode in modes],
        "frequency_hz": ("mode", [mode.frequency_hz for mode in modes]),
        "damping_ratio": ("mode", [mode.damping_ratio for mode in modes]),
        "kind": ("mode", [str(mode.kind) for mode in modes]),
    }


def _principal_axes(linear: LinearModel) -> tuple[Array, Array]:
    """Squared circular frequencies, ascending, with rounding taken off zeros, and mass-normalised shapes."""
    stiffness = linear.stiffness
    if np.abs(stiffness - stiffness.T).max() > 1e-9 * np.abs(stiffness).max():
        raise LinearisationError(
            f"stiffness of {linear.name!r} is not symmetric: its forces at rest have no potential; use "
            "damped_modes"
        )
    linear.mass_factor  # noqa: B018 - refuses a singular mass matrix by the name of the coordinate
    squares, shapes = eigh(stiffness, linear.mass)
    return np.where(np.abs(squares) <= ZERO_TOLERANCE * np.abs(squares).max(), 0.0, squares), shapes


def _partners(linear: LinearModel, values: Sequence[complex]) -> list[complex | None]:
    """The other eigenvalue of its pair for every one that belongs to an overdamped oscillation."""
    partners: list[complex | None] = [None] * len(values)
    decays = [i for i, value in enumerate(values) if value.imag == 0 and value.real < 0]
    if len(decays) < 2:
        return partners
    try:
        pairs = paired(linear)
    except PartnersLostError:
        return partners
    decaying = np.array([values[i].real for i in decays])
    for pair in pairs.eigenvalues:
        if not pair.imag.any() and pair.real.max() < 0:
            one, other = (decays[np.abs(decaying - value).argmin()] for value in pair.real)
            partners[one], partners[other] = values[other], values[one]
    return partners


def _mode(
    linear: LinearModel, name: str, value: complex, shape: Array, partner: complex | None = None
) -> Mode:
    size = abs(value)
    return Mode(
        frequency_hz=float(size / (2 * np.pi)),
        damping_ratio=float(-value.real / size) if size else 0.0,
        name=name,
        eigenvalue=value,
        shape=shape,
        energy=energy_shares(linear, shape),
        potential_energy=potential_shares(linear, shape),
        dissipation=dissipation_shares(linear, shape),
        partner=partner,
    )


def normalised(linear: LinearModel, shape: Array) -> Array:
    """Unit modal mass, and the largest entry real and positive; of equal ones the first."""
    sizes = np.abs(shape)
    peak = shape[(sizes >= (1 - SYMMETRIC) * sizes.max()).argmax()]
    return shape * (np.abs(peak) / peak / np.sqrt((shape.conj() @ linear.mass @ shape).real))
