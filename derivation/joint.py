"""Joints: what a body may do relative to its parent, step by step along and about single axes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy

from chassym.derivation.direction import Direction, unit_vector
from chassym.derivation.errors import MechanismError
from chassym.derivation.vector import Vector

ANGLES = {"x": "roll", "y": "pitch", "z": "yaw"}
EULER_ANGLES = ("precession", "nutation", "spin")


@dataclass(frozen=True)
class Coordinate:
    """A generalised coordinate with its rate and its second derivative as independent sympy symbols."""

    name: str
    unit: str

    @cached_property
    def position(self) -> sympy.Symbol:
        """The coordinate itself, zero at the design position."""
        return sympy.Symbol(self.name, real=True)

    @cached_property
    def rate(self) -> sympy.Symbol:
        """Its time derivative."""
        return sympy.Symbol(f"{self.name}_rate", real=True)

    @cached_property
    def acceleration(self) -> sympy.Symbol:
        """Its second time derivative."""
        return sympy.Symbol(f"{self.name}_acceleration", real=True)


@dataclass(frozen=True)
class Step:
    """Rotation about, or translation along, a unit vector fixed in the frame reached so far."""

    coordinate: Coordinate
    axis: Vector
    is_rotation: bool


@dataclass(frozen=True)
class Joint:
    """A sequence of elementary steps from the parent's frame to the body's frame.

    Raises
    ------
    MechanismError
        If one step can do what others do, so that the coordinates would not be independent.
    """

    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        if _freedoms(self.steps) < len(self.steps):
            names = ", ".join(repr(step.coordinate.name) for step in self.steps)
            raise MechanismError(
                f"joint with coordinates {names}: {len(self.steps)} steps give {_freedoms(self.steps)} "
                "degrees of freedom; leave out those that repeat what others do"
            )

    def then(self, other: Joint) -> Joint:
        """This joint followed by another one at the same place."""
        return Joint(self.steps + other.steps)


def weld() -> Joint:
    """No relative motion."""
    return Joint(())


def revolute(coordinate: str, axis: Direction) -> Joint:
    """Rotation in rad about one axis."""
    return Joint((Step(Coordinate(coordinate, "rad"), _axis(coordinate, axis), is_rotation=True),))


def prismatic(coordinate: str, axis: Direction) -> Joint:
    """Translation in m along one axis."""
    return Joint((Step(Coordinate(coordinate, "m"), _axis(coordinate, axis), is_rotation=False),))


def _axis(coordinate: str, axis: Direction) -> Vector:
    return unit_vector(axis, f"joint axis of {coordinate!r}:")


def cylindrical(slide: str, turn: str, axis: Direction) -> Joint:
    """Translation along one axis and rotation about it."""
    return prismatic(slide, axis).then(revolute(turn, axis))


def planar(
    names: tuple[str, str, str] = ("x", "y", "yaw"), axes: tuple[Direction, Direction] = ("x", "y")
) -> Joint:
    """Translation along two axes, then rotation about their normal.

    >>> [step.axis for step in planar(("x", "z", "pitch"), ("z", "x")).steps][2]
    (0, 1, 0)
    """
    first, second = (unit_vector(axis) for axis in axes)
    normal = tuple(sympy.Matrix(first).cross(sympy.Matrix(second)))
    if not any(normal):
        raise MechanismError(f"planar joint with coordinates {', '.join(names)}: its two axes are parallel")
    return prismatic(names[0], first).then(prismatic(names[1], second)).then(revolute(names[2], normal))


def spherical(sequence: str = "zyx", prefix: str = "") -> Joint:
    """Three rotations, one after the other, each about an axis of the frame that the earlier ones left.

    Parameters
    ----------
    sequence
        Three axes, no two neighbours the same. The rotations are called roll (x), pitch (y) and yaw (z), or
        precession, nutation and spin where the first axis is also the last. A sequence of three different
        axes is singular when the second angle is 90 degrees, one such as "zxz" when it is zero.
    prefix
        Put before the names, which have to be unique in a mechanism.

    Examples
    --------
    >>> [step.coordinate.name for step in spherical("zxz", prefix="top_").steps]
    ['top_precession', 'top_nutation', 'top_spin']
    """
    if len(sequence) != 3 or set(sequence) - set("xyz") or sequence[1] in (sequence[0], sequence[2]):
        raise MechanismError(
            f"rotation sequence {sequence!r}: expected three of x, y, z with no two neighbours the same, "
            "as 'zyx'"
        )
    names = EULER_ANGLES if sequence[0] == sequence[2] else [ANGLES[axis] for axis in sequence]
    joint = weld()
    for name, axis in zip(names, sequence, strict=True):
        joint = joint.then(revolute(f"{prefix}{name}", axis))
    return joint


def free(sequence: str = "zyx", prefix: str = "") -> Joint:
    """Six degrees of freedom: x, y, z in the parent's axes, then three rotations as in `spherical`."""
    slides = tuple(step for axis in "xyz" for step in prismatic(f"{prefix}{axis}", axis).steps)
    return Joint(slides).then(spherical(sequence, prefix))


def _freedoms(steps: tuple[Step, ...]) -> int:
    """Rank of the steps' twists at a position drawn at random; numbers are drawn for symbols, too."""
    generator = np.random.default_rng(0)
    rotation, place, twists = np.eye(3), np.zeros(3), []
    drawn = {s: generator.uniform(0.5, 1) for s in sorted(_symbols(steps), key=str)}
    for step in steps:
        axis = np.array([float(component.xreplace(drawn)) for component in step.axis])
        along, amount = rotation @ (axis / np.linalg.norm(axis)), generator.uniform(0.5, 1)
        if step.is_rotation:
            twists.append([*along, *np.cross(place, along)])
            rotation = _turned(rotation, along, amount)
        else:
            twists.append([0, 0, 0, *along])
            place = place + amount * along
    return int(np.linalg.matrix_rank(np.array(twists), tol=1e-9)) if twists else 0


def _turned(rotation: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    """A rotation matrix after one more rotation about an axis of the base (Rodrigues' formula)."""
    across = np.cross(axis, rotation, axisb=0, axisc=0)
    along = np.outer(axis, axis @ rotation)
    return np.cos(angle) * rotation + np.sin(angle) * across + (1 - np.cos(angle)) * along


def _symbols(steps: tuple[Step, ...]) -> set[sympy.Symbol]:
    return set().union(*(component.free_symbols for step in steps for component in step.axis))
