"""The steady state as a whole: what must be the same, limits of frequency and amplitude, and refusals."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from chassym.derivation import (
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    build_model,
    prismatic,
)
from chassym.derivation.schema import ParameterError
from chassym.nonlinear import (
    ExcitationError,
    Harmonic,
    NoPeriodicOrbitError,
    SteadyState,
    harmonic_steady_state,
    rig,
    steady_state,
)
from chassym.nonlinear.harmonics.harmonic_balance import Extension, at_rest, newton
from chassym.nonlinear.harmonics.subharmonics import subharmonic_orbit
from chassym.nonlinear.steady.shooting import shooting_steady_state

from .duffing import Duffing
from .oscillator import oscillator

ALL_METHODS = [steady_state, harmonic_steady_state, shooting_steady_state]


def values(found: SteadyState) -> Mapping[str, float]:
    return {name: metric.value for name, metric in found.peak_to_peak.items()}


@pytest.mark.parametrize("frequency_hz", [0.05, 2.5, 60.0])
@pytest.mark.parametrize("method", ALL_METHODS)
def test_a_linear_oscillator_has_its_closed_form(method, frequency_hz: float) -> None:
    """Its extremes too: nothing is left of the error but rounding and what the tolerance allows."""
    s = 2j * np.pi * frequency_hz
    transfer = (6.0 * s + 800.0) / (2.0 * s**2 + 6.0 * s + 800.0)
    names = ["displacement", "acceleration"]
    found = method(oscillator(), Harmonic(frequency_hz, {"road": 0.03j}), metrics=names, tolerance=1e-8)
    expected = {"displacement": 0.06 * abs(transfer), "acceleration": 0.06 * abs(transfer * s**2)}
    assert values(found) == pytest.approx(expected, rel=1e-7)
    assert found.orbit.harmonic_content(1)[0, 1] == pytest.approx(0.03j * transfer, rel=1e-7)


def test_a_shifted_phase_shifts_the_orbit_and_nothing_else(sedan: Model) -> None:
    shift = 0.7
    first = rig.lateral()
    later = Harmonic(
        first.frequency_hz, {name: u * np.exp(-1j * shift) for name, u in first.amplitudes.items()}
    )
    both = [steady_state(sedan, excitation, tolerance=1e-9) for excitation in (first, later)]
    assert values(both[0]) == pytest.approx(values(both[1]), rel=1e-8)
    phases = np.linspace(0, 2 * np.pi, 9)
    motion = both[0].orbit.motion_at(phases)
    scale = np.abs(motion).max(axis=1, keepdims=True)
    assert both[1].orbit.motion_at(phases + shift) / scale == pytest.approx(motion / scale, abs=1e-7)
    assert np.sort(np.abs(both[0].multipliers)) == pytest.approx(
        np.sort(np.abs(both[1].multipliers)), abs=1e-8
    )


@pytest.mark.parametrize("name", ["sedan", "quarter_car", "half_car"])
def test_without_an_amplitude_nothing_moves(request: pytest.FixtureRequest, name: str) -> None:
    found = steady_state(request.getfixturevalue(name), Harmonic(3.0, {}))
    assert max(values(found).values()) < 1e-9
    assert np.abs(found.orbit.state()).max() < 1e-9
    assert found.is_stable and found.contact is not None and found.contact.is_kept


def test_a_very_slow_test_moves_the_car_with_its_pads(sedan: Model) -> None:
    excitation = rig.heave(0.05, 0.01)
    found = steady_state(sedan, excitation, metrics=["body_displacement", "vertical_acceleration"])
    assert found.peak_to_peak["body_displacement"].value == pytest.approx(0.02, rel=1e-2)
    rigid = 0.02 * excitation.angular_frequency**2
    assert found.peak_to_peak["vertical_acceleration"].value == pytest.approx(rigid, rel=0.1)
    assert found.is_stable


def test_a_very_fast_test_leaves_the_body_at_rest(sedan: Model) -> None:
    found = steady_state(sedan, rig.heave(60.0, 0.001), metrics=["body_displacement"], tolerance=1e-5)
    assert found.peak_to_peak["body_displacement"].value < 2e-5
    again = shooting_steady_state(
        sedan, rig.heave(60.0, 0.001), metrics=["body_displacement"], tolerance=1e-5, start=found.orbit
    )
    assert values(again) == pytest.approx(values(found), rel=1e-4)


def test_a_start_from_another_frequency_and_vehicle_leads_to_the_same(sedan: Model) -> None:
    soft = sedan.with_parameters({"body.front.torsional_stiffness": 5e3})
    start = steady_state(soft, rig.vertical(2.8), tolerance=1e-2).orbit
    expected = values(steady_state(sedan, rig.vertical(), tolerance=1e-8))
    found = steady_state(sedan, rig.vertical(), tolerance=1e-8, start=start)
    assert values(found) == pytest.approx(expected, rel=3e-8)
    assert found.orbit.model is sedan


def test_a_subharmonic_of_order_three() -> None:
    """Duffing's oscillator driven at about three times its own frequency answers with a third of that."""
    lightly = Duffing(damping=0.02, stiffness=1.0, cubic=1.0, force=4.0)
    excitation = lightly.excitation(4.5)
    start = subharmonic_orbit(lightly.model(), excitation, 3).orbit
    found = steady_state(
        lightly.model(), excitation, metrics=["displacement"], tolerance=1e-8, start=start, subharmonic=3
    )
    assert found.orbit.subharmonic == 3
    content = np.abs(found.orbit.harmonic_content(3)[0])
    assert content[1] > content[3] > 0, "most of the motion has a third of the frequency"
    state, expected = lightly.shot(found.orbit.state(), 4.5, periods=3)
    assert found.orbit.state() == pytest.approx(state, abs=1e-7)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(expected), abs=1e-6)
    once = steady_state(lightly.model(), excitation, metrics=["displacement"])
    assert once.peak_to_peak["displacement"].value < 0.7 * found.peak_to_peak["displacement"].value


@pytest.mark.parametrize("name", ["vertical_acceleration", "pitch_rate"])
def test_metrics_of_the_series_converge_as_a_corner_implies(sedan: Model, name: str) -> None:
    """What equations of motion make of a series is off by 1/H^2; the series' own accelerations by more."""
    exact = steady_state(sedan, rig.vertical(), metrics=[name], tolerance=1e-9)
    low = newton(at_rest(sedan, rig.vertical(), 10), 1e-6)
    extension, row = Extension(low), sedan.output_names.index(name)
    orders, errors = np.array([20, 40, 80, 160, 320, 640]), []
    for harmonics in orders:
        low_value, high_value = extension.solve(low.orbit, int(harmonics), 1e-11).orbit.extremes([row])
        errors.append(abs(float((high_value - low_value)[0]) - exact.peak_to_peak[name].value))
    slope = np.polyfit(np.log(orders), np.log(errors), 1)[0]
    assert -3.2 < slope < -1.6


def test_accelerations_read_off_the_series_converge_more_slowly(sedan: Model) -> None:
    low = newton(at_rest(sedan, rig.vertical(), 10), 1e-6)
    extension = Extension(low)
    rows = slice(2 * sedan.size, 3 * sedan.size)
    orders, series_errors, equation_errors = np.array([40, 80, 160, 320]), [], []
    exact = steady_state(sedan, rig.vertical(), tolerance=1e-9).orbit.sampled(4096)[rows]
    for harmonics in orders:
        orbit = extension.solve(low.orbit, int(harmonics), 1e-11).orbit
        series_errors.append(np.abs(orbit.arguments(4096)[rows] - exact).max())
        equation_errors.append(np.abs(orbit.sampled(4096)[rows] - exact).max())
    slope = np.polyfit(np.log(orders), np.log(series_errors), 1)[0]
    assert -1.4 < slope < -0.6, "a corner in the accelerations leaves 1/H"
    assert equation_errors[-1] < 0.05 * series_errors[-1]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_an_excitation_that_turns_the_car_over_is_refused(sedan: Model) -> None:
    over = {f"{corner}_pad_z": (5.0 if "front" in corner else -5.0) for corner in rig.CORNERS}
    with pytest.raises(NoPeriodicOrbitError, match="amplitude|singular") as caught:
        steady_state(sedan, Harmonic(0.5, over))
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_divergent_search_names_cause_and_remedy(sedan: Model) -> None:
    with pytest.raises(NoPeriodicOrbitError, match="smaller amplitude") as caught:
        steady_state(sedan, rig.vertical(amplitude_m=50.0))
    assert "\n" not in str(caught.value)


def test_an_undamped_resonance_has_no_steady_state() -> None:
    model = oscillator(stiffness=2.0 * (2 * np.pi) ** 2, damping=0.0)
    with pytest.raises(NoPeriodicOrbitError, match="stiffness|damping|amplitude") as caught:
        steady_state(model, Harmonic(1.0, {"road": 0.01}), metrics=["displacement"])
    assert "\n" not in str(caught.value)


def test_a_body_that_nothing_holds_has_no_steady_state() -> None:
    mechanism = Mechanism("drifting", gravity=0)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1.0)
    port = JointPort(mechanism.coordinate("z")).less(mechanism.add_input("road", "m"))
    mechanism.add_force_element("damper", port, Linear(0, 2.0))
    point = mechanism.point("p", mass, (0, 0, 0))
    mechanism.add_output(PointAcceleration("acceleration", point, "z", mechanism.ground))
    with pytest.raises(NoPeriodicOrbitError, match="coordinate 'z'; give it some stiffness"):
        steady_state(build_model(mechanism, {}), Harmonic(1.0, {"road": 0.1}))


def test_a_table_of_one_point_is_refused_by_name(quarter_car: Model) -> None:
    with pytest.raises(ParameterError, match="damper") as caught:
        quarter_car.with_parameters({"damper.velocity": [0.0], "damper.force": [0.0]})
    assert "\n" not in str(caught.value)


def test_an_input_the_model_lacks_is_refused_by_name(quarter_car: Model) -> None:
    with pytest.raises(ExcitationError, match="input 'pad'.*road"):
        steady_state(quarter_car, Harmonic(1.0, {"pad": 0.01}))


def test_results_of_all_methods_have_the_same_form(quarter_car: Model) -> None:
    for method, name in zip(ALL_METHODS, ["collocation", "harmonic balance", "shooting"], strict=True):
        found = method(quarter_car, Harmonic(2.0, {"road": 0.02}))
        assert found.statistics.method == name
        assert found.statistics.unknowns >= 4 and found.statistics.iterations > 0
        assert list(found.peak_to_peak) == ["vertical_acceleration"]
        assert len(found.multipliers) == 4 and found.is_stable
        assert found.contact is not None and found.contact.error >= 0
        restarted = steady_state(quarter_car, Harmonic(2.1, {"road": 0.02}), start=found.orbit)
        assert restarted.orbit.excitation.frequency_hz == 2.1


def test_the_same_motion_under_another_excitation_keeps_its_phases(quarter_car: Model) -> None:
    found = steady_state(quarter_car, Harmonic(2.0, {"road": 0.02}), tolerance=1e-6).orbit
    faster = found.under(quarter_car, replace(found.excitation, frequency_hz=3.0))
    phases = np.linspace(0, 6, 5)
    factors = np.array([[1.0], [1.0], [1.5], [1.5]])
    assert faster.motion_at(phases) == pytest.approx(factors * found.motion_at(phases), rel=1e-12)
