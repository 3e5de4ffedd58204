"""Running rig tests: one frequency, stepped sines with jumps, and their labelled arrays."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
import sympy
from matplotlib.figure import Figure

from chassym.derivation import (
    ContactForce,
    Deflection,
    Linear,
    Mechanism,
    Model,
    ParameterError,
    PointDisplacement,
    Polynomial,
    TravelPort,
    build_model,
    prismatic,
)
from chassym.nonlinear import NoPeriodicOrbitError, steady_state
from chassym.nonlinear.rig import Motion, Rate, RigResult, RigTest, load_rig_test, run
from chassym.nonlinear.rig.pads import PADS
from chassym.nonlinear.rig.plots import draw_rig_test

STEPPED = RigTest("own", "one road", "own", (0.8, 1.1, 2.0), (Motion(("all",), "vertical", 0.01),))


def hardening() -> Model:
    """A mass on a spring that hardens, above a road: its resonance leans over."""
    m, k, stiffening, c = sympy.symbols("m k k_3 c", positive=True)
    mechanism = Mechanism("hardening", gravity=0)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    centre = mechanism.point("centre", mass, (0, 0, 0))
    absolute = TravelPort(centre, mechanism.ground, "z")
    height = absolute.less(mechanism.add_input("road", "m"))
    spring = mechanism.add_force_element("spring", height, Polynomial((k, 0, stiffening)))
    mechanism.add_force_element("damper", absolute, Linear(0, c))
    mechanism.add_output(PointDisplacement("displacement", centre, "z", mechanism.ground))
    mechanism.add_output(ContactForce("spring_force", spring))
    mechanism.add_output(Deflection("deflection", height))
    return build_model(mechanism, {m: 1.0, k: (2 * np.pi) ** 2, stiffening: 4e3, c: 1.4})


@pytest.fixture(scope="module")
def leaning() -> RigResult:
    test = replace(
        STEPPED,
        frequencies_hz=tuple(np.arange(8, 21) / 10),
        motions=(Motion(("all",), "vertical", 0.02),),
        metrics=("displacement",),
    )
    return run(hardening(), test)


def test_one_frequency_is_the_steady_state(quarter_car: Model) -> None:
    test = load_rig_test("heave")
    (step,) = run(quarter_car, test).steps
    expected = steady_state(quarter_car, test.excitation(quarter_car))
    assert step.state.peak_to_peak == expected.peak_to_peak
    assert (step.frequency_hz, step.direction, step.reason) == (1.0, "upward", "")


@pytest.mark.parametrize("unit", ["m", "m/s", "m/s^2"])
def test_every_step_is_the_steady_state_at_its_frequency(quarter_car: Model, unit: str) -> None:
    test = replace(STEPPED, amplitude_unit=unit, tolerance=1e-5).with_amplitude(0.02, unit)
    found = run(quarter_car, test)
    assert [step.frequency_hz for step in found.steps] == [0.8, 1.1, 2.0, 2.0, 1.1, 0.8]
    assert [step.direction for step in found.steps] == 3 * ["upward"] + 3 * ["downward"]
    for step in found.steps:
        expected = steady_state(quarter_car, test.excitation(quarter_car, step.frequency_hz), tolerance=1e-5)
        for name, metric in expected.peak_to_peak.items():
            moved = step.state.peak_to_peak[name]
            assert moved.value == pytest.approx(metric.value, rel=1e-3)


def test_the_lag_of_a_stepped_sine_is_a_time(half_car: Model) -> None:
    test = replace(STEPPED, rear_lag_s=0.07)
    for step in run(half_car, test).steps:
        expected = steady_state(half_car, test.excitation(half_car, step.frequency_hz))
        found = step.state.peak_to_peak["pitch_rate"]
        assert found.value == pytest.approx(expected.peak_to_peak["pitch_rate"].value, rel=1e-3)


def test_lags_that_add_up_on_one_pad_cannot_be_stepped(quarter_car: Model) -> None:
    motions = (*STEPPED.motions, Motion(("all",), "vertical", 0.01, lag_s=0.1))
    with pytest.raises(ParameterError, match=r"lag: received 0\.1 s and 0 s of road"):
        run(quarter_car, replace(STEPPED, motions=motions))
    assert len(replace(STEPPED, motions=motions).harmonic(PADS).amplitudes) == 4


def test_a_resonance_that_leans_over_jumps_at_different_frequencies(leaning: RigResult) -> None:
    directions = {jump.direction: jump for jump in leaning.jumps}
    assert set(directions) == {"upward", "downward"}
    assert directions["upward"].value > directions["downward"].value
    assert directions["upward"].from_amplitude > directions["upward"].to_amplitude
    assert directions["downward"].from_amplitude < directions["downward"].to_amplitude
    assert leaning.coexisting_hz
    low, high = directions["downward"].value, directions["upward"].value
    assert all(low <= frequency <= high for frequency in leaning.coexisting_hz)


def test_labelled_arrays_hold_both_ways(leaning: RigResult) -> None:
    data = leaning.to_xarray()
    assert data["displacement"].dims == ("direction", "frequency")
    assert data["displacement"].attrs["units"] == "m"
    for step in leaning.steps:
        labelled = data.sel(direction=step.direction, frequency=step.frequency_hz)
        metric = step.state.peak_to_peak["displacement"]
        assert float(labelled["displacement"]) == metric.value
        assert float(labelled["displacement_error"]) == metric.error
        assert bool(labelled["is_stable"]) == step.state.is_stable
    up, down = data["displacement"].sel(frequency=list(leaning.coexisting_hz))
    assert np.all(up > 1.05 * down)


def test_labelled_arrays_of_one_frequency_hold_its_period(quarter_car: Model) -> None:
    found = run(quarter_car, load_rig_test("heave"))
    data = found.to_xarray()
    signal = data["vertical_acceleration_signal"]
    assert np.ptp(signal.values) == pytest.approx(data["vertical_acceleration"].item(), rel=1e-3)
    assert (signal.dims, signal.attrs["units"]) == (("time",), "m/s^2")
    assert float(data["time"][-1]) == pytest.approx(1.0)
    assert float(data["patch_force_z_signal"].min()) == pytest.approx(
        data["minimum_patch_force"].item(), rel=1e-4
    )
    assert "units" in data["frequency"].attrs


def test_a_rate_is_the_slope_of_a_regression_line() -> None:
    """Of k s + k_3 s^3 over s = A cos it is k + 3/4 k_3 A^2; the spring's support feels the opposite."""
    test = replace(
        STEPPED,
        frequencies_hz=(10.0,),  # far above resonance: the mass all but stands and the spring takes the road
        motions=(Motion(("all",), "vertical", 0.1),),
        metrics=("displacement",),
        rates=(Rate("stiffness", "spring_force", "deflection"),),
    )
    (step,) = run(hardening(), test).steps
    outputs = dict(
        zip(("displacement", "spring_force", "deflection"), step.state.orbit.outputs(256), strict=True)
    )
    amplitude = 0.5 * np.ptp(outputs["deflection"])
    expected = -((2 * np.pi) ** 2 + 0.75 * 4e3 * amplitude**2)
    assert step.rates["stiffness"].value == pytest.approx(expected, rel=1e-3)
    assert step.rates["stiffness"].unit == "N/m"


def test_what_is_not_found_keeps_its_reason(monkeypatch: pytest.MonkeyPatch, quarter_car: Model) -> None:
    stepped_sine = import_module("chassym.nonlinear.continuation.stepped_sine")
    genuine = stepped_sine.steady_state

    def failing(model, excitation, **options):
        if excitation.frequency_hz == 1.1:
            raise NoPeriodicOrbitError("nothing here")
        return genuine(model, excitation, **options)

    monkeypatch.setattr(stepped_sine, "steady_state", failing)
    found = run(quarter_car, STEPPED)
    reasons = {step.frequency_hz: step.reason for step in found.steps}
    assert (reasons[1.1], reasons[2.0]) == ("nothing here", "")
    assert all((step.state is None) == bool(step.reason) for step in found.steps)
    data = found.to_xarray()
    assert np.isnan(data["vertical_acceleration"].sel(frequency=1.1)).all()
    assert not np.isnan(data["vertical_acceleration"].sel(frequency=2.0)).any()


def test_progress_ends_at_one(quarter_car: Model) -> None:
    told: list[float] = []
    run(quarter_car, STEPPED, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1


def test_pictures(leaning: RigResult, quarter_car: Model) -> None:
    stepped = draw_rig_test(leaning)
    period = draw_rig_test(run(quarter_car, load_rig_test("heave")))
    assert isinstance(stepped, Figure)
    assert len(stepped.axes) == 1
    assert len(period.axes) == 2
    upward = stepped.axes[0].lines[0]
    expected = [s.state.peak_to_peak["displacement"].value for s in leaning.steps if s.direction == "upward"]
    assert upward.get_ydata() == pytest.approx(expected)


def test_a_rate_brings_its_outputs_to_the_usual_metrics(quarter_car: Model) -> None:
    heave = load_rig_test("heave")
    with_rate = replace(heave, rates=(Rate("stiffness", "patch_force_z", "body_displacement"),))
    [step], [usual] = run(quarter_car, with_rate).steps, run(quarter_car, heave).steps
    assert step.state is not None and usual.state is not None
    assert [*step.state.peak_to_peak] == [*usual.state.peak_to_peak, "patch_force_z", "body_displacement"]
    assert step.rates["stiffness"].unit == "N/m"


def test_the_rate_of_an_exact_test_is_asked_for_no_more_exactly_than_numbers_are(quarter_car: Model) -> None:
    rates = (Rate("stiffness", "patch_force_z", "body_displacement"),)
    [step] = run(quarter_car, replace(load_rig_test("heave"), rates=rates, tolerance=1e-11)).steps
    assert step.rates["stiffness"].error < 1e-6 * abs(step.rates["stiffness"].value)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"motions": ()}, "motion: received no amplitude"),
        ({"rates": (Rate("r", "patch_force_z", "yaw"),)}, "rate 'r': over: received 'yaw'"),
        ({"metrics": ("yaw",)}, "metrics: received 'yaw'"),
        ({"motions": (Motion(("frnt",), "vertical", 0.01),)}, "pads: received 'frnt', expected \"all\""),
    ],
)
def test_what_a_test_asks_for_in_vain_is_refused_by_its_key(quarter_car: Model, changes, told: str) -> None:
    with pytest.raises(ParameterError, match=f"heave test: {told}"):
        run(quarter_car, replace(load_rig_test("heave"), **changes))


def test_results_say_what_they_were_measured_under(quarter_car: Model) -> None:
    test = replace(load_rig_test("heave").with_rear_lag(0.2), tyres_lift=True)
    attributes = run(quarter_car, test).to_xarray().attrs
    told = {name: attributes[name] for name in ("test", "amplitude_unit", "rear_lag_s", "body", "tyres")}
    assert told == {
        "test": "heave",
        "amplitude_unit": "m",
        "rear_lag_s": 0.2,
        "body": "free",
        "tyres": "lifting",
    }
    assert attributes["amplitude"] == test.amplitude
