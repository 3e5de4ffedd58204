"""Duffing's oscillator: closed forms, exact orbits, and an independent shooting method.

x'' + c x' + k x + g x^3 = P cos(w t).

- One harmonic balanced: M. Krack and J. Gross, Harmonic Balance for Nonlinear Vibration Problems, Springer
  2019, chapter 1, and example 1 of their program NLvib: c = 0.05, k = 1, g = 0.1, P = 0.18.
- Their program's own figures for that example: three harmonics in steps along the response, tabulated by
  M. Goldack, J. Gross, M. Krack and M. Stender, "Learning Duffing-Type Forces for the Harmonic Balance Method
  Using Neural Networks", GAMM 2026 (results/Duffing_reference_results.csv of github.com/MiriamAlina/
  gamm-duffing-hbm-nn, commit 2b4b61f); seven harmonics at the peak, printed by NLvib 1.3 (its column in
  examples/comparison/01_duffing.ipynb of github.com/julianjurai/NLvib-py, commit 64ad450).
- Jump frequencies and amplitudes: M. J. Brennan, I. Kovacic, A. Carrella and T. P. Waters, "On the jump-up
  and jump-down frequencies of the Duffing oscillator", Journal of Sound and Vibration 318 (2008) 1250-1261.
- Free vibrations of finite amplitude by elliptic integrals: I. Kovacic and M. J. Brennan (eds.), The Duffing
  Equation, Wiley 2011, chapter 2.
- Hill's determinant of Mathieu's equation: E. T. Whittaker and G. N. Watson, A Course of Modern Analysis, 4th
  ed., sections 19.41 and 19.42.
- Subharmonic of order three without damping: J. J. Stoker, Nonlinear Vibrations in Mechanical and Electrical
  Systems, Interscience 1950, chapter IV. x = A cos(w t / 3) solves the equation if (w / 3)^2 = k + 3 g A^2/4
  and P = g A^3 / 4, because 4 cos^3 = 3 cos + cos(3 ..).
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipk

from chassym.derivation import (
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    PointDisplacement,
    Polynomial,
    TravelPort,
    build_model,
    prismatic,
)
from chassym.nonlinear import FourierOrbit, Harmonic, SteadyState, steady_state
from chassym.nonlinear.continuation.backbone import backbone
from chassym.nonlinear.continuation.continuation import Branch, follow
from chassym.nonlinear.continuation.paths import FrequencyPath
from chassym.nonlinear.continuation.stepped_sine import stepped_sine
from chassym.nonlinear.harmonics.harmonic_balance import newton
from chassym.nonlinear.harmonics.subharmonics import subharmonic_orbit

from .shooting import Duffing, ShotOrbit

Array = np.ndarray

BOOK = Duffing(mass=1.0, damping=0.05, stiffness=1.0, cubic=0.1, force=0.18, frequency=1.0)
"""Krack and Gross' example."""

TOLERANCE = 1e-9
MULTIPLIER_TOLERANCE = 1e-7
METRICS = ["displacement", "acceleration"]


@cache
def duffing(damping: float, stiffness: float, cubic: float, mass: float = 1.0) -> Model:
    """Give a mass on a cubic spring with a force on it."""
    mechanism = Mechanism("duffing", gravity=0)
    body = mechanism.add_body("body", mechanism.ground, prismatic("x", "x"), (0, 0, 0), mass=mass)
    point = mechanism.point("centre", body, (0, 0, 0))
    port = TravelPort(point, mechanism.ground, "x")
    mechanism.add_force_element("spring", port, Polynomial((stiffness, 0, cubic), (damping,)))
    mechanism.add_applied_force("push", point, "x", mechanism.ground)
    mechanism.add_output(PointDisplacement("displacement", point, "x", mechanism.ground))
    mechanism.add_output(PointAcceleration("acceleration", point, "x", mechanism.ground))
    return build_model(mechanism, {})


def model_of(equation: Duffing) -> Model:
    return duffing(equation.damping, equation.stiffness, equation.cubic, equation.mass)


def force_of(equation: Duffing) -> Harmonic:
    return Harmonic(equation.frequency / (2 * np.pi), {"push": equation.force})


def series(model: Model, excitation: Harmonic, coefficients: dict[int, complex]) -> FourierOrbit:
    """An orbit to start from, by some of its harmonics."""
    found = np.zeros((1, max(coefficients) + 1), dtype=complex)
    for order, coefficient in coefficients.items():
        found[0, order] = coefficient
    return FourierOrbit(model, excitation, found)


def solved(equation: Duffing, first: complex | None = None, tolerance: float = TOLERANCE) -> SteadyState:
    """The steady state, from rest or from a first harmonic."""
    model, excitation = model_of(equation), force_of(equation)
    start = None if first is None else series(model, excitation, {1: first})
    return steady_state(model, excitation, metrics=METRICS, tolerance=tolerance, start=start)


# One harmonic


def one_harmonic(equation: Duffing) -> list[complex]:
    """Every first harmonic that balances alone, smallest magnitude first.

    (k - m w^2 + 3 g a^2 / 4 + i c w) x_1 = P, of which the squared magnitude is a cubic in a^2.
    """
    loss = equation.damping * equation.frequency
    stiffness = equation.stiffness - equation.mass * equation.frequency**2
    hardening = 0.75 * equation.cubic
    cubic = [hardening**2, 2 * hardening * stiffness, stiffness**2 + loss**2, -(equation.force**2)]
    squares = [root.real for root in np.roots(cubic) if abs(root.imag) < 1e-9 * abs(root)]
    return [equation.force / (stiffness + hardening * square + 1j * loss) for square in sorted(squares)]


@pytest.mark.parametrize("frequency", [0.6, 0.9, 1.2, 1.5])
def test_shooting_agrees_on_every_coexisting_orbit(frequency: float) -> None:
    """Amplitudes, harmonics and multipliers of stable and unstable orbits of Krack and Gross' example."""
    equation = replace(BOOK, frequency=frequency)
    firsts = one_harmonic(equation)
    assert len(firsts) == (3 if frequency == 1.2 else 1)
    for branch, first in enumerate(firsts):
        found = solved(equation, first)
        state = np.array([first.real, -frequency * first.imag])
        expected = equation.orbit(state)
        assert abs(found.orbit.harmonic_content(1)[0, 1]) == pytest.approx(abs(first), rel=0.02)
        agree(found, expected)
        assert found.is_stable == (branch != 1)


def agree_in_stability(found: Array, exact: Array, tolerance: float = MULTIPLIER_TOLERANCE) -> None:
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(exact), rtol=tolerance)


def agree(found: SteadyState, expected: ShotOrbit) -> None:
    """All that a steady state tells beside the same from shooting."""
    np.testing.assert_allclose(found.orbit.state(), expected.state, rtol=1e-9, atol=1e-10)
    displacement = found.peak_to_peak["displacement"]
    assert displacement.value == pytest.approx(expected.peak_to_peak(), rel=1e-9)
    content = found.orbit.harmonic_content(7)[0]
    np.testing.assert_allclose(content, expected.harmonics(7), atol=1e-10 * displacement.value)
    agree_in_stability(found.multipliers, expected.multipliers)


@pytest.mark.parametrize("frequency", [0.7, 1.2, 1.45])
def test_one_harmonic_is_the_limit_of_weak_nonlinearity(frequency: float) -> None:
    """With g a^2 a small part of k, what one harmonic leaves out falls as the square of that part."""

    def left_out(part: float) -> float:
        equation = replace(BOOK, frequency=frequency, cubic=part, force=0.05)
        first = one_harmonic(equation)[0]
        exact = solved(equation, first).orbit.harmonic_content(1)[0, 1]
        return abs(exact - first) / abs(first)

    assert left_out(0.05) / left_out(0.025) == pytest.approx(4, rel=0.15)


def test_multipliers_obey_liouville() -> None:
    """Their product is exp(-c T / m), whatever the spring is."""
    for frequency in (0.3, 1.0, 1.7):
        equation = replace(BOOK, frequency=frequency, cubic=2.0, force=1.5)
        found = solved(equation)
        expected = np.exp(-equation.damping * equation.duration)
        assert np.prod(found.multipliers).real == pytest.approx(expected, rel=1e-8)


# Exact orbits


def between_two_springs(stiffness: float, between: float, amplitude: float) -> tuple[Model, Harmonic, float]:
    """Give a damped oscillator between two cubic springs whose motion is exactly one harmonic.

    The third harmonics of x^3, from the spring to the ground, and of (x - u)^3, from the spring to the moving
    base, cancel if x and x - u have the same amplitude A and phases that differ by 60 degrees. The base's
    amplitude is then A, too. What is left of the first harmonic is balanced by the choice of frequency and
    damping: w^2 = k + 3 A^2 / 4 + s / 2 and c w = s sin(60 degrees), where s = k_b + 3 A^2 / 4.
    """
    hardening = 0.75 * amplitude**2
    across = between + hardening
    frequency = float(np.sqrt(stiffness + hardening + across / 2))
    damping = across * np.sqrt(0.75) / frequency
    mechanism = Mechanism("between_two_springs", gravity=0)
    body = mechanism.add_body("body", mechanism.ground, prismatic("x", "x"), (0, 0, 0), mass=1)
    point = mechanism.point("centre", body, (0, 0, 0))
    port = TravelPort(point, mechanism.ground, "x")
    base = mechanism.add_input("base", "m")
    mechanism.add_force_element("ground_spring", port, Polynomial((stiffness, 0, 1)))
    mechanism.add_force_element("damper", port, Linear(0, damping))
    mechanism.add_force_element("base_spring", port.less(base), Polynomial((between, 0, 1)))
    mechanism.add_output(PointDisplacement("displacement", point, "x", mechanism.ground))
    mechanism.add_output(PointAcceleration("acceleration", point, "x", mechanism.ground))
    excitation = Harmonic(frequency / (2 * np.pi), {"base": amplitude * np.exp(1j * np.pi / 3)})
    return build_model(mechanism, {}), excitation, damping


def mathieu_multipliers(stiffness: float, modulation: float, frequency: float, damping: float) -> Array:
    """Multipliers over 2 pi / w of d'' + c d' + (a + b cos(2 w t)) d = 0 by Hill's determinant."""
    a = (stiffness - damping**2 / 4) / frequency**2
    q = modulation / (2 * frequency**2)
    # Continuants of the determinant with ones on its diagonal, from the middle outwards.
    orders = np.arange(1, 4001)
    ratio = q / (a - 4.0 * orders**2)
    pair = np.ones(len(orders) + 2)
    for i in range(len(orders) - 1, 0, -1):
        pair[i] = pair[i + 1] - ratio[i - 1] * ratio[i] * pair[i + 2]
    half, without_first = pair[1], pair[2]
    determinant = half**2 - 2 * (q / a) * ratio[0] * half * without_first
    sine_squared = determinant * np.sin(np.pi * np.sqrt(complex(a)) / 2) ** 2
    exponent = 2 / np.pi * np.arcsin(np.sqrt(complex(sine_squared)))
    turns = np.exp(2j * np.pi * exponent * np.array([1, -1]))
    return np.asarray(turns * np.exp(-damping * np.pi / frequency))


@pytest.mark.parametrize(
    ("stiffness", "between", "amplitude"),
    [(15.0, 0.0, 1.0), (0.5, 0.0, 1.0), (2.0, 1.0, 1.5), (4.0, 0.0, 0.3)],
)
def test_motion_of_exactly_one_harmonic(stiffness: float, between: float, amplitude: float) -> None:
    """Orbit and multipliers are known in closed form; deviations obey a damped Mathieu equation.

    3 (x^2 + (x - u)^2) = 3 A^2 (1 + cos(2 w t - 60 degrees) / 2).
    """
    model, excitation, damping = between_two_springs(stiffness, between, amplitude)
    start = series(model, excitation, {1: 1.1 * amplitude, 3: 0.1 * amplitude})
    found = steady_state(model, excitation, tolerance=TOLERANCE, metrics=METRICS, start=start)
    frequency = excitation.angular_frequency
    np.testing.assert_allclose(found.orbit.state(), [amplitude, 0], atol=1e-10)
    assert found.peak_to_peak["displacement"].value == pytest.approx(2 * amplitude, rel=1e-10)
    assert found.peak_to_peak["acceleration"].value == pytest.approx(2 * amplitude * frequency**2, rel=1e-9)
    square = 3 * amplitude**2
    exact = mathieu_multipliers(stiffness + between + square, square / 2, frequency, damping)
    agree_in_stability(found.multipliers, exact)


# Folds


@cache
def branch_of(equation: Duffing, start: float, stop: float, harmonics: int = 11) -> Branch:
    path = FrequencyPath(model_of(equation), force_of(equation))
    return follow(path, start / (2 * np.pi), stop / (2 * np.pi), harmonics=harmonics)


@pytest.mark.parametrize(("cubic", "start", "stop"), [(0.1, 0.5, 1.6), (1.0, 0.8, 2.5), (-0.02, 1.5, 0.5)])
def test_folds_agree_with_shooting(cubic: float, start: float, stop: float) -> None:
    """Of hardening and softening springs, to rounding; every orbit between them is unstable, no other."""
    equation = replace(BOOK, cubic=cubic)
    branch = branch_of(equation, start, stop)
    jumps = [fold.point for fold in branch.folds]
    assert len(jumps) == 2
    for fold in branch.folds:
        frequency = 2 * np.pi * fold.value
        expected = equation.fold(np.array([*fold.orbit.state(), frequency]))
        assert frequency == pytest.approx(expected.equation.frequency, rel=1e-9)
        np.testing.assert_allclose(fold.orbit.state(), expected.state, rtol=1e-6, atol=1e-8)
        assert abs(fold.orbit.coefficients[0, 1]) == pytest.approx(abs(expected.harmonics(1)[1]), rel=1e-7)
        assert expected.multipliers[0] == pytest.approx(1, abs=1e-6)
    points = np.arange(len(branch.values))
    np.testing.assert_array_equal(branch.is_stable, (points <= jumps[0]) | (points > jumps[1]))


def test_folds_of_one_harmonic() -> None:
    """Krack and Gross' formula w^2 = k - c^2/2 + 3 g a^2/4 + sqrt(P^2/a^2 + c^4/4 - c^2 (k + 3 g a^2/4)).

    On this side of the resonance it is greatest just below the tip and least further down.
    """

    def frequency(amplitude: float) -> float:
        stiffness, loss = 1 + 0.075 * amplitude**2, BOOK.damping**2
        root = (BOOK.force / amplitude) ** 2 + loss**2 / 4 - loss * stiffness
        return float(np.sqrt(stiffness - loss / 2 + np.sqrt(max(root, 0))))

    highest = brentq(lambda a: (BOOK.force / a) ** 2 - BOOK.damping**2 * (1 + 0.075 * a**2), 2.0, 3.5)
    tip = minimize_scalar(lambda a: -frequency(a), bounds=(0.9 * highest, highest), method="bounded")
    foot = minimize_scalar(frequency, bounds=(0.5, 0.9 * highest), method="bounded")
    folds = branch_of(BOOK, 0.5, 1.6).folds
    for fold, expected, limit in zip(folds, (-tip.fun, foot.fun), (3e-3, 3e-3), strict=True):
        assert 2 * np.pi * fold.value == pytest.approx(expected, rel=limit)


TABULATED = {
    1.13348175443439: 0.71068366176687,
    1.1380325873232: 1.6295041473644,
    1.2074573937769: 2.3223840591022,
    1.2576939170761: 2.7141103143975,
    1.2682790779941: 2.8044615650718,
    1.2350180095641: 2.6885938481481,
    1.1021598796401: 1.9517602296025,
}
"""Amplitudes of the first of three harmonics by frequency (rad/s), on all three parts of the response."""

TABULATED_EXTREMES = (1.26959987220511, 1.11571579064291)
"""The highest frequency before the response turns back, and the lowest after."""

PRINTED_PEAK = {"root mean square": 2.001518, "first": 2.830198, "third": 0.046166, "fifth": 0.000741}
"""Of seven harmonics at the resonance, which is printed as 1.2687."""


@pytest.mark.parametrize(("frequency", "amplitude"), TABULATED.items())
def test_tabulated_response_of_three_harmonics(frequency: float, amplitude: float) -> None:
    """To the accuracy with which their steps are solved."""
    found = balanced_near(frequency, amplitude, harmonics=3)
    assert abs(found[1]) == pytest.approx(amplitude, abs=2e-6)


def balanced_near(frequency: float, amplitude: float, harmonics: int) -> Array:
    """The harmonics at a frequency (rad/s) on the part of the response that has about this amplitude."""

    def distance(orbit: FourierOrbit) -> float:
        return float(np.hypot(orbit.angular_frequency - frequency, abs(orbit.coefficients[0, 1]) - amplitude))

    near = min(branch_of(BOOK, 0.5, 1.6, harmonics).orbits, key=distance)
    equation = replace(BOOK, frequency=frequency)
    guess = near.under(model_of(equation), force_of(equation))
    return newton(guess, 1e-10).orbit.coefficients[0]


def test_tabulated_response_turns_at_the_folds() -> None:
    """Its steps come as near to them as their length lets them, and not beyond."""
    tip, foot = (2 * np.pi * fold.value for fold in branch_of(BOOK, 0.5, 1.6, harmonics=3).folds)
    highest, lowest = TABULATED_EXTREMES
    assert 0 < tip - highest < 1e-6
    assert 0 < lowest - foot < 2e-5


def test_printed_harmonics_at_the_resonance() -> None:
    """As it is stationary there, the amplitude at the frequency of the backbone is that of the peak."""
    path = FrequencyPath(model_of(BOOK), force_of(BOOK))
    peak = backbone(path, [1.0], 0.5 / (2 * np.pi), 1.6 / (2 * np.pi), output="displacement", harmonics=7)
    frequency = float(2 * np.pi * peak.frequencies_hz[0])
    assert frequency == pytest.approx(1.2687, abs=5e-5)
    found = balanced_near(frequency, PRINTED_PEAK["first"], harmonics=7)
    assert np.linalg.norm(found) / np.sqrt(2) == pytest.approx(PRINTED_PEAK["root mean square"], abs=2e-6)
    for order, name in ((1, "first"), (3, "third"), (5, "fifth")):
        assert abs(found[order]) == pytest.approx(PRINTED_PEAK[name], abs=2e-6)


@pytest.mark.parametrize(("ratio", "cubic"), [(0.02, 0.005), (0.02, 0.02), (0.01, 0.01)])
def test_jumps_of_brennan_and_others(ratio: float, cubic: float) -> None:
    """x'' + 2 r x' + x + g x^3 = cos(w t) jumps down and up at frequencies and amplitudes of closed form.

    Down: w^2 = (1 + R) / 2 and a^2 = 2 (R - 1) / 3g, where R^2 = 1 + 3 g / (4 r^2). Up, with no regard to
    damping: w = 1 + (3/2)^(4/3) g^(1/3) / 2 and a = (2 / 3g)^(1/3).
    """
    folds = branch_of(Duffing(1.0, 2 * ratio, 1.0, cubic, 1.0, 1.0), 0.8, 3.0).folds
    root = np.sqrt(1 + 0.75 * cubic / ratio**2)
    down = np.sqrt((1 + root) / 2), np.sqrt(2 * (root - 1) / (3 * cubic))
    up = 1 + 1.5 ** (4 / 3) * cubic ** (1 / 3) / 2, (2 / (3 * cubic)) ** (1 / 3)
    for fold, (frequency, amplitude), limit in zip(folds, (down, up), (5e-3, 2e-2), strict=True):
        assert 2 * np.pi * fold.value == pytest.approx(frequency, rel=limit)
        assert abs(fold.orbit.coefficients[0, 1]) == pytest.approx(amplitude, rel=2e-2)


# Free vibrations and subharmonics


def free_frequency(stiffness: float, cubic: float, amplitude: float) -> float:
    """Of free vibrations without damping: pi sqrt(k + g A^2) / 2K, parameter m = g A^2 / (2 (k + g A^2))."""
    square = stiffness + cubic * amplitude**2
    return float(np.pi * np.sqrt(square) / (2 * ellipk(cubic * amplitude**2 / (2 * square))))


@pytest.mark.parametrize("cubic", [0.5, -0.05])
def test_backbone_is_that_of_free_vibrations(cubic: float) -> None:
    """With little damping the tip of the resonance is an orbit that is free but for its phase."""
    equation = Duffing(1.0, 0.002, 1.0, cubic, 0.002, 1.0)
    path = FrequencyPath(model_of(equation), force_of(equation))
    found = backbone(
        path, [0.5, 1.0, 2.5], 0.7 / (2 * np.pi), 1.9 / (2 * np.pi), output="displacement", harmonics=15
    )
    assert found.amplitudes[-1] > 1.5
    exact = [free_frequency(1.0, cubic, amplitude) for amplitude in found.amplitudes]
    np.testing.assert_allclose(2 * np.pi * found.frequencies_hz, exact, rtol=1e-5)


def test_stepped_sine_jumps_at_the_folds() -> None:
    """Upward at the tip, downward at the foot; between them two motions coexist."""
    path = FrequencyPath(model_of(BOOK), force_of(BOOK))
    frequencies = np.linspace(1.0, 1.4, 9) / (2 * np.pi)
    swept = stepped_sine(path, frequencies, metrics=["displacement"], harmonics=11)
    tip, foot = (fold.value for fold in branch_of(BOOK, 0.5, 1.6).folds)
    up, down = swept.upward.jumps, swept.downward.jumps
    assert [jump.cause for jump in (*up, *down)] == ["fold", "fold"]
    assert up[0].value == pytest.approx(tip, rel=1e-6)
    assert down[0].value == pytest.approx(foot, rel=1e-6)
    between = frequencies[(frequencies > foot) & (frequencies < tip)]
    np.testing.assert_allclose(swept.coexisting, between)
    for run, branch in ((swept.upward, -1), (swept.downward, 0)):
        for frequency, state in zip(run.values, run.states, strict=True):
            equation = replace(BOOK, frequency=2 * np.pi * frequency)
            first = one_harmonic(equation)[branch]
            assert state is not None
            expected = equation.orbit(np.array([first.real, -equation.frequency * first.imag]))
            metric = state.peak_to_peak["displacement"]
            assert metric.value == pytest.approx(expected.peak_to_peak(), rel=1e-3)
            assert state.is_stable


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 2.0])
def test_subharmonic_of_order_three(amplitude: float) -> None:
    """Stoker's exact orbit x = A cos(w t / 3), and Mathieu's equation for what deviates from it.

    3 g x^2 = 3 g A^2 (1 + cos(2 w t / 3)) / 2.
    """
    cubic = 0.8
    third = float(np.sqrt(1 + 0.75 * cubic * amplitude**2))
    equation = Duffing(1.0, 0.0, 1.0, cubic, cubic * amplitude**3 / 4, 3 * third, periods=3)
    model, excitation = model_of(equation), force_of(equation)
    guess = series(model, excitation, {1: 1.01 * amplitude, 3: 0.01 * amplitude, 12: 0})
    balanced = newton(replace(guess, subharmonic=3), 1e-11).orbit
    expected = np.zeros(13)
    expected[1] = amplitude
    np.testing.assert_allclose(balanced.coefficients[0], expected, atol=1e-11)
    found = steady_state(
        model, excitation, metrics=METRICS, tolerance=TOLERANCE, start=balanced, subharmonic=3
    )
    square = 1.5 * cubic * amplitude**2
    agree_in_stability(found.multipliers, mathieu_multipliers(1 + square, square, third, 0.0))
    assert found.peak_to_peak["displacement"].value == pytest.approx(2 * amplitude, rel=1e-9)


def test_branch_of_damped_subharmonics() -> None:
    """It is closed off by folds, which shooting over three periods finds, too."""
    equation = Duffing(1.0, 0.02, 1.0, 0.3, 3.0, 4.5, periods=3)
    model, excitation = model_of(equation), force_of(equation)
    first = subharmonic_orbit(model, excitation, 3, harmonics=21).orbit
    expected = equation.orbit(first.state())
    np.testing.assert_allclose(first.coefficients[0, :12], expected.harmonics(11), atol=1e-8)
    found = steady_state(model, excitation, metrics=METRICS, tolerance=TOLERANCE, start=first, subharmonic=3)
    agree(found, expected)
    branch = follow(
        FrequencyPath(model, excitation),
        excitation.frequency_hz,
        0.4,
        harmonics=21,
        first=first,
        subharmonic=3,
        most_points=2000,
    )
    lowest = min(branch.folds, key=lambda fold: fold.value)
    fold = equation.fold(np.array([*lowest.orbit.state(), 2 * np.pi * lowest.value]))
    assert 2 * np.pi * lowest.value == pytest.approx(fold.equation.frequency, rel=1e-8)


@pytest.mark.parametrize("frequency", [0.4, 0.9, 1.5])
def test_multipliers_along_a_branch(frequency: float) -> None:
    """Those of balanced harmonics are integrated to the fourth order in 128 steps."""
    branch = branch_of(BOOK, 0.3, 1.6)
    point = int(np.argmin(np.abs(branch.values - frequency / (2 * np.pi))))
    equation = replace(BOOK, frequency=2 * np.pi * float(branch.values[point]))
    expected = equation.orbit(branch.orbits[point].state())
    agree_in_stability(branch.multipliers[point], expected.multipliers, 1e-5)
