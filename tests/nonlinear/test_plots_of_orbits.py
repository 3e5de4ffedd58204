"""Pictures of orbits and branches show the numbers they are given, with units, on the axes they are given."""

from collections.abc import Iterator

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot
from matplotlib.axes import Axes

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, SteadyState, steady_state
from chassym.nonlinear.continuation.branch import Branch
from chassym.nonlinear.continuation.continuation import follow
from chassym.nonlinear.continuation.paths import FrequencyPath
from chassym.nonlinear.continuation.stepped_sine import SteppedResponse, stepped_sine
from chassym.nonlinear.plots import (
    plot_branch,
    plot_harmonics,
    plot_multipliers,
    plot_orbit,
    plot_steps,
)

from .duffing import Duffing

OUTPUT = "displacement"


@pytest.fixture
def axes() -> Iterator[Axes]:
    figure, axes = pyplot.subplots()
    yield axes
    pyplot.close(figure)


@pytest.fixture(scope="module")
def state(quarter_car: Model) -> SteadyState:
    return steady_state(quarter_car, Harmonic(2.0, {"road": 0.001}), tolerance=1e-6)


@pytest.fixture(scope="module")
def path() -> FrequencyPath:
    duffing = Duffing()
    return FrequencyPath(duffing.model(), duffing.excitation())


@pytest.fixture(scope="module")
def branch(path: FrequencyPath) -> Branch:
    return follow(path, 0.8 / (2 * np.pi), 2.4 / (2 * np.pi))


@pytest.fixture(scope="module")
def stepped(path: FrequencyPath) -> SteppedResponse:
    return stepped_sine(path, np.arange(0.8, 2.5, 0.1) / (2 * np.pi), metrics=[OUTPUT])


def legend(axes: Axes) -> list[str]:
    return axes.get_legend_handles_labels()[1]


def test_one_period_of_an_output(axes: Axes, state: SteadyState) -> None:
    assert plot_orbit(axes, state.orbit, "wheel_travel") is axes
    line = axes.lines[0]
    assert line.get_xdata()[-1] == pytest.approx(500.0)
    row = state.orbit.model.output_names.index("wheel_travel")
    phases = 2 * np.pi * line.get_xdata() / 500
    np.testing.assert_allclose(line.get_ydata(), 1e3 * state.orbit.outputs_at(phases)[row], rtol=1e-9)
    assert axes.get_xlabel() == "time (ms)"
    assert axes.get_ylabel() == "wheel travel\n(mm)"
    assert legend(axes) == ["wheel travel"]


def test_ticks_are_where_the_damper_passes_its_knots(axes: Axes, state: SteadyState) -> None:
    """At this amplitude there is one knot, that of rest: travel turns there."""
    plot_orbit(axes, state.orbit, "wheel_travel")
    travel, ticks = axes.lines[:2]
    turns = travel.get_xdata()[[np.argmin(travel.get_ydata()), np.argmax(travel.get_ydata())]]
    np.testing.assert_allclose(ticks.get_xdata(), np.sort(turns), atol=500 / 1440)


def test_several_outputs_have_colours_and_one_row_of_ticks(axes: Axes, state: SteadyState) -> None:
    plot_orbit(axes, state.orbit, "body_displacement")
    plot_orbit(axes, state.orbit, "wheel_displacement", label="wheel")
    assert legend(axes) == ["body displacement", "wheel"]
    assert len(axes.lines) == 3
    assert axes.lines[0].get_color() != axes.lines[2].get_color()
    assert axes.get_ylabel() == "(mm)"


def test_harmonics(axes: Axes, state: SteadyState) -> None:
    plot_harmonics(axes, state.orbit, "patch_force_z", 5)
    row = state.orbit.model.output_names.index("patch_force_z")
    expected = 1e-3 * np.abs(state.orbit.harmonic_content(5)[row, 1:])
    np.testing.assert_allclose([bar.get_height() for bar in axes.patches], expected)
    assert axes.get_ylabel() == "patch force z\n(kN)"
    assert axes.get_xlabel() == "harmonic of 2 Hz"
    assert axes.get_yscale() == "log"


def test_harmonics_of_zero_are_left_out(axes: Axes, branch: Branch) -> None:
    """A symmetric spring makes odd harmonics only."""
    plot_harmonics(axes, branch.orbits[3], OUTPUT, 5)
    assert [bar.get_x() + 0.5 * bar.get_width() for bar in axes.patches] == pytest.approx([1, 3, 5])


def test_multipliers(axes: Axes) -> None:
    plot_multipliers(axes, np.array([0.5 + 0.5j, 0.5 - 0.5j, -2.0]), "car")
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[0.5, 0.5], [0.5, -0.5], [-2.0, 0.0]])
    (circle,) = axes.patches
    assert circle.radius == 1.0
    assert axes.get_xlim()[0] < -2.0
    assert axes.get_aspect() == 1.0
    assert legend(axes) == ["car"]


def test_a_branch_with_folds(axes: Axes, branch: Branch) -> None:
    plot_branch(axes, branch, OUTPUT)
    assert legend(axes) == ["stable", "unstable", "fold"]
    *lines, folds = axes.lines
    assert [line.get_linestyle() for line in lines] == ["-", ":", "-"]
    for line, following in zip(lines, lines[1:], strict=False):
        np.testing.assert_allclose(line.get_xydata()[-1], following.get_xydata()[0])
    drawn = np.concatenate([lines[0].get_xydata(), *(line.get_xydata()[1:] for line in lines[1:])])
    np.testing.assert_allclose(drawn[:, 0], branch.values)
    np.testing.assert_allclose(drawn[:, 1], 1e3 * branch.amplitude(OUTPUT))
    np.testing.assert_allclose(folds.get_xdata(), [fold.value for fold in branch.folds])
    assert axes.get_xlabel() == "frequency (Hz)"
    assert axes.get_ylabel() == "displacement, half peak-to-peak\n(mm)"


def test_steps_and_jumps(axes: Axes, stepped: SteppedResponse) -> None:
    plot_steps(axes, stepped, OUTPUT)
    assert legend(axes) == ["steps upward", "steps downward"]
    for line, run in zip(axes.lines, (stepped.upward, stepped.downward), strict=True):
        np.testing.assert_allclose(line.get_xdata(), stepped.values)
        np.testing.assert_allclose(line.get_ydata(), 500 * run.peak_to_peak(OUTPUT))
    assert len(axes.texts) == len(stepped.jumps) == 2
    for arrow, jump in zip(axes.texts, stepped.jumps, strict=True):
        assert arrow.xy[0] == pytest.approx(jump.to_value)
        assert arrow.xy[1] == pytest.approx(1e3 * jump.to_amplitude, rel=0.02)
        assert (arrow.xyann[0] < jump.to_value) == (jump.direction == "upward")


def test_an_unknown_output_is_refused(axes: Axes, state: SteadyState, branch: Branch) -> None:
    with pytest.raises(KeyError, match="output 'lift': quarter_car has"):
        plot_orbit(axes, state.orbit, "lift")
    with pytest.raises(KeyError, match="output 'lift'"):
        plot_harmonics(axes, state.orbit, "lift")
    with pytest.raises(KeyError, match="output 'lift'"):
        plot_branch(axes, branch, "lift")
