"""The two reference tests by four independent methods: collocation in pieces, shooting, integration until the
transients have died out, and a Fourier series.
"""

import numpy as np
import pytest

from chassym.derivation import Model, with_lifting_tyres
from chassym.nonlinear import (
    Harmonic,
    SteadyState,
    harmonic_steady_state,
    rig,
    shooting_steady_state,
    steady_state,
    waited_steady_state,
)

AGREED = 1e-7
TESTS = [pytest.param(rig.lateral(), id="lateral"), pytest.param(rig.vertical(), id="vertical")]


def assert_same(found: SteadyState, expected: SteadyState, relative: float) -> None:
    """Every metric, the smallest patch force, the state and the largest multipliers."""
    for name, metric in expected.peak_to_peak.items():
        assert found.peak_to_peak[name].value == pytest.approx(metric.value, rel=relative), name
        difference = abs(found.peak_to_peak[name].value - metric.value)
        assert difference <= 3 * (found.peak_to_peak[name].error + metric.error) + 1e-12, name
    assert found.contact is not None and expected.contact is not None
    # Left and right tie in a symmetric car.
    assert found.contact.patch.split("_")[0] == expected.contact.patch.split("_")[0]
    assert found.contact.value == pytest.approx(expected.contact.value, rel=relative)
    scale = np.abs(expected.orbit.state()).max()
    assert found.orbit.state() == pytest.approx(expected.orbit.state(), abs=10 * relative * scale)
    assert np.abs(found.multipliers[:6]) == pytest.approx(np.abs(expected.multipliers[:6]), abs=1e-6)


@pytest.mark.parametrize("excitation", TESTS)
def test_collocation_and_shooting(sedan: Model, excitation: Harmonic) -> None:
    refined = steady_state(sedan, excitation, tolerance=1e-9)
    shot = shooting_steady_state(sedan, excitation, tolerance=AGREED)
    assert_same(shot, refined, AGREED)


def test_tyres_in_the_air_for_a_third_of_the_time(sedan: Model) -> None:
    lifting, excitation = with_lifting_tyres(sedan), rig.heave(10.0, 0.01)
    refined = steady_state(lifting, excitation, tolerance=1e-8)
    shot = shooting_steady_state(lifting, excitation, tolerance=1e-6)
    losses = rig.contact_losses(refined.orbit)
    assert {loss.patch for loss in losses} == {"rear_left", "rear_right"}
    assert all(0.25 < loss.share < 0.4 and loss.is_in_the_air for loss in losses)
    for name in ("longitudinal_acceleration", "vertical_acceleration", "pitch_rate"):
        assert shot.peak_to_peak[name].value == pytest.approx(refined.peak_to_peak[name].value, rel=AGREED)


@pytest.mark.slow
@pytest.mark.parametrize("excitation", TESTS)
def test_collocation_and_waiting_for_the_transients_to_die_out(sedan: Model, excitation: Harmonic) -> None:
    refined = steady_state(sedan, excitation, tolerance=1e-9)
    waited = waited_steady_state(sedan, excitation, tolerance=AGREED)
    assert_same(waited, refined, AGREED)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize("excitation", TESTS)
def test_a_fourier_series_is_within_its_stated_error(
    sedan: Model, excitation: Harmonic, tolerance: float
) -> None:
    refined = steady_state(sedan, excitation, tolerance=1e-9)
    series = harmonic_steady_state(sedan, excitation, tolerance=tolerance)
    for name, metric in series.peak_to_peak.items():
        expected = refined.peak_to_peak[name].value
        assert abs(metric.value - expected) <= metric.error + 1e-9 * expected, name
        assert abs(metric.value - expected) <= tolerance * expected, name
    assert series.contact is not None and refined.contact is not None
    assert abs(series.contact.value - refined.contact.value) <= series.contact.error
    assert np.abs(series.multipliers[:4]) == pytest.approx(np.abs(refined.multipliers[:4]), abs=1e-2)


@pytest.mark.parametrize("excitation", TESTS)
def test_harmonics_of_outputs_are_the_same(sedan: Model, excitation: Harmonic) -> None:
    refined = steady_state(sedan, excitation, tolerance=1e-8).orbit.harmonic_content(7)
    series = harmonic_steady_state(sedan, excitation, tolerance=1e-6).orbit.harmonic_content(7)
    scale = np.abs(refined).max(axis=1, keepdims=True) + 1e-9
    assert series / scale == pytest.approx(refined / scale, abs=1e-4)
