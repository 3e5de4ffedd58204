"""The linear model is what the nonlinear equations become for small motions."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chassym.derivation import Model
from chassym.linear import LinearModel, frequency_response, linearise
from chassym.linear.slope_rule import SlopeRule, left_slope, mean_slope, right_slope

VEHICLES = ["sedan", "quarter_car", "half_car", "torsion_chain"]


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


def off_the_knots(model: Model) -> Model:
    """The same car with damper tables that have no knot at rest: 1500 N s/m from -0.05 to 0.1 m/s."""
    tables = [name.removesuffix(".velocity") for name in model.parameters if name.endswith("damper.velocity")]
    velocity, force = [-1.0, -0.15, -0.05, 0.1, 1.0], [-1000.0, -300.0, -75.0, 150.0, 700.0]
    changes = {f"{table}.velocity": velocity for table in tables} | {
        f"{table}.force": force for table in tables
    }
    return model.with_parameters(changes)


def steady_motion(
    linear: LinearModel, frequency_hz: float, pads: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Arguments q, q', q'', u, u' and outputs of the linear steady state at 16 instants of a period."""
    s = 2j * np.pi * frequency_hz
    dynamic = s**2 * linear.mass + s * linear.damping + linear.stiffness
    q = np.linalg.solve(dynamic, (linear.input_stiffness + s * linear.input_damping) @ pads)
    amplitudes = np.concatenate([q, s * q, s**2 * q, pads, s * pads])
    turning = np.exp(2j * np.pi * np.arange(16) / 16)
    outputs = frequency_response(linear, [frequency_hz]).response[:, :, 0] @ pads
    return np.outer(amplitudes, turning).real, np.outer(outputs, turning).real


@pytest.fixture(params=VEHICLES)
def model(request: pytest.FixtureRequest) -> Model:
    return request.getfixturevalue(request.param)


@pytest.fixture(params=VEHICLES[:3])
def smooth(request: pytest.FixtureRequest) -> Model:
    """Give a car on pads whose dampers have no knot at rest."""
    return off_the_knots(request.getfixturevalue(request.param))


@pytest.mark.parametrize("rule", [left_slope, right_slope])
def test_derivatives_are_those_of_the_nonlinear_model_off_the_knots(model: Model, rule: SlopeRule) -> None:
    smooth = off_the_knots(model)
    found, expected = jacobian(linearise(smooth, rule)), richardson(smooth, 0.016)
    scale = np.abs(found).max(axis=1, keepdims=True)
    assert np.abs((found - expected) / scale).max() < 1e-11


def test_mean_slope_is_the_central_difference_across_the_knot(model: Model) -> None:
    """A step to either side of a corner sees half of each slope."""
    found, expected = jacobian(linearise(model, mean_slope)), richardson(model, 0.016)
    scale = np.abs(found).max(axis=1, keepdims=True)
    assert np.abs((found - expected) / scale).max() < 1e-11


def test_left_and_right_slopes_are_the_one_sided_differences(quarter_car: Model) -> None:
    """A rebound rate (body up) meets the left slope of the table, a jounce rate the right one."""
    step = np.zeros((quarter_car.argument_count, 1))
    step[2] = 1e-3
    for rule, sign in ((left_slope, 1), (right_slope, -1)):
        change = quarter_car.residual(sign * step) - quarter_car.residual(0 * step)
        column = linearise(quarter_car, rule).damping[:, 0]
        np.testing.assert_allclose(change[:, 0] / (sign * 1e-3), column, rtol=1e-9)


def test_deviation_from_the_nonlinear_equations_is_of_second_order(smooth: Model) -> None:
    """The linear steady state in the nonlinear equations: at half the amplitude a quarter is left over."""
    linear = linearise(smooth)
    pads = [1, 1j] @ np.random.default_rng(1).normal(size=(2, len(linear.inputs)))
    arguments, outputs = steady_motion(linear, 1.7, pads)
    n, rest = len(linear.coordinates), np.zeros((smooth.argument_count, 1))
    expected = np.vstack([np.zeros((n, 16)), outputs])
    left = {}
    for amplitude in (4e-4, 2e-4):
        deviation = nonlinear(smooth, amplitude * arguments) - nonlinear(smooth, rest) - amplitude * expected
        left[amplitude] = np.abs(deviation).max(axis=1)
    first_order = 4e-4 * (np.abs(jacobian(linear)) @ np.abs(arguments)).max(axis=1)
    curved = left[4e-4] > 1e-8 * first_order
    np.testing.assert_allclose(left[4e-4][curved] / left[2e-4][curved], 4, rtol=0.05)
    assert (left[4e-4] < 1e-2 * first_order).all()
    # All of the quarter car moves along one line: nothing in it is curved.
    assert curved.sum() > 5 or smooth.system.name == "quarter_car"


def test_simulation_at_small_amplitude_settles_on_the_frequency_response(quarter_car: Model) -> None:
    """Time integration from rest, until what the start has set off has died out."""
    smooth = off_the_knots(quarter_car)
    amplitude, frequency = 1e-3, 2.5
    omega = 2 * np.pi * frequency

    def change(time: float, state: np.ndarray) -> np.ndarray:
        road = amplitude * np.array([np.cos(omega * time), -omega * np.sin(omega * time)])
        arguments = np.concatenate([state, np.zeros(2), road])[:, None]
        return np.concatenate([state[2:], smooth.accelerations(arguments)[:, 0]])

    times = 12 + np.arange(9) / 8 / frequency
    run = solve_ivp(
        change, (0, times[-1]), np.zeros(4), t_eval=times, rtol=1e-10, atol=1e-14, method="DOP853"
    )
    response = frequency_response(linearise(smooth), [frequency])
    for row, output in enumerate(("body_displacement", "wheel_displacement")):
        expected = (amplitude * response.select(output, "road")[0] * np.exp(1j * omega * times)).real
        np.testing.assert_allclose(run.y[row], expected, atol=1e-7 * amplitude)
