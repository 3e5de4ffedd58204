"""The linear model of a system about an operating point: second-order matrices with names and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, eigh

from chassym.linear.operating_point import OperatingPoint

Array = np.ndarray

LEAST_INERTIA = 10 * np.finfo(float).eps
"""Smallest eigenvalue, for each coordinate, of a regular mass matrix scaled to a diagonal of ones."""


class LinearisationError(ValueError):
    """A linear model, or what was asked of it, that cannot be."""


@dataclass(frozen=True, eq=False)
class StateMatrices:
    """x' = A x + B u, y = C x + D u with names and SI units.

    Attributes
    ----------
    A, B, C, D
        Shapes (states, states), (states, inputs), (outputs, states) and (outputs, inputs). Which states and
        inputs there are is up to the convention that made them, see `chassym.linear.input_conventions`.
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
    """M q'' + C q' + K q = B_u u + B_u' u' about an operating point, with outputs.

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
    slopes
        The slope used for every element with a table, by the element's name.
    slope_rules
        Name of the rule that chose it, by the element's name.
    operating_point
        The position linearised about.
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
    slopes: Mapping[str, float]
    slope_rules: Mapping[str, str]
    operating_point: OperatingPoint

    def __str__(self) -> str:
        return self.description

    def __repr__(self) -> str:
        return f"<LinearModel: {self.description}>"

    @property
    def description(self) -> str:
        """What was linearised where, with the slope used for every table, in one line."""
        start = f"{self.name} linearised {self.operating_point.description}"
        if not self.slopes:
            return start
        used = ", ".join(f"{name} {slope:.6g}" for name, slope in self.slopes.items())
        return f"{start}; slopes by {self.slope_rule} (SI units): {used}"

    @property
    def slope_rule(self) -> str:
        """Names of the rules that chose the slopes of tables, in the order of the elements."""
        return ", ".join(dict.fromkeys(self.slope_rules.values()))

    @property
    def residual(self) -> Array:
        """What is left of the static equilibrium at the operating point, length n (N or N m)."""
        return self.operating_point.residual

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
            if smallest[0] > len(diagonal) * LEAST_INERTIA:
                return cho_factor(self.mass)
            worst = int(np.abs(direction[:, 0]).argmax())
        raise LinearisationError(
            f"mass matrix of {self.name!r} is singular: coordinate {self.coordinates[worst]!r} moves without "
            "inertia; give what it moves a mass or an inertia"
        )
