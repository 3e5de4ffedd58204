"""The operating point of a linear model: whether the design position is at rest there and smooth about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model
from chassym.derivation.equilibrium import design_residual

RESIDUAL_TOLERANCE = 1e-6
"""Largest residual accepted at the design position, relative to the largest force that the preloads hold."""

_BESIDE = 1e-150
"""Step beside the design position: its square is still a number, and added to any other it is lost."""

_ROUNDING = 1e-12
"""Change taken for rounding, relative to the largest force that the preloads hold."""

_CONTINUOUS = 1e-60
"""Change taken for that of a continuous force over so small a step, even of a root of the argument."""


class OperatingPointError(ValueError):
    """The position to linearise about is not an equilibrium."""


@dataclass(frozen=True)
class Jump:
    """A force that jumps at the design position.

    Attributes
    ----------
    argument
        The coordinate, rate, acceleration, input or input rate whose passage through zero makes it jump.
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


def check_equilibrium(model: Model) -> None:
    """Compare the residual with the weights that the preloads hold, and with the forces of small motions.

    Raises
    ------
    OperatingPointError
        If the design position is not an equilibrium, or a rotation sequence is singular there.
    """
    near = model.nearest_singularity(np.zeros((model.argument_count, 1)))
    if near is not None and near.is_harmful:
        raise OperatingPointError(f"the design position of {model.system.name!r}: {near.refusal}")
    residual = np.abs(model.design_residual)
    accepted = RESIDUAL_TOLERANCE * _held_force(model)
    worst = int(residual.argmax())
    if not residual[worst] <= accepted:
        accepted = max(accepted, _ROUNDING * _stiffest(model))
    if not residual[worst] <= accepted:
        coordinate = model.system.coordinates[worst]
        raise OperatingPointError(
            f"the design position of {model.system.name!r} is not an equilibrium: {residual[worst]:.3g} "
            f"{_unit(model, worst)} is left on coordinate {coordinate.name!r} and {accepted:.3g} accepted; "
            "have elements preloaded and give no preloads, so that those are found that hold it, or measure "
            "the coordinates from an equilibrium"
        )


def find_jump(model: Model) -> Jump | None:
    """The largest jump of the residual at the design position; None if it is continuous there.

    Every argument in turn is set to either side of zero, by so little that only a jump changes the residual.
    A jump at a distance from the design position does not count, however short the distance is.
    """
    count = model.argument_count
    beside = _BESIDE * np.eye(count)
    residual = model.residual(np.hstack([np.zeros((count, 1)), beside, -beside]))
    at, after, before = np.split(residual, [1, 1 + count], axis=1)
    sizes = np.ptp([np.broadcast_to(at, after.shape), after, before], axis=0)
    coordinate, argument = np.unravel_index(np.nan_to_num(sizes, nan=0.0).argmax(), sizes.shape)
    size = float(sizes[coordinate, argument])
    if not size > _CONTINUOUS or not size > _ROUNDING * _held_force(model):
        return None
    name = model.equations.arguments[argument].name
    return Jump(name, model.system.coordinates[coordinate].name, size, _unit(model, int(coordinate)))


def _stiffest(model: Model) -> float:
    """The largest force (N or N m) of a coordinate that a motion by one unit makes, linearly."""
    n = model.size
    jacobian = model.residual_jacobian.matrix(np.zeros(model.argument_count), (n, 3 * n))
    return float(np.abs(np.nan_to_num(jacobian[:, :n])).max())


def _held_force(model: Model) -> float:
    """The largest force (N or N m) that the preloads hold; zero without preloads."""
    if not model.system.preloads:
        return 0.0
    unloaded = model.values | {symbol.name: 0.0 for symbol in model.system.preloads}
    return float(np.abs(design_residual(model.compiled, unloaded)).max())


def _unit(model: Model, coordinate: int) -> str:
    return "N" if model.system.coordinates[coordinate].unit == "m" else "N m"
