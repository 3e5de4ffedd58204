"""Natural modes: frequencies, damping, shapes, and names for what moves."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import eig, eigh, solve_triangular

from chassym.linear.state_space import LinearisationError, LinearModel

Array = np.ndarray

ZERO_TOLERANCE = 1e-11
"""Squared natural frequencies below this part of the largest one are those of a rigid-body mode."""

PARTICIPATES = 0.1
"""Least share of a group's energy for one of its coordinates to be said to take part."""


@dataclass(frozen=True)
class Motion:
    """Coordinates that an engineer has one word for.

    Attributes
    ----------
    coordinates
        Regular expression that matches their names in full.
    group
        The word for them together, a template for the match.
    alone
        The word for one of them by itself, a template for the match.
    along
        Group of the body motion along which their directions are compared; empty where each stands alone.
    """

    coordinates: re.Pattern[str]
    group: str
    alone: str
    along: str = ""


MOTIONS = (
    Motion(re.compile(r"x"), "longitudinal", "longitudinal"),
    Motion(re.compile(r"y"), "lateral", "lateral"),
    Motion(re.compile(r"z|bounce|body"), "bounce", "bounce"),
    Motion(re.compile(r"(front|rear)_torsion"), "body torsion", r"\1 body torsion", along="roll"),
    Motion(
        re.compile(r"(front|rear)_(left|right)_arm_angle"),
        r"\1 wheel hop",
        r"\1 \2 wheel hop",
        along="bounce",
    ),
    Motion(re.compile(r"(front|rear)_travel"), r"\1 wheel hop", r"\1 wheel hop", along="bounce"),
    Motion(re.compile(r"wheel"), "wheel hop", "wheel hop"),
)
"""Words for the coordinates of vehicles; a coordinate that none matches is called by its own name."""

TRANSLATIONS = ("longitudinal", "lateral", "bounce")
ROTATIONS = ("yaw", "pitch", "roll")


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of the damped system.

    Attributes
    ----------
    frequency_hz
        |eigenvalue| / (2 pi): for an oscillation its undamped natural frequency (Hz).
    damping_ratio
        -Re(eigenvalue) / |eigenvalue|: below 1 an oscillation, 1 a decay without oscillation, negative if it grows.
        Zero for a rigid-body mode.
    name
        What moves.
    eigenvalue
        1/s; of a complex pair the one with positive imaginary part.
    shape
        Complex amplitudes of the coordinates, length n, with shape^H M shape = 1 and the largest entry real and positive.
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
        A mode in every column, shape (n, n), with shapes^T M shapes = 1 and the largest entry of each positive.
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
        falls = _named(linear, [shapes[:, 0]])[0]
        raise LinearisationError(
            f"{linear.name!r} falls over in {falls!r}: its stiffness there is negative; stiffen its springs, or use damped_modes"
        )
    columns = [_normalised(linear, shape) for shape in shapes.T]
    names = _named(linear, columns)
    energy = tuple(energy_shares(linear, shape) for shape in columns)
    return UndampedModes(np.sqrt(squared) / (2 * np.pi), np.array(columns).T, names, energy)


def damped_modes(linear: LinearModel) -> tuple[Mode, ...]:
    """Modes with damping, in ascending order of frequency.

    Of a complex pair of eigenvalues the one with positive imaginary part makes a mode. Every real eigenvalue makes a
    mode of its own: an overdamped oscillation has two, a fast and a slow decay. A direction without stiffness makes
    one mode of frequency zero, whether its eigenvalue zero is double (free flight) or single (a dashpot to the ground,
    whose decay is a further mode).

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
    names = _named(linear, shapes)
    return tuple(_mode(linear, value, *rest) for (value, _), *rest in zip(found, shapes, names, strict=True))


def energy_shares(linear: LinearModel, shape: Array) -> dict[str, float]:
    """Shares of a mode's kinetic energy by what moves; the sum is 1.

    A coordinate's share is its amplitude times its generalised momentum, q_i (M q)_i / (q^T M q): the momentum of an arm
    is that of its wheel's absolute motion, so that a wheel which stays in place under a moving body has none. A share
    can be slightly negative, where a part lags behind what carries it.

    The body's displacement is taken at its elastic centre, where a push on the tyres moves the body without turning it:
    sideways motion at the mass centre which comes from roll about an axis near the road then counts as roll.

    Parameters
    ----------
    linear
        The linear model.
    shape
        Amplitudes of the coordinates, real or complex, length n.

    Returns
    -------
    dict of str to float
        By the group of `MOTIONS`, in the order of the coordinates.
    """
    shares: dict[str, float] = {}
    for name, share in zip(linear.coordinates, _coordinate_shares(linear, shape), strict=True):
        group = _word(name).group
        shares[group] = shares.get(group, 0.0) + float(share)
    return shares


def _principal_axes(linear: LinearModel) -> tuple[Array, Array]:
    """Squared circular frequencies, ascending, and mass-normalised shapes; what rounding leaves of a zero is zero."""
    stiffness = linear.stiffness
    if np.abs(stiffness - stiffness.T).max() > 1e-9 * np.abs(stiffness).max():
        raise LinearisationError(
            f"stiffness of {linear.name!r} is not symmetric: its forces have no potential, without which it has no modes"
        )
    factor, lower = linear.mass_factor
    half = solve_triangular(factor, stiffness, trans="T", lower=lower)
    squared, vectors = eigh(solve_triangular(factor, half.T, trans="T", lower=lower))
    shapes = solve_triangular(factor, vectors, lower=lower)
    return np.where(np.abs(squared) <= ZERO_TOLERANCE * np.abs(squared).max(), 0.0, squared), shapes


def _zero_eigenvalues(linear: LinearModel, axes: Array, rigid: Array) -> int:
    """How many eigenvalues are zero: one for every rigid direction, and another where no damper resists it either."""
    scale = np.abs(axes.T @ linear.damping @ axes).max()
    resisted = np.linalg.matrix_rank(rigid.T @ linear.damping @ rigid, tol=ZERO_TOLERANCE * scale)
    return 2 * rigid.shape[1] - int(resisted)


def _mode(linear: LinearModel, value: complex, shape: Array, name: str) -> Mode:
    size = abs(value)
    ratio = float(-value.real / size) if size else 0.0
    return Mode(float(size / (2 * np.pi)), ratio, name, complex(value), shape, energy_shares(linear, shape))


def _normalised(linear: LinearModel, shape: Array) -> Array:
    """Unit modal mass, and the largest entry real and positive."""
    peak = shape[np.abs(shape).argmax()]
    return shape * (np.abs(peak) / peak / np.sqrt((shape.conj() @ linear.mass @ shape).real))


def _coordinate_shares(linear: LinearModel, shape: Array) -> Array:
    """Amplitude times momentum, with the body's displacement taken at its elastic centre.

    A displacement p of the centre is that of the origin plus N times the rotations, and K[p, rotation] = K[p, p] N. With
    the displacement p = q + N r as coordinate the momentum that belongs to r is less by N^T times that of q.
    """
    shifted, momentum = shape.astype(complex), linear.mass @ shape
    groups = [_word(name).group for name in linear.coordinates]
    rotations = [i for i, group in enumerate(groups) if group in ROTATIONS]
    moved, pushed = shifted.copy(), momentum.astype(complex)
    for i in (i for i, group in enumerate(groups) if group in TRANSLATIONS and linear.stiffness[i, i] > 0):
        lever = linear.stiffness[i, rotations] / linear.stiffness[i, i]
        moved[i] += lever @ shifted[rotations]
        pushed[rotations] -= lever * momentum[i]
    shares = (moved.conj() * pushed).real
    return shares / shares.sum()


def _named(linear: LinearModel, shapes: Sequence[Array]) -> tuple[str, ...]:
    """A name for every shape; equal ones are told apart by what else moves, and then by number."""
    energies = [energy_shares(linear, shape) for shape in shapes]
    names = [
        _name(linear, shape, max(e, key=e.__getitem__)) for shape, e in zip(shapes, energies, strict=True)
    ]
    repeated = Counter(names)
    for i, energy in enumerate(energies):
        if repeated[names[i]] > 1 and len(energy) > 1:
            names[i] += f" with {sorted(energy, key=energy.__getitem__)[-2]}"
    repeated = Counter(names)
    seen: Counter[str] = Counter()
    for i, name in enumerate(names):
        seen[name] += 1
        names[i] = f"{name} {seen[name]}" if repeated[name] > 1 else name
    return tuple(names)


def _name(linear: LinearModel, shape: Array, group: str) -> str:
    """The word for the coordinates of a group that take part, and whether they move the same way."""
    members = [i for i, name in enumerate(linear.coordinates) if _word(name).group == group]
    shares = _coordinate_shares(linear, shape)
    active = [i for i in members if shares[i] >= PARTICIPATES * shares[members].sum()]
    if len(active) == 1:
        return _word(linear.coordinates[active[0]]).alone
    body = [
        i
        for i, name in enumerate(linear.coordinates)
        if _word(name).group == _word(linear.coordinates[active[0]]).along
    ]
    if not body:
        return group
    moves = shape[active] * np.sign(linear.mass[body[0], active])
    return f"{group}, {'in phase' if (moves[0].conj() * moves[1:]).real.min() > 0 else 'opposite'}"


@cache
def _word(coordinate: str) -> Motion:
    """The words for a coordinate; by default its own name."""
    for motion in MOTIONS:
        match = motion.coordinates.fullmatch(coordinate)
        if match:
            return Motion(
                motion.coordinates, match.expand(motion.group), match.expand(motion.alone), motion.along
            )
    own = coordinate.replace("_", " ")
    return Motion(re.compile(re.escape(coordinate)), own, own)
