"""The operating point of a linear model: a position at rest, and how well it is at rest there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chassym.derivation import ContactForce, Model

Array = np.ndarray

RESIDUAL_TOLERANCE = 1e-6
"""Largest residual accepted at an operating point, relative to the largest force that the preloads hold."""

ROUNDING = 1e-12
"""Change taken for rounding, relative to the largest force that the preloads hold."""

_NO_STIFFNESS = 1e-14
"""Stiffness taken for rounding, relative to the largest one."""

_SAID = 1e-12
"""Least displacement (m or rad) that a description mentions."""


class OperatingPointError(ValueError):
    """The position to linearise about is not an equilibrium, or there is none."""


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """A model at rest.

    Attributes
    ----------
    model
        The model, with the preloads that hold there.
    coordinates, inputs
        The position, shape (n,), and the prescribed displacements, shape (p,).
    loads
        Constant generalised forces (N or N m) that act besides those of the model, shape (n,).
    """

    model: Model
    coordinates: Array
    inputs: Array
    loads: Array

    def __str__(self) -> str:
        """How well it is at rest where, in one line."""
        known = f"condition {self.condition:.3g}" if np.isfinite(self.condition) else "singular"
        pulling = "".join(f"; {name} is {force:.4g} N, a pull" for name, force in self.pulling.items())
        place = f"{self.model.system.name} {self.description}"
        return f"{place}: residual {self.left}, stiffness {known}{pulling}"

    @property
    def left(self) -> str:
        """The largest residual in words."""
        share = f" ({self.relative_residual:.1g} of the largest force held)" if self.largest_force else ""
        worst = self._worst
        left = f"{abs(self.residual[worst]):.3g} {force_unit(self.model, worst)}"
        return f"{left} on {self._names[worst]!r}{share}"

    @property
    def description(self) -> str:
        """Where it is under which loads, in words; what is below a millionth of a micrometre is not said."""
        system = self.model.system
        parts = [(c.name, c.unit) for c in system.coordinates] + [(u.name, u.unit) for u in system.inputs]
        values = np.append(self.coordinates, self.inputs)
        moved = [
            f"{name} = {value:.6g} {unit}"
            for (name, unit), value in zip(parts, values, strict=True)
            if abs(value) >= _SAID
        ]
        place = f"at {', '.join(moved)}" if moved else "at the design position"
        loads = [
            f"{self.loads[i]:.6g} {force_unit(self.model, int(i))} on {self._names[i]}"
            for i in np.flatnonzero(self.loads)
        ]
        return f"{place} under {', '.join(loads)}" if loads else place

    @property
    def summary(self) -> dict[str, object]:
        """Place, loads and quality by name, as JSON takes them: an infinite condition number is None."""
        worst = self._worst
        return {
            "coordinates": dict(zip(self._names, self.coordinates.tolist(), strict=True)),
            "inputs": {
                each.name: value
                for each, value in zip(self.model.system.inputs, self.inputs.tolist(), strict=True)
            },
            "loads": dict(zip(self._names, self.loads.tolist(), strict=True)),
            "residual": {
                "value": float(abs(self.residual[worst])),
                "unit": force_unit(self.model, worst),
                "coordinate": self._names[worst],
            },
            "relative_residual": self.relative_residual,
            "condition": self.condition if np.isfinite(self.condition) else None,
            "pulling": self.pulling,
        }

    @property
    def _worst(self) -> int:
        return int(np.abs(self.residual).argmax())

    @property
    def _names(self) -> list[str]:
        return [each.name for each in self.model.system.coordinates]

    @cached_property
    def arguments(self) -> Array:
        """Coordinates, rates, accelerations, inputs and input rates, shape (arguments,)."""
        n = len(self.coordinates)
        return np.concatenate([self.coordinates, np.zeros(2 * n), self.inputs, np.zeros(len(self.inputs))])

    @cached_property
    def residual(self) -> Array:
        """What is left of the static equilibrium, shape (n,) (N or N m)."""
        return np.asarray(self.model.residual(self.arguments[:, None])[:, 0] - self.loads)

    @cached_property
    def relative_residual(self) -> float:
        """The largest residual, as part of `largest_force`; zero where there is no force."""
        return float(np.abs(self.residual).max() / self.largest_force) if self.largest_force else 0.0

    @cached_property
    def stiffness(self) -> Array:
        """Derivatives of the static residual by the coordinates, shape (n, n)."""
        n = len(self.coordinates)
        return self.model.residual_jacobian.matrix(self.arguments, (n, 3 * n))[:, :n]

    @cached_property
    def condition(self) -> float:
        """Condition number of the stiffness, every coordinate scaled to unit stiffness; infinite if singular.

        Its logarithm tells how many digits of the position the forces leave undetermined.
        """
        scale = self.coordinate_scale
        condition = float(np.linalg.cond(self.stiffness * np.outer(scale, scale)))
        return condition if condition * np.finfo(float).eps < 1 else float("inf")

    @cached_property
    def coordinate_scale(self) -> Array:
        """Motion of every coordinate (m or rad) that gives it unit stiffness, shape (n,).

        A coordinate whose own stiffness is zero, but for rounding, takes the scale of the stiffest one.
        """
        diagonal = np.abs(np.diag(self.stiffness))
        largest = diagonal.max()
        return 1 / np.sqrt(np.where(diagonal > _NO_STIFFNESS * largest, diagonal, largest or 1.0))

    @cached_property
    def table_places(self) -> dict[str, float]:
        """Deflection or rate at which every table is, by its element's name."""
        model = self.model
        if not model.system.knotted:
            return {}
        places = model.compiled.table_variables.bind(model.values)(self.arguments[:, None])[:, 0]
        return dict(zip(model.system.knotted, places.tolist(), strict=True))

    @cached_property
    def largest_force(self) -> float:
        """The largest force (N or N m) on a coordinate at the design position, no preload holding against it.

        It is that of weights, prescribed displacements or loads; zero without any.
        """
        return max(held_force(self.model, self.inputs), float(np.abs(self.loads).max(initial=0.0)))

    @cached_property
    def pulling(self) -> dict[str, float]:
        """Contact forces (N) that press at the design position and pull here, as no tyre can, by name."""
        outputs = self.model.system.outputs
        if not any(isinstance(each, ContactForce) for each in outputs):
            return {}
        forces = self.model.outputs(np.column_stack([np.zeros_like(self.arguments), self.arguments]))
        least = ROUNDING * self.largest_force
        return {
            output.name: float(here)
            for output, (design, here) in zip(outputs, forces, strict=True)
            if isinstance(output, ContactForce) and design > least and here < -least
        }

    def check(self) -> None:
        """Compare the residual with what the preloads and loads hold, and with the forces of small motions.

        Raises
        ------
        OperatingPointError
            If it is not an equilibrium, or a rotation sequence is singular there.
        """
        model = self.model
        near = model.nearest_singularity(self.arguments[:, None])
        if near is not None and near.is_harmful:
            raise OperatingPointError(f"{model.system.name!r} {self.description}: {near.refusal}")
        worst = self._worst
        accepted = RESIDUAL_TOLERANCE * self.largest_force
        if not abs(self.residual[worst]) <= accepted:
            accepted = max(accepted, ROUNDING * float(np.abs(np.nan_to_num(self.stiffness)).max()))
        if not abs(self.residual[worst]) <= accepted:
            raise OperatingPointError(
                f"{model.system.name!r} {self.description} is not an equilibrium: "
                f"{abs(self.residual[worst]):.3g} {force_unit(model, worst)} is left on coordinate "
                f"{self._names[worst]!r} and {accepted:.3g} accepted; "
                "have elements preloaded and give no preloads, so that those are found that hold it, measure "
                "the coordinates from an equilibrium, or use find_equilibrium"
            )


def design_position(model: Model) -> OperatingPoint:
    """The position in which all coordinates and inputs are zero.

    Raises
    ------
    OperatingPointError
        If it is not an equilibrium, or a rotation sequence is singular there.
    """
    return position(model)


def position(
    model: Model,
    coordinates: Mapping[str, float] | None = None,
    inputs: Mapping[str, float] | None = None,
    loads: Mapping[str, float] | None = None,
) -> OperatingPoint:
    """A position that is known to be an equilibrium, stable or not.

    Parameters
    ----------
    model
        The model.
    coordinates, inputs
        Those that are not zero, by name (SI).
    loads
        Constant generalised forces (N or N m), by the coordinate's name.

    Raises
    ------
    OperatingPointError
        If a name is unknown, the position is not an equilibrium, or a rotation sequence is singular there.
    """
    system = model.system
    names = [each.name for each in system.coordinates]
    point = OperatingPoint(
        model,
        by_name("coordinate", coordinates, names),
        by_name("input", inputs, [each.name for each in system.inputs]),
        by_name("coordinate", loads, names),
    )
    point.check()
    return point


def by_name(kind: str, given: Mapping[str, float] | None, names: list[str]) -> Array:
    """Numbers in the order of names; zero where none is given.

    Raises
    ------
    OperatingPointError
        If a name is unknown or a number not finite.
    """
    numbers = np.zeros(len(names))
    for name, number in (given or {}).items():
        if name not in names:
            raise OperatingPointError(
                f"{kind} {name!r} is unknown; expected one of {', '.join(names) or 'none'}"
            )
        if not isinstance(number, int | float | np.number) or not np.isfinite(number):
            raise OperatingPointError(f"{kind} {name!r}: {number!r} received; expected a finite number")
        numbers[names.index(name)] = number
    numbers.flags.writeable = False
    return numbers


def held_force(model: Model, inputs: Array | None = None) -> float:
    """The largest force (N or N m) on a coordinate at the design position without preloads.

    Parameters
    ----------
    inputs
        Prescribed displacements, shape (p,); zero unless given.
    """
    unloaded = model.values | {symbol.name: 0.0 for symbol in model.system.preloads}
    arguments = np.zeros((model.argument_count, 1))
    if inputs is not None:
        arguments[3 * model.size : 3 * model.size + len(inputs), 0] = inputs
    return float(np.abs(model.compiled.residual.of_variants(unloaded, arguments)).max())


def force_unit(model: Model, coordinate: int) -> str:
    """Unit of a generalised force."""
    return "N" if model.system.coordinates[coordinate].unit == "m" else "N m"
