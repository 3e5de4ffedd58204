"""Pole maps, root loci and tracked modes: the right places, legible labels, units."""

from collections.abc import Iterator

import matplotlib
import numpy as np
import pytest
import xarray

matplotlib.use("Agg")

from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.text import Text

from chassym.derivation import Model
from chassym.linear import LinearModel, damped_modes
from chassym.linear.modal.root_locus import parameter_root_locus
from chassym.linear.plots import plot_poles, plot_root_locus, plot_tracked_modes
from chassym.linear.plots.style import spread


@pytest.fixture
def axes() -> Iterator[Axes]:
    figure, axes = pyplot.subplots(figsize=(8, 5))
    yield axes
    pyplot.close(figure)


def assert_legible(axes: Axes, labels: list[str]) -> None:
    """Every label is drawn once, and none covers another."""
    axes.figure.canvas.draw()
    texts = [text for text in axes.texts if text.get_text() in labels]
    assert sorted(text.get_text() for text in texts) == sorted(labels)
    boxes = [Text.get_window_extent(text) for text in texts]  # without the line to its point
    assert not any(box.overlaps(other) for i, box in enumerate(boxes) for other in boxes[:i])


def test_poles_and_their_names(axes: Axes, sedan_linear: LinearModel) -> None:
    modes = damped_modes(sedan_linear)
    assert plot_poles(axes, modes, sedan_linear.description) is axes
    poles = next(line for line in axes.get_lines() if line.get_marker() == "x")
    drawn = poles.get_xdata() + 1j * poles.get_ydata()
    np.testing.assert_array_equal(drawn, [mode.eigenvalue for mode in modes])
    assert_legible(axes, [mode.name for mode in modes])
    for mode in modes:
        text = next(text for text in axes.texts if text.get_text() == mode.name)
        assert text.xy == (mode.eigenvalue.real, mode.eigenvalue.imag)
    assert axes.get_xlabel() == "real part (1/s)" and axes.get_ylabel() == "imaginary part (rad/s)"
    assert "mean_slope" in axes.get_title(loc="left")


def test_lines_of_damping_ratio_and_frequency(axes: Axes, quarter_linear: LinearModel) -> None:
    plot_poles(axes, damped_modes(quarter_linear))
    labels = {text.get_text(): complex(*text.xy) for text in axes.texts}
    ratios = {text: place for text, place in labels.items() if text.startswith("ζ")}
    frequencies = {text: place for text, place in labels.items() if text.endswith("Hz")}
    assert len(ratios) >= 4 and len(frequencies) >= 3
    for text, place in ratios.items():
        assert -place.real / abs(place) == pytest.approx(float(text[1:]))
    for text, place in frequencies.items():
        assert abs(place) / (2 * np.pi) == pytest.approx(float(text[:-2]))
    rays = [line.get_xydata() for line in axes.get_lines() if line.get_linestyle() == ":"]
    assert all(any(np.allclose(ray[-1], (p.real, p.imag)) for ray in rays) for p in ratios.values())
    sizes = [np.linalg.norm(line.get_xydata(), axis=1) for line in axes.get_lines()]
    circles = [size[0] for size in sizes if len(size) > 10 and np.ptp(size) < 1e-9 * size[0]]
    np.testing.assert_allclose(sorted(circles), sorted(map(abs, frequencies.values())))


def test_limits_that_are_set_are_kept(axes: Axes, sedan_linear: LinearModel) -> None:
    modes = damped_modes(sedan_linear)
    axes.set(xlim=(-8, 2), ylim=(-1, 35))
    plot_poles(axes, modes)
    assert axes.get_xlim() == (-8, 2) and axes.get_ylim() == (-1, 35)
    assert_legible(axes, [mode.name for mode in modes if mode.frequency_hz < 5])
    assert "body torsion, in phase" not in [text.get_text() for text in axes.texts]


def test_undamped_poles(axes: Axes, chain_linear: LinearModel) -> None:
    modes = damped_modes(chain_linear)
    plot_poles(axes, modes)
    assert_legible(axes, [mode.name for mode in modes])


def test_root_locus(axes: Axes, quarter_car: Model) -> None:
    masses = np.linspace(20.0, 80.0, 30)
    locus = parameter_root_locus(quarter_car, "unsprung.mass", masses)
    assert plot_root_locus(axes, locus) is axes
    (lines,) = axes.collections
    segments = np.array(lines.get_segments())
    assert len(segments) == 4 * 29
    np.testing.assert_array_equal(lines.get_array(), np.tile(masses[1:], 4))
    roots = locus.to_numpy()
    places = segments[:, 1].reshape(4, 29, 2)
    np.testing.assert_array_equal(places[..., 0].T, roots[1:].real)
    np.testing.assert_array_equal(places[..., 1].T, np.abs(roots[1:].imag))
    for marker, row in (("x", 0), ("o", -1)):
        ends = next(line for line in axes.get_lines() if line.get_marker() == marker)
        np.testing.assert_array_equal(ends.get_xdata(), roots[row].real)
    bar = axes.figure.axes[1]
    assert bar.get_ylabel() == "unsprung mass (kg), from × to ○"
    assert bar.get_yscale() == "linear" and bar.get_ylim() == (20.0, 80.0)
    assert axes.get_xlabel() == "real part (1/s)" and axes.get_ylabel() == "imaginary part (rad/s)"
    axes.figure.canvas.draw()


def test_root_locus_over_decades(axes: Axes, torsion_chain: Model) -> None:
    plot_root_locus(axes, parameter_root_locus(torsion_chain, "stiffness.front", np.geomspace(1e4, 1e7, 10)))
    bar = axes.figure.axes[1]
    assert bar.get_yscale() == "log"
    assert bar.get_ylabel().startswith("stiffness front (N m/rad)")


def tracked(values: np.ndarray, frequencies: np.ndarray, names: list[str]) -> xarray.Dataset:
    return xarray.Dataset(
        {"frequency_hz": (("value", "mode"), frequencies)},
        {"value": values, "mode": names},
        {"parameter": "body.front.torsional_stiffness", "unit": "N*m/rad"},
    )


def test_tracked_modes(axes: Axes) -> None:
    values = np.geomspace(1e2, 1e9, 20)
    names = ["bounce", "pitch", "roll", "wheel hop", "body torsion"]
    frequencies = np.outer(values**0.1, [1.0, 1.01, 1.02, 9.0, 9.05])
    assert plot_tracked_modes(axes, tracked(values, frequencies, names)) is axes
    for line, frequency in zip(axes.get_lines(), frequencies.T, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), values)
        np.testing.assert_array_equal(line.get_ydata(), frequency)
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_xlabel() == "body front torsional stiffness (N m/rad)"
    assert axes.get_ylabel() == "undamped natural frequency (Hz)"
    assert_legible(axes, names)
    for name, end in zip(names, frequencies[-1], strict=True):
        assert next(text for text in axes.texts if text.get_text() == name).xy == (1e9, end)


def test_tracked_modes_with_a_rigid_one_in_falling_order(axes: Axes) -> None:
    frequencies = np.array([[0.0, 3.0], [0.0, 2.0], [0.0, 1.0]])
    plot_tracked_modes(axes, tracked(np.array([3.0, 2.0, 1.0]), frequencies, ["yaw", "roll"]))
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "linear")
    assert next(text for text in axes.texts if text.get_text() == "roll").xy == (3.0, 3.0)


def test_labels_are_moved_as_little_as_can_be() -> None:
    """Two labels at one height part by half the distance each; more than fit are spaced evenly."""
    np.testing.assert_allclose(spread(np.array([0.5, 0.9, 0.5]), 0.1), [0.45, 0.9, 0.55])
    np.testing.assert_allclose(spread(np.array([1.2, 1.2]), 0.1), [0.9, 1.0])
    np.testing.assert_allclose(spread(np.zeros(5), 0.5), np.linspace(0, 1, 5))
    np.testing.assert_allclose(spread(np.array([0.3]), 0.5), [0.3])
