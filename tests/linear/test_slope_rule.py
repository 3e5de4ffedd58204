"""Slopes that stand for tables: against differences and integrals of the tables' forces."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from chassym.derivation import Model, TableNumbers
from chassym.linear import linearise
from chassym.linear.slope_rule import (
    DescribingFunction,
    Secant,
    SlopeRule,
    SlopeRuleError,
    StatisticalSlope,
    find_slope_rule,
    left_slope,
    mean_slope,
    right_slope,
    slope_of,
)

Array = np.ndarray
Force = Callable[[Array], Array]

PLACES = np.array([-0.9, -0.3, 0.0, 0.2, 1.1])
FORCES = np.array([-700.0, -500.0, 40.0, 90.0, 800.0])
SLOPES = np.diff(FORCES) / np.diff(PLACES)
TABLE = TableNumbers(PLACES[1:-1, None], SLOPES[:, None])

MOTIONS = [
    Secant(0.25),
    Secant(-1.7),
    DescribingFunction(0.15),
    DescribingFunction(2.0),
    StatisticalSlope(0.3),
]
RULES = [left_slope, right_slope, mean_slope, *MOTIONS]


@pytest.fixture
def force(table_force: Callable[[Array, Array, Array], Array]) -> Force:
    return lambda rate: table_force(np.asarray(rate, dtype=float), PLACES, FORCES)


def slope(rule: SlopeRule, place: float = 0.0) -> float:
    return float(slope_of(TABLE, rule, place)[0])


def knots_on(motion: Callable[[float], float], start: float, end: float) -> list[float]:
    """Where a monotonous motion passes the table's knots."""
    grid = np.linspace(start, end, 20001)
    passed = np.array([motion(t) for t in grid])
    order = np.argsort(passed)
    inside = [k for k in PLACES[1:-1] if passed.min() < k < passed.max()]
    return np.interp(inside, passed[order], grid[order]).tolist()


@pytest.mark.parametrize("place", [-2.0, -0.3, -0.1, 0.0, 0.2, 0.6])
def test_rules_at_knots_are_one_sided_differences(force: Force, place: float) -> None:
    step = 1e-4
    before = (force(place) - force(place - step)) / step
    after = (force(place + step) - force(place)) / step
    assert slope(left_slope, place) == pytest.approx(before, rel=1e-9)
    assert slope(right_slope, place) == pytest.approx(after, rel=1e-9)
    central = (force(place + step) - force(place - step)) / (2 * step)
    assert slope(mean_slope, place) == pytest.approx(central, rel=1e-9)


@pytest.mark.parametrize("place", [-0.6, 0.0, 0.15])
@pytest.mark.parametrize("reach", [-3.0, -0.3, -0.01, 0.05, 0.2, 2.5])
def test_secant_is_the_rise_over_the_way(force: Force, place: float, reach: float) -> None:
    expected = (force(place + reach) - force(place)) / reach
    assert slope(Secant(reach), place) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("place", [-0.6, 0.0, 0.15])
@pytest.mark.parametrize("amplitude", [0.01, 0.2, 0.5, 4.0])
def test_describing_function_is_the_first_harmonic(force: Force, place: float, amplitude: float) -> None:
    """Over half a period place + a cos t passes every rate once: 2 / (pi a) times the integral of F cos t."""

    def motion(angle: float) -> float:
        return place + amplitude * float(np.cos(angle))

    integral, _ = quad(
        lambda t: force(motion(t)) * np.cos(t), 0, np.pi, points=knots_on(motion, 0, np.pi) or None, limit=200
    )
    assert slope(DescribingFunction(amplitude), place) == pytest.approx(
        2 * integral / (np.pi * amplitude), rel=1e-7
    )


def test_describing_function_of_a_dead_zone() -> None:
    """N(a) = k (2/pi) (pi/2 - asin(d/a) - d/a sqrt(1 - d^2/a^2)); Gelb and Vander Velde, appendix B."""
    width, stiffness = 0.3, 50.0
    dead_zone = TableNumbers(np.array([[-width], [width]]), np.array([[stiffness], [0.0], [stiffness]]))
    for amplitude in (0.31, 0.5, 3.0):
        part = width / amplitude
        expected = stiffness * (1 - 2 / np.pi * (np.arcsin(part) + part * np.sqrt(1 - part**2)))
        assert slope_of(dead_zone, DescribingFunction(amplitude), 0.0)[0] == pytest.approx(
            expected, rel=1e-12
        )
    assert slope_of(dead_zone, DescribingFunction(0.3), 0.0)[0] == 0.0


@pytest.mark.parametrize("place", [-0.6, 0.0, 0.15])
def test_statistical_slope_is_the_least_wrong(force: Force, place: float) -> None:
    """E[x F(place + x)] / E[x^2] of a Gaussian x."""
    rms = 0.4
    points = [k - place for k in PLACES[1:-1]]
    integral, _ = quad(
        lambda x: x * force(place + x) * norm.pdf(x, scale=rms), -4, 4, points=points, limit=200
    )
    assert slope(StatisticalSlope(rms), place) == pytest.approx(integral / rms**2, rel=1e-9)


@pytest.mark.parametrize("rule", [DescribingFunction, StatisticalSlope])
def test_small_motions_have_the_mean_slope_and_wide_ones_that_of_the_ends(rule: Callable) -> None:
    assert slope(rule(1e-6)) == pytest.approx(slope(mean_slope), rel=1e-5)
    assert slope(rule(1e6)) == pytest.approx((SLOPES[0] + SLOPES[-1]) / 2, rel=1e-5)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_a_straight_table_has_one_slope(rule: SlopeRule) -> None:
    straight = TableNumbers(np.array([[-0.2], [0.0], [0.7]]), np.full((4, 1), 123.0))
    for place in (-0.5, 0.0, 0.3):
        assert slope_of(straight, rule, place)[0] == 123.0


@pytest.mark.parametrize("rule", MOTIONS, ids=lambda rule: rule.name)
def test_density_is_the_fall_of_the_share(rule: SlopeRule) -> None:
    distances = np.array([-2.3, -0.4, -0.11, 0.07, 0.13, 0.6, 1.9])
    step = 1e-6
    fall = (rule.share_beyond(distances - step) - rule.share_beyond(distances + step)) / (2 * step)
    np.testing.assert_allclose(rule.density(distances), fall, atol=1e-8)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_names_are_read_back(rule: SlopeRule) -> None:
    assert find_slope_rule(rule.name) == rule


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Secant(0.0), "secant_slope: reach 0.0 received"),
        (lambda: Secant(np.inf), "secant_slope: reach inf received"),
        (lambda: DescribingFunction(-0.1), "describing_function: amplitude -0.1 received"),
        (lambda: StatisticalSlope(0.0), "statistical_slope: rms 0.0 received"),
        (lambda: find_slope_rule("meen"), r"'meen' is unknown \(near: mean\); expected left, right"),
        (lambda: find_slope_rule("secant"), "'secant' is unknown"),
        (lambda: find_slope_rule("secant(fast)"), "'fast' is no number"),
        (lambda: find_slope_rule("secant(0)"), "reach 0.0 received"),
    ],
)
def test_impossible_rules_are_refused_in_one_line(make: Callable[[], object], message: str) -> None:
    with pytest.raises(SlopeRuleError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


# Rules in linear models


def test_slopes_of_the_reference_car_at_rest(sedan: Model) -> None:
    """The printed points over the lever ratios squared: 3912 in rebound, 978 in jounce at the front."""
    value = sedan.parameters.flat()
    found = {rule.name: linearise(sedan, rule) for rule in (left_slope, right_slope, mean_slope)}
    for axle, printed in (("front", (3912, 978)), ("rear", (1925, 740))):
        place = f"suspension.{axle}.damper"
        ratio = value[f"{place}.lever_ratio"] ** 2
        rebound = value[f"{place}.force[1]"] / value[f"{place}.velocity[1]"] / ratio
        jounce = value[f"{place}.force[3]"] / value[f"{place}.velocity[3]"] / ratio
        np.testing.assert_allclose((rebound, jounce), printed, rtol=5e-4)
        expected = {"left_slope": rebound, "right_slope": jounce, "mean_slope": (rebound + jounce) / 2}
        for side in ("left", "right"):
            for rule, linear in found.items():
                assert linear.slopes[f"{axle}_{side}_damper"] == pytest.approx(expected[rule], rel=1e-14)
    mean, right = found["mean_slope"], found["right_slope"]
    assert mean.slope_rule == "mean_slope" and right.slope_rule == "right_slope"
    assert "mean_slope" in str(mean) and "front_left_damper 2445.11" in str(mean)
    # The slope reaches the equations: only C changes, by the difference of slopes along the wheels' travel.
    travel = mean.output_by_coordinates[[mean.outputs.index(f"{s[:-7]}_wheel_travel") for s in mean.slopes]]
    less = np.array([mean.slopes[name] - right.slopes[name] for name in mean.slopes])
    np.testing.assert_allclose(mean.damping - right.damping, travel.T * less @ travel, atol=1e-9)
    np.testing.assert_array_equal(mean.stiffness, right.stiffness)


def test_every_element_may_have_a_rule_of_its_own(sedan: Model) -> None:
    rules = {
        "front_left_damper": left_slope,
        "front_right_damper": Secant(0.15),
        "rear_left_damper": DescribingFunction(0.2),
        "rear_right_damper": mean_slope,
    }
    mixed = linearise(sedan, rules)
    for element, rule in rules.items():
        assert mixed.slopes[element] == linearise(sedan, rule).slopes[element]
        assert mixed.slope_rules[element] == rule.name
    assert mixed.slope_rule == "left_slope, secant_slope(0.15), describing_function(0.2), mean_slope"
    with pytest.raises(SlopeRuleError, match="none for element 'rear_right_damper'"):
        linearise(sedan, {name: rule for name, rule in rules.items() if name != "rear_right_damper"})


def test_a_function_of_two_slopes_is_no_rule(quarter_car: Model) -> None:
    with pytest.raises(SlopeRuleError, match="is no rule; expected left_slope, right_slope"):
        linearise(quarter_car, min)  # type: ignore[arg-type]


def test_a_rule_without_a_finite_slope_is_refused(quarter_car: Model) -> None:
    class Nowhere:
        name = "nowhere"

        def share_beyond(self, distance: Array) -> Array:
            return np.full_like(distance, np.nan)

        def density(self, distance: Array) -> Array:
            return np.zeros_like(distance)

    with pytest.raises(SlopeRuleError, match="'nowhere' gave nan; a finite slope is needed"):
        linearise(quarter_car, Nowhere())
