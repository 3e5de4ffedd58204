"""Pictures show the numbers they are given, with units, on the axes they are given."""

from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot
from matplotlib.axes import Axes

from chassym.derivation import load_model
from chassym.linear import (
    FrequencyResponse,
    LinearisationError,
    LinearModel,
    damped_modes,
    frequency_response,
    heave_response,
    left_slope,
    linearise,
)
from chassym.linear.plots import (
    DECIBEL,
    plot_bode,
    plot_frequency_response,
    plot_modes,
    plot_nyquist,
    plot_phase,
    plot_singular_values,
    plot_spectrum,
    plot_tornado,
    save_bode,
)
from chassym.linear.variation.tornado import Bar, Tornado

FREQUENCIES = np.geomspace(0.1, 50, 60)


@pytest.fixture
def axes() -> Iterator[Axes]:
    figure, axes = pyplot.subplots()
    yield axes
    pyplot.close(figure)


@pytest.fixture(scope="module")
def quarter_response(quarter_linear: LinearModel) -> FrequencyResponse:
    return frequency_response(quarter_linear, FREQUENCIES)


def legend(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_amplitude(axes: Axes, sedan_linear: LinearModel) -> None:
    response = frequency_response(sedan_linear, FREQUENCIES)
    assert plot_frequency_response(axes, response, "vertical_acceleration", "front_left_pad_z") is axes
    (line,) = axes.get_lines()
    np.testing.assert_array_equal(line.get_xdata(), FREQUENCIES)
    expected = np.abs(response.select("vertical_acceleration", "front_left_pad_z"))
    np.testing.assert_array_equal(line.get_ydata(), expected)
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_xlabel() == "frequency (Hz)"
    assert axes.get_ylabel() == "amplitude per unit of front left pad z\n((m/s²)/m)"
    assert legend(axes) == ["vertical acceleration"]
    assert "mean_slope" in axes.get_title(loc="left")
    axes.figure.canvas.draw()


def test_decibels(axes: Axes, quarter_response: FrequencyResponse) -> None:
    plot_frequency_response(axes, quarter_response, "patch_force_z", "road", scale=DECIBEL)
    (line,) = axes.get_lines()
    amplitude = np.abs(quarter_response.select("patch_force_z", "road"))
    np.testing.assert_allclose(10 ** (line.get_ydata() / 20), amplitude)
    assert axes.get_yscale() == "linear"
    assert axes.get_ylabel().endswith("(dB relative to 1 N/m)")


def test_another_unit_needs_axes_of_its_own(axes: Axes, sedan_linear: LinearModel) -> None:
    response = frequency_response(sedan_linear, FREQUENCIES)
    plot_frequency_response(axes, response, "vertical_acceleration", "front_left_pad_z")
    plot_frequency_response(axes, response, "lateral_acceleration", "front_left_pad_z")
    with pytest.raises(LinearisationError, match=r"response in \(rad/s\)/m; draw it on axes of its own"):
        plot_frequency_response(axes, response, "roll_rate", "front_left_pad_z")
    with pytest.raises(LinearisationError, match="draw it on axes of its own"):
        plot_frequency_response(axes, response, "vertical_acceleration", "front_left_pad_z", scale=DECIBEL)
    assert len(axes.lines) == 2


def test_curves_of_two_models_have_no_description_in_common(axes: Axes, sedan_linear: LinearModel) -> None:
    for linear in (sedan_linear, linearise(load_model("sedan"), left_slope)):
        response = frequency_response(linear, FREQUENCIES)
        plot_frequency_response(axes, response, "vertical_acceleration", "front_left_pad_z", "one")
    assert axes.get_title(loc="left") == ""


def test_phase_in_degrees(axes: Axes, sedan_linear: LinearModel) -> None:
    response = heave_response(sedan_linear, FREQUENCIES)
    plot_phase(axes, response, "body_displacement", "heave", label="body")
    (line,) = axes.get_lines()
    turned = np.exp(1j * np.radians(line.get_ydata()))
    expected = response.select("body_displacement", "heave")
    np.testing.assert_allclose(turned, expected / np.abs(expected), atol=1e-12)
    assert np.abs(np.diff(line.get_ydata())).max() < 180
    assert "degrees" in axes.get_ylabel()
    assert legend(axes) == ["body"]


def test_the_phase_of_an_acceleration_begins_at_half_a_turn(axes: Axes, sedan_linear: LinearModel) -> None:
    """Displacement to acceleration is -w^2 at low frequency, where rounding decides between 180 and -180."""
    response = frequency_response(sedan_linear, FREQUENCIES)
    for output in ("vertical_acceleration", "body_axes_vertical_acceleration"):
        plot_phase(axes, response, output, "rear_left_pad_z")
    for line in axes.get_lines():
        assert line.get_ydata()[0] == pytest.approx(180, abs=5)


def test_bode(quarter_response: FrequencyResponse) -> None:
    figure, (above, below) = pyplot.subplots(2, 1, sharex=True)
    for output in ("body_displacement", "wheel_displacement"):
        assert plot_bode((above, below), quarter_response, output, "road") == (above, below)
        amplitude, phase = above.get_lines()[-1].get_ydata(), below.get_lines()[-1].get_ydata()
        drawn = amplitude * np.exp(1j * np.radians(phase))
        np.testing.assert_allclose(drawn, quarter_response.select(output, "road"), rtol=1e-9)
    assert above.get_ylabel().endswith("(m/m)") and below.get_ylabel().endswith("(degrees)")
    assert (above.get_xlabel(), below.get_xlabel()) == ("", "frequency (Hz)")
    assert legend(above) == ["body displacement", "wheel displacement"]
    assert len({line.get_color() for line in above.get_lines()}) == 2
    assert "mean_slope" in above.get_title(loc="left")
    figure.canvas.draw()
    pyplot.close(figure)


def test_a_bode_plot_as_a_file(tmp_path: Path, quarter_response: FrequencyResponse) -> None:
    picture = tmp_path / "bode.svg"
    with matplotlib.rc_context({"svg.fonttype": "none"}):
        save_bode(picture, quarter_response, "body_displacement", "road")
    written = picture.read_text(encoding="utf-8")
    for text in ("amplitude per unit of road", "(m/m)", "(degrees)", "frequency (Hz)", "mean_slope"):
        assert text in written
    with pytest.raises(ValueError, match="bmp"):
        save_bode(tmp_path / "bode.bmp", quarter_response, "body_displacement", "road")


def test_nyquist(axes: Axes, quarter_linear: LinearModel, quarter_response: FrequencyResponse) -> None:
    marked = [1.0, 5.0]
    assert plot_nyquist(axes, quarter_response, "body_displacement", "road", None, marked) is axes
    curve = axes.get_lines()[0]
    expected = quarter_response.select("body_displacement", "road")
    np.testing.assert_array_equal(curve.get_xdata() + 1j * curve.get_ydata(), expected)
    exact = frequency_response(quarter_linear, marked).select("body_displacement", "road")
    marks = axes.get_lines()[-1]
    np.testing.assert_allclose(marks.get_xdata() + 1j * marks.get_ydata(), exact, atol=0.01)
    assert [text.get_text() for text in axes.texts] == ["−1", "1 Hz", "5 Hz"]
    assert axes.texts[0].xy == (-1, 0)
    assert axes.get_aspect() == 1
    assert axes.get_xlabel() == "real part per unit of road (m/m)"
    assert axes.get_ylabel() == "imaginary part (m/m)"
    axes.figure.canvas.draw()


def test_nyquist_between_other_units_has_no_critical_point(
    axes: Axes, quarter_response: FrequencyResponse
) -> None:
    plot_nyquist(axes, quarter_response, "patch_force_z", "road")
    labels = [text.get_text() for text in axes.texts]
    assert "−1" not in labels and "10 Hz" in labels
    assert axes.get_ylabel() == "imaginary part (N/m)"


def test_labels_of_nyquist_curves_do_not_overlap(axes: Axes, quarter_response: FrequencyResponse) -> None:
    for output in ("body_displacement", "wheel_displacement"):
        plot_nyquist(axes, quarter_response, output, "road")
    axes.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in axes.texts if text.get_text() != "−1"]
    assert len(boxes) > 8
    assert not any(box.overlaps(other) for i, box in enumerate(boxes) for other in boxes[:i])


def test_nyquist_marks_only_what_is_known(axes: Axes, quarter_response: FrequencyResponse) -> None:
    with pytest.raises(LinearisationError, match=r"holds 60; .* 0\.1 to 50 Hz"):
        plot_nyquist(axes, quarter_response, "body_displacement", "road", None, [1.0, 60.0])


def test_singular_values(axes: Axes, sedan_linear: LinearModel) -> None:
    response = frequency_response(sedan_linear, FREQUENCIES)
    pads = [name for name in response.inputs if name.endswith("_z")]
    rates = ["roll_rate", "pitch_rate"]
    assert plot_singular_values(axes, response, rates, pads) is axes
    largest, smallest = (line.get_ydata() for line in axes.get_lines())
    matrix = np.array([[response.select(rate, pad) for pad in pads] for rate in rates])
    np.testing.assert_allclose(largest**2 + smallest**2, (np.abs(matrix) ** 2).sum(axis=(0, 1)))
    assert axes.get_ylabel() == "singular values ((rad/s)/m)"
    assert legend(axes) == [r"$\sigma_{1}$", r"$\sigma_{2}$"]
    axes.figure.canvas.draw()


def test_singular_values_that_are_zero_but_for_rounding_are_left_out(
    axes: Axes, sedan_linear: LinearModel
) -> None:
    response = frequency_response(sedan_linear, FREQUENCIES)
    plot_singular_values(axes, response, ["roll_rate", "roll_rate"], ["front_left_pad_z", "rear_left_pad_z"])
    assert np.isnan(axes.get_lines()[1].get_ydata()).all()


def test_scaled_singular_values(axes: Axes, quarter_response: FrequencyResponse) -> None:
    outputs = ["vertical_acceleration", "wheel_travel"]
    scales = {"vertical_acceleration": 1.0, "wheel_travel": 0.05, "road": 0.01}
    plot_singular_values(axes, quarter_response, outputs, scales=scales)
    assert axes.get_ylabel() == "singular values of scaled signals"
    with pytest.raises(LinearisationError, match="different units"):
        plot_singular_values(axes, quarter_response, outputs)


def test_spectrum(axes: Axes) -> None:
    assert plot_spectrum(axes, FREQUENCIES, FREQUENCIES**-2, "m/s^2", "seat") is axes
    (line,) = axes.get_lines()
    np.testing.assert_array_equal(line.get_ydata(), FREQUENCIES**-2)
    assert axes.get_ylabel() == "power spectral density ((m/s²)²/Hz)"
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    plot_spectrum(axes, FREQUENCIES, FREQUENCIES**-4, "m", "body")
    assert axes.get_ylabel() == "power spectral density (m²/Hz)"
    assert legend(axes) == ["seat", "body"]


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
    assert len({container[0].get_facecolor() for container in axes.containers}) == len(groups)
    torsion = groups.index("body torsion")
    assert widths[torsion].argmax() >= 10 and widths[torsion].max() > 97
    axes.figure.canvas.draw()


def test_tornado(axes: Axes) -> None:
    bars = Bar("patch", -1.0, 0.8, -0.9, 0.9), Bar("body.damper", 0.2, -0.3, 0.25, -0.25)
    found = Tornado("frequency of yaw", "m/s^2", 3.0, 0.25, bars)
    assert plot_tornado(axes, found) is axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["patch", "body damper"]
    less, more = ([bar.get_width() for bar in container] for container in axes.containers)
    assert less == [-1.0, 0.2] and more == [0.8, -0.3]
    diamonds = next(line for line in axes.get_lines() if line.get_marker() == "D")
    assert list(diamonds.get_xdata()) == [-0.9, 0.9, 0.25, -0.25]
    # Every diamond lies on the middle of its bar.
    pairs = zip(*axes.containers, strict=True)
    centres = [bar.get_y() + bar.get_height() / 2 for pair in pairs for bar in pair]
    np.testing.assert_allclose(diamonds.get_ydata(), centres)
    assert axes.get_ylim()[0] > axes.get_ylim()[1]
    assert axes.get_xlabel() == "change of frequency of yaw (m/s²)"
    assert legend(axes) == ["−25 %", "+25 %", "by the derivative"]
    axes.figure.canvas.draw()


def test_unknown_output_is_refused(axes: Axes, sedan_linear: LinearModel) -> None:
    response = heave_response(sedan_linear, FREQUENCIES)
    for plot in (plot_frequency_response, plot_phase, plot_nyquist):
        with pytest.raises(LinearisationError, match="unknown"):
            plot(axes, response, "engine", "heave")
