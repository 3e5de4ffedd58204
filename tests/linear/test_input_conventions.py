"""What a state space takes for its inputs: states, names and units, motions in time, and what cannot be."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chassym.derivation import Model
from chassym.linear import LinearisationError, LinearModel, frequency_response, to_control
from chassym.linear.input_conventions import (
    InputConvention,
    accelerations,
    displacements,
    displacements_and_rates,
    rates,
    rates_from_static_shape,
)
from chassym.linear.state_space import select_signals

Array = np.ndarray

PROPER = ["vertical_acceleration", "wheel_travel", "body_displacement", "wheel_displacement"]


@pytest.fixture
def ride(quarter_linear: LinearModel) -> LinearModel:
    """Give the quarter car without its patch force, which answers the road's rate directly."""
    return select_signals(quarter_linear, outputs=PROPER)


def bump(time: float | Array) -> list[float | Array]:
    """A road of 6 cm, and its first two derivatives: u = 10 t^2 exp(-10 t), from rest."""
    decay = 10 * np.exp(-10 * time)
    return [decay * time**2, decay * (2 * time - 10 * time**2), decay * (2 - 40 * time + 100 * time**2)]


def motion(
    linear: LinearModel, convention: InputConvention, given: Callable[[float], Array], times: Array
) -> Array:
    """Outputs from rest, shape (outputs, times), by an integrator of high order."""
    m = convention(linear)

    def change(time: float, state: Array) -> Array:
        return m.A @ state + m.B @ given(time)

    start = np.zeros(len(m.A))
    run = solve_ivp(change, (0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-11, atol=1e-15)
    return m.C @ run.y + m.D @ np.transpose([given(time) for time in times])


def test_every_convention_moves_alike(ride: LinearModel) -> None:
    times = np.linspace(0, 2, 41)
    expected = motion(ride, displacements_and_rates, lambda t: np.array(bump(t)[:2]), times)
    assert np.abs(expected).max(axis=1).min() > 5e-3
    conventions = [(displacements, 0), (rates, 1), (rates_from_static_shape, 1), (accelerations, 2)]
    for convention, order in conventions:
        found = motion(ride, convention, lambda t, order=order: np.array([bump(t)[order]]), times)
        np.testing.assert_allclose(
            found, expected, atol=1e-9 * np.abs(expected).max(), err_msg=f"order {order}"
        )


def test_appended_states_are_the_displacements_and_their_rates(ride: LinearModel) -> None:
    m, times = accelerations(ride), np.linspace(0, 2, 41)

    def change(time: float, state: Array) -> Array:
        return m.A @ state + m.B[:, 0] * bump(time)[2]

    run = solve_ivp(change, (0, 2), np.zeros(6), "DOP853", t_eval=times, rtol=1e-11, atol=1e-15)
    np.testing.assert_allclose(run.y[4:], bump(times)[:2], atol=1e-11)


def test_a_step_of_the_road(ride: LinearModel) -> None:
    """At once the wheel's rate jumps by c_t / m_u, and in the end all has risen with the road."""
    system = to_control(ride, displacements)
    names = list(system.state_labels)
    assert names == ["body_bounce", "wheel_bounce", "body_bounce_rate", "wheel_bounce_rate_without_jump"]
    jump = ride.input_damping[1, 0] / ride.mass[1, 1]
    np.testing.assert_allclose(system.B[:, 0][[0, 1]], [0.0, jump], rtol=1e-14)
    np.testing.assert_allclose(system.dcgain()[:, 0], [0, 0, 1, 1], atol=1e-10)
    import control

    response = control.step_response(system, np.linspace(0, 8, 801))
    np.testing.assert_allclose(response.outputs[2:, 0, -1], 1.0, atol=2e-4)
    assert response.outputs[2, 0].max() > 1.1


def test_heights_over_the_road(quarter_car: Model, quarter_linear: LinearModel) -> None:
    """The equations of ride control, written out for heights over the road a = z_s - w, b = z_u - w.

    With F = k (a - b) + c (z_s' - z_u'): m_s z_s'' = -F and m_u z_u'' = F - k_t b - c_t (z_u' - w'). States
    z_s', z_u', a, b, w.
    """
    value = quarter_car.parameters.flat()
    ms, mu, k = value["sprung.mass"], value["unsprung.mass"], value["spring.rate"]
    kt, ct, c = value["tyre.stiffness"], value["tyre.damping"], quarter_linear.slopes["damper"]
    expected = [
        [-c / ms, c / ms, -k / ms, k / ms, 0],
        [c / mu, -(c + ct) / mu, k / mu, -(k + kt) / mu, 0],
        [1, 0, 0, 0, 0],
        [0, 1, 0, 0, 0],
        [0, 0, 0, 0, 0],
    ]
    found = rates_from_static_shape(quarter_linear)
    np.testing.assert_allclose(found.A, expected, rtol=1e-13)
    np.testing.assert_allclose(found.B[:, 0], [0, ct / mu, -1, -1, 1], rtol=1e-13)
    assert found.state_names[2:] == (
        "body_bounce_from_static_shape",
        "wheel_bounce_from_static_shape",
        "road",
    )
    assert found.state_units == ("m/s", "m/s", "m", "m", "m")


def test_what_no_static_shape_balances_still_acts(quarter_linear: LinearModel) -> None:
    """A force on a body that nothing holds: K = 0, so that T = 0."""
    free = replace(quarter_linear, stiffness=np.zeros((2, 2)))
    found, absolute = rates_from_static_shape(free), rates(free)
    order = [2, 3, 0, 1, 4]
    np.testing.assert_array_equal(found.A, absolute.A[np.ix_(order, order)])
    np.testing.assert_array_equal(found.B, absolute.B[order])
    np.testing.assert_array_equal(found.C, absolute.C[:, order])


def test_rates_that_do_not_jump_keep_their_names(half_linear: LinearModel) -> None:
    """The road's damping pushes the wheels, and through their inertia body and wheels."""
    outputs = [name for name in half_linear.outputs if name.endswith("displacement")]
    travel_only = displacements(select_signals(half_linear, outputs=outputs))
    jumps = np.linalg.solve(half_linear.mass, half_linear.input_damping)
    for name, row in zip(travel_only.state_names[4:], jumps, strict=True):
        assert name.endswith("_rate") == (np.abs(row).max() < 1e-12)
    assert travel_only.state_names[:4] == half_linear.coordinates


def test_names_and_units(sedan_linear: LinearModel) -> None:
    expected = {
        displacements_and_rates: (24, ["front_left_pad_x", "m"], ["rear_right_pad_z_rate", "m/s"]),
        rates: (36, ["front_left_pad_x_rate", "m/s"], ["rear_right_pad_z_rate", "m/s"]),
        accelerations: (
            48,
            ["front_left_pad_x_acceleration", "m/s^2"],
            ["rear_right_pad_z_acceleration", "m/s^2"],
        ),
    }
    for convention, (states, first, last) in expected.items():
        m = convention(sedan_linear)
        assert [m.input_names[0], m.input_units[0]] == first and [
            m.input_names[-1],
            m.input_units[-1],
        ] == last
        shapes = [m.A.shape, m.B.shape, m.C.shape, m.D.shape]
        p, outputs = len(m.input_names), len(m.output_names)
        assert shapes == [(states, states), (states, p), (outputs, states), (outputs, p)]
        assert len(m.state_names) == len(m.state_units) == states and len(set(m.state_names)) == states
        assert m.state_units[3] == "rad" and m.state_units[15] == "rad/s"
        system = to_control(sedan_linear, convention)
        assert tuple(system.state_labels) == m.state_names and tuple(system.input_labels) == m.input_names
    appended = accelerations(sedan_linear)
    assert appended.state_names[24] == "front_left_pad_x" and appended.state_units[24] == "m"
    assert appended.state_names[36] == "front_left_pad_x_rate" and appended.state_units[36] == "m/s"
    assert not appended.D.any()


def test_improper_transfer_functions_are_refused(
    quarter_linear: LinearModel, sedan_linear: LinearModel
) -> None:
    """Where the response to a displacement keeps growing with the frequency there is no state space."""
    with pytest.raises(LinearisationError, match="'patch_force_z' answer the rate of an input") as error:
        to_control(quarter_linear, displacements)
    assert "\n" not in str(error.value) and "select_signals" in str(error.value)
    with pytest.raises(LinearisationError, match="'front_left_patch_force_x'.* and 14 more"):
        displacements(sedan_linear)
    slow, fast = np.abs(frequency_response(sedan_linear, [1e7, 1e8]).response).max(axis=1).T
    growing = {name for name, ratio in zip(sedan_linear.outputs, fast / slow, strict=True) if ratio > 5}
    for name in sedan_linear.outputs:
        one = select_signals(sedan_linear, outputs=[name])
        if name in growing:
            with pytest.raises(LinearisationError, match=f"improper, as of its outputs '{name}' answer"):
                displacements(one)
        else:
            assert displacements(one).output_names == (name,)
    assert 0 < len(growing) < len(sedan_linear.outputs)


def test_selected_signals_have_the_response_they_had(sedan_linear: LinearModel) -> None:
    outputs, inputs = ["yaw_rate", "vertical_acceleration"], ["rear_left_pad_z", "front_left_pad_y"]
    part = frequency_response(select_signals(sedan_linear, inputs=inputs, outputs=outputs), [2.0])
    full = frequency_response(sedan_linear, [2.0])
    assert part.outputs == tuple(outputs) and part.inputs == tuple(inputs)
    assert part.output_units == ("rad/s", "m/s^2") and part.input_units == ("m", "m")
    for output in outputs:
        for name in inputs:
            np.testing.assert_allclose(part.select(output, name), full.select(output, name), rtol=1e-12)
    everything = select_signals(sedan_linear)
    assert everything.outputs == sedan_linear.outputs and everything.inputs == sedan_linear.inputs


def test_unknown_signals_are_refused(quarter_linear: LinearModel) -> None:
    with pytest.raises(
        LinearisationError, match="output 'wheel_travle' is unknown; the nearest is 'wheel_trav"
    ):
        select_signals(quarter_linear, outputs=["wheel_travle"])
    with pytest.raises(LinearisationError, match="input 'raod' is unknown; the nearest is 'road'"):
        select_signals(quarter_linear, inputs=["raod"])
