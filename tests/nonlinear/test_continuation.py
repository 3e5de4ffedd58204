"""Branches of orbits: exact derivatives, Duffing's oscillator by closed forms and shooting; first orbits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chassym.derivation import (
    CombinedPort,
    ContactForce,
    Linear,
    Mechanism,
    Model,
    ParameterError,
    PointDisplacement,
    TravelPort,
    Unilateral,
    build_model,
    prismatic,
)
from chassym.nonlinear import ExcitationError, Harmonic, NoPeriodicOrbitError, rig, simulate
from chassym.nonlinear.collocation.floquet import multipliers
from chassym.nonlinear.continuation.branch import Branch
from chassym.nonlinear.continuation.continuation import first_orbit, follow
from chassym.nonlinear.continuation.paths import (
    ACCELERATION,
    DISPLACEMENT,
    VELOCITY,
    AmplitudePath,
    FrequencyPath,
    Held,
    ParameterPath,
    Path,
)
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_balance import at_rest, balance_residual, jacobian, newton
from chassym.nonlinear.harmonics.harmonic_equations import HarmonicEquations, samples_at_knots
from chassym.nonlinear.harmonics.subharmonics import repeats_late, subharmonic_orbit

from .duffing import Duffing

TURN = 2 * np.pi
DUFFING = Duffing()


@pytest.fixture(scope="module")
def duffing() -> Model:
    return DUFFING.model()


@pytest.fixture(scope="module")
def resonance(duffing: Model) -> Branch:
    """The branch over the bent resonance, from 0.8 to 2.6 rad/s."""
    return follow(FrequencyPath(duffing, DUFFING.excitation()), 0.8 / TURN, 2.6 / TURN, harmonics=15)


@pytest.fixture(scope="module")
def hopping() -> Model:
    """A quarter car whose tyre pushes but does not pull."""
    mechanism = Mechanism("hopping", gravity=9.81)
    bodies = [
        mechanism.add_body(name, mechanism.ground, prismatic(f"{name}_z", "z"), (0, 0, 0), mass=mass)
        for name, mass in (("body", 400), ("wheel", 40))
    ]
    points = [mechanism.point(f"{body.name}_point", body, (0, 0, 0)) for body in bodies]
    body, wheel = (TravelPort(point, mechanism.ground, "z") for point in points)
    spring = CombinedPort(((wheel, 1), (body, -1)))
    mechanism.add_force_element("spring", spring, Linear(20e3, 1500), preloaded=True)
    tyre = Unilateral(Linear(200e3, 100))
    road = wheel.less(mechanism.add_input("road", "m"))
    element = mechanism.add_force_element("tyre", road, tyre, preloaded=True)
    mechanism.add_output(ContactForce("patch_force_z", element))
    mechanism.add_output(PointDisplacement("wheel_height", points[1], "z", mechanism.ground))
    return build_model(mechanism, {})


ROADS = Harmonic(2.0, {"front_road": 0.02, "rear_road": 0.02 * np.exp(-2j * np.pi * 2.0 * 0.13)})
LAGS = {"rear_road": 0.13}


@pytest.mark.parametrize(
    ("make", "value"),
    [
        (lambda m: FrequencyPath(m, ROADS, DISPLACEMENT, LAGS), 2.3),
        (lambda m: FrequencyPath(m, ROADS, VELOCITY), 2.3),
        (lambda m: FrequencyPath(m, ROADS, ACCELERATION, LAGS), 2.3),
        (lambda m: AmplitudePath(m, ROADS), 1.3),
        (lambda m: ParameterPath(m, ROADS, "body.mass"), 700.0),
        (lambda m: ParameterPath(m, ROADS, "suspension.front.spring.rate"), 30e3),
    ],
    ids=["displacement", "velocity", "acceleration", "amplitude", "mass", "rate"],
)
@pytest.mark.parametrize("subharmonic", [1, 2])
def test_slope_is_the_derivative_by_the_parameter(
    half_car: Model, make, value: float, subharmonic: int
) -> None:
    path: Path = make(half_car)
    unknowns = fourier.packed(newton(at_rest(half_car, ROADS, 5), 1e-3).orbit.coefficients)

    def equations(at: float) -> HarmonicEquations:
        return HarmonicEquations(*path.at(at), 5, subharmonic)

    def residual(at: float) -> np.ndarray:
        return equations(at).residual(equations(at).arguments(unknowns))

    exact = path.slope(equations(value), equations(value).arguments(unknowns), value)
    step = 1e-4 * value
    coarse, fine = ((residual(value + h) - residual(value - h)) / (2 * h) for h in (2 * step, step))
    assert (4 * fine - coarse) / 3 == pytest.approx(exact, rel=1e-6, abs=1e-7 * np.abs(exact).max())


@pytest.mark.parametrize("held", [DISPLACEMENT, VELOCITY, ACCELERATION])
def test_what_is_held_keeps_its_amplitude(half_car: Model, held: Held) -> None:
    path = FrequencyPath(half_car, ROADS, held, LAGS)
    _, at_five = path.at(5.0)
    for name, amplitude in at_five.amplitudes.items():
        kept = abs(amplitude) * 5.0**held.order
        assert kept == pytest.approx(abs(ROADS.amplitudes[name]) * 2.0**held.order)
    turned = np.angle(at_five.amplitudes["rear_road"] / at_five.amplitudes["front_road"])
    assert np.exp(1j * turned) == pytest.approx(np.exp(-2j * np.pi * 5.0 * 0.13))


def test_jacobian_of_a_subharmonic_orbit(sedan: Model) -> None:
    generator = np.random.default_rng(3)
    rest = at_rest(sedan, rig.vertical(amplitude_m=0.01), 6, subharmonic=2)
    noise = generator.normal(size=(2, *rest.coefficients.shape))
    orbit = replace(rest, coefficients=1e-3 * (noise[0] + 1j * noise[1] * (np.arange(7) > 0)))
    direction = orbit.coefficients[::-1]

    def residual(step: float) -> np.ndarray:
        moved = replace(orbit, coefficients=orbit.coefficients + step * direction)
        return fourier.packed(balance_residual(moved))

    exact = jacobian(orbit) @ fourier.packed(direction)
    coarse, fine = ((residual(h) - residual(-h)) / (2 * h) for h in (2e-6, 1e-6))
    assert (4 * fine - coarse) / 3 == pytest.approx(exact, abs=1e-6 * np.abs(exact).max())


def test_one_harmonic_is_the_closed_form(duffing: Model) -> None:
    branch = follow(FrequencyPath(duffing, DUFFING.excitation()), 0.8 / TURN, 2.6 / TURN, harmonics=1)
    amplitudes = branch.amplitude("displacement")
    left = [DUFFING.one_harmonic(f, a) for f, a in zip(TURN * branch.values, amplitudes, strict=True)]
    assert len(branch.folds) == 2
    assert np.abs(left).max() < 1e-6 * DUFFING.force**2


def test_three_orbits_agree_with_shooting(resonance: Branch) -> None:
    frequency = 1.6
    found = resonance.at(frequency / TURN)
    assert len(found) == 3
    for orbit in found:
        state, expected = DUFFING.shot(orbit.state(), frequency)
        assert orbit.state() == pytest.approx(state, abs=1e-9)
        assert np.sort(multipliers(orbit).real) == pytest.approx(np.sort(expected.real), rel=2e-4)
    heights = [np.ptp(orbit.outputs(256)[0]) for orbit in found]
    assert heights == sorted(heights, reverse=True)


def test_orbits_right_beside_a_fold_are_found(duffing: Model) -> None:
    """The two that are about to meet differ by the square root of the distance; beyond there are none."""
    path = FrequencyPath(duffing, DUFFING.excitation())
    coarse = follow(path, 0.8 / TURN, 2.6 / TURN, largest_step=0.3)
    high, low = (fold.value for fold in coarse.folds)
    for distance in np.geomspace(1e-8, 1e-2, 13):
        for value, pair in ((high * (1 - distance), slice(0, 2)), (low * (1 + distance), slice(1, 3))):
            found = coarse.at(value)
            assert len(found) == 3
            first, second = (orbit.coefficients for orbit in found[pair])
            assert 0.5 < np.abs(first - second).max() / np.sqrt(distance) < 20
        assert len(coarse.at(high * (1 + distance))) == len(coarse.at(low * (1 - distance))) == 1


def test_folds_agree_with_shooting(resonance: Branch) -> None:
    upper, lower = resonance.folds
    for fold in (upper, lower):
        expected = DUFFING.fold(fold.orbit.state(), TURN * fold.value)
        assert TURN * fold.value == pytest.approx(expected, rel=1e-8)
    assert upper.value > lower.value


def test_folds_of_little_damping_have_their_closed_forms() -> None:
    """Undamped, the lower fold is where d(w^2)/dA = 0 on the branch in antiphase: A^3 = 2 F / 3 k3.

    The upper one comes to phase resonance, A c w = F on the backbone w^2 = k + 3/4 k3 A^2.
    """
    lightly = Duffing(damping=0.002, cubic=0.5, force=0.02)
    branch = follow(
        FrequencyPath(lightly.model(), lightly.excitation()),
        0.8 / TURN,
        4.0 / TURN,
        harmonics=1,
        largest_step=0.1,
    )
    upper, lower = (TURN * fold.value for fold in branch.folds)
    amplitude = (2 * lightly.force / (3 * lightly.cubic)) ** (1 / 3)
    assert lower**2 == pytest.approx(1 + 2.25 * lightly.cubic * amplitude**2, rel=1e-4)
    squared = np.roots([1.0, -1.0, -0.75 * lightly.cubic * (lightly.force / lightly.damping) ** 2]).max()
    assert upper**2 == pytest.approx(squared, rel=1e-4)


def test_stability_changes_at_the_folds(resonance: Branch) -> None:
    first, second = (fold.point for fold in resonance.folds)
    expected = np.ones(len(resonance.values), dtype=bool)
    expected[first + 1 : second + 1] = False
    assert np.array_equal(resonance.is_stable, expected)
    away = np.abs(resonance.multipliers[:, 0] * resonance.multipliers[:, 1])
    assert away == pytest.approx(np.exp(-DUFFING.damping / resonance.values), rel=1e-5)


def test_a_branch_ends_on_its_bounds_and_is_labelled(resonance: Branch) -> None:
    assert resonance.values[[0, -1]] == pytest.approx([0.8 / TURN, 2.6 / TURN], rel=1e-12)
    labelled = resonance.to_xarray()
    assert labelled.displacement.attrs["units"] == "m"
    assert labelled.frequency.attrs["units"] == "Hz"
    assert labelled.displacement.values == pytest.approx(resonance.amplitude("displacement"))
    assert labelled.fold_value.values.tolist() == [fold.value for fold in resonance.folds]


def test_both_ways_along_a_branch_agree(duffing: Model, resonance: Branch) -> None:
    path = FrequencyPath(duffing, DUFFING.excitation())
    back = follow(path, 2.6 / TURN, 0.8 / TURN, harmonics=15)
    assert [fold.value for fold in back.folds] == pytest.approx(
        [f.value for f in resonance.folds[::-1]], rel=1e-9
    )


def test_a_branch_that_turns_back_ends_where_it_began(duffing: Model, resonance: Branch) -> None:
    """From between the folds, upwards on the upper orbits, it comes back on the unstable ones."""
    start = 1.6 / TURN
    path = FrequencyPath(duffing, DUFFING.excitation())
    upper, unstable, _ = resonance.at(start)
    branch = follow(path, start, 3.0 / TURN, harmonics=15, first=upper)
    assert branch.values[-1] == pytest.approx(start, rel=1e-12)
    assert branch.orbits[-1].coefficients == pytest.approx(unstable.coefficients, abs=1e-8)


def test_amplitude_folds_as_frequency_does(duffing: Model, resonance: Branch) -> None:
    """At a fold over frequency the factor on the amplitudes has one as well: the same singular orbit."""
    fold = resonance.folds[1]
    path = AmplitudePath(duffing, DUFFING.excitation(TURN * fold.value))
    branch = follow(path, 0.2, 3.0, harmonics=15)
    assert min(abs(found.value - 1) for found in branch.folds) < 1e-8


def test_a_parameter_leads_to_the_variant(half_car: Model) -> None:
    excitation = replace(ROADS, frequency_hz=2.5)
    path = ParameterPath(half_car, excitation, "body.mass")
    heavy = 1.3 * half_car.parameters.value("body.mass")
    branch = follow(path, half_car.parameters.value("body.mass"), heavy, harmonics=5, largest_step=0.5)
    direct = newton(at_rest(half_car.with_parameters({"body.mass": heavy}), excitation, 5), 1e-10).orbit
    assert branch.orbits[-1].coefficients == pytest.approx(direct.coefficients, abs=1e-9)
    assert (path.name, path.unit) == ("body.mass", "kg")


def test_the_sedan_has_one_smooth_stable_branch(sedan: Model) -> None:
    branch = follow(FrequencyPath(sedan, rig.vertical()), 2.5, 3.5, harmonics=3, largest_step=0.3)
    assert not branch.folds and np.all(np.diff(branch.values) > 0) and branch.is_stable.all()
    (found,) = branch.at(3.0)
    fewest = samples_at_knots(sedan)
    direct = newton(at_rest(sedan, rig.vertical(), 3), 1e-9, fewest_samples=fewest).orbit
    assert found.coefficients == pytest.approx(direct.coefficients, abs=1e-8)


@pytest.mark.parametrize("frequency", [4.0, 5.0])
def test_a_third_of_the_frequency_agrees_with_shooting(frequency: float) -> None:
    lightly = Duffing(damping=0.01, force=2.0)
    found = subharmonic_orbit(lightly.model(), lightly.excitation(frequency), 3).orbit
    state, expected = lightly.shot(found.state(), frequency, periods=3)
    assert repeats_late(found) and found.period_s == pytest.approx(3 * TURN / frequency)
    assert found.state() == pytest.approx(state, abs=1e-6)
    once, _ = lightly.mapped(state, frequency, periods=1)
    assert np.abs(once - state).max() > 0.1 * np.abs(state).max()
    assert np.abs(expected).max() < 1 and abs(multipliers(found)[0]) < 1


def test_subharmonic_branch_folds_where_shooting_says() -> None:
    """At its low end the 1/3 orbit meets its unstable companion; the multiplier is one there."""
    lightly = Duffing(damping=0.01, force=2.0)
    path = FrequencyPath(lightly.model(), lightly.excitation())
    first = subharmonic_orbit(*path.at(4 / TURN), 3).orbit
    branch = follow(path, 4 / TURN, 2 / TURN, harmonics=21, first=first, subharmonic=3, largest_step=0.2)
    (fold,) = branch.folds
    _, found = lightly.shot(fold.orbit.state() * (1 + 1e-9), TURN * fold.value, periods=3)
    assert np.abs(found - 1).min() < 1e-3
    assert branch.values[-1] == pytest.approx(4 / TURN) and not branch.is_stable[-1]


def test_an_orbit_of_one_period_is_one_of_three_too(duffing: Model) -> None:
    once = first_orbit(duffing, DUFFING.excitation(0.9), 4, tolerance=1e-10).orbit
    thrice = first_orbit(duffing, DUFFING.excitation(0.9), 12, once, subharmonic=3, tolerance=1e-10).orbit
    assert thrice.coefficients[:, ::3] == pytest.approx(once.coefficients, abs=1e-12)
    assert not repeats_late(thrice)
    assert thrice.period_s == 3 * once.period_s
    assert thrice.outputs(48)[:, :16] == pytest.approx(once.outputs(16), abs=1e-12)


def test_a_start_chooses_among_orbits(duffing: Model, resonance: Branch) -> None:
    upper, _, lower = resonance.at(1.6 / TURN)
    for orbit in (upper, lower):
        found = first_orbit(duffing, orbit.excitation, 5, orbit, tolerance=1e-8).orbit
        assert found.coefficients[0, 1] == pytest.approx(orbit.coefficients[0, 1], rel=1e-2)


def test_a_lifting_tyre_is_reached(hopping: Model) -> None:
    """Long in the air, and where integration in time stays."""
    excitation = Harmonic(8.0, {"road": 0.05})
    found = first_orbit(hopping, excitation, 40, tolerance=1e-6).orbit
    forces = found.outputs(512)[hopping.output_names.index("patch_force_z")]
    assert 0.3 < np.mean(forces <= 0) < 0.7
    times = excitation.period_s * np.append(0.0, np.arange(80.0, 81.0, 1 / 64))
    moved = simulate(hopping, excitation, times, start=found.state(), relative_tolerance=1e-9).states[:, 1:]
    series = found.motion_at(TURN / 64 * np.arange(64))
    assert series[:2] == pytest.approx(moved[:2], abs=2e-4 * np.abs(moved[:2]).max())


def test_where_newton_fails_amplitude_leads_there(sedan: Model) -> None:
    excitation = rig.vertical(amplitude_m=0.7)
    with pytest.raises(NoPeriodicOrbitError):
        newton(at_rest(sedan, excitation, 3), 1e-6)
    orbit = first_orbit(sedan, excitation, 3, tolerance=1e-8).orbit
    whole = newton(at_rest(sedan, rig.vertical(amplitude_m=0.01), 3), 1e-6).orbit
    rigid = np.abs(sedan.residual(whole.arguments(16))).max()
    assert np.abs(balance_residual(orbit)).max() < 1e-6 * rigid + 1e-3
    assert np.abs(orbit.coefficients[:, 1]).max() > 0.1


def test_what_cannot_be_reached_says_how_far_it_came(sedan: Model) -> None:
    message = (
        "followed from small motions, the response came to .* of the amplitudes .*; try a smaller amplitude"
    )
    with pytest.raises(NoPeriodicOrbitError, match=message):
        first_orbit(sedan, rig.vertical(amplitude_m=10.0), 3)


def test_a_motion_that_nothing_holds_is_named(sedan: Model) -> None:
    loose = sedan.with_parameters({f"tyre.{axle}.stiffness.x": 0.0 for axle in ("front", "rear")})
    with pytest.raises(NoPeriodicOrbitError, match="coordinate 'x'; give it some stiffness$"):
        first_orbit(loose, rig.lateral(), 3)


def test_refusals(duffing: Model) -> None:
    path = FrequencyPath(duffing, DUFFING.excitation())
    with pytest.raises(ValueError, match="start and stop: 0.2 and 0.2 received"):
        follow(path, 0.2, 0.2)
    with pytest.raises(ValueError, match="largest_step: 0 received"):
        follow(path, 0.2, 0.3, largest_step=0)
    with pytest.raises(ValueError, match="most_points: 1 received; 2 or more are needed"):
        follow(path, 0.2, 0.3, most_points=1)
    for tolerance in (-1.0, 0.0, 1.0, np.nan):
        with pytest.raises(ValueError, match=f"tolerance: {tolerance} received; a positive number"):
            follow(path, 0.2, 0.3, tolerance=tolerance)
    with pytest.raises(ValueError, match="harmonics: 2 received with subharmonic 3"):
        first_orbit(duffing, DUFFING.excitation(), 2, subharmonic=3)
    with pytest.raises(ValueError, match="subharmonic: 1 received; a whole number of at least 2"):
        subharmonic_orbit(duffing, DUFFING.excitation(), 1)
    with pytest.raises(
        NoPeriodicOrbitError,
        match="5 points lead from frequency 0.15 Hz only to frequency .* Hz, not to 0.4;",
    ):
        follow(path, 0.15, 0.4, most_points=5)
    with pytest.raises(ExcitationError, match="frequency: -1 Hz received"):
        path.at(-1)
    with pytest.raises(ExcitationError, match="lag of input 'pad': the excitation moves push"):
        FrequencyPath(duffing, DUFFING.excitation(), lags_s={"pad": 0.1})
    with pytest.raises(NoPeriodicOrbitError, match="no orbit of 5 periods found at .* among 72 guesses"):
        subharmonic_orbit(duffing, DUFFING.excitation(0.5), 5)


def test_names_that_are_not_there_are_refused(half_car: Model, resonance: Branch) -> None:
    with pytest.raises(KeyError, match="output 'speed': duffing has displacement"):
        resonance.amplitude("speed")
    with pytest.raises((ParameterError, ValueError), match="body.masses"):
        ParameterPath(half_car, ROADS, "body.masses")
