"""Excitations: rates against values, closed forms, files, and what is refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from chassym.derivation import Model
from chassym.nonlinear import (
    Excitation,
    ExcitationError,
    Harmonic,
    LinearChirp,
    LogarithmicChirp,
    PeriodicTimeSeries,
    Step,
    SteppedSine,
    Superposition,
    TimeSeries,
    read_time_series,
    rig,
)

TIMES = np.linspace(0.0, 6.0, 601)

MEASURED = np.linspace(-1.0, 7.0, 400)

EXCITATIONS = {
    "harmonic": Harmonic(1.3, {"road": 0.02 - 0.01j}),
    "linear chirp": LinearChirp(0.5, 6.0, 4.0, {"road": 0.02 - 0.01j}),
    "falling logarithmic chirp": LogarithmicChirp(6.0, 0.5, 4.0, {"road": 0.01j}),
    "stepped sine": SteppedSine((1.0, 2.5, 1.7), (2.0, 3.5, 1.0), {"road": (0.02, 0.01j, 0.03)}),
    "step": Step({"road": 0.05}, ramp_s=0.7, start_s=1.1),
    "superposition": Superposition((Step({"road": 0.05}, 1.0), Harmonic(2.0, {"road": 0.01}))),
    "time series": TimeSeries(MEASURED, {"road": np.sin(3 * MEASURED) * np.exp(-0.1 * MEASURED)}),
    "periodic": PeriodicTimeSeries(np.linspace(0, 1.5, 40), {"road": np.cos(np.linspace(0, 4 * np.pi, 40))}),
}

each_excitation = pytest.mark.parametrize("excitation", EXCITATIONS.values(), ids=EXCITATIONS.keys())


def away_from_breaks(excitation: Excitation, times: np.ndarray, distance: float) -> np.ndarray:
    breaks = np.append(excitation.breaks(-np.inf, np.inf), np.inf)
    return times[np.abs(times[:, None] - breaks).min(axis=1) > distance]


@each_excitation
def test_the_rate_is_the_derivative_of_the_value(quarter_car: Model, excitation: Excitation) -> None:
    """By differences of eighth order."""
    weights, h = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280]), 2e-3
    times = away_from_breaks(excitation, TIMES[1:], 5 * h)
    if isinstance(excitation, TimeSeries):  # a cubic between its samples
        interval = np.diff(excitation.time_s)[0]
        times, h = excitation.time_s[2:-3] + 0.5 * interval, 0.1 * interval
    found = np.zeros(len(times))
    for k, weight in enumerate(weights, start=1):
        ahead, behind = (excitation.signals(quarter_car, times + s * k * h)[0][0] for s in (1, -1))
        found += weight * (ahead - behind) / h
    rates = excitation.signals(quarter_car, times)[1][0]
    np.testing.assert_allclose(found, rates, atol=1e-8 * np.abs(rates).max())


@each_excitation
def test_one_instant_is_as_many_are(quarter_car: Model, excitation: Excitation) -> None:
    at = excitation.at(quarter_car)
    several = np.concatenate(excitation.signals(quarter_car, TIMES))
    assert several.shape == (2, len(TIMES))
    np.testing.assert_allclose(np.stack([at(t) for t in TIMES], axis=1), several, rtol=1e-12, atol=1e-12)


@each_excitation
def test_no_value_jumps_and_rates_do_so_at_breaks_only(quarter_car: Model, excitation: Excitation) -> None:
    breaks, tiny = excitation.breaks(0.0, 6.0), 1e-9
    assert np.all(np.diff(breaks) > 0) and np.all((breaks > 0) & (breaks < 6.0))
    for instants, jumping in ((breaks, 1), (away_from_breaks(excitation, TIMES[1:-1], 1e-6), 2)):
        before, after = (excitation.signals(quarter_car, instants + s * tiny)[:jumping] for s in (-1, 1))
        np.testing.assert_allclose(before, after, atol=1e-5)


@pytest.mark.parametrize(
    ("chirp", "method"),
    [
        (LinearChirp(0.5, 6.0, 4.0, {"road": 1.0}), "linear"),
        (LogarithmicChirp(0.5, 6.0, 4.0, {"road": 1.0}), "logarithmic"),
    ],
)
def test_chirps_are_those_of_signal_processing(quarter_car: Model, chirp: Excitation, method: str) -> None:
    times = np.linspace(0, 4.0, 500)
    expected = signal.chirp(times, 0.5, 4.0, 6.0, method)
    np.testing.assert_allclose(chirp.signals(quarter_car, times)[0][0], expected, atol=1e-12)


@pytest.mark.parametrize("kind", [LinearChirp, LogarithmicChirp])
def test_a_chirp_holds_its_frequencies_before_and_after(quarter_car: Model, kind: type) -> None:
    chirp = kind(1.0, 4.0, 2.0, {"road": 1.0})
    before = chirp.signals(quarter_car, np.array([-0.7]))[0][0]
    assert before == pytest.approx(np.cos(2 * np.pi * 0.7))
    late = chirp.cycles(np.array([5.0])) - chirp.cycles(np.array([2.0]))
    assert late == pytest.approx(4.0 * 3.0)
    assert chirp.frequency_hz(np.array([-1.0, 9.0])) == pytest.approx([1.0, 4.0])
    assert chirp.breaks(0.0, 9.0) == pytest.approx([2.0])


def test_a_stepped_sine_goes_on_where_the_last_step_left_it(quarter_car: Model) -> None:
    """1 Hz for 2.25 cycles, then 2 Hz: after its first cycle it is a sine of the second amplitude."""
    sine = SteppedSine((1.0, 2.0), (2.25, 4.0), {"road": (3.0, 5.0)})
    assert sine.starts_s == pytest.approx([0.0, 2.25]) and sine.end_s == pytest.approx(4.25)
    first, second = np.array([1.1, 1.9, 2.2]), np.array([2.76, 3.5, 4.2, 9.0])
    found = sine.signals(quarter_car, np.concatenate([first, second]))[0][0]
    expected = [*(3 * np.cos(2 * np.pi * first)), *(5 * np.cos(2 * np.pi * (2.25 + 2 * (second - 2.25))))]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert not np.any(sine.signals(quarter_car, np.array([-1.0, 0.0])))


def test_steps_may_be_given_by_their_durations() -> None:
    by_cycles = SteppedSine((2.0, 4.0), (3.0, 10.0), {"road": 0.01})
    assert SteppedSine.of_durations((2.0, 4.0), (1.5, 2.5), {"road": 0.01}).starts_s == pytest.approx(
        by_cycles.starts_s
    )


def test_a_step_ends_at_its_level(quarter_car: Model) -> None:
    step = Step({"road": 0.05}, ramp_s=0.5, start_s=1.0)
    values, rates = step.signals(quarter_car, np.array([0.9, 1.0, 1.25, 1.5, 7.0]))
    assert values[0] == pytest.approx([0, 0, 0.025, 0.05, 0.05])
    assert rates[0] == pytest.approx([0, 0, 1.875 * 0.05 / 0.5, 0, 0])


def test_a_time_series_meets_a_cubic_exactly(quarter_car: Model) -> None:
    """Unevenly sampled; a spline without a knot next to its ends reproduces it."""
    samples, cubic = np.array([0.0, 0.3, 0.5, 1.1, 1.7, 2.0]), np.polynomial.Polynomial([1, -2, 3, -0.5])
    series = TimeSeries(samples, {"road": cubic(samples)})
    times = np.linspace(0, 2, 41)
    values, rates = series.signals(quarter_car, times)
    np.testing.assert_allclose(values[0], cubic(times), rtol=1e-12)
    np.testing.assert_allclose(rates[0], cubic.deriv()(times), atol=1e-12)


def test_a_periodic_time_series_repeats(quarter_car: Model) -> None:
    series = EXCITATIONS["periodic"]
    once, again = (series.signals(quarter_car, TIMES + shift) for shift in (0.0, -4.5))
    np.testing.assert_allclose(once, again, atol=1e-10)


def test_inputs_that_are_not_named_stand_still(half_car: Model) -> None:
    values, rates = Harmonic(1.0, {"rear_road": 0.01}).signals(half_car, TIMES)
    assert not values[0].any() and not rates[0].any() and values[1].any()


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "chirp of one frequency": (lambda: LinearChirp(1, 1, 1, {}), "end_hz: 1 Hz received, as start_hz"),
    "chirp from nothing": (lambda: LogarithmicChirp(0, 1, 1, {}), "start_hz: 0 Hz received; a positive"),
    "chirp in no time": (lambda: LinearChirp(1, 2, 0, {}), "duration_s: 0 s received"),
    "infinite amplitude": (lambda: LinearChirp(1, 2, 1, {"road": np.inf}), "amplitude of 'road': inf"),
    "no steps": (lambda: SteppedSine((), 1, {}), "frequencies_hz: none received"),
    "negative step": (lambda: SteppedSine((1, -2), 1, {}), "frequencies_hz: -2 Hz received"),
    "part of a cycle": (lambda: SteppedSine((1, 2), 0.5, {}), "cycles: .*0.5.* received; .* 1 or more"),
    "cycles of two": (
        lambda: SteppedSine((1,), (1, 2), {}),
        "cycles: 2 received; one, or one for",
    ),
    "amplitudes of two": (lambda: SteppedSine((1,), 1, {"road": (1, 2)}), "amplitudes of 'road': 2 received"),
    "durations of two": (
        lambda: SteppedSine.of_durations((1, 2, 3), (1, 2), {}),
        "seconds: 2 received; one, or one for each of the 3 steps",
    ),
    "jump": (lambda: Step({"road": 1}, 0.0), "ramp_s: 0.0 s received; a positive"),
    "endless level": (lambda: Step({"road": np.nan}, 1), "amplitude of 'road': nan"),
    "step at no time": (lambda: Step({"road": 1}, 1, np.nan), "start_s: nan s received"),
    "empty sum": (lambda: Superposition(()), "parts: none received"),
    "few samples": (lambda: TimeSeries([0, 1, 2], {}), "four or more finite, increasing instants"),
    "samples in disorder": (lambda: TimeSeries([0, 2, 1, 3], {}), "four or more finite, increasing instants"),
    "missing samples": (
        lambda: TimeSeries(range(4), {"road": [1, 2]}),
        r"shape \(2,\) received; \(4,\)",
    ),
    "gap": (lambda: TimeSeries(range(4), {"road": [1, 2, np.nan, 3]}), "'road': .*nan.* received at 2 s"),
    "no period": (
        lambda: PeriodicTimeSeries(np.arange(4.0), {"road": [1, 2, 3, 4]}),
        "begin with 1 and end with 4",
    ),
}


@pytest.mark.parametrize(("make", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_is_impossible_is_refused_in_one_line(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ExcitationError, match=message) as refusal:
        make()
    assert "\n" not in str(refusal.value)


@each_excitation
def test_an_input_that_is_not_there_is_refused_by_name(half_car: Model, excitation: Excitation) -> None:
    for use in (lambda: excitation.signals(half_car, TIMES), lambda: excitation.at(half_car)(0.0)):
        with pytest.raises(ExcitationError, match="input 'road': .* has front_road, rear_road"):
            use()


def test_a_time_series_of_another_unit_is_refused(quarter_car: Model) -> None:
    series = TimeSeries(np.arange(4.0), {"road": np.zeros(4)}, {"road": "N"})
    with pytest.raises(ExcitationError, match="'road': in N; .* takes it in m$"):
        series.signals(quarter_car, TIMES)


def test_a_time_series_is_not_continued(quarter_car: Model) -> None:
    series = TimeSeries(np.arange(4.0), {"road": np.zeros(4)})
    for use in (lambda: series.signals(quarter_car, np.array([3.5])), lambda: series.at(quarter_car)(3.5)):
        with pytest.raises(ExcitationError, match="3.5 s asked for; it is known from 0 to 3 s"):
            use()


# Files


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    def written(text: str) -> Path:
        path = tmp_path / "drive.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return written


def test_files_are_read_in_their_units(write: Callable[[str], Path], quarter_car: Model) -> None:
    path = write("time (ms),road [mm]\n0,0\n10,1\n20,4\n30,9\n\n40,16\n")
    series = read_time_series(path)
    assert series.units == {"road": "m"}
    assert series.time_s == pytest.approx([0, 0.01, 0.02, 0.03, 0.04])
    assert series.values["road"] == pytest.approx([0, 0.001, 0.004, 0.009, 0.016])
    assert series.signals(quarter_car, np.array([0.02]))[1][0] == pytest.approx(0.4)


def test_columns_are_chosen_by_name(write: Callable[[str], Path]) -> None:
    path = write("\ufeffclock (s),left post (cm),oil (degC)\n0,0,20\n1,1,20\n2,3,20\n3,5,20\n")
    series = read_time_series(path, {"time": "clock", "front_left_pad_z": "left post"})
    assert series.values.keys() == {"front_left_pad_z"}
    assert series.values["front_left_pad_z"] == pytest.approx([0, 0.01, 0.03, 0.05])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "column 'time' is missing; there are none"),
        ("time (s),road (m)\n", "four or more"),
        ("road (m)\n1\n", "column 'time' is missing; there are road"),
        ("time,road (m)\n", "column 'time': a name with a unit is needed"),
        ("time (s),road (m),road (mm)\n", "column 'road': named twice"),
        ("time (s),road (parsec/fortnit)\n0,0\n", "road: .*parsec/fortnit"),
        ("time (m),road (m)\n0,0\n", "column 'time': the unit of a time is needed"),
        ("time (s),road (m)\n0,0\n1,high\n", "column 'road': 'high' received in line 3; a number is needed"),
        ("time (s),road (m)\n0,0\n1\n", "column 'road': nothing received in line 3"),
        ("time (s),road (m)\n\n0,0\n\n\n1,high\n", "column 'road': 'high' received in line 6;"),
        ('time (s),road (m)\n0,"\n0"\n1,high\n', "column 'road': 'high' received in line 4;"),
        ("time (s),road (m)\n0,0\n1,0\n1,0\n2,0\n", "increasing instants"),
    ],
)
def test_impossible_files_are_refused_by_name(write: Callable[[str], Path], text: str, message: str) -> None:
    with pytest.raises(ExcitationError, match=f"^drive.csv: .*{message}") as refusal:
        read_time_series(write(text))
    assert "\n" not in str(refusal.value)


# Harmonic


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan, np.inf])
def test_impossible_frequency_is_refused(frequency: float) -> None:
    with pytest.raises(ExcitationError, match="frequency"):
        Harmonic(frequency, {})


@pytest.mark.parametrize("amplitude", [np.nan, np.inf, complex(0, np.nan)])
def test_impossible_amplitude_is_refused_by_name(amplitude: complex) -> None:
    with pytest.raises(ExcitationError, match="'road'"):
        Harmonic(1.0, {"road": amplitude})


def test_unknown_input_is_refused_by_name(quarter_car: Model) -> None:
    with pytest.raises(ExcitationError, match="'rode'.*road"):
        Harmonic(1.0, {"rode": 0.01}).vector(quarter_car)


def test_lateral_pads_reach_six_tenths_of_gravity_and_the_rear_lags() -> None:
    test = rig.lateral()
    front, rear = test.amplitudes["front_left_pad_y"], test.amplitudes["rear_right_pad_y"]
    assert abs(front) * test.angular_frequency**2 == pytest.approx(0.6 * 9.81)
    assert abs(front) == pytest.approx(0.01657, abs=5e-6)
    assert rear / front == pytest.approx(np.exp(-1j * test.angular_frequency * 0.2))


def test_twist_and_heave_move_the_pads_as_named() -> None:
    twist = {name: value.real for name, value in rig.vertical().amplitudes.items()}
    assert twist == {
        "front_left_pad_z": 0.025,
        "front_right_pad_z": -0.025,
        "rear_left_pad_z": -0.025,
        "rear_right_pad_z": 0.025,
    }
    assert set(rig.heave().amplitudes.values()) == {0.01}
