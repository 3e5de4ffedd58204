"""Shooting, and waiting for transients to die out: known orbits, deviations, and what is refused."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, SimulationError, rig, simulate, steady_state
from chassym.nonlinear.collocation.collocation import Linearisation
from chassym.nonlinear.collocation.floquet import monodromy
from chassym.nonlinear.steady.integrated_orbit import IntegratedOrbit, integrated_orbit
from chassym.nonlinear.steady.shooting import shooting_steady_state
from chassym.nonlinear.steady.waiting import waited_steady_state

from .duffing import Duffing

METHODS = [
    pytest.param(shooting_steady_state, id="shooting"),
    pytest.param(waited_steady_state, id="waiting"),
]
SMOOTH = Duffing(damping=0.3, stiffness=1.0, cubic=0.5, force=0.6)


@pytest.mark.parametrize("method", METHODS)
def test_a_smooth_orbit_is_the_one_shot_elsewhere(method) -> None:
    found = method(SMOOTH.model(), SMOOTH.excitation(0.8), metrics=["displacement"], tolerance=1e-8)
    state, expected = SMOOTH.shot(found.orbit.state(), 0.8)
    assert found.orbit.state() == pytest.approx(state, abs=1e-7)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(expected), abs=1e-7)
    assert found.statistics.correction < 1e-7 and found.statistics.unknowns == 2


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
@pytest.mark.parametrize("method", METHODS)
def test_stated_errors_hold_across_knots(quarter_car: Model, method, tolerance: float) -> None:
    excitation = Harmonic(2.0, {"road": 0.03})
    found = method(quarter_car, excitation, tolerance=tolerance)
    exact = steady_state(quarter_car, excitation, tolerance=1e-11)
    metric, expected = (s.peak_to_peak["vertical_acceleration"] for s in (found, exact))
    assert abs(metric.value - expected.value) <= metric.error + 1e-10 * expected.value
    assert metric.error <= tolerance * metric.value
    assert found.contact is not None and exact.contact is not None
    assert abs(found.contact.value - exact.contact.value) <= found.contact.error + 1e-6


def test_the_orbit_is_the_simulated_motion(quarter_car: Model) -> None:
    """Also where it does not close, between the instants at which it was sampled, and across its knots."""
    excitation, state = Harmonic(1.5, {"road": 0.04}), np.array([0.01, -0.02, 0.3, 0.1])
    orbit = integrated_orbit(quarter_car, excitation, state, 1e-12)
    times = np.linspace(0, excitation.period_s, 203)
    moved = simulate(quarter_car, excitation, times, start=state, relative_tolerance=1e-12).states
    inside = orbit.motion_at(2 * np.pi * times[:-1] / excitation.period_s)
    assert inside == pytest.approx(moved[:, :-1], abs=1e-9)
    assert orbit.end == pytest.approx(moved[:, -1], abs=1e-10)
    assert orbit.gap == pytest.approx(moved[:, -1] - state, abs=1e-10)


@pytest.mark.parametrize("name", ["quarter_car", "sedan"])
def test_deviations_by_integration_and_by_collocation_are_the_same(
    request: pytest.FixtureRequest, name: str
) -> None:
    model = request.getfixturevalue(name)
    excitation = rig.vertical() if name == "sedan" else Harmonic(2.0, {"road": 0.03})
    orbit = integrated_orbit(model, excitation, np.zeros(2 * model.size), 1e-11)
    by_collocation = Linearisation(orbit).monodromy
    assert monodromy(orbit) == pytest.approx(by_collocation, abs=1e-8 * np.abs(by_collocation).max())


def test_closing_is_newtons_step(quarter_car: Model) -> None:
    """A second one from nearby leaves the square of what the first one left."""
    excitation, state = Harmonic(2.0, {"road": 0.03}), np.zeros(4)
    gaps = []
    for _ in range(5):
        orbit = integrated_orbit(quarter_car, excitation, state, 1e-12)
        gaps.append(orbit.relative_gap)
        state = state + orbit.closing
    assert gaps[0] > 1e-2 and gaps[-1] < 1e-10


def test_shooting_finds_an_unstable_orbit(quarter_car: Model) -> None:
    """Between two folds of Duffing's response there are three orbits; the middle one repels."""
    duffing = Duffing(damping=0.1, stiffness=1.0, cubic=1.0, force=0.4)
    model, excitation = duffing.model(), duffing.excitation(1.7)
    low = shooting_steady_state(model, excitation, metrics=["displacement"], tolerance=1e-6)
    assert low.is_stable
    balanced = [Duffing.one_harmonic(duffing, 1.7, a) for a in np.linspace(0.05, 2.5, 500)]
    amplitudes = np.linspace(0.05, 2.5, 500)[:-1][np.diff(np.sign(balanced)) != 0]
    assert len(amplitudes) == 3
    phase = np.arccos(
        (duffing.stiffness - 1.7**2 + 0.75 * amplitudes[1] ** 2) * amplitudes[1] / duffing.force
    )
    guess = amplitudes[1] * np.array([np.cos(phase), 1.7 * np.sin(phase)])
    start = integrated_orbit(model, excitation, guess, 1e-6)
    middle = shooting_steady_state(model, excitation, metrics=["displacement"], tolerance=1e-6, start=start)
    assert not middle.is_stable
    assert middle.peak_to_peak["displacement"].value == pytest.approx(2 * amplitudes[1], rel=0.1)
    left = waited_steady_state(model, excitation, metrics=["displacement"], tolerance=1e-6, start=start)
    assert left.is_stable, "a motion does not stay on an orbit that repels"


def test_what_never_settles_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("chassym.nonlinear.steady.waiting._MOST_PERIODS", 50)
    lightly = Duffing(damping=1e-4, cubic=0.0)
    with pytest.raises(NoPeriodicOrbitError, match="50 are waited at most; give it more damping"):
        waited_steady_state(lightly.model(), lightly.excitation(0.7), metrics=["displacement"])


@pytest.mark.parametrize("method", METHODS)
def test_undamped_resonance_has_no_orbit(method, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("chassym.nonlinear.steady.waiting._MOST_PERIODS", 200)
    undamped = Duffing(damping=0.0, cubic=0.0)
    with pytest.raises(NoPeriodicOrbitError, match="some stiffness|still misses|more damping"):
        method(undamped.model(), undamped.excitation(1.0), metrics=["displacement"])


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("method", METHODS)
def test_a_motion_that_cannot_be_integrated_is_an_error(sedan: Model, method) -> None:
    with pytest.raises(SimulationError, match="integration stopped at"):
        method(sedan, rig.vertical(amplitude_m=1e200))


@pytest.mark.parametrize("method", METHODS)
def test_impossible_accuracy_is_refused(quarter_car: Model, method) -> None:
    with pytest.raises((NoPeriodicOrbitError, ValueError), match="less accuracy|received"):
        method(quarter_car, Harmonic(2.0, {"road": 0.03}), tolerance=1e-15)
    with pytest.raises(ValueError, match="tolerance: 0.0 received"):
        method(quarter_car, Harmonic(2.0, {"road": 0.03}), tolerance=0.0)


def test_an_orbit_of_several_periods_is_shot_too() -> None:
    """Around twice its period, an orbit of one period is the same motion with squared multipliers."""
    model, excitation = SMOOTH.model(), SMOOTH.excitation(0.8)
    once, twice = (
        shooting_steady_state(model, excitation, metrics=["displacement"], tolerance=1e-8, subharmonic=count)
        for count in (1, 2)
    )
    assert isinstance(twice.orbit, IntegratedOrbit)
    assert twice.orbit.period_s == pytest.approx(2 * once.orbit.period_s)
    assert np.sort(np.abs(twice.multipliers)) == pytest.approx(
        np.sort(np.abs(once.multipliers)) ** 2, abs=1e-7
    )
