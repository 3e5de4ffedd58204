"""Refinement of an orbit: what it does to a rough one, what it refuses, and whether stated errors hold."""

from collections.abc import Mapping
from itertools import islice

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, rig, steady_state
from chassym.nonlinear.collocation.refinement import FEWEST_POINTS, refinements
from chassym.nonlinear.harmonics.harmonic_balance import at_rest, newton
from chassym.nonlinear.orbits.metrics import Reader
from chassym.nonlinear.steady.result import SteadyState

from .random_cases import random_cases


def guessed(model: Model, excitation: Harmonic, harmonics: int = 5):
    return newton(at_rest(model, excitation, harmonics), 0.1).orbit


def test_every_step_has_a_point_more_and_corrections_shrink(sedan: Model) -> None:
    found = list(islice(refinements(guessed(sedan, rig.vertical()), rough=0.1), 4))
    assert [each.orbit.points for each in found] == [FEWEST_POINTS + more for more in (1, 2, 3, 4)]
    corrections = [each.correction for each in found]
    assert corrections[2] < 1e-3 * corrections[0]
    assert corrections[3] < 1e-7


def test_jumps_between_pieces_shrink_with_the_error(sedan: Model) -> None:
    """They are what the motion lacks to be an orbit, so they tell how far off it is."""
    found = [each.orbit for each in islice(refinements(guessed(sedan, rig.vertical()), rough=0.1), 4)]
    exact = found.pop().motion_at(np.linspace(0, 6, 50))
    jumps = [np.abs(orbit.jumps).max() for orbit in found]
    errors = [np.abs(orbit.motion_at(np.linspace(0, 6, 50)) - exact).max() for orbit in found]
    assert jumps[2] < 1e-3 * jumps[0]
    assert 0.1 < np.median(np.array(errors) / jumps) < 10


def test_the_guess_does_not_matter(sedan: Model) -> None:
    values = []
    for harmonics in (1, 3, 12):
        start = guessed(sedan, rig.lateral(), harmonics)
        found = steady_state(sedan, rig.lateral(), metrics=["yaw_rate"], tolerance=1e-9, start=start)
        values.append(found.peak_to_peak["yaw_rate"].value)
    assert values == pytest.approx([values[0]] * 3, rel=1e-9)


def test_rough_pieces_are_halved_until_they_are_smooth(sedan: Model) -> None:
    """Where little roughness is allowed, there are more pieces and the same orbit."""
    ends = []
    for rough in (1.0, 1e-5):
        for refined in refinements(guessed(sedan, rig.vertical()), rough):
            if refined.orbit.points == 8:
                ends.append(refined.orbit)
                break
    coarse, fine = ends
    assert len(fine.starts) > 1.5 * len(coarse.starts)
    assert fine.state() == pytest.approx(coarse.state(), abs=1e-4 * np.abs(fine.state()).max())


def test_a_motion_too_rough_is_refused(sedan: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("chassym.nonlinear.collocation.refinement.MOST_PIECES", 30)
    with pytest.raises(NoPeriodicOrbitError, match="more than 30 pieces .* ask for less accuracy"):
        for _ in refinements(guessed(sedan, rig.vertical()), rough=1e-6):
            pass


def test_stated_errors_shrink_with_the_tolerance(sedan: Model) -> None:
    found = [steady_state(sedan, rig.vertical(), tolerance=t) for t in (1e-3, 1e-5, 1e-7)]
    for name in found[0].peak_to_peak:
        errors = [each.peak_to_peak[name].error for each in found]
        assert errors[2] < errors[0]
    for each, tolerance in zip(found, (1e-3, 1e-5, 1e-7), strict=True):
        relative = [metric.error / metric.value for metric in each.peak_to_peak.values()]
        assert max(relative) < 2 * tolerance


def _readings(found: SteadyState) -> tuple[np.ndarray, np.ndarray]:
    """Values and stated errors of all metrics and of the patch that carries least."""
    metrics = [*found.peak_to_peak.values(), *([found.contact] if found.contact else [])]
    return np.array([m.value for m in metrics]), np.array([m.error for m in metrics])


@pytest.fixture(scope="module")
def built_in(sedan: Model, quarter_car: Model, half_car: Model) -> Mapping[str, Model]:
    return {"sedan": sedan, "quarter_car": quarter_car, "half_car": half_car}


def judged(built_in: Mapping[str, Model], count: int, seed: int) -> tuple[np.ndarray, np.ndarray, list[bool]]:
    """True and stated errors of all metrics, and of every case whether its worst metric is covered."""
    true, stated, worst = [], [], []
    for case in random_cases(built_in, count, seed):
        found = steady_state(case.model, case.excitation, tolerance=case.tolerance)
        exact, _ = _readings(steady_state(case.model, case.excitation, tolerance=1e-10))
        values, errors = _readings(found)
        reader = Reader(case.model, list(found.peak_to_peak))
        scale = reader.scale(reader.read(found.orbit))[: len(found.peak_to_peak)]
        off = np.abs(values - exact)
        assert np.all(errors[: len(scale)] <= case.tolerance * scale * (1 + 1e-9) + 2e-12)
        true.append(off)
        stated.append(errors)
        worst.append(bool((off[: len(scale)] / scale).max() <= (errors[: len(scale)] / scale).max()))
    return np.concatenate(true), np.concatenate(stated), worst


def _check(true: np.ndarray, stated: np.ndarray, worst: list[bool], covered: float) -> None:
    assert np.mean(true <= stated) >= covered
    assert np.mean(worst) >= covered - 0.02
    assert 1 < np.median(stated / np.maximum(true, 1e-15)) <= 30


def test_stated_errors_cover_the_true_ones_of_a_few_vehicles(built_in: Mapping[str, Model]) -> None:
    _check(*judged(built_in, 20, 7), covered=0.9)


@pytest.mark.slow
def test_stated_errors_cover_19_of_20_true_ones(built_in: Mapping[str, Model]) -> None:
    """300 random vehicles in random tests, and not by more than 30 times in the median."""
    true, stated, worst = judged(built_in, 300, 2026)
    print(f"\ncovered {np.mean(true <= stated):.4f}, stated/true {np.median(stated / (true + 1e-15)):.1f}")
    _check(true, stated, worst, covered=0.95)
