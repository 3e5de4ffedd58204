"""The steady states of the three tests against long time integration from rest, exact about the knots."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, rig, simulate, steady_state
from chassym.nonlinear.collocation.floquet import monodromy
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

SAMPLES = 40_000
"""Samples of the last period: a corner's tip may lie half a sample from the nearest."""


@pytest.mark.parametrize(
    ("excitation", "periods"),
    [
        pytest.param(rig.lateral(), 180, id="lateral", marks=pytest.mark.slow),
        pytest.param(rig.vertical(), 170, id="vertical", marks=pytest.mark.slow),
        pytest.param(rig.heave(1.0), 25, id="heave at the body's peak"),
        pytest.param(rig.heave(9.5), 600, id="heave at the wheels' peak", marks=pytest.mark.slow),
    ],
)
def test_every_metric_agrees(sedan: Model, excitation: Harmonic, periods: int) -> None:
    """The slowest multiplier is 0.904 per period of the lateral and twist tests: 180 periods leave 1e-8."""
    found = steady_state(sedan, excitation)
    last = np.linspace(periods - 1, periods, SAMPLES + 1) * excitation.period_s
    moved = simulate(sedan, excitation, np.concatenate([[0.0], last]), relative_tolerance=1e-9)
    assert moved.states[:, 1] == pytest.approx(moved.states[:, -1], abs=1e-7), "transients must have died out"
    outputs = dict(zip(sedan.output_names, moved.outputs()[:, 1:], strict=True))
    _compare(found.peak_to_peak, {name: np.ptp(outputs[name]) for name in found.peak_to_peak}, outputs)
    assert found.contact is not None
    forces = [outputs[f"{corner}_patch_force_z"].min() for corner in rig.CORNERS]
    assert abs(found.contact.value - min(forces)) < max(found.contact.error, 1e-4 * abs(min(forces)))


def _compare(metrics: dict, integrated: dict[str, float], outputs: dict[str, np.ndarray]) -> None:
    for name, metric in metrics.items():
        # What the sampling may miss at a tip: half the largest step between neighbouring samples, at both
        # tips.
        sampling = np.abs(np.diff(outputs[name])).max()
        vanishing = 1e-8
        difference = abs(metric.value - integrated[name])
        assert difference < 1e-4 * metric.value + vanishing, name
        assert difference < metric.error + sampling + vanishing, name


def test_deviations_move_as_the_monodromy_matrix_says(sedan: Model) -> None:
    """Integration beside the orbit over one period, in eight directions at once by eight runs."""
    excitation = rig.lateral()
    orbit = steady_state(sedan, excitation, tolerance=1e-6).orbit
    generator = np.random.default_rng(3)
    assert isinstance(orbit, PiecewiseOrbit)
    begin = orbit.state(orbit.boundaries[0])
    times = orbit.boundaries[0] / excitation.angular_frequency + np.array([0.0, excitation.period_s])
    for _ in range(8):
        deviation = 1e-5 * generator.normal(size=2 * sedan.size)
        deviation[sedan.size :] *= excitation.angular_frequency
        moved = simulate(sedan, excitation, times, start=begin + deviation, relative_tolerance=1e-10)
        left = moved.states[:, 1] - begin
        assert np.linalg.norm(monodromy(orbit) @ deviation - left) < 0.01 * np.linalg.norm(left)
