"""The study: its results agree with each other and with closed forms; what fails stays in with its reason."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.optimize import brentq

from chassym import rig_tests, thesis
from chassym.comparison import NOT_SOLVED, UNDECIDED, compare, direction, sweep_spans, trends
from chassym.derivation import Model, ParameterError, load_model
from chassym.nonlinear import Metric, NoPeriodicOrbitError, steady_state
from chassym.rig_tests import TESTS, Outcome, change, outcome
from chassym.study import (
    StudyPlan,
    StudyResults,
    changed_parameters,
    free_torsion_frequencies,
    run_study,
    summarise,
)
from chassym.thesis import Published
from chassym.variants import FACTORS, GROUPS, PLACES, READINGS, Stiffened, VariantRunner
from chassym.wheel_rate import (
    WheelRateError,
    closed_form,
    measure_wheel_rates,
    spring_rate,
    static_patch_force,
)

RANGE = Published("2 to 4", 2.0, 4.0, "m", "a table")


# What is asked for


def test_the_whole_study_covers_what_the_thesis_covers() -> None:
    plan = StudyPlan()
    assert len(plan.stiffnesses) == 29
    np.testing.assert_allclose(np.diff(np.log10(plan.stiffnesses)), 0.25)
    assert plan.stiffnesses[0] == pytest.approx(1e2) and plan.stiffnesses[-1] == pytest.approx(1e9)
    assert plan.heave_frequencies_hz == tuple(np.arange(1, 31) / 2)
    assert plan.tolerance == 1e-4


@pytest.mark.parametrize("vehicle", ["quarter_car", "half_car", "torsion_chain"])
def test_another_model_is_refused_in_one_line_before_any_work(vehicle: str) -> None:
    announced: list[str] = []
    with pytest.raises(ParameterError) as refusal:
        run_study(load_model(vehicle), lambda what, _: announced.append(what))
    message = str(refusal.value)
    assert repr(vehicle) in message and "'full_car'" in message and "\n" not in message
    assert not announced


def test_progress_rises_from_zero_to_one(
    small_study: StudyResults, announced: list[tuple[str, float]]
) -> None:
    fractions = [fraction for _, fraction in announced]
    assert fractions[0] == 0 and fractions[-1] == 1 and fractions == sorted(fractions)
    assert len(announced) == small_study.plan.solutions + 1
    assert len(set(announced)) == len(announced) and all(what for what, _ in announced)


# What is in the results


def test_every_variant_is_there_once(small_study: StudyResults) -> None:
    scaled = {(s.outcome.test, s.group, s.factor) for s in small_study.sensitivity}
    assert scaled == {(test, group, factor) for test in TESTS for group in GROUPS for factor in FACTORS}
    swept = [(s.outcome.test, s.placement, s.stiffness) for s in small_study.sweep]
    plan = small_study.plan
    assert swept == [(t, place, k) for t in TESTS for place in PLACES for k in plan.stiffnesses]
    halved = [(s.outcome.test, s.placement, s.stiffness) for s in small_study.halved]
    assert halved == [(test, place, 2.5e6) for test in TESTS for place in PLACES]
    read = [(r.outcome.test, r.reading) for r in small_study.rereadings]
    assert read == [(test, reading.name) for test in TESTS for reading in READINGS]
    assert not small_study.failures and not small_study.changed


def test_groups_scale_what_they_are_named_after(sedan: Model) -> None:
    stiffness = {f"tyre.{axle}.stiffness.{axis}" for axle in ("front", "rear") for axis in "xyz"}
    damping = {name.replace("stiffness", "damping") for name in stiffness}
    expected = {
        "contact patch stiffness": stiffness,
        "contact patch stiffness and damping": stiffness | damping,
        "damper": {"suspension.front.damper.force", "suspension.rear.damper.force"},
        "body stiffness": {"body.front.torsional_stiffness", "body.rear.torsional_stiffness"},
    }
    scaled = {group: sedan.scaled(*names, factor=0.75).parameters for group, names in GROUPS.items()}
    assert {group: set(changed_parameters(found)) for group, found in scaled.items()} == expected


def test_readings_change_what_they_are_named_after(sedan: Model) -> None:
    found = {each.name: each.applied(sedan).parameters for each in READINGS}
    ratios = found["damper tables without their lever ratios"]
    assert {name: ratios.value(name) for name in changed_parameters(ratios)} == {
        "suspension.front.damper.lever_ratio": 1.0,
        "suspension.rear.damper.lever_ratio": 1.0,
    }
    bars = found["anti-roll bars at half the rate"]
    assert {name: bars.value(name) for name in changed_parameters(bars)} == {
        "suspension.front.anti_roll_bar.rate": pytest.approx(2755.0),
        "suspension.rear.anti_roll_bar.rate": pytest.approx(1680.0),
    }


def test_changes_are_differences_with_the_sum_of_the_errors(small_study: StudyResults) -> None:
    for each in (*small_study.sensitivity, *small_study.sweep, *small_study.halved, *small_study.rereadings):
        nominal = small_study.tests[each.outcome.test].metrics
        for name, metric in each.outcome.metrics.items():
            changed = each.outcome.changes[name]
            assert changed.value == metric.value - nominal[name].value
            assert changed.error == metric.error + nominal[name].error > 0


def test_errors_keep_within_the_tolerance(small_study: StudyResults) -> None:
    outcomes = [each.outcome for each in (*small_study.sensitivity, *small_study.sweep)]
    metrics = [record.metrics[name] for record in small_study.tests.values() for name in record.test.metrics]
    for metric in [*metrics, *(metric for found in outcomes for metric in found.metrics.values())]:
        assert metric.error <= small_study.plan.tolerance * metric.value


def test_a_variant_is_the_car_with_its_parameters_changed(small_study: StudyResults, sedan: Model) -> None:
    stiff = sedan.with_parameters({"body.rear.torsional_stiffness": 1e8})
    tolerance = small_study.plan.tolerance
    alone = steady_state(stiff, TESTS["vertical"].excitation, tolerance=1e-2 * tolerance).peak_to_peak
    (found,) = (
        s
        for s in small_study.sweep
        if (s.outcome.test, s.placement, s.stiffness) == ("vertical", "rear", 1e8)
    )
    for name, metric in found.outcome.metrics.items():
        assert metric.value == pytest.approx(alone[name].value, rel=tolerance)


def test_waveforms_are_one_period_of_what_was_measured(small_study: StudyResults) -> None:
    for record in small_study.tests.values():
        assert record.time_s[-1] == pytest.approx(record.test.excitation.period_s)
        for name, values in record.waveforms.items():
            metric = record.metrics[name]
            assert values[0] == values[-1] and len(values) == len(record.time_s)
            assert np.ptp(values) <= metric.value + metric.error
            assert np.ptp(values) >= 0.99 * metric.value  # the extremes lie between samples


def test_both_sets_of_axes_differ_by_less_than_one_percent_in_what_is_compared(
    small_study: StudyResults,
) -> None:
    for record in small_study.tests.values():
        for name in record.test.metrics:
            own = record.metrics[f"body_axes_{name}"].value
            assert own == pytest.approx(record.metrics[name].value, rel=0.01)


def test_equations_are_summarised(sedan: Model) -> None:
    summary = summarise(sedan)
    assert summary.degrees_of_freedom == 12
    assert summary.operations == sedan.equations.operations
    assert summary.weight == pytest.approx(9.81 * (3 * 475 + 2 * 48 + 2 * 45))
    forces = sum(static_patch_force(sedan.preloads, axle) for axle in ("front", "rear"))
    assert 2 * forces == pytest.approx(summary.weight, rel=1e-12)
    assert summary.design_residual < 1e-9


def test_changed_parameters_are_named(sedan: Model) -> None:
    assert changed_parameters(sedan.parameters) == ()
    changed = sedan.parameters.replace({"gravity": "9.80665 m/s^2", "body.front.mass": 475.0})
    assert changed_parameters(changed) == ("gravity",)


# Free torsion


def test_free_torsion_of_equal_sections_is_root_k_over_i_and_root_three_times_that(sedan: Model) -> None:
    values = sedan.parameters.flat()
    first = math.sqrt(values["body.front.torsional_stiffness"] / values["body.front.inertia.xx"]) / (
        2 * math.pi
    )
    expected = 0.0, first, math.sqrt(3) * first
    np.testing.assert_allclose(free_torsion_frequencies(sedan.parameters), expected, atol=1e-4)


def test_free_torsion_of_unequal_sections(sedan: Model) -> None:
    changes = {"body.front.torsional_stiffness": 2e6, "body.rear.inertia.xx": 90.0}
    front, rear = 2e6, sedan.parameters.flat()["body.rear.torsional_stiffness"]
    stiffness = [[front, -front, 0], [-front, front + rear, -rear], [0, -rear, rear]]
    squared = eigh(stiffness, np.diag([126.0, 126.0, 90.0]), eigvals_only=True)
    found = free_torsion_frequencies(sedan.with_parameters(changes).parameters)
    np.testing.assert_allclose(found[1:], np.sqrt(squared[1:]) / (2 * np.pi), rtol=1e-9)


# Wheel rate


@pytest.fixture(scope="module")
def off_axis(sedan: Model) -> Model:
    """A car whose patches do not lie under the wheel centres."""
    changes = {"suspension.front.contact_patch.y": -0.80, "suspension.rear.contact_patch.y": -0.70}
    return sedan.with_parameters(changes)


def statics(car: Model, axle: str, travel: float) -> float:
    """Patch force at a travel, from moments about the pivot of the left arm by rotated points."""
    values = car.parameters.flat()
    place = f"suspension.{axle}"
    pivot, centre, patch = (
        np.array([values[f"{place}.{name}.{axis}"] for axis in "yz"])
        for name in ("arm_pivot", "wheel_centre", "contact_patch")
    )

    def moved(point: np.ndarray, angle: float) -> np.ndarray:
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return pivot + turn @ (point - pivot)

    angle = brentq(lambda a: moved(centre, a)[1] - centre[1] - travel, -0.1, 0.1, xtol=1e-15)
    wheel_rate = values[f"{place}.spring.rate"] / values[f"{place}.spring.lever_ratio"] ** 2
    weight = values["gravity"] * values[f"{place}.unsprung.mass"]
    load = car.preloads[f"{axle}_left_spring.preload"] + weight + wheel_rate * travel
    levers = moved(centre, angle)[0] - pivot[0], moved(patch, angle)[0] - pivot[0]
    return float(load * levers[0] / levers[1])


@pytest.mark.parametrize("axle", ["front", "rear"])
@pytest.mark.parametrize("car_name", ["sedan", "off_axis"])
def test_closed_form_is_the_slope_of_statics(
    car_name: str, axle: str, request: pytest.FixtureRequest
) -> None:
    car = request.getfixturevalue(car_name)
    force = static_patch_force(car.preloads, axle)
    assert statics(car, axle, 0.0) == pytest.approx(force, rel=1e-9)
    step = 1e-4
    slope = (statics(car, axle, step) - statics(car, axle, -step)) / (2 * step)
    assert closed_form(car.parameters, axle, force) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("car_name", ["sedan", "off_axis"])
def test_small_travel_measures_the_closed_form(car_name: str, request: pytest.FixtureRequest) -> None:
    car = request.getfixturevalue(car_name)
    for rate in measure_wheel_rates(car, amplitude_m=1e-3).values():
        assert rate.slope == pytest.approx(rate.closed_form, rel=1e-4)


def test_without_static_load_the_spring_alone_is_measured(small_study: StudyResults) -> None:
    for axle, rate in small_study.wheel_rates["without the static load"].items():
        assert rate.slope == pytest.approx(spring_rate(small_study.parameters, axle), rel=2e-4)
        assert abs(rate.load_stiffness) < 1e-3


def test_large_travel_follows_statics(small_study: StudyResults, sedan: Model) -> None:
    for axle, rate in small_study.wheel_rates["with the static load"].items():
        assert rate.travel.max() > 0.044
        # What is left is the dampers' force at 5 mm/s, at most.
        expected = np.array([statics(sedan, axle, travel) for travel in rate.travel[::32]])
        assert np.abs(rate.force[::32] - expected).max() < 30


# Heave


def test_lost_contact_is_marked_and_peaks_are_read(small_study: StudyResults) -> None:
    heave = small_study.heave
    assert heave.without_contact_hz == [9.0, 9.5]
    assert heave.peak_hz("body") == 1.0
    unsolved = replace(heave, points=tuple(replace(p, amplitudes={}, reason="no") for p in heave.points))
    assert math.isnan(unsolved.peak_hz("body"))


def test_linear_heave_at_its_lowest_frequency_follows_the_pads(sedan: Model) -> None:
    from chassym.heave import AMPLITUDE_M, run_heave
    from chassym.linear import linearise

    found = run_heave(sedan, linearise(sedan), (0.02, 0.03), 1e-3, lambda what: None)
    for what, amplitudes in found.linear_amplitudes.items():
        assert amplitudes[0] == pytest.approx(AMPLITUDE_M, rel=2e-3)
        assert found.points[0].amplitudes[what] == pytest.approx(AMPLITUDE_M, rel=2e-3)


# Failures


@pytest.fixture
def nothing_above_a_million(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every steady state fail with a front stiffness above 1e6 N m/rad other than the nominal one."""

    def limited(model: Model, *arguments: object, **options: object) -> object:
        if 1e6 < model.values[PLACES["front"][0]] != 5e6:
            raise NoPeriodicOrbitError("too stiff for this test")
        return steady_state(model, *arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(rig_tests, "steady_state", limited)


@pytest.mark.usefixtures("nothing_above_a_million")
def test_failed_points_are_kept_with_the_reason(small_study: StudyResults, sedan: Model) -> None:
    runner = VariantRunner(sedan, small_study.tests, 1e-4, lambda what: None)
    sweep = list(runner.sweep((1e5, 1e6, 1e7, 1e8)))
    failed = {(s.placement, s.stiffness) for s in sweep if s.outcome.reason}
    assert failed == {(place, stiffness) for place in ("front", "both") for stiffness in (1e7, 1e8)}
    for each in sweep:
        if each.outcome.reason:
            assert each.outcome.reason == "too stiff for this test"
            assert not each.outcome.metrics and not each.outcome.is_sound
            assert math.isnan(each.outcome.minimum_patch_force)
        else:
            assert each.outcome.is_sound and len(each.outcome.metrics) == 3
    spans = [each for each in sweep_spans(sweep) if "front stiffness sweep: largest lateral" in each.quantity]
    solved = [s.outcome.metrics["lateral_acceleration"].value for s in sweep[:2]]
    assert spans[0].computed == max(solved)
    results = replace(small_study, sweep=tuple(sweep))
    assert len(results.failures) == len([s for s in sweep if s.outcome.reason])
    assert ("lateral test, front body stiffness 1e+07 N m/rad", "too stiff for this test") in results.failures


def test_what_was_not_solved_is_not_judged(small_study: StudyResults) -> None:
    failed = Outcome("lateral", {}, {}, math.nan, math.nan, "no luck")
    found = list(trends(small_study.tests, [Stiffened("front", 2.5e6, failed)]))
    assert [each.verdict for each in found] == [NOT_SOLVED] * 3
    assert all(math.isnan(each.computed) for each in found)
    assert all(each.verdict == NOT_SOLVED for each in sweep_spans([Stiffened("front", 1e5, failed)]))


def test_a_start_that_leads_nowhere_is_replaced_by_rest(
    small_study: StudyResults, sedan: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    def only_from_rest(*arguments: object, start: object = None, **options: object) -> object:
        if start is not None:
            raise NoPeriodicOrbitError("misled")
        return steady_state(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(rig_tests, "steady_state", only_from_rest)
    record = small_study.tests["lateral"]
    found, orbit = outcome(sedan, record, 1e-4, [record.orbit])
    assert orbit is not None and not found.reason
    assert all(abs(changed.value) <= changed.error for changed in found.changes.values())


# Verdicts


@given(st.floats(-10, 10), st.floats(0, 1))
def test_a_verdict_says_where_the_value_is(computed: float, error: float) -> None:
    found = compare("topic", "quantity", RANGE, computed, error)
    if RANGE.low <= computed <= RANGE.high:
        assert found.verdict == "inside" and found.deviation == 0
    elif RANGE.low - error <= computed <= RANGE.high + error:
        assert found.verdict == "inside within the error"
    else:
        side, end = ("below", 2.0) if computed < 2 else ("above", 4.0)
        assert found.verdict.startswith("outside by ") and found.verdict.endswith(f"({side})")
        assert found.deviation == pytest.approx((computed - end) / end)


def test_what_could_not_be_computed_is_said_so() -> None:
    assert compare("topic", "quantity", RANGE, math.nan).verdict == NOT_SOLVED


@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        (0.5, 0.1, thesis.INCREASES),
        (-0.5, 0.1, thesis.DECREASES),
        (0.1, 0.1, UNDECIDED),
        (-0.05, 0.1, UNDECIDED),
        (0.05, 0.01, thesis.HARDLY_CHANGES),
        (-0.05, 0.01, thesis.HARDLY_CHANGES),
    ],
)
def test_direction_of_a_change(value: float, error: float, expected: str) -> None:
    assert direction(Metric(value, "m", error), Metric(100.0, "m", 0.0)) == expected


def test_a_change_of_nothing_is_undecided() -> None:
    metric = Metric(1.0, "m", 1e-4)
    assert direction(change(metric, metric), metric) == UNDECIDED


def test_a_wheel_that_cannot_travel_has_no_rate(sedan: Model) -> None:
    pivot = {"suspension.front.arm_pivot.y": -0.744, "suspension.front.arm_pivot.z": 0.0}
    with pytest.raises(WheelRateError, match="front wheels do not travel"):
        measure_wheel_rates(sedan.with_parameters(pivot))
