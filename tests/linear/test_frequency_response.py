"""Frequency response: against the state space, against statics and symmetry, and the heave test's peaks."""

from dataclasses import replace

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
)

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")


def lower_slope(left: float, right: float) -> float:
    return min(left, right)


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


@pytest.mark.parametrize("vehicle", ["sedan", "quarter_car", "half_car"])
def test_dynamic_stiffness_agrees_with_the_control_system(
    vehicle: str, request: pytest.FixtureRequest
) -> None:
    """Every channel to 1e-9 from 0.01 to 1000 Hz.

    Beside that an error of 1e-10 of the output's largest channel is accepted: the state space makes an
    acceleration as the small difference of large terms, and zeros by symmetry are zero but for rounding.
    """
    linear = linearise(request.getfixturevalue(vehicle))
    frequencies = np.geomspace(0.01, 1000, 31)
    response = frequency_response(linear, frequencies).response
    by_displacement, by_rate = np.split(to_control(linear)(2j * np.pi * frequencies), 2, axis=1)
    expected = by_displacement + 2j * np.pi * frequencies * by_rate
    largest = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(response - expected) <= 1e-9 * np.abs(expected) + 1e-10 * largest).all()


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
    softer = linearise(sedan, lower_slope)
    for corner in CORNERS:
        frequency, amplitude = peak(softer, f"{corner}_wheel_displacement", 6.0, 15.0)
        assert frequency == pytest.approx(9.5, abs=0.5) and amplitude > 2


def test_heave_moves_every_vertical_input_together(
    half_linear: LinearModel, sedan_linear: LinearModel
) -> None:
    heave, full = (f(half_linear, [1.3]) for f in (heave_response, frequency_response))
    both = full.select("body_displacement", "front_road") + full.select("body_displacement", "rear_road")
    np.testing.assert_allclose(heave.select("body_displacement", "heave"), both, rtol=1e-12)
    names = heave_response(sedan_linear, [1.0]).outputs
    assert set(names) == {"body_displacement", *(f"{corner}_wheel_displacement" for corner in CORNERS)}
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


def test_unknown_signals_are_refused_with_the_nearest(quarter_linear: LinearModel) -> None:
    response = frequency_response(quarter_linear, [1.0])
    with pytest.raises(
        LinearisationError, match="output 'body_displacment' is unknown; the nearest is 'body_displacement'"
    ):
        response.select("body_displacment", "road")
    with pytest.raises(LinearisationError, match="input 'rode' is unknown; the nearest is 'road'"):
        response.combined("body_displacement", {"rode": 1.0})
