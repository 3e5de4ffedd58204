"""Oscillators with piecewise-linear springs and dampers against periodic motions pieced together exactly.

- The method, and the bilinear spring: S. W. Shaw and P. J. Holmes, "A periodically forced piecewise linear
  oscillator", Journal of Sound and Vibration 90 (1983) 129-155. Free vibrations of a bilinear spring have the
  frequency 2 w_1 w_2 / (w_1 + w_2), whatever their amplitude is.
- Two masses, one of which meets a spring: M. Krack and J. Gross, Harmonic Balance for Nonlinear Vibration
  Problems, Springer 2019, and example 3 of their program NLvib, which has turning points in the curve of
  amplitudes over frequency, period doublings and Neimark-Sacker bifurcations.

A base that moves u = a cos(w t) drives every oscillator through its springs and dampers, which are functions
of s = x - u and s': m s'' + f(s) + g(s') = - m u'' - weight.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import islice, pairwise

import numpy as np
import pytest
import sympy
from scipy.optimize import brentq, root

from chassym.derivation import (
    ContactForce,
    DamperTable,
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    PointDisplacement,
    SpringTable,
    TravelPort,
    Unilateral,
    build_model,
    prismatic,
)
from chassym.nonlinear import FourierOrbit, Harmonic, SteadyState, simulate, steady_state
from chassym.nonlinear.continuation.arclength import Tracer
from chassym.nonlinear.continuation.continuation import first_orbit, follow
from chassym.nonlinear.continuation.paths import FrequencyPath
from chassym.nonlinear.harmonics.subharmonics import subharmonic_orbit

from .exact_pieces import ExactOrbit, Piece, PiecewiseLinear, Signs

Array = np.ndarray

GRAVITY = 9.81

TOLERANCE = 1e-8
"""Asked of the steady states."""

MULTIPLIER_TOLERANCE = 1e-7


START = np.array([1e-3, 2e-3])
"""A state from which orbits settle; at rest it would be on the knots."""


# Laws


@dataclass(frozen=True)
class Law:
    """A continuous law through the origin: slopes between knots."""

    knots: tuple[float, ...]
    slopes: tuple[float, ...]

    def force(self, place: float) -> float:
        """Its value: the integral of the slope from zero."""
        ends = [-np.inf, *self.knots, np.inf]
        return float(
            sum(
                slope * (np.clip(place, low, high) - np.clip(0.0, low, high))
                for slope, (low, high) in zip(self.slopes, pairwise(ends), strict=True)
            )
        )

    @property
    def points(self) -> tuple[list[float], list[float]]:
        """Places and forces of a table that continues its end segments."""
        inner = self.knots or (0.0,)
        places = [inner[0] - 1.0, *self.knots, inner[-1] + 1.0]
        return places, [self.force(place) for place in places]

    def line(self, signs: Sequence[bool]) -> tuple[float, float]:
        """Slope, and force at zero, of the piece that is beyond as many knots as signs are true."""
        slope = self.slopes[sum(signs)]
        if not self.knots:
            return slope, 0.0
        knot = self.knots[max(sum(signs) - 1, 0)]
        return slope, self.force(knot) - slope * knot


def straight(slope: float) -> Law:
    return Law((), (slope,))


@dataclass(frozen=True)
class Oscillator:
    """A mass on a base that moves."""

    spring: Law
    damper: Law
    mass: float
    amplitude: float
    frequency_hz: float

    @property
    def excitation(self) -> Harmonic:
        return Harmonic(self.frequency_hz, {"base": self.amplitude})

    @property
    def push(self) -> float:
        """Amplitude of -u''."""
        return self.amplitude * self.excitation.angular_frequency**2

    def exact(self) -> PiecewiseLinear:
        springs, dampers = np.array(self.spring.knots), np.array(self.damper.knots)
        count = len(springs)
        switches = np.zeros((count + len(dampers), 5))
        switches[:count, 0], switches[:count, 2] = 1, -springs
        switches[count:, 1], switches[count:, 2] = 1, -dampers

        def rates(signs: Signs) -> Array:
            stiffness, at_rest = self.spring.line(signs[:count])
            damping, still = self.damper.line(signs[count:])
            second = np.array([stiffness, damping, at_rest + still, 0, 0]) / -self.mass
            second[3] = self.push
            return np.array([[0, 1, 0, 0, 0], second])

        return PiecewiseLinear(self.excitation.angular_frequency, switches, rates)

    def displacement(self, piece: Piece) -> Array:
        """x = s + u as a row."""
        return np.array([1, 0, 0, self.amplitude, 0])

    def acceleration(self, piece: Piece) -> Array:
        """x'' = s'' + u'' as a row."""
        return piece.matrix[1] - [0, 0, 0, self.push, 0]

    def model(self) -> Model:
        return suspended(self.spring, self.damper, self.mass)

    def state(self, orbit: ExactOrbit) -> Array:
        """Coordinate and rate of the model at time zero."""
        return orbit.state + [self.amplitude, 0]


@cache
def suspended(spring: Law, damper: Law, mass: float) -> Model:
    """Give the model of a mass on a base; laws of as many points are other values of the same parameters."""
    tables = {"spring": spring.points, "damper": damper.points}
    values = {"mass": mass} | {
        f"{name}_{kind}_{i}": value
        for name, points in tables.items()
        for kind, column in zip(("place", "force"), points, strict=True)
        for i, value in enumerate(column)
    }
    return build_model(on_a_base(len(spring.points[0]), len(damper.points[0])), values)


@cache
def on_a_base(spring_points: int, damper_points: int) -> Mechanism:
    def table(name: str, count: int) -> list[list[sympy.Symbol]]:
        return [
            [sympy.Symbol(f"{name}_{kind}_{i}", real=True) for i in range(count)]
            for kind in ("place", "force")
        ]

    mechanism = Mechanism("suspended", gravity=0)
    mass = sympy.Symbol("mass", positive=True)
    body = mechanism.add_body("body", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=mass)
    point = mechanism.point("centre", body, (0, 0, 0))
    port = TravelPort(point, mechanism.ground, "z").less(mechanism.add_input("base", "m"))
    mechanism.add_force_element("spring", port, SpringTable(*table("spring", spring_points)))
    mechanism.add_force_element("damper", port, DamperTable(*table("damper", damper_points)))
    mechanism.add_output(PointDisplacement("displacement", point, "z", mechanism.ground))
    mechanism.add_output(PointAcceleration("acceleration", point, "z", mechanism.ground))
    return mechanism


BILINEAR = Oscillator(Law((0.0,), (200.0, 500.0)), straight(2.0), 1.0, 0.05, 1.5)
BUMP_AND_REBOUND = Oscillator(straight(20e3), Law((0.0,), (978.0, 3912.0)), 350.0, 0.02, 1.6)
CLEARANCE = Oscillator(Law((-0.01, 0.01), (4e3, 200.0, 4e3)), straight(30.0), 10.0, 0.02, 2.6)
PROGRESSIVE = Oscillator(
    Law((-0.03, 0.02), (90e3, 18e3, 45e3)),
    Law((-0.3, -0.05, 0.0, 0.1), (600.0, 1500.0, 3000.0, 5000.0, 900.0)),
    400.0,
    0.03,
    2.1,
)

CASES = {
    "bilinear spring": BILINEAR,
    "bump and rebound": BUMP_AND_REBOUND,
    "clearance": CLEARANCE,
    "bump stops and a damper table": PROGRESSIVE,
}


def found(case: Oscillator, tolerance: float = TOLERANCE, start: FourierOrbit | None = None) -> SteadyState:
    return steady_state(
        case.model(),
        case.excitation,
        metrics=["displacement", "acceleration"],
        tolerance=tolerance,
        start=start,
        subharmonic=1 if start is None else start.subharmonic,
    )


def agree_in_stability(found: Array, expected: ExactOrbit, tolerance: float = MULTIPLIER_TOLERANCE) -> None:
    np.testing.assert_allclose(
        np.sort_complex(found),
        np.sort_complex(expected.multipliers),
        atol=tolerance * np.abs(expected.multipliers).max(),
    )


def agree(steady: SteadyState, expected: ExactOrbit, case: Oscillator) -> None:
    """All that a steady state tells beside the same exactly."""
    for name, row in (("displacement", case.displacement), ("acceleration", case.acceleration)):
        metric, exact = steady.peak_to_peak[name], expected.peak_to_peak(row)
        assert metric.value == pytest.approx(exact, rel=TOLERANCE)
    state = case.state(expected)
    np.testing.assert_allclose(steady.orbit.state(), state, atol=10 * TOLERANCE * np.abs(state).max())
    np.testing.assert_allclose(
        steady.orbit.harmonic_content(5)[0],
        expected.harmonics(case.displacement, 5),
        atol=TOLERANCE * steady.peak_to_peak["displacement"].value,
    )
    agree_in_stability(steady.multipliers, expected)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
@pytest.mark.parametrize("ratio", [0.45, 1.0, 1.7])
def test_orbit_and_multipliers_are_exact(case: Oscillator, ratio: float) -> None:
    """Below, near and above resonance."""
    moved = Oscillator(case.spring, case.damper, case.mass, case.amplitude, ratio * case.frequency_hz)
    expected = moved.exact().orbit(START, settle=40)
    assert expected.switchings >= 2
    agree(found(moved), expected, moved)


def at_random(generator: np.random.Generator) -> Oscillator:
    """Give two knots each to a spring and a damper that the motion passes or not."""

    def between(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))

    natural = between(10, 100)
    spring = Law(
        tuple(np.sort(generator.uniform(-0.03, 0.03, 2)).tolist()),
        tuple(natural**2 * between(0.4, 3) for _ in range(3)),
    )
    damper = Law(
        tuple(np.sort(generator.uniform(-0.01, 0.01, 2) * natural).tolist()),
        tuple(natural * between(0.1, 1.2) for _ in range(3)),
    )
    return Oscillator(spring, damper, 1.0, between(0.005, 0.05), natural / (2 * np.pi) * between(0.3, 2.5))


@cache
def random_orbits() -> tuple[tuple[Oscillator, ExactOrbit], ...]:
    generator, orbits = np.random.default_rng(1), []
    while len(orbits) < 30:
        case = at_random(generator)
        try:
            expected = case.exact().orbit(START, settle=8)
        except RuntimeError:  # it has not settled, or repeats later
            continue
        if expected.switchings > 1 and np.abs(expected.multipliers[0]) < 0.97:
            orbits.append((case, expected))
    return tuple(orbits)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_stated_errors_cover_the_true_ones(tolerance: float) -> None:
    """In 95 of 100 metrics; and the others are not far off."""
    ratios = []
    for case, expected in random_orbits():
        steady = found(case, tolerance)
        for name, row in (("displacement", case.displacement), ("acceleration", case.acceleration)):
            metric, exact = steady.peak_to_peak[name], expected.peak_to_peak(row)
            assert metric.value == pytest.approx(exact, rel=10 * tolerance)
            ratios.append(abs(metric.value - exact) / metric.error)
    assert np.mean(np.array(ratios) <= 1) >= 0.95
    assert np.median(ratios) > 1e-2, "a stated error is no use if it is a hundred times the true one"


@pytest.mark.parametrize("ratio", [20.0, 180.0])
@pytest.mark.parametrize("beyond", [-1e-4, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_a_stop_that_is_hardly_touched(ratio: float, beyond: float, tolerance: float) -> None:
    """Contact takes 1 to 10 % of the period, or none, and its stiffness makes accelerations of any error."""
    natural, damping_ratio, share, knot = 20.0, 0.02, 0.8, 0.01
    linear = abs(share**2 / (1 - share**2 + 2j * damping_ratio * share))
    spring = Law((-knot, knot), tuple(natural**2 * np.array([ratio, 1.0, ratio])))
    damper, frequency_hz = straight(2 * damping_ratio * natural), natural * share / (2 * np.pi)
    case = Oscillator(spring, damper, 1.0, knot / linear * (1 + beyond), frequency_hz)
    steady = found(case, tolerance)
    expected = case.exact().orbit(steady.orbit.state() - [case.amplitude, 0])
    assert expected.switchings == (4 if beyond > 0 else 0)
    for name, row in (("displacement", case.displacement), ("acceleration", case.acceleration)):
        metric, exact = steady.peak_to_peak[name], expected.peak_to_peak(row)
        assert metric.value == pytest.approx(exact, abs=metric.error)
    if tolerance < 1e-3:
        agree_in_stability(steady.multipliers, expected, tolerance=1e-3)


def test_a_contact_of_a_six_hundredth_of_the_period_is_seen() -> None:
    """It makes the orbit unstable; steps and pieces are many times as long."""
    spring = Law((0.00988747808841165,), (5029.688438643712, 200676.82442290572))
    case = Oscillator(spring, straight(0.9545780659510497), 1.0, 0.01, 7.959108430592895)
    steady = found(case, 1e-5)
    expected = case.exact().orbit(steady.orbit.state() - [case.amplitude, 0])
    assert expected.switchings == 2
    for name, row in (("displacement", case.displacement), ("acceleration", case.acceleration)):
        metric = steady.peak_to_peak[name]
        assert metric.value == pytest.approx(expected.peak_to_peak(row), abs=metric.error)
    assert np.abs(expected.multipliers[0]) > 1 and not steady.is_stable
    times, state = np.array([0.0, case.excitation.period_s]), case.state(expected)
    moved = simulate(case.model(), case.excitation, times, start=state, relative_tolerance=1e-11)
    np.testing.assert_allclose(moved.states[:, -1], state, atol=1e-7 * np.abs(state).max())


STEEP = [
    Oscillator(
        Law((-0.01573524349, 0.01573524349), (56876.3164, 503.90641, 29102.86764)),
        straight(7.9905438295),
        1.0,
        0.0982386487545,
        9.074607664,
    ),
    Oscillator(
        Law((0.02444439158057535,), (38.813173872987974, 307363.87661951786)),
        straight(0.22736486382943774),
        1.0,
        0.01,
        1.2875764160762058,
    ),
]
"""Stops a hundred times and more as stiff, where rough orbits that touch them otherwise miss their starts."""


@pytest.mark.parametrize("case", STEEP, ids=["clearance", "stop"])
def test_what_is_found_while_knots_still_come_and_go_is_not_taken_for_an_orbit(case: Oscillator) -> None:
    steady = found(case, 1e-2)
    expected = case.exact().orbit(steady.orbit.state() - [case.amplitude, 0])
    for name, row in (("displacement", case.displacement), ("acceleration", case.acceleration)):
        metric = steady.peak_to_peak[name]
        assert metric.value == pytest.approx(expected.peak_to_peak(row), abs=metric.error)
    assert steady.is_stable == (np.abs(expected.multipliers[0]) < 1)


def test_a_law_that_bends_at_the_origin_scales() -> None:
    """With the knots at zero the orbit grows as the excitation, and the multipliers stay."""
    spring, damper = Law((0.0,), (200.0, 700.0)), Law((0.0,), (1.0, 6.0))
    small, large = (found(Oscillator(spring, damper, 1.0, size, 2.3)) for size in (1e-3, 1.0))
    np.testing.assert_allclose(large.orbit.state(), 1e3 * small.orbit.state(), rtol=1e-7)
    np.testing.assert_allclose(large.multipliers, small.multipliers, rtol=1e-7)
    for name, metric in small.peak_to_peak.items():
        assert large.peak_to_peak[name].value == pytest.approx(1e3 * metric.value, rel=1e-7)


@pytest.mark.parametrize("ratio", [2.0, 9.0])
def test_resonance_of_a_bilinear_spring(ratio: float) -> None:
    """With little damping it is at the frequency of free vibrations, 2 w_1 w_2 / (w_1 + w_2)."""
    soft, hard = 100.0, 100.0 * ratio
    free = 2 / (soft**-0.5 + hard**-0.5) / (2 * np.pi)
    bilinear = Law((0.0,), (soft, hard))

    def lag(frequency_hz: float) -> float:
        """In-phase part of the first harmonic of s, which vanishes at resonance."""
        case = Oscillator(bilinear, straight(0.2), 1.0, 0.01, frequency_hz)
        steady = found(case, tolerance=1e-3)
        return float((steady.orbit.harmonic_content(1)[0, 1] - case.amplitude).real)

    assert brentq(lag, 0.97 * free, 1.03 * free, rtol=1e-6) == pytest.approx(free, rel=1e-3)


# A spring of two slopes beyond twice its resonance: the orbit gives way to one of twice the period

DOUBLING = {"spring": Law((0.0,), (100.0, 900.0)), "damper": straight(1.0), "mass": 1.0, "amplitude": 0.05}


def doubling(frequency_hz: float) -> Oscillator:
    return Oscillator(**DOUBLING, frequency_hz=frequency_hz)  # type: ignore[arg-type]


@cache
def doubling_frequency() -> float:
    """Where a multiplier passes -1, exactly."""

    def beyond(frequency_hz: float) -> float:
        orbit = doubling(frequency_hz).exact().orbit(START, settle=30)
        return float(np.linalg.det(orbit.monodromy + np.eye(2)))

    return float(brentq(beyond, 3.5, 3.75, xtol=1e-10))


@pytest.mark.parametrize("side", [-1, 1])
def test_stability_is_lost_where_the_period_doubles(side: int) -> None:
    """One part in a thousand before and after it."""
    case = doubling(doubling_frequency() * (1 + 1e-3 * side))
    expected = case.exact().orbit(START, settle=30)
    steady = found(case)
    agree(steady, expected, case)
    assert steady.is_stable == (side < 0)
    assert steady.multipliers[0].real == pytest.approx(-1, abs=0.05)


@pytest.mark.parametrize("frequency_hz", [4.0, 4.5, 5.0, 7.0])
def test_orbits_of_twice_the_period(frequency_hz: float) -> None:
    """Found without a hint; at 7 Hz they are unstable, too."""
    case, harmonics = doubling(frequency_hz), 60
    orbit = subharmonic_orbit(case.model(), case.excitation, 2, harmonics=harmonics).orbit
    expected = case.exact().orbit(orbit.state() - [case.amplitude, 0], periods=2)
    exact = expected.harmonics(case.displacement, 8)
    assert abs(exact[1]) > 0.1 * abs(exact[2])
    # Corners of the forces leave coefficients in error as 1 / H^3.
    atol = 2 * np.abs(exact[1:]).max() / harmonics**2
    np.testing.assert_allclose(orbit.coefficients[0, :9], exact, atol=atol)
    steady = found(case, start=orbit)
    agree(steady, expected, case)
    assert steady.is_stable == (np.abs(expected.multipliers[0]) < 1) == (frequency_hz < 6)


# Springs that get stiffer, or softer, beyond a knot on either side


@pytest.mark.parametrize(
    ("slopes", "damping"), [((4e3, 1.5e3, 4e3), 12.0), ((1e3, 3e3, 1e3), 10.0)], ids=["harder", "softer"]
)
@pytest.mark.parametrize(("harmonics", "tolerance"), [(7, 2e-5), (31, 1e-6)])
def test_folds_of_a_trilinear_spring(
    slopes: tuple[float, float, float], damping: float, harmonics: int, tolerance: float
) -> None:
    """The only two beside the exact ones, where the orbit repeats and a multiplier is 1; unstable between."""

    def case(frequency_hz: float) -> Oscillator:
        return Oscillator(Law((-0.01, 0.01), slopes), straight(damping), 10.0, 0.004, frequency_hz)

    def residual(unknown: Array) -> Array:
        system = case(float(unknown[2])).exact()
        orbit = ExactOrbit(system, system.pieces(unknown[:2], system.period))
        gap = orbit.pieces[-1].end[:2] - unknown[:2]
        return np.array([*gap, np.linalg.det(orbit.monodromy - np.eye(2))])

    path = FrequencyPath(case(1.0).model(), case(1.0).excitation)
    branch = follow(path, 1.0, 4.5, harmonics=harmonics)
    assert len(branch.folds) == 2
    for fold in branch.folds:
        near = np.array([*(fold.orbit.state() - [case(1.0).amplitude, 0]), fold.value])
        exact = root(residual, near, tol=1e-12, options={"eps": 1e-8})
        assert np.abs(exact.fun).max() < 1e-10
        assert fold.value == pytest.approx(exact.x[2], rel=tolerance)
    number, (first, last) = np.arange(len(branch.values)), (fold.point for fold in branch.folds)
    expected = (number <= first) | (number > last)
    away = np.min([np.abs(branch.values / fold.value - 1) for fold in branch.folds], axis=0) > tolerance
    assert away.sum() > 140 and np.array_equal(branch.is_stable[away], expected[away])


# Loss of contact


@dataclass(frozen=True)
class Bouncer:
    """A mass that stands on a base by its weight alone, on a spring and a damper that can only push."""

    frequency_hz: float
    amplitude: float = 0.006
    mass: float = 50.0
    stiffness: float = 50e3
    damping: float = 600.0

    @property
    def weight(self) -> float:
        return self.mass * GRAVITY

    def exact(self) -> PiecewiseLinear:
        """Contact ends where the push k s + c s' - m g would become a pull; s = 0 at rest."""
        frequency = 2 * np.pi * self.frequency_hz
        push = self.amplitude * frequency**2
        loads = np.array([self.stiffness, self.damping, -self.weight, 0, 0])

        def rates(signs: Signs) -> Array:
            contact = np.array([-self.stiffness / self.mass, -self.damping / self.mass, 0, push, 0])
            flight = np.array([0, 0, -GRAVITY, push, 0])
            return np.array([[0, 1, 0, 0, 0], flight if signs[0] else contact])

        return PiecewiseLinear(frequency, loads[None], rates)

    def displacement(self, piece: Piece) -> Array:
        return np.array([1, 0, 0, self.amplitude, 0])

    def load(self, piece: Piece) -> Array:
        """The force of the base on the mass."""
        row = np.array([-self.stiffness, -self.damping, self.weight, 0, 0])
        return 0 * row if piece.signs[0] else row

    def model(self) -> Model:
        mechanism = Mechanism("bouncer", gravity=GRAVITY)
        body = mechanism.add_body("body", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=self.mass)
        point = mechanism.point("foot", body, (0, 0, 0))
        port = TravelPort(point, mechanism.ground, "z").less(mechanism.add_input("base", "m"))
        law = Unilateral(Linear(self.stiffness, self.damping))
        foot = mechanism.add_force_element("foot_on_base", port, law, preloaded=True)
        mechanism.add_output(PointDisplacement("displacement", point, "z", mechanism.ground))
        mechanism.add_output(ContactForce("load", foot))
        return build_model(mechanism, {})


@pytest.mark.parametrize("frequency_hz", [3.0, 4.8, 5.4, 6.0])
def test_a_mass_that_leaves_its_base(frequency_hz: float) -> None:
    """At 3 Hz it stays on it and the motion is linear; beyond, it flies once in every period."""
    bouncer = Bouncer(frequency_hz)
    expected = bouncer.exact().orbit(START, settle=80)
    steady = steady_state(
        bouncer.model(),
        Harmonic(frequency_hz, {"base": bouncer.amplitude}),
        metrics=["displacement", "load"],
        tolerance=TOLERANCE,
    )
    assert expected.switchings == (0 if frequency_hz < 4 else 2)
    for name, row in (("displacement", bouncer.displacement), ("load", bouncer.load)):
        exact = expected.peak_to_peak(row)
        assert steady.peak_to_peak[name].value == pytest.approx(exact, rel=TOLERANCE)
    assert steady.contact is not None
    assert steady.contact.value == pytest.approx(
        expected.extremes(bouncer.load)[0], abs=TOLERANCE * bouncer.weight
    )
    agree_in_stability(steady.multipliers, expected)


# Two masses, one of which meets a spring

LOSS = 0.03
"""Damping over stiffness of both linear springs (s)."""

STOP, GAP, FORCE = 100.0, 1.0, 0.1
"""Stiffness and place of the spring that the first mass meets; force on the second mass."""


STOP_TOLERANCE = 1e-5
"""Multipliers are of first order in the instants of contact, and the stop is a hundred times stiffer."""


def two_masses(frequency: float) -> PiecewiseLinear:
    def rates(signs: Signs) -> Array:
        stop = STOP if signs[0] else 0.0
        first = [-(1 + stop), 1, -LOSS, LOSS, stop * GAP, 0, 0]
        second = [1, -2, LOSS, -2 * LOSS, 0, FORCE, 0]
        return np.array([[0, 0, 1, 0, 0, 0, 0], [0, 0, 0, 1, 0, 0, 0], first, second])

    return PiecewiseLinear(frequency, np.array([[1, 0, 0, 0, -GAP, 0, 0.0]]), rates)


@cache
def two_masses_model() -> Model:
    mechanism = Mechanism("two_masses", gravity=0)
    points = []
    for name in ("first", "second"):
        body = mechanism.add_body(name, mechanism.ground, prismatic(f"x_{name}", "x"), (0, 0, 0), mass=1)
        points.append(mechanism.point(f"centre_{name}", body, (0, 0, 0)))
        mechanism.add_output(PointDisplacement(f"{name}_displacement", points[-1], "x", mechanism.ground))
    first, second = (JointPort(mechanism.coordinate(f"x_{name}")) for name in ("first", "second"))
    relative = TravelPort(points[0], points[1].body, "x")
    mechanism.add_force_element("between", relative, Linear(1, LOSS))
    mechanism.add_force_element("wall", second, Linear(1, LOSS))
    mechanism.add_force_element("stop", first, SpringTable([0, GAP, GAP + 1], [0, 0, STOP]))
    mechanism.add_applied_force("push", points[1], "x", mechanism.ground)
    return build_model(mechanism, {})


def near(frequency: float, state: Sequence[float]) -> ExactOrbit:
    return two_masses(frequency).orbit(np.array(state))


def followed(begin: float, state: Sequence[float]) -> Callable[[float], ExactOrbit]:
    """The exact orbit at any frequency, each from one nearby, the first from a state."""
    known = {begin: near(begin, state)}

    def at(frequency: float) -> ExactOrbit:
        closest = min(known, key=lambda each: abs(each - frequency))
        steps = 1 + int(np.ceil(abs(frequency - closest) / 5e-3))
        for each in np.linspace(closest, frequency, steps)[1:]:
            known[float(each)] = near(float(each), known[closest].state)
            closest = float(each)
        return known[closest]

    return at


CONTACT = {
    "unstable, where a deviation grows": (0.70, [-1.121, -0.561, 0.160, 0.039]),
    "period doubled": (0.748, [0.184, -0.034, 0.686, 1.173]),
    "stable with contact": (0.70, [0.834, 0.756, 0.581, 0.310]),
    "Neimark-Sacker, lost": (0.60033, [0.982, 0.641, 0.170, 0.060]),
    "without contact": (0.55016, [0.541, 0.378, 0.024, 0.015]),
}
"""States near the orbits of one period that a turn round the amplitude-frequency curve passes."""


def series(orbit: ExactOrbit, frequency: float, harmonics: int = 20) -> FourierOrbit:
    """An exact orbit's harmonics to start from."""
    rows = np.eye(7)[:2]
    found = [orbit.harmonics(lambda piece, row=row: row, harmonics) for row in rows]  # type: ignore[misc]
    return FourierOrbit(two_masses_model(), pushed(frequency), np.array(found))


def pushed(frequency: float) -> Harmonic:
    return Harmonic(frequency / (2 * np.pi), {"push": FORCE})


@pytest.mark.parametrize(("frequency", "state"), CONTACT.values(), ids=CONTACT.keys())
def test_two_masses_one_of_which_meets_a_spring(frequency: float, state: Sequence[float]) -> None:
    """Stable and unstable orbits, with a multiplier beyond 1, one beyond -1, or a pair beyond the circle."""
    expected = near(frequency, state)
    steady = steady_state(
        two_masses_model(),
        pushed(frequency),
        metrics=["first_displacement", "second_displacement"],
        tolerance=TOLERANCE,
        start=series(expected, frequency),
    )
    for row, name in zip(np.eye(7), ("first_displacement", "second_displacement"), strict=False):
        exact = expected.peak_to_peak(lambda piece, row=row: row)  # type: ignore[misc]
        assert steady.peak_to_peak[name].value == pytest.approx(exact, rel=TOLERANCE)
    np.testing.assert_allclose(steady.orbit.state(), expected.state, atol=TOLERANCE * 10)
    agree_in_stability(steady.multipliers, expected, STOP_TOLERANCE)
    assert steady.is_stable == (np.abs(expected.multipliers[0]) < 1)


def linear_reach(frequency: float) -> float:
    """Amplitude of the first mass while it does not meet the stop."""
    link = 1 + 1j * frequency * LOSS
    stiffness = np.array([[link, -link], [-link, 2 * link]]) - frequency**2 * np.eye(2)
    return float(np.abs(np.linalg.solve(stiffness, [0, FORCE])[0]))


def test_a_branch_goes_on_where_contact_begins() -> None:
    """It turns sharply where the first mass comes to reach the stop, and there alone meets the linear one."""
    path = FrequencyPath(two_masses_model(), pushed(0.8))
    branch = follow(path, 0.8 / (2 * np.pi), 0.55 / (2 * np.pi), harmonics=21)
    frequencies, reach = 2 * np.pi * branch.values, branch.amplitude("first_displacement")
    assert frequencies[-1] == pytest.approx(0.55, rel=1e-12)
    upper, lower = (brentq(lambda w: linear_reach(w) - GAP, *ends) for ends in ((0.62, 0.7), (0.55, 0.6)))
    assert 2 * np.pi * branch.folds[0].value == pytest.approx(upper, rel=1e-4)
    touching = np.flatnonzero(reach > GAP)
    assert np.array_equal(touching, np.arange(touching[0], touching[-1] + 1))
    assert frequencies[touching[0] - 1] > upper > lower > frequencies[touching[-1] + 1]
    free = np.setdiff1d(np.arange(len(reach)), touching)
    assert reach[free] == pytest.approx([linear_reach(w) for w in frequencies[free]], rel=1e-9)
    for point in touching[::8]:
        exact = two_masses(frequencies[point]).orbit(branch.orbits[point].state())
        assert branch.orbits[point].state() == pytest.approx(exact.state, abs=0.03)
        assert abs(branch.multipliers[point][0]) == pytest.approx(abs(exact.multipliers[0]), abs=0.1)
        assert branch.is_stable[point] == (abs(exact.multipliers[0]) < 1)


def test_corners_are_turned_however_sharp() -> None:
    """Few samples meet the stop one by one; at each the branch turns, at some by more than 90 degrees."""
    path, begin = FrequencyPath(two_masses_model(), pushed(0.8)), 0.8 / (2 * np.pi)
    tracer = Tracer(path, 0.04, 5)
    first = first_orbit(*path.at(begin), 5, tolerance=1e-9).orbit
    steps = list(islice(tracer.march(tracer.begin(first, begin, -1.0), 0.05), 150))
    turns = [step.straightness for step in steps if step.is_corner]
    assert len(turns) >= 3 and min(turns) < -0.5


@pytest.mark.parametrize(
    ("begin", "low", "high"), [(0.70, 0.735, 0.745), (0.70, 0.60, 0.63)], ids=["doubling", "Neimark-Sacker"]
)
@pytest.mark.parametrize("side", [-1, 1])
def test_where_two_masses_lose_stability(begin: float, low: float, high: float, side: int) -> None:
    """One part in a thousand before and after the frequency where a multiplier leaves the unit circle."""
    exact = followed(begin, CONTACT["stable with contact"][1])
    critical = brentq(lambda w: np.abs(exact(w).multipliers[0]) - 1, low, high, xtol=1e-9)
    frequency = float(critical * (1 + 1e-3 * side))
    expected = exact(frequency)
    steady = steady_state(
        two_masses_model(),
        pushed(frequency),
        metrics=["first_displacement", "second_displacement"],
        tolerance=TOLERANCE,
        start=series(expected, frequency),
    )
    np.testing.assert_allclose(steady.orbit.state(), expected.state, atol=TOLERANCE * 10)
    agree_in_stability(steady.multipliers, expected, STOP_TOLERANCE)
    assert steady.is_stable == (np.abs(expected.multipliers[0]) < 1) == ((side > 0) == (critical < 0.7))
