"""Pictures show the numbers they are given, with units."""

from collections.abc import Iterator

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot
from matplotlib.axes import Axes

from chassym.linear import LinearisationError, LinearModel, damped_modes, frequency_response, heave_response
from chassym.linear.plots import plot_frequency_response, plot_modes, plot_phase

FREQUENCIES = np.geomspace(0.1, 50, 60)


@pytest.fixture
def axes() -> Iterator[Axes]:
    figure, axes = pyplot.subplots()
    yield axes
    pyplot.close(figure)


def test_amplitude(axes: Axes, sedan_linear: LinearModel) -> None:
    response = frequency_response(sedan_linear, FREQUENCIES)
    assert plot_frequency_response(axes, response, "vertical_acceleration", "front_left_pad_z") is axes
    (line,) = axes.get_lines()
    np.testing.assert_array_equal(line.get_xdata(), FREQUENCIES)
    expected = np.abs(response.select("vertical_acceleration", "front_left_pad_z"))
    np.testing.assert_array_equal(line.get_ydata(), expected)
    assert axes.get_xlabel() == "frequency (Hz)"
    assert axes.get_ylabel() == "amplitude per unit of front left pad z ((m/s²)/m)"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["vertical acceleration"]
    assert "mean_slope" in axes.get_title(loc="left")
    axes.figure.canvas.draw()


def test_phase_in_degrees(axes: Axes, sedan_linear: LinearModel) -> None:
    response = heave_response(sedan_linear, FREQUENCIES)
    plot_phase(axes, response, "body_displacement", "heave", label="body")
    (line,) = axes.get_lines()
    turned = np.exp(1j * np.radians(line.get_ydata()))
    expected = response.select("body_displacement", "heave")
    np.testing.assert_allclose(turned, expected / np.abs(expected), atol=1e-12)
    assert np.abs(np.diff(line.get_ydata())).max() < 180
    assert "degrees" in axes.get_ylabel()
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["body"]


def test_modes_fill_their_bars(axes: Axes, sedan_linear: LinearModel) -> None:
    modes = damped_modes(sedan_linear)
    assert plot_modes(axes, modes, sedan_linear.description) is axes
    widths = np.array([[bar.get_width() for bar in container] for container in axes.containers])
    np.testing.assert_allclose(widths.sum(axis=0), 100)
    starts = np.array([[bar.get_x() for bar in container] for container in axes.containers])
    np.testing.assert_allclose(starts[1:], np.cumsum(widths, axis=0)[:-1], atol=1e-9)
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert len(labels) == 12
    for label, mode in zip(labels, modes, strict=True):
        assert label.startswith(mode.name) and f"{mode.frequency_hz:.2f} Hz" in label
    groups = [container.get_label() for container in axes.containers]
    assert groups == list(modes[0].energy)
    torsion = groups.index("body torsion")
    assert widths[torsion].argmax() >= 10 and widths[torsion].max() > 97
    axes.figure.canvas.draw()


def test_unknown_output_is_refused(axes: Axes, sedan_linear: LinearModel) -> None:
    with pytest.raises(LinearisationError, match="unknown"):
        plot_frequency_response(axes, heave_response(sedan_linear, FREQUENCIES), "engine", "heave")
