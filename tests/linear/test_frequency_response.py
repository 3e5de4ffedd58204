"""Frequency response: against the state space, against statics and symmetry, and the heave test's peaks."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from chassym.derivation import Model
from chassym.linear import (
    LinearisationError,
    LinearModel,
    frequency_response,
    heave_response,
    linearise,
    to_control,
    undamped_modes,
)
from chassym.linear.input_conventions import (
    InputConvention,
    accelerations,
    displacements,
    displacements_and_rates,
    rates,
    rates_from_static_shape,
)
from chassym.linear.refinement import refined_solve
from chassym.linear.slope_rule import right_slope
from chassym.linear.state_space import select_signals

Array = np.ndarray

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")


def peak(linear: LinearModel, output: str, lowest: float, highest: float) -> tuple[float, float]:
    """Frequency (Hz) and amplitude of the largest heave response between two frequencies."""

    def less(frequency: float) -> float:
        return -float(abs(heave_response(linear, [frequency]).select(output, "heave")[0]))

    grid = np.linspace(lowest, highest, 200)
    best = grid[np.abs(heave_response(linear, grid).select(output, "heave")).argmax()]
    step = grid[1] - grid[0]
    found = minimize_scalar(
        less, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-6}
    )
    return float(found.x), -float(found.fun)


def with_body_stiffness(sedan: Model, stiffness: float) -> LinearModel:
    """Both torsion springs; the damping of the body is proportional to them."""
    names = ("body.front.torsional_stiffness", "body.rear.torsional_stiffness")
    return linearise(sedan.with_parameters(dict.fromkeys(names, stiffness)))


def by_state_matrices(
    linear: LinearModel,
    frequencies: Array,
    convention: InputConvention = displacements_and_rates,
    orders: tuple[int, ...] = (0, 1),
) -> Array:
    """C (s - A)^-1 B + D with more digits than double precision has, where the platform offers them.

    The orders are those of the derivatives of u that the convention has for its inputs.
    """
    m = convention(linear)
    s = (2j * np.pi * frequencies)[:, None, None].astype(np.clongdouble)
    state, _ = refined_solve(s * np.eye(len(m.A)) - m.A, np.broadcast_to(m.B, (len(s), *m.B.shape)) + 0 * s)
    blocks = np.split(m.C @ state + m.D, len(orders), axis=2)
    response = sum(s**order * block for order, block in zip(orders, blocks, strict=True))
    return np.moveaxis(np.asarray(response).astype(complex), 0, -1)


def by_thirty_digits(linear: LinearModel, frequency: float) -> Array:
    """By dynamic stiffness in mpmath, which takes the numbers of the matrices as exact."""
    with mpmath.workdps(30):
        s = mpmath.mpc(0, float(2 * np.pi * frequency))
        stiffness, force, seen, through = (
            sum((s**power * mpmath.matrix(each.tolist()) for power, each in enumerate(group)), start)
            for group, start in (
                ((linear.stiffness, linear.damping, linear.mass), 0 * mpmath.matrix(linear.mass.tolist())),
                ((linear.input_stiffness, linear.input_damping), mpmath.matrix(*linear.input_damping.shape)),
                (
                    (
                        linear.output_by_coordinates,
                        linear.output_by_rates,
                        linear.output_by_accelerations,
                    ),
                    mpmath.matrix(*linear.output_by_rates.shape),
                ),
                (
                    (linear.output_by_inputs, linear.output_by_input_rates),
                    mpmath.matrix(*linear.output_by_inputs.shape),
                ),
            )
        )
        return np.array((seen * (mpmath.inverse(stiffness) * force) + through).tolist(), dtype=complex)


def deviation(found: Array, expected: Array, floor: float = 0.0) -> float:
    """Largest deviation of a response, relative to itself or to a part of its output's largest."""
    size = np.abs(expected)
    size = np.maximum(size, floor * size.max(axis=1, keepdims=True))
    return float((np.abs(found - expected) / size).max())


def by_control(
    linear: LinearModel, frequencies: Array, convention: InputConvention, orders: tuple[int, ...]
) -> Array:
    """The same in double precision by python-control."""
    s = 2j * np.pi * frequencies
    blocks = np.split(to_control(linear, convention)(s), len(orders), axis=1)
    return np.asarray(sum(s**order * block for order, block in zip(orders, blocks, strict=True)))


def check_agreement(linear: LinearModel, frequencies: Array) -> None:
    """Compare every response of every output by dynamic stiffness with that of the state space.

    The matrices of the state space determine every response to 1e-9, however small it is. Evaluated in
    double precision, with coordinates from the static shape, they do so where it is more than a hundredth of
    the output's largest at that frequency, and below to 1e-11 of that: other wheels hardly move at 1000 Hz.
    With absolute coordinates an acceleration is a small difference of large forces at 0.01 Hz, and agrees to
    1e-9 of the largest.
    """
    response = frequency_response(linear, frequencies).response
    assert deviation(by_state_matrices(linear, frequencies), response) < 1e-9
    relative = by_control(linear, frequencies, rates_from_static_shape, (1,))
    assert deviation(relative, response, floor=0.01) < 1e-9
    absolute = by_control(linear, frequencies, displacements_and_rates, (0, 1))
    assert deviation(absolute, response, floor=1.0) < 1e-9


@pytest.mark.parametrize("stiffness", np.geomspace(1e2, 1e9, 8))
def test_two_routes_agree_over_seven_decades_of_body_stiffness(sedan: Model, stiffness: float) -> None:
    check_agreement(with_body_stiffness(sedan, stiffness), np.geomspace(0.01, 1000, 41))


@pytest.mark.slow
def test_two_routes_agree_at_many_frequencies_and_stiffnesses(sedan: Model) -> None:
    for stiffness in np.geomspace(1e2, 1e9, 29):
        check_agreement(with_body_stiffness(sedan, stiffness), np.geomspace(0.01, 1000, 1001))


@pytest.mark.parametrize(
    ("stiffness", "frequency"), [(1e2, 0.01), (1e2, 1000.0), (5e6, 3.0), (1e9, 0.01), (1e9, 1000.0)]
)
def test_both_routes_have_the_digits_of_exact_arithmetic(
    sedan: Model, stiffness: float, frequency: float
) -> None:
    linear = with_body_stiffness(sedan, stiffness)
    expected = by_thirty_digits(linear, frequency)[:, :, None]
    frequencies = np.array([frequency])
    assert deviation(frequency_response(linear, frequencies).response, expected) < 1e-10
    assert deviation(by_state_matrices(linear, frequencies), expected) < 1e-9


@pytest.mark.parametrize(
    ("convention", "orders"),
    [
        (displacements_and_rates, (0, 1)),
        (rates, (1,)),
        (accelerations, (2,)),
        (displacements, (0,)),
        (rates_from_static_shape, (1,)),
    ],
)
@pytest.mark.parametrize("vehicle", ["sedan", "quarter_car", "half_car"])
def test_every_convention_has_the_same_response(
    vehicle: str, convention: InputConvention, orders: tuple[int, ...], request: pytest.FixtureRequest
) -> None:
    linear = linearise(request.getfixturevalue(vehicle))
    if convention is displacements:
        improper = ("force", "acceleration")
        proper = [name for name in linear.outputs if not any(word in name for word in improper)]
        linear = select_signals(linear, outputs=proper)
    frequencies = np.geomspace(0.01, 1000, 31)
    response = frequency_response(linear, frequencies).response
    found = by_state_matrices(linear, frequencies, convention, orders)
    assert deviation(found, response, floor=0.01) < 1e-9
    assert deviation(by_control(linear, frequencies, convention, orders), response, floor=1.0) < 1e-9


def test_pads_that_move_together_carry_the_car_along(sedan_linear: LinearModel) -> None:
    """Statically, translated or turned pads leave every force and travel as it was."""
    static = frequency_response(sedan_linear, [0.0])
    for axis in "xyz":
        pads = {f"{corner}_pad_{axis}": 1.0 for corner in CORNERS}
        for output in static.outputs:
            carried = axis == "z" and output.endswith("displacement")
            stiff = 1e5 if "force" in output else 1.0
            value = static.combined(output, pads)[0]
            assert value == pytest.approx(float(carried), abs=1e-10 * stiff), (axis, output)
    turned = {
        "front_left_pad_y": -1.0,
        "front_right_pad_y": -1.0,
        "rear_left_pad_y": 1.0,
        "rear_right_pad_y": 1.0,
    }
    lever = {"left": 0.744 / 1.383, "right": -0.744 / 1.383}
    turned |= {f"{corner}_pad_x": lever[corner.split("_")[1]] for corner in CORNERS}
    assert static.combined("front_left_patch_force_y", turned)[0] == pytest.approx(0, abs=1e-5)


def test_symmetry_of_the_car(sedan_linear: LinearModel) -> None:
    response = frequency_response(sedan_linear, np.geomspace(0.1, 100, 40))
    heave = {f"{corner}_pad_z": 1.0 for corner in CORNERS}
    for output in ("yaw_rate", "roll_rate", "lateral_acceleration"):
        largest = np.abs(response.select(output, "front_left_pad_y")).max()
        assert np.abs(response.combined(output, heave)).max() < 1e-10 * largest
    for axis, sign in (("x", 1), ("y", -1), ("z", 1)):
        for output, turns in (("pitch_rate", 1), ("roll_rate", -1), ("yaw_rate", -1)):
            left, right = (response.select(output, f"rear_{side}_pad_{axis}") for side in ("left", "right"))
            np.testing.assert_allclose(left, sign * turns * right, rtol=1e-8)


def test_combined_adds_up_complex_amplitudes(sedan_linear: LinearModel) -> None:
    """A rear pad that follows 0.2 s behind the front one is turned back in phase by 2 pi f 0.2."""
    frequencies = np.array([0.7, 3.0])
    response = frequency_response(sedan_linear, frequencies)
    for column, frequency in enumerate(frequencies):
        lag = np.exp(-2j * np.pi * frequency * 0.2)
        found = response.combined("yaw_rate", {"front_left_pad_y": 0.01, "rear_left_pad_y": 0.01 * lag})
        front, rear = (response.select("yaw_rate", f"{axle}_left_pad_y") for axle in ("front", "rear"))
        assert found[column] == pytest.approx(0.01 * front[column] + 0.01 * lag * rear[column], rel=1e-12)


def test_peaks_of_the_heave_test(sedan_linear: LinearModel) -> None:
    """Liu 2016: body peak near 1 Hz, wheel peak near 9.5 Hz with pads that move by 10 mm.

    Its dampers then work beyond their first knots, with less slope than the mean at rest used here.
    """
    frequency, amplitude = peak(sedan_linear, "body_displacement", 0.5, 4.0)
    assert frequency == pytest.approx(1.0, abs=0.25) and amplitude > 2
    frequency, amplitude = peak(sedan_linear, "rear_left_wheel_displacement", 6.0, 15.0)
    assert frequency == pytest.approx(9.5, abs=0.6) and amplitude > 1.5


def test_wheel_peaks_of_the_heave_test_are_near_nine_and_a_half_hertz_with_softer_dampers(
    sedan: Model,
) -> None:
    softer = linearise(sedan, right_slope)
    for corner in CORNERS:
        frequency, amplitude = peak(softer, f"{corner}_wheel_displacement", 6.0, 15.0)
        assert frequency == pytest.approx(9.5, abs=0.5) and amplitude > 2


def test_heave_moves_every_vertical_input_together(
    half_linear: LinearModel, sedan_linear: LinearModel
) -> None:
    heave, full = (f(half_linear, [1.3]) for f in (heave_response, frequency_response))
    both = full.select("body_displacement", "front_road") + full.select("body_displacement", "rear_road")
    np.testing.assert_allclose(heave.select("body_displacement", "heave"), both, rtol=1e-12)
    assert heave_response(sedan_linear, [1.0]).outputs == sedan_linear.outputs
    assert "mean_slope" in heave_response(sedan_linear, [1.0]).description


def test_heave_without_a_road_is_refused(chain_linear: LinearModel) -> None:
    with pytest.raises(LinearisationError, match="heave of 'torsion_chain'"):
        heave_response(chain_linear, [1.0])


@pytest.mark.parametrize(
    ("frequencies", "message"), [([1.0, -2.0], "holds -2"), ([np.nan], "nan"), ([[1.0]], "shape")]
)
def test_impossible_frequencies_are_refused(
    quarter_linear: LinearModel, frequencies: list, message: str
) -> None:
    with pytest.raises(LinearisationError, match=message):
        frequency_response(quarter_linear, frequencies)


def test_infinite_response_is_refused(quarter_linear: LinearModel) -> None:
    free = replace(quarter_linear, stiffness=np.zeros((2, 2)))
    with pytest.raises(LinearisationError, match="holds 0, where 'quarter_car' has an undamped mode"):
        frequency_response(free, [1.0, 0.0])


@pytest.mark.parametrize("mode", [0, 1])
def test_infinite_response_of_an_undamped_mode_is_refused(quarter_linear: LinearModel, mode: int) -> None:
    """Rounding leaves the dynamic stiffness regular at the frequency as computed; beside it all is well."""
    undamped = replace(quarter_linear, damping=np.zeros((2, 2)), input_damping=np.zeros((2, 1)))
    pole = undamped_modes(undamped).frequencies_hz[mode]
    with pytest.raises(LinearisationError, match=f"holds {pole:g}, where .* is infinite") as error:
        frequency_response(undamped, [0.5, pole, 20.0])
    assert "\n" not in str(error.value)
    beside = frequency_response(undamped, [pole * (1 + 1e-9)]).select("body_displacement", "road")[0]
    stiffness = undamped.stiffness - (2 * np.pi * pole * (1 + 1e-9)) ** 2 * undamped.mass
    expected = np.linalg.solve(stiffness, undamped.input_stiffness)[0, 0]
    assert beside == pytest.approx(expected, rel=1e-4) and abs(beside) > 1e6


def test_unknown_signals_are_refused_with_the_nearest(quarter_linear: LinearModel) -> None:
    response = frequency_response(quarter_linear, [1.0])
    with pytest.raises(
        LinearisationError, match="output 'body_displacment' is unknown; the nearest is 'body_displacement'"
    ):
        response.select("body_displacment", "road")
    with pytest.raises(LinearisationError, match="input 'rode' is unknown; the nearest is 'road'"):
        response.combined("body_displacement", {"rode": 1.0})
