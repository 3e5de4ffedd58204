"""The linear model is what the nonlinear equations become for small motions."""

import numpy as np
import pytest

from chassym.derivation import Model, mean_slope
from chassym.linear import LinearModel, frequency_response, linearise

VEHICLES = ["sedan", "quarter_car", "half_car", "torsion_chain"]


def left_slope(left: float, right: float) -> float:
    return left


def right_slope(left: float, right: float) -> float:
    return right


def jacobian(linear: LinearModel) -> np.ndarray:
    """Derivatives of the residual, then the outputs, by q, q', q'', u, u'."""
    dynamics = [linear.stiffness, linear.damping, linear.mass, -linear.input_stiffness, -linear.input_damping]
    outputs = [
        linear.output_by_coordinates,
        linear.output_by_rates,
        linear.output_by_accelerations,
        linear.output_by_inputs,
        linear.output_by_input_rates,
    ]
    return np.vstack([np.hstack(dynamics), np.hstack(outputs)])


def nonlinear(model: Model, arguments: np.ndarray) -> np.ndarray:
    return np.vstack([model.residual(arguments), model.outputs(arguments)])


def richardson(model: Model, step: float) -> np.ndarray:
    """Central differences at three step sizes, extrapolated to an error of the sixth order."""
    size = model.argument_count
    table = []
    for h in (step, step / 2, step / 4):
        both = nonlinear(model, np.hstack([h * np.eye(size), -h * np.eye(size)]))
        table.append((both[:, :size] - both[:, size:]) / (2 * h))
    table = [(4 * fine - coarse) / 3 for coarse, fine in zip(table, table[1:], strict=False)]
    return (16 * table[1] - table[0]) / 15


def dampers_moved_off_their_knots(model: Model) -> Model:
    """The same car with damper tables that have no knot at rest: force at rest zero, slope 1500 to 1300 N s/m about it."""
    tables = [name.removesuffix(".velocity") for name in model.parameters if name.endswith("damper.velocity")]
    if not tables:
        return model
    velocity, force = [-1.0, -0.15, 0.1, 1.0], [-1000.0, -225.0, 150.0, 700.0]
    changes = {f"{table}.velocity": velocity for table in tables} | {f"{table}.force": force for table in tables}
    return type(model)(model.parameters.replace(changes), _recompiled(model, changes))


@pytest.fixture(params=VEHICLES)
def model(request: pytest.FixtureRequest) -> Model:
    return request.getfixturevalue(request.param)
