"""Singular values compare like with like."""

import control
import numpy as np
import pytest

from chassym.linear import FrequencyResponse, LinearisationError, LinearModel, frequency_response
from chassym.linear.control_objects import to_control_frequency_response
from chassym.linear.singular_values import singular_values

FREQUENCIES = np.geomspace(0.1, 50, 30)
MOTIONS = ("vertical_acceleration", "roll_rate", "pitch_rate")


@pytest.fixture(scope="module")
def response(sedan_linear: LinearModel) -> FrequencyResponse:
    return frequency_response(sedan_linear, FREQUENCIES)


def pads(response: FrequencyResponse) -> list[str]:
    return [name for name in response.inputs if name.endswith("_z")]


def test_against_python_control(response: FrequencyResponse) -> None:
    forces = [name for name in response.outputs if "patch_force" in name]
    values = singular_values(response, forces)
    data = to_control_frequency_response(response)[forces, list(response.inputs)]
    expected = control.singular_values_response(data, 2 * np.pi * FREQUENCIES)
    np.testing.assert_allclose(values.T, expected.magnitude[:, 0], rtol=1e-9)
    assert values.attrs["units"] == "N/m"
    assert values.dims == ("frequency_hz", "order")
    np.testing.assert_array_equal(values["frequency_hz"], FREQUENCIES)
    np.testing.assert_array_equal(values["order"], np.arange(1, 13))


def test_one_input_and_one_output_give_the_amplitude(response: FrequencyResponse) -> None:
    values = singular_values(response, ["yaw_rate"], ["front_left_pad_y"])
    expected = np.abs(response.select("yaw_rate", "front_left_pad_y"))
    np.testing.assert_allclose(values.sel(order=1), expected, rtol=1e-12)
    assert values.attrs["units"] == "(rad/s)/m"


def test_the_sum_of_squares_is_that_of_the_scaled_responses(response: FrequencyResponse) -> None:
    sizes = {"vertical_acceleration": 2.0, "roll_rate": 0.1, "pitch_rate": 0.2}
    scales = sizes | dict.fromkeys(pads(response), 0.01)
    values = singular_values(response, MOTIONS, pads(response), scales)
    squares = sum(
        np.abs(response.select(output, pad) * 0.01 / size) ** 2
        for output, size in sizes.items()
        for pad in pads(response)
    )
    np.testing.assert_allclose((values**2).sum("order"), squares, rtol=1e-12)
    assert values.attrs["units"] == "1"


def test_scaled_outputs_alone(response: FrequencyResponse) -> None:
    values = singular_values(response, MOTIONS, pads(response), dict.fromkeys(MOTIONS, 2.0))
    assert values.attrs["units"] == "1/m"


@pytest.mark.parametrize(
    ("outputs", "inputs", "scales", "message"),
    [
        (MOTIONS, None, {}, r"'vertical_acceleration' \(m/s\^2\) and 'roll_rate' \(rad/s\)"),
        (None, None, {}, "different units"),
        (MOTIONS, None, {"roll_rate": 1.0}, "missing for the outputs vertical_acceleration, pitch_rate"),
        (["yaw"], None, {}, "output 'yaw' is unknown"),
        (["yaw_rate"], ["steer"], {}, "input 'steer' is unknown"),
        (["yaw_rate"], None, {"yaw_rat": 1.0}, "'yaw_rat'"),
        (["yaw_rate"], None, {"yaw_rate": 0.0}, r"is 0\.0; a positive"),
        (["yaw_rate"], None, {"yaw_rate": np.inf}, "is inf"),
        ("yaw_rate", None, {}, "a sequence of output names"),
        (["yaw_rate"], [], {}, "a sequence of input names"),
    ],
)
def test_refusals(
    response: FrequencyResponse, outputs: object, inputs: object, scales: dict, message: str
) -> None:
    with pytest.raises(LinearisationError, match=message):
        singular_values(response, outputs, inputs, scales)
