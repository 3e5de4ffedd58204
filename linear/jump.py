"""Forces that jump at an operating point, and so have no slope there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chassym.linear.operating_point import ROUNDING, OperatingPoint, force_unit, held_force

BESIDE = 1e-150
"""Step beside the operating point: its square is still a number, and added to any other it is lost."""

CONTINUOUS = 1e-60
"""Change taken for that of a continuous force over so small a step, even of a root of the argument."""


@dataclass(frozen=True)
class Jump:
    """A force that jumps at the operating point.

    Attributes
    ----------
    argument
        The coordinate, rate, acceleration, input or input rate whose passage through its value there makes
        it jump.
    coordinate
        The coordinate whose equation jumps most.
    size
        Height of that jump.
    unit
        Unit of `size`.
    """

    argument: str
    coordinate: str
    size: float
    unit: str

    def __str__(self) -> str:
        """One line with the remedy."""
        return (
            f"the force on coordinate {self.coordinate!r} jumps by {self.size:.3g} {self.unit} where "
            f"{self.argument!r} passes zero and has no slope there; use a force law without a jump: "
            "tanh(v/v0), say, for sign(v)"
        )


def find_jump(point: OperatingPoint) -> Jump | None:
    """The largest jump of the residual at an operating point; None if it is continuous there.

    Every argument that is zero is set to either side of it, by so little that only a jump changes the
    residual. A jump at a distance from the operating point does not count, however short the distance is.
    """
    model, count = point.model, point.model.argument_count
    beside = BESIDE * np.eye(count)
    steps = np.hstack([np.zeros((count, 1)), beside, -beside])
    residual = model.residual(point.arguments[:, None] + steps)
    at, after, before = np.split(residual, [1, 1 + count], axis=1)
    sizes = np.ptp([np.broadcast_to(at, after.shape), after, before], axis=0)
    coordinate, argument = np.unravel_index(np.nan_to_num(sizes, nan=0.0).argmax(), sizes.shape)
    size = float(sizes[coordinate, argument])
    if not size > CONTINUOUS or not size > ROUNDING * held_force(model):
        return None
    name = model.equations.arguments[argument].name
    return Jump(name, model.system.coordinates[coordinate].name, size, force_unit(model, int(coordinate)))
