"""From a model at rest to its linear model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chassym.derivation import Model
from chassym.derivation.table_numbers import TableNumbers
from chassym.linear.jump import find_jump
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.operating_point import OperatingPoint, design_position
from chassym.linear.slope_rule import SlopeRuleError, SlopeRules, mean_slope, rule_of, slope_of

Array = np.ndarray


def linearise(source: Model | OperatingPoint, slope_rule: SlopeRules = mean_slope) -> LinearModel:
    """Linearise a model about a position at rest, by exact symbolic derivatives.

    Parameters
    ----------
    source
        A model, whose design position has to be an equilibrium, or an operating point of one.
    slope_rule
        Which slope stands for a table: `left_slope`, `right_slope`, `mean_slope`, `Secant(reach)`,
        `DescribingFunction(amplitude)`, `StatisticalSlope(rms)`, or a mapping with one of them for every
        element with a table.

    Raises
    ------
    OperatingPointError
        If the design position is not an equilibrium, or a rotation sequence is singular there.
    SlopeRuleError
        If a rule is unknown or gives no finite slope.
    LinearisationError
        If a force jumps at the operating point, as Coulomb's friction does at rest, or a derivative is not
        finite.

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
    if not isinstance(source, Model | OperatingPoint):
        raise TypeError(f"{type(source).__name__} received; a Model is needed, which build_model makes")
    point = design_position(source) if isinstance(source, Model) else source
    jump = find_jump(point)
    if jump is not None:
        raise LinearisationError(
            f"{point.model.system.name!r} cannot be linearised {point.description}: {jump}"
        )
    system = point.model.system
    if isinstance(slope_rule, Mapping) and (unknown := slope_rule.keys() - system.knotted.keys()):
        expected = ", ".join(system.knotted) or "none, as nothing has a table"
        raise SlopeRuleError(f"slope_rule for {min(unknown)!r}: no element with a table; expected {expected}")
    rules = {element: rule_of(slope_rule, element) for element in system.knotted}
    slopes = _slopes(point, rules)
    return LinearModel(
        name=system.name,
        **split(_jacobian(point, slopes), len(system.coordinates), len(system.inputs)),
        coordinates=tuple(c.name for c in system.coordinates),
        inputs=tuple(u.name for u in system.inputs),
        outputs=tuple(y.name for y in system.outputs),
        coordinate_units=tuple(c.unit for c in system.coordinates),
        input_units=tuple(u.unit for u in system.inputs),
        output_units=tuple(y.unit for y in system.outputs),
        slopes=slopes,
        slope_rules={element: rule.name for element, rule in rules.items()},
        operating_point=point,
    )


def split(jacobian: Array, coordinates: int, inputs: int) -> dict[str, Array]:
    """The matrices of a linear model by the names of its attributes.

    Parameters
    ----------
    jacobian
        Derivatives of residual, then outputs, by q, q', q'', u, u', shape (..., n + outputs, arguments).
    coordinates, inputs
        Numbers n and p.
    """
    bounds = np.cumsum([coordinates, coordinates, coordinates, inputs])
    stiffness, damping, mass, by_input, by_input_rate = np.split(jacobian[..., :coordinates, :], bounds, -1)
    outputs = np.split(jacobian[..., coordinates:, :], bounds, -1)
    return {
        "mass": mass,
        "damping": damping,
        "stiffness": stiffness,
        "input_stiffness": -by_input,
        "input_damping": -by_input_rate,
        "output_by_coordinates": outputs[0],
        "output_by_rates": outputs[1],
        "output_by_accelerations": outputs[2],
        "output_by_inputs": outputs[3],
        "output_by_input_rates": outputs[4],
    }


def slopes_of(
    tables: Mapping[str, TableNumbers], places: Mapping[str, Array | float], rules: SlopeRules
) -> dict[str, Array]:
    """The slope that stands for every table, shape (sets,), by the element's name.

    Raises
    ------
    SlopeRuleError
        If there is no rule for an element, or it gives no finite slope.
    """
    return {
        element: slope_of(table, rule_of(rules, element), places[element])
        for element, table in tables.items()
    }


def _slopes(point: OperatingPoint, rules: SlopeRules) -> dict[str, float]:
    found = slopes_of(point.model.tables, point.table_places, rules)
    return {element: float(slope[0]) for element, slope in found.items()}


def _jacobian(point: OperatingPoint, slopes: Mapping[str, float]) -> Array:
    """Derivatives of residual, then outputs, by q, q', q'', u, u' at the operating point, read-only."""
    model = point.model
    symbols = model.system.slopes
    values = model.values | {symbols[name].name: slope for name, slope in slopes.items()}
    shape = model.size + len(model.system.outputs), model.argument_count
    jacobian = model.compiled.linearisation.bind(values).matrix(point.arguments, shape)
    if not np.isfinite(jacobian).all():
        raise LinearisationError(
            f"a derivative of {model.system.name!r} {point.description} is not finite; check its parameters"
        )
    jacobian.flags.writeable = False
    return jacobian
