"""The linear model about the design position, and its state space."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh

from chassym.derivation import Model, mean_slope
from chassym.derivation.table import SlopeRule
from chassym.linear.operating_point import check_equilibrium, find_jump

if TYPE_CHECKING:
    import control

Array = np.ndarray


class LinearisationError(ValueError):
    """A linear model, or what was asked of it, that cannot be."""


@dataclass(frozen=True, eq=False)
class StateMatrices:
    """x' = A x + B u, y = C x + D u with names and SI units.

    Attributes
    ----------
    A, B, C, D
        Shapes (2 n, 2 n), (2 n, 2 inputs), (outputs, 2 n) and (outputs, 2 inputs). States are the
        coordinates, then their rates; inputs are the prescribed displacements, then their rates.
    state_names, input_names, output_names, state_units, input_units, output_units
        In the order of the matrices.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class LinearModel:
    """M q'' + C q' + K q = B_u u + B_u' u' about the design position, with outputs.

    With n coordinates, p prescribed displacements and m outputs:

    Attributes
    ----------
    name
        The system's name.
    mass, damping, stiffness
        M, C, K, shape (n, n).
    input_stiffness, input_damping
        B_u, B_u', shape (n, p).
    output_by_coordinates, output_by_rates, output_by_accelerations
        Derivatives of the outputs by q, q', q'', shape (m, n).
    output_by_inputs, output_by_input_rates
        Derivatives of the outputs by u, u', shape (m, p).
    coordinates, inputs, outputs
        Names.
    coordinate_units, input_units, output_units
        SI units.
    slope_rule
        Name of the rule that chose the slopes at the knots of tables.
    slopes
        The slope (N s/m or N m s/rad) used for every element with a table, by the element's name.
    residual
        What is left of the static equilibrium at the operating point, length n (N or N m).
    """

    name: str
    mass: Array
    damping: Array
    stiffness: Array
    input_stiffness: Array
    input_damping: Array
    output_by_coordinates: Array
    output_by_rates: Array
    output_by_accelerations: Array
    output_by_inputs: Array
    output_by_input_rates: Array
    coordinates: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    coordinate_units: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    slope_rule: str
    slopes: Mapping[str, float]
    residual: Array

    def __str__(self) -> str:
        return self.description

    @property
    def description(self) -> str:
        """What was linearised where, with the slope used for every table, in one line."""
        start = f"{self.name} linearised at the design position"
        if not self.slopes:
            return start
        used = ", ".join(f"{name} {slope:.6g}" for name, slope in self.slopes.items())
        return f"{start}; slopes by {self.slope_rule} (SI units): {used}"

    @cached_property
    def mass_factor(self) -> tuple[Array, bool]:
        """Cholesky factor of M for `scipy.linalg.cho_solve`.

        Raises
        ------
        LinearisationError
            If M is singular.
        """
        diagonal = np.diag(self.mass)
        worst = int(diagonal.argmin())
        if diagonal[worst] > 0:
            scale = 1 / np.sqrt(diagonal)
            smallest, direction = eigh(self.mass * np.outer(scale, scale), subset_by_index=(0, 0))
            if smallest[0] > 10 * len(diagonal) * np.finfo(float).eps:
                return cho_factor(self.mass)
            worst = int(np.abs(direction[:, 0]).argmax())
        raise LinearisationError(
            f"mass matrix of {self.name!r} is singular: coordinate {self.coordinates[worst]!r} moves without "
            "inertia; give what it moves a mass or an inertia"
        )

    def state_matrices(self) -> StateMatrices:
        """The state space, with q'' eliminated from the outputs.

        Raises
        ------
        LinearisationError
            If M is singular.
        """
        n = len(self.coordinates)
        by_state = cho_solve(self.mass_factor, -np.hstack([self.stiffness, self.damping]))
        by_input = cho_solve(self.mass_factor, np.hstack([self.input_stiffness, self.input_damping]))
        upper = np.eye(n, 2 * n, k=n)
        outputs = np.hstack([self.output_by_coordinates, self.output_by_rates])
        through = np.hstack([self.output_by_inputs, self.output_by_input_rates])
        return StateMatrices(
            A=np.vstack([upper, by_state]),
            B=np.vstack([np.zeros((n, 2 * len(self.inputs))), by_input]),
            C=outputs + self.output_by_accelerations @ by_state,
            D=through + self.output_by_accelerations @ by_input,
            state_names=_with_rates(self.coordinates, "_rate"),
            input_names=_with_rates(self.inputs, "_rate"),
            output_names=self.outputs,
            state_units=_with_rates(self.coordinate_units, "/s"),
            input_units=_with_rates(self.input_units, "/s"),
            output_units=self.output_units,
        )


def linearise(model: Model, slope_rule: SlopeRule = mean_slope) -> LinearModel:
    """Linearise a model about its design position, by exact symbolic derivatives.

    Parameters
    ----------
    model
        The model; its design position has to be an equilibrium.
    slope_rule
        Combines the slopes on the two sides of a knot: a function of the left and the right slope.

    Raises
    ------
    OperatingPointError
        If the design position is not an equilibrium, or a rotation sequence is singular there.
    LinearisationError
        If a force jumps at the design position, as Coulomb's friction does at rest, or the slope rule or a
        derivative gives no finite number.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> linear = linearise(load_model("quarter_car"))
    >>> linear.slopes
    {'damper': 2445.1...}
    >>> linear.mass
    array([[356.25,   0.  ],
           [  0.  ,  48.  ]])
    """
    if not isinstance(model, Model):
        raise TypeError(f"{type(model).__name__} received; a Model is needed, which build_model makes")
    check_equilibrium(model)
    _check_continuity(model)
    system, n, p = model.system, model.size, len(model.system.inputs)
    rule = getattr(slope_rule, "__name__", repr(slope_rule))
    slopes = _slopes(model, slope_rule, rule)
    derivatives = np.split(_jacobian(model, slopes), [n])
    dynamics, outputs = (np.split(part, np.cumsum([n, n, n, p]), axis=1) for part in derivatives)
    return LinearModel(
        name=system.name,
        mass=dynamics[2],
        damping=dynamics[1],
        stiffness=dynamics[0],
        input_stiffness=-dynamics[3],
        input_damping=-dynamics[4],
        output_by_coordinates=outputs[0],
        output_by_rates=outputs[1],
        output_by_accelerations=outputs[2],
        output_by_inputs=outputs[3],
        output_by_input_rates=outputs[4],
        coordinates=tuple(c.name for c in system.coordinates),
        inputs=tuple(u.name for u in system.inputs),
        outputs=tuple(y.name for y in system.outputs),
        coordinate_units=tuple(c.unit for c in system.coordinates),
        input_units=tuple(u.unit for u in system.inputs),
        output_units=tuple(y.unit for y in system.outputs),
        slope_rule=rule,
        slopes=slopes,
        residual=model.design_residual,
    )


def to_control(linear: LinearModel) -> control.StateSpace:
    """The state space as a python-control system with named signals; its name states the slope rule.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular.
    """
    import control  # it takes a second to import: only for those who ask for it

    matrices = linear.state_matrices()
    return control.StateSpace(
        matrices.A,
        matrices.B,
        matrices.C,
        matrices.D,
        states=list(matrices.state_names),
        inputs=list(matrices.input_names),
        outputs=list(matrices.output_names),
        name=f"{linear.name}_{linear.slope_rule}" if linear.slopes else linear.name,
        remove_useless_states=False,
    )


def _with_rates(texts: tuple[str, ...], suffix: str) -> tuple[str, ...]:
    return (*texts, *(text + suffix for text in texts))


def _check_continuity(model: Model) -> None:
    """At a jump the compiled derivative is that of both sides, which for Coulomb's friction means none."""
    jump = find_jump(model)
    if jump is not None:
        raise LinearisationError(f"{model.system.name!r} cannot be linearised at the design position: {jump}")


def _slopes(model: Model, rule: SlopeRule, name: str) -> dict[str, float]:
    """The slope at rest of every element with a table, by the element's name."""
    laws = model.system.knotted
    slopes = {element: law.slope(0.0, model.values, rule) for element, law in laws.items()}
    for element, slope in slopes.items():
        if not np.isfinite(slope):
            raise LinearisationError(
                f"slope_rule {name!r} gave {slope} for element {element!r}; a finite slope is needed"
            )
    return slopes


def _jacobian(model: Model, slopes: Mapping[str, float]) -> Array:
    """Derivatives of residual, then outputs, by q, q', q'', u, u' at the design position, read-only."""
    symbols = model.system.slopes
    values = model.values | {symbols[name].name: slope for name, slope in slopes.items()}
    shape = model.size + len(model.system.outputs), model.argument_count
    jacobian = model.compiled.linearisation.bind(values).matrix(np.zeros(model.argument_count), shape)
    if not np.isfinite(jacobian).all():
        raise LinearisationError(
            f"a derivative of {model.system.name!r} at the design position is not finite; check its "
            "parameters"
        )
    jacobian.flags.writeable = False
    return jacobian
