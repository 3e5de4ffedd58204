"""What moves in a mode: shares of its energies, and words for them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from chassym.linear.linear_model import LinearModel

Array = np.ndarray

PARTICIPATES = 0.1
"""Least energy, as part of the largest one in its group, for a coordinate to be said to take part."""

SPEAKS = 0.25
"""Least share of a mode's energy for a group to name it before another one that has more."""


AT_REST = 1e-3
"""Amplitude, as a part of the largest one along the body, below which a section stands in a node itself."""


ROUNDING = 1e-11
"""Energy below this part of its largest term is nothing."""

TORSION = "body torsion"
"""The group of the twists of body sections."""


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


ALONG_AXES = (
    Motion(re.compile(r"x"), "longitudinal", "longitudinal"),
    Motion(re.compile(r"y"), "lateral", "lateral"),
    Motion(re.compile(r"z"), "bounce", "bounce"),
)
"""Words for coordinates along the axes of a vehicle, which is what has a coordinate among `ROTATIONS`."""

MOTIONS = (
    Motion(re.compile(r"(body_)?bounce"), "bounce", "bounce"),
    Motion(re.compile(r"(front|rear)_torsion"), TORSION, r"\1 body torsion", along="roll"),
    Motion(re.compile(r"section_(\d+)_torsion"), TORSION, r"section \1 body torsion", along="roll"),
    Motion(
        re.compile(r"(front|rear)_(left|right)_(arm_angle|wheel_bounce)"),
        r"\1 wheel hop",
        r"\1 \2 wheel hop",
        along="bounce",
    ),
    Motion(re.compile(r"(front|rear)_travel"), r"\1 wheel hop", r"\1 wheel hop", along="bounce"),
    Motion(re.compile(r"(left|right)_wheel_bounce"), "wheel hop", r"\1 wheel hop", along="bounce"),
    Motion(re.compile(r"wheel_bounce"), "wheel hop", "wheel hop"),
)
"""Words for the coordinates of vehicles; a coordinate that none matches is called by its own name."""

TRANSLATIONS = ("longitudinal", "lateral", "bounce")
ROTATIONS = ("yaw", "pitch", "roll")


def energy_shares(linear: LinearModel, shape: Array) -> dict[str, float]:
    """Shares of a mode's kinetic energy by what moves; the sum is 1.

    A coordinate's share is its amplitude times its generalised momentum, q_i (M q)_i / (q^T M q): the
    momentum of an arm is that of its wheel's absolute motion, so that a wheel which stays in place under a
    moving body has none. A share can be slightly negative, where a part lags behind what carries it.

    The body's displacement is taken at its elastic centre, where a push on the tyres moves the body without
    turning it: sideways motion at the mass centre which comes from roll about an axis near the road then
    counts as roll.

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
    return _by_group(linear, _coordinate_shares(linear, shape, linear.mass))


def potential_shares(linear: LinearModel, shape: Array) -> dict[str, float]:
    """Shares of a mode's potential energy by what moves, q_i (K q)_i / (q^T K q); see `energy_shares`.

    They say along which coordinates springs and weights hold the mode. The sum is 1; all are 0 in a mode
    without stiffness.
    """
    return _by_group(linear, _coordinate_shares(linear, shape, linear.stiffness))


def dissipation_shares(linear: LinearModel, shape: Array) -> dict[str, float]:
    """Shares of the power that a mode loses by what moves, q'_i (C q')_i / (q'^T C q'); see `energy_shares`.

    The sum is 1; all are 0 in a mode without damping.
    """
    return _by_group(linear, _coordinate_shares(linear, shape, linear.damping))


def mode_names(linear: LinearModel, shapes: Sequence[Array], oscillates: Sequence[bool]) -> tuple[str, ...]:
    """A name for every shape: the group of coordinates that has most of the kinetic energy.

    Where two modes share two motions almost evenly, sideways and yaw say, both may have most of it in the
    same one. A group therefore names no more oscillations than it has coordinates, those with the largest
    shares, and the next one is named by its second largest share. Decays are named by their largest share.
    Where several coordinates of a group take part it is said whether they move the same way. Names that are
    still equal are numbered.

    Parameters
    ----------
    linear
        The linear model.
    shapes
        Amplitudes of the coordinates, length n each.
    oscillates
        Whether the mode is an oscillation.
    """
    energies = [energy_shares(linear, shape) for shape in shapes]
    groups = [max(energy, key=energy.__getitem__) for energy in energies]
    room = Counter(motion_of_coordinates(linear))
    claims = [
        (share, i, group) for i, e in enumerate(energies) if oscillates[i] for group, share in e.items()
    ]
    named = set()
    for share, index, group in sorted(claims, reverse=True):
        if share >= SPEAKS and room[group] and index not in named:
            named.add(index)
            room[group] -= 1
            groups[index] = group
    return tuple(
        _numbered([_name(linear, shape, group) for shape, group in zip(shapes, groups, strict=True)])
    )


def motion_of_coordinates(linear: LinearModel) -> tuple[str, ...]:
    """The word for the group of every coordinate."""
    return tuple(words.group for words in _words(linear.coordinates))


def _numbered(names: Sequence[str]) -> list[str]:
    """Names with a number where they are equal."""
    often, seen = Counter(names), Counter[str]()
    numbered = []
    for name in names:
        seen[name] += 1
        numbered.append(f"{name} {seen[name]}" if often[name] > 1 else name)
    return numbered


def _name(linear: LinearModel, shape: Array, group: str) -> str:
    """The word for the coordinates of a group that take part, and whether they move the same way."""
    members = _members(linear, group)
    if group == TORSION and len(members) > 2:
        nodes = _nodes(linear, shape)
        return f"{group}, {nodes} {'node' if nodes == 1 else 'nodes'}"
    shares = _coordinate_shares(linear, shape, linear.mass)
    active = [i for i in members if shares[i] >= PARTICIPATES * shares[members].max()]
    words = _words(linear.coordinates)[active[0]]
    if len(active) == 1:
        return words.alone
    carrier = _members(linear, words.along)
    if not carrier:
        return group
    # The sign of the coupling in M tells which way a coordinate moves its mass along the carrier's motion.
    moves = shape[active] * np.where(linear.mass[carrier[0], active] < 0, -1.0, 1.0)
    return f"{group}, {'in phase' if (moves[0].conj() * moves[1:]).real.min() > 0 else 'opposite'}"


def _nodes(linear: LinearModel, shape: Array) -> int:
    """How often the roll angle changes its sign along the body.

    Coordinates are the twists of the sections against a free one, which stands at index count // 2.
    """
    twisted = sorted(_members(linear, TORSION), key=lambda i: _place(linear.coordinates[i]))
    roll = shape[_members(linear, "roll")].sum()
    angles = np.insert(roll + shape[twisted], (len(twisted) + 1) // 2, roll)
    turned = (angles / np.sqrt(np.sum(angles**2) + 0j)).real
    signs = np.sign(turned[np.abs(turned) > AT_REST * np.abs(turned).max()])
    return int((np.diff(signs) != 0).sum())


def _place(coordinate: str) -> float:
    """Order of the sections from front to rear."""
    number = re.search(r"\d+", coordinate)
    return float(number[0]) if number else (0.0 if coordinate.startswith("front") else np.inf)


def _members(linear: LinearModel, group: str) -> list[int]:
    return [i for i, word in enumerate(motion_of_coordinates(linear)) if word == group]


def _by_group(linear: LinearModel, coordinate_shares: Array) -> dict[str, float]:
    shares: dict[str, float] = {}
    for word, share in zip(motion_of_coordinates(linear), coordinate_shares, strict=True):
        shares[word] = shares.get(word, 0.0) + float(share)
    return shares


def _coordinate_shares(linear: LinearModel, shape: Array, matrix: Array) -> Array:
    """Amplitude times momentum or force, with the body's displacement taken at its elastic centre.

    With the rotations r, that displacement is p = d + N r, where d is the origin's and N = K[d, r] / K[d, d]:
    in these coordinates no force acts along p when the body turns. What pushes along r is then less by N^T
    times that along d. If all adds up to nothing but rounding, there are no shares.
    """
    push = (matrix @ shape).astype(complex)
    moved, pushed = shape.astype(complex), push.copy()
    rotations = [i for group in ROTATIONS for i in _members(linear, group)]
    for i in (i for group in TRANSLATIONS for i in _members(linear, group)):
        if linear.stiffness[i, i] > 0:
            lever = linear.stiffness[i, rotations] / linear.stiffness[i, i]
            moved[i] += lever @ shape[rotations]
            pushed[rotations] -= lever * push[i]
    shares = (moved.conj() * pushed).real
    total, largest = shares.sum(), np.abs(matrix * np.outer(shape, shape)).max()
    return shares / total if abs(total) > ROUNDING * largest else np.zeros(len(shares))


@cache
def _words(coordinates: tuple[str, ...]) -> tuple[Motion, ...]:
    """The words for every coordinate; by default its own name."""
    known = ALONG_AXES + MOTIONS if set(ROTATIONS).intersection(coordinates) else MOTIONS
    return tuple(_word(coordinate, known) for coordinate in coordinates)


def _word(coordinate: str, known: Sequence[Motion]) -> Motion:
    for motion in known:
        match = motion.coordinates.fullmatch(coordinate)
        if match:
            group, alone = match.expand(motion.group), match.expand(motion.alone)
            return Motion(motion.coordinates, group, alone, motion.along)
    own = coordinate.replace("_", " ")
    return Motion(re.compile(re.escape(coordinate)), own, own)
