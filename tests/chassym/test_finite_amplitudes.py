"""The response at finite amplitudes beside closed forms, linear models and one harmonic; and its picture."""

from collections.abc import Iterator

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot
from matplotlib.axes import Axes

from chassym.derivation import Model
from chassym.finite_amplitudes import AmplitudeResponse, amplitude_response
from chassym.linear import frequency_response, linearise
from chassym.linear.plots import plot_bode
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, steady_state
from chassym.plots import plot_amplitude_response

FREQUENCIES = (0.8, 1.3, 4.0, 9.0)
BODY = "body_displacement"


def with_table(car: Model, velocities: list[float], slopes: list[float]) -> Model:
    """The car with the damper table of these slopes between and beyond velocities, zero among them."""
    force = np.concatenate([[0.0], np.cumsum(np.diff(velocities) * slopes)])
    force -= force[velocities.index(0.0)]
    return car.with_parameters({"damper.velocity": velocities, "damper.force": list(force)})


def test_a_linear_car_responds_linearly(quarter_car: Model) -> None:
    car = with_table(quarter_car, [-1.0, -0.15, 0.0, 0.1, 1.0], [1500.0] * 4)
    found = amplitude_response(car, {"road": 1j}, BODY, FREQUENCIES, (0.001, 0.05), tolerance=1e-8)
    linear = 1j * frequency_response(linearise(car), FREQUENCIES).select(BODY, "road")
    for response in (*found.nonlinear, *found.equivalent):
        np.testing.assert_allclose(response, linear, rtol=1e-7)
    assert found.distortion.max() < 1e-7
    assert np.abs(found.mean).max() < 1e-9
    assert (found.output_unit, found.input_unit, found.motion) == ("m", "m", "road")


def test_small_motions_of_a_smooth_table_are_linear_and_large_ones_are_not(quarter_car: Model) -> None:
    car = with_table(quarter_car, [-1.0, -0.15, 0.0, 0.15, 1.0], [500.0, 2500.0, 2500.0, 500.0])
    found = amplitude_response(car, {"road": 1.0}, BODY, FREQUENCIES, (0.001, 0.05), tolerance=1e-6)
    linear = frequency_response(linearise(car), FREQUENCIES).select(BODY, "road")
    np.testing.assert_allclose(found.nonlinear[0], linear, rtol=1e-6)
    np.testing.assert_allclose(found.equivalent[0], linear, rtol=1e-6)
    assert np.abs(found.nonlinear[1] / linear - 1).max() > 0.3
    np.testing.assert_allclose(found.equivalent[1], found.nonlinear[1], rtol=0.03)


def test_within_a_corner_at_zero_the_response_is_proportional(quarter_car: Model) -> None:
    """Slopes that differ at zero velocity act at any amplitude: small motions never become linear."""
    found = amplitude_response(quarter_car, {"road": 1.0}, BODY, FREQUENCIES, (1e-6, 1e-4), tolerance=1e-6)
    linear = frequency_response(linearise(quarter_car), FREQUENCIES).select(BODY, "road")
    np.testing.assert_allclose(found.equivalent[0], linear, rtol=1e-9)
    np.testing.assert_allclose(found.nonlinear[0], found.nonlinear[1], rtol=1e-5)
    assert 0.01 < np.abs(found.nonlinear[0] / linear - 1).max() < 0.07
    np.testing.assert_allclose(found.mean[0] / 1e-6, found.mean[1] / 1e-4, rtol=1e-3)
    assert found.distortion.min() > 1e-3


def test_the_mean_is_what_the_mean_damper_force_makes_of_the_spring(quarter_car: Model) -> None:
    """No part accelerates in the mean, so the springs carry the mean of the damper's force."""
    found = amplitude_response(quarter_car, {"road": 1.0}, BODY, [4.0, 9.0], [0.02], tolerance=1e-6)
    p = quarter_car.parameters
    velocity, table = np.array(p["damper.velocity"].value), np.array(p["damper.force"].value)
    slopes = np.diff(table) / np.diff(velocity)
    ends = table[0] - 8 * slopes[0], table[-1] + 8 * slopes[-1]
    velocity = np.array([velocity[0] - 8, *velocity, velocity[-1] + 8])
    table = np.array([ends[0], *table, ends[1]])
    for index, frequency in enumerate((4.0, 9.0)):
        orbit = steady_state(quarter_car, Harmonic(frequency, {"road": 0.02}), tolerance=1e-6).orbit
        phases = 2 * np.pi * np.arange(4096) / 4096
        travel = orbit.outputs_at(phases)[quarter_car.output_names.index("wheel_travel")]
        rate = np.fft.irfft(2j * np.pi * frequency * np.arange(2049) * np.fft.rfft(travel))
        force = np.interp(rate, velocity, table).mean()
        assert found.mean[0, index] == pytest.approx(force / p["spring.rate"].value, rel=2e-3)
        assert found.mean[0, index] < -0.01


def test_several_inputs_and_patches(sedan: Model) -> None:
    inputs = {"front_left_pad_z": 1, "rear_right_pad_z": 1, "front_right_pad_z": -1, "rear_left_pad_z": -1}
    found = amplitude_response(sedan, inputs, "roll_rate", [3.0], [0.025], motion="twist")
    state = steady_state(sedan, Harmonic(3.0, inputs).scaled(0.025), metrics=["roll_rate"])
    assert state.contact is not None
    assert found.smallest_patch_force[0, 0] == pytest.approx(state.contact.value, rel=1e-6)
    half = state.peak_to_peak["roll_rate"].value / 2
    assert abs(found.nonlinear[0, 0]) * 0.025 == pytest.approx(half, rel=0.02)
    assert abs(found.equivalent[0, 0]) == pytest.approx(abs(found.nonlinear[0, 0]), rel=0.02)
    assert found.motion == "twist"


def test_what_is_not_found_has_a_reason(quarter_car: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*_: object, **__: object) -> None:
        raise NoPeriodicOrbitError("the branch is lost")

    monkeypatch.setattr("chassym.finite_amplitudes.steady_state", lost)
    found = amplitude_response(quarter_car, {"road": 1.0}, BODY, [1.0], [0.01])
    for numbers in (found.nonlinear, found.mean, found.distortion, found.smallest_patch_force):
        assert np.isnan(numbers).all()
    assert np.isfinite(found.equivalent).all()
    assert found.reasons == {(0.01, 1.0): "the branch is lost"}


@pytest.mark.parametrize(
    ("inputs", "output", "amplitudes", "error", "message"),
    [
        ({}, BODY, [0.01], ValueError, "inputs: none received"),
        ({"road": 1.0}, BODY, [0.0], ValueError, "amplitudes: .* positive numbers"),
        ({"road": 1.0}, "lift", [0.01], KeyError, "output 'lift': quarter_car has"),
        ({"pad": 1.0}, BODY, [0.01], ValueError, "input 'pad': quarter_car has road"),
    ],
)
def test_what_cannot_be_is_refused(
    quarter_car: Model,
    inputs: dict[str, complex],
    output: str,
    amplitudes: list[float],
    error: type[Exception],
    message: str,
) -> None:
    with pytest.raises(error, match=message):
        amplitude_response(quarter_car, inputs, output, [1.0], amplitudes)


def test_the_tolerance_is_that_of_the_steady_states(quarter_car: Model) -> None:
    with pytest.raises(ValueError, match="tolerance: 0.0 received"):
        amplitude_response(quarter_car, {"road": 1.0}, BODY, [1.0], [0.01], tolerance=0.0)


@pytest.fixture
def pair() -> Iterator[tuple[Axes, Axes]]:
    figure, (above, below) = pyplot.subplots(2, 1, sharex=True)
    yield above, below
    pyplot.close(figure)


@pytest.fixture(scope="module")
def found(quarter_car: Model) -> AmplitudeResponse:
    return amplitude_response(quarter_car, {"road": 1.0}, "vertical_acceleration", (2.0, 9.0), (0.001, 0.03))


def dots(axes: Axes, *, hollow: bool) -> np.ndarray:
    """Points drawn full or hollow, shape (points, 2), without what is in the legend only."""
    lines = [line for line in axes.lines if line.get_marker() == "o" and len(line.get_xdata())]
    chosen = [line.get_xydata() for line in lines if (str(line.get_markerfacecolor()) == "white") == hollow]
    return np.concatenate(chosen)


def test_the_picture_shows_the_numbers(pair: tuple[Axes, Axes], found: AmplitudeResponse) -> None:
    above, below = plot_amplitude_response(pair, found)
    assert (above, below) == pair
    assert list(found.smallest_patch_force.ravel() < 0) == [False, False, False, True]
    np.testing.assert_allclose(dots(above, hollow=True), [[9.0, abs(found.nonlinear[1, 1])]])
    full = [[2.0, abs(found.nonlinear[0, 0])], [9.0, abs(found.nonlinear[0, 1])]]
    np.testing.assert_allclose(dots(above, hollow=False), [*full, [2.0, abs(found.nonlinear[1, 0])]])
    dashed = [line.get_ydata() for line in above.lines if line.get_linestyle() == "--"]
    np.testing.assert_allclose(dashed[:2], np.abs(found.equivalent))
    phases = np.degrees(np.angle(found.nonlinear[0]))
    np.testing.assert_allclose(dots(below, hollow=False)[:2, 1], phases, rtol=1e-12)


def test_the_picture_names_units_and_amplitudes(pair: tuple[Axes, Axes], found: AmplitudeResponse) -> None:
    above, below = plot_amplitude_response(pair, found)
    assert above.get_ylabel() == "amplitude per unit of road\n((m/s²)/m)"
    assert below.get_ylabel() == "phase against road\n(degrees)"
    assert below.get_xlabel() == "frequency (Hz)"
    legend = [text.get_text() for text in above.get_legend().get_texts()]
    assert legend == ["1 mm", "30 mm", "describing function", "a tyre would have to pull"]


def test_linear_responses_go_on_the_same_axes(
    pair: tuple[Axes, Axes], found: AmplitudeResponse, quarter_car: Model
) -> None:
    plot_amplitude_response(pair, found)
    response = frequency_response(linearise(quarter_car), np.geomspace(1, 10, 20))
    plot_bode(pair, response, found.output, "road", "at rest")
    assert pair[0].get_ylabel() == "amplitude per unit of road\n((m/s²)/m)"
