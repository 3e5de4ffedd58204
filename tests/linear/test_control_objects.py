"""python-control takes the state space and the frequency response, and its own plots work on them."""

from collections.abc import Iterator

import control
import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot

from chassym.linear import LinearisationError, LinearModel, frequency_response, to_control
from chassym.linear.control_objects import to_control_frequency_response
from chassym.linear.input_conventions import displacements_and_rates

FREQUENCIES = np.geomspace(0.1, 50, 40)


@pytest.fixture(autouse=True)
def closed_figures() -> Iterator[None]:
    yield
    pyplot.close("all")


def test_the_response_is_that_of_the_state_space(quarter_linear: LinearModel) -> None:
    """The rate of an input is s times it: G = G_u + s G_u', both by python-control."""
    data = to_control_frequency_response(frequency_response(quarter_linear, FREQUENCIES))
    omega = 2 * np.pi * FREQUENCIES
    parts = control.frequency_response(to_control(quarter_linear), omega).frdata
    np.testing.assert_allclose(data.omega, omega)
    np.testing.assert_allclose(data.frdata[:, 0], parts[:, 0] + 1j * omega * parts[:, 1], rtol=1e-9)


def test_names_are_kept(sedan_linear: LinearModel) -> None:
    data = to_control_frequency_response(frequency_response(sedan_linear, FREQUENCIES))
    assert tuple(data.input_labels) == sedan_linear.inputs
    assert tuple(data.output_labels) == sedan_linear.outputs


@pytest.mark.parametrize("frequencies", [[2.0, 1.0], [1.0, 1.0]])
def test_frequencies_have_to_ascend(quarter_linear: LinearModel, frequencies: list[float]) -> None:
    with pytest.raises(LinearisationError, match=f"holds 1 after {frequencies[0]:g}"):
        to_control_frequency_response(frequency_response(quarter_linear, frequencies))


def test_plots_of_the_state_space(quarter_linear: LinearModel) -> None:
    plant = to_control(quarter_linear)["wheel_travel", "road"]
    omega = 2 * np.pi * FREQUENCIES
    assert control.bode_plot(plant, omega, Hz=True).axes.shape == (2, 1)
    assert control.singular_values_plot(to_control(quarter_linear), omega).axes.shape == (1, 1)
    assert control.nyquist_plot(plant, omega).axes.shape == (1, 1)
    drawn = control.pole_zero_map(plant)
    assert drawn.plot().axes.shape == (1, 1)
    roots = np.linalg.eigvals(displacements_and_rates(quarter_linear).A)
    np.testing.assert_allclose(np.sort_complex(drawn.poles), np.sort_complex(roots))


def test_plots_of_the_frequency_response(quarter_linear: LinearModel) -> None:
    data = to_control_frequency_response(frequency_response(quarter_linear, FREQUENCIES))
    travel = data["body_displacement", "road"]
    assert control.bode_plot(travel).axes.shape == (2, 1)
    assert control.nyquist_plot(travel, warn_encirclements=False).axes.shape == (1, 1)
    pyplot.figure()
    drawn = control.singular_values_response(travel, data.omega).plot()
    sizes = drawn.axes[0, 0].get_lines()[0].get_ydata()
    np.testing.assert_allclose(sizes, np.abs(travel.frdata[0, 0]))
