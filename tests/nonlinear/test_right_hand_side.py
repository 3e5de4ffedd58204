"""x' = f(t, x): against the batch's accelerations, exact derivatives, any excitation, a compiled loop."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chassym.derivation import Model, load_model, vehicle_names
from chassym.nonlinear.excitation.excitation import Excitation, ExcitationError, Harmonic
from chassym.nonlinear.simulation.right_hand_side import RightHandSide

Array = np.ndarray


class Parabola(Excitation):
    """All inputs move by t^2 / 100: nothing but what the protocol asks for."""

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        ones = np.ones((len(model.system.inputs), 1))
        return 0.01 * ones * time_s**2, 0.02 * ones * time_s

    def breaks(self, start_s: float, end_s: float) -> Array:
        return np.empty(0)


def shaken(model: Model, amplitude: float = 0.01) -> Harmonic:
    """All inputs move, each with a phase of its own."""
    names = [motion.name for motion in model.system.inputs]
    return Harmonic(3.0, {name: amplitude * np.exp(1j * k) for k, name in enumerate(names)})


def random_states(model: Model, count: int, scale: float = 0.05) -> Array:
    return np.random.default_rng(4).normal(0, scale, (count, 2 * model.size))


def by_the_batch(model: Model, excitation: Excitation, time_s: float, state: Array) -> Array:
    """Rates, and accelerations by the function of many samples."""
    n = model.size
    signals = np.concatenate(excitation.signals(model, np.array([time_s])))[:, 0]
    arguments = np.concatenate([state, np.zeros(n), signals])
    return np.concatenate([state[n:], model.accelerations(arguments[:, None])[:, 0]])


@pytest.mark.parametrize("excite", [shaken, lambda model: Parabola()], ids=["harmonic", "any"])
@pytest.mark.parametrize("name", vehicle_names())
def test_rates(name: str, excite: Callable[[Model], Excitation]) -> None:
    model = load_model(name)
    excitation = excite(model)
    rates = RightHandSide(model, excitation)
    for time_s, state in zip((0.0, 0.1, 7.3), random_states(model, 3), strict=True):
        assert rates(time_s, state) == pytest.approx(by_the_batch(model, excitation, time_s, state), rel=1e-9)


def test_results_of_one_call_outlive_the_next(half_car: Model) -> None:
    rates = RightHandSide(half_car, shaken(half_car))
    first, second = random_states(half_car, 2)
    for method in (rates, rates.jacobian, rates.knot_distances):
        kept = method(0.1, first)
        before = kept.copy()
        method(0.2, second)
        assert np.array_equal(kept, before)
        assert np.array_equal(method(0.1, first), before)


def test_methods_do_not_disturb_each_other(half_car: Model) -> None:
    rates = RightHandSide(half_car, shaken(half_car))
    first, second = random_states(half_car, 2)
    expected = rates(0.1, first)
    rates.jacobian(0.3, second)
    rates.knot_distances(0.4, second)
    assert np.array_equal(rates(0.1, first), expected)


def test_evaluations_are_counted(half_car: Model) -> None:
    rates = RightHandSide(half_car, shaken(half_car))
    state = random_states(half_car, 1)[0]
    rates(0.0, state)
    rates(0.1, state)
    rates.jacobian(0.1, state)
    assert rates.evaluations == 2


def test_an_input_that_the_model_lacks(half_car: Model) -> None:
    with pytest.raises(ExcitationError, match="input 'moon'"):
        RightHandSide(half_car, Harmonic(1.0, {"moon": 1.0}))


@pytest.mark.parametrize("shape", [(), (0,), (1,), (7,), (9,), (8, 1)])
def test_a_state_of_another_shape_is_refused(half_car: Model, shape: tuple[int, ...]) -> None:
    rates = RightHandSide(half_car, shaken(half_car))
    for method in (rates, rates.jacobian, rates.knot_distances):
        with pytest.raises(ValueError, match=r"state: shape \(.*\) received; \(8,\) is needed"):
            method(0.0, np.zeros(shape))


def test_any_numbers_are_a_state(half_car: Model) -> None:
    rates = RightHandSide(half_car, shaken(half_car))
    expected = rates(0.1, np.array([0, 0, 0, 0, 1, -1, 0, 2], dtype=float))
    for state in ([0, 0, 0, 0, 1, -1, 0, 2], np.array([0, 0, 0, 0, 1, -1, 0, 2])):
        assert np.array_equal(rates(0.1, state), expected)
    assert np.array_equal(rates(0.1, np.repeat([0.0, 0, 0, 0, 1, -1, 0, 2], 2)[::2]), expected)


def richardson(function: Callable[[Array], Array], at: Array, step: float) -> Array:
    """Derivatives by central differences of two steps, with the error of fourth order."""

    def differences(h: float) -> Array:
        moved = h * np.eye(len(at))
        return np.stack([(function(at + d) - function(at - d)) / (2 * h) for d in moved], axis=1)

    return (4 * differences(step / 2) - differences(step)) / 3


@pytest.mark.parametrize("name", vehicle_names())
def test_jacobian(name: str) -> None:
    """Against differences, where no difference crosses a knot; every row on a scale of its own."""
    model = load_model(name)
    rates, step, compared = RightHandSide(model, shaken(model)), 1e-3, 0
    for state in random_states(model, 12, 0.3):
        distances = rates.knot_distances(0.1, state)
        if distances.size and np.abs(distances).min() < 20 * step:
            continue
        expected = richardson(lambda x: rates(0.1, x), state, step)
        error = np.abs(rates.jacobian(0.1, state) - expected).max(axis=1)
        assert np.all(error < 1e-8 * np.abs(expected).max(axis=1))
        compared += 1
    assert compared >= 1


def test_jacobian_is_that_of_the_residual_at_the_true_accelerations(sedan: Model) -> None:
    """d(q'') = -M^-1 (K dq + C dq') by dense linear algebra, fast and far from the design position."""
    n, excitation = sedan.size, shaken(sedan)
    rates = RightHandSide(sedan, excitation)
    for state in random_states(sedan, 5, 0.3):
        signals = np.concatenate(excitation.signals(sedan, np.array([0.2])))[:, 0]
        arguments = np.concatenate([state, rates(0.2, state)[n:], signals])
        by_motion = sedan.residual_jacobian.matrix(arguments, (n, 3 * n))
        expected = -np.linalg.solve(by_motion[:, 2 * n :], by_motion[:, : 2 * n])
        found = rates.jacobian(0.2, state)
        assert np.array_equal(found[:n], np.eye(n, 2 * n, n))
        assert np.abs(found[n:] - expected).max() < 1e-10 * np.abs(expected).max()


def test_knot_distances_change_sign_where_the_jacobian_jumps(quarter_car: Model) -> None:
    """Through the damper's knot at zero rate."""
    rates = RightHandSide(quarter_car, Harmonic(1.0, {}))
    sides = [np.array([0.0, 0.0, rate, 0.0]) for rate in (-1e-9, 1e-9)]
    distances = [rates.knot_distances(0.0, state) for state in sides]
    jacobians = [rates.jacobian(0.0, state) for state in sides]
    assert np.sum(distances[0] * distances[1] < 0) == 1
    jump = jacobians[1] - jacobians[0]
    assert np.abs(jump[2:, 2:]).min() > 0.1
    # At the knot it is the mean of both.
    assert rates.jacobian(0.0, np.zeros(4)) == pytest.approx((jacobians[0] + jacobians[1]) / 2, rel=1e-6)


def test_a_loop_in_machine_code(sedan: Model) -> None:
    """One second of the car by the classical Runge-Kutta method, in a loop compiled by numba."""
    numba = pytest.importorskip("numba")
    function, n = sedan.right_hand_side, sedan.size
    evaluate, constants = function.pointer, function.constants
    excitation, steps = shaken(sedan, 0.002), 4000
    amplitudes, frequency = excitation.vector(sedan), excitation.angular_frequency

    @numba.njit
    def integrate(state: Array, amplitudes: Array, constants: Array) -> Array:
        arguments, rates, h = np.empty(2 * len(state)), np.empty(len(state)), 1.0 / steps
        total = np.zeros(len(state))
        nodes, weights = (0.0, h / 2, h / 2, h), (h / 6, h / 3, h / 3, h / 6)
        for step in range(steps):
            total[:], rates[:] = state, 0.0
            for node, weight in zip(nodes, weights):  # noqa: B905, of equal length; numba knows no strict
                turned = amplitudes * np.exp(1j * frequency * (step * h + node))
                arguments[: 2 * n] = state + node * rates
                arguments[2 * n : 3 * n], arguments[3 * n :] = turned.real, -frequency * turned.imag
                evaluate(arguments.ctypes, constants.ctypes, rates.ctypes)
                total += weight * rates
            state = total.copy()
        return state

    found = integrate(np.zeros(2 * n), amplitudes, constants)
    rates = RightHandSide(sedan, excitation)
    expected = solve_ivp(rates, (0, 1), np.zeros(2 * n), "DOP853", rtol=1e-9, atol=1e-11).y[:, -1]
    scale = np.repeat([np.abs(expected[:n]).max(), np.abs(expected[n:]).max()], n)
    assert np.all(np.abs(found - expected) < 1e-5 * scale)
