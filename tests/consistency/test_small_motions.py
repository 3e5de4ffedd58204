"""Small motions: the nonlinear steady state is the linear frequency response, but for what a knot at zero
makes.
"""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.linear import frequency_response, linearise
from chassym.nonlinear import Harmonic, rig, steady_state

SMALL = 1e-4
TESTS = [rig.lateral(), rig.vertical(), rig.heave(1.0), rig.heave(9.5)]
NAMES = ["lateral", "vertical", "heave at 1 Hz", "heave at 9.5 Hz"]


@pytest.fixture(scope="module")
def without_knot_at_zero(sedan: Model) -> Model:
    """The reference car whose damper tables are straight through zero; their other knots stay."""
    straight = {
        f"suspension.{axle}.damper.force": [-2400.0, -15 * slope, 0.0, 10 * slope, 1100.0]
        for axle, slope in (("front", 50.0), ("rear", 20.0))
    }
    return sedan.with_parameters(straight)


def _amplitudes(model: Model, excitation: Harmonic) -> tuple[np.ndarray, np.ndarray]:
    """Peak-to-peak values by both routes, per unit of the excitation."""
    small = excitation.scaled(SMALL)
    found = steady_state(model, small, tolerance=1e-7)
    response = frequency_response(linearise(model), [excitation.frequency_hz])
    names = list(found.peak_to_peak)
    linear = [2 * abs(response.combined(name, dict(small.amplitudes))[0]) for name in names]
    return np.array([found.peak_to_peak[name].value for name in names]), np.array(linear)


@pytest.mark.parametrize("excitation", TESTS, ids=NAMES)
def test_without_a_knot_both_stages_are_the_same_model(
    without_knot_at_zero: Model, excitation: Harmonic
) -> None:
    nonlinear, linear = _amplitudes(without_knot_at_zero, excitation)
    moving = linear > 1e-6 * linear.max()
    assert moving.sum() >= 3
    assert nonlinear[moving] == pytest.approx(linear[moving], rel=1e-6)


def test_the_knot_at_zero_makes_a_difference_at_any_amplitude(sedan: Model) -> None:
    """The reference table has slopes 978 and 3912 N s/m at zero: the mean slope misses what their difference
    does.
    """
    metrics = ["vertical_acceleration", "pitch_rate"]
    linear = frequency_response(linearise(sedan), [3.0])
    small, smaller = (steady_state(sedan, rig.vertical().scaled(s), metrics=metrics) for s in (1e-3, 1e-4))
    for name in metrics:
        ratio = small.peak_to_peak[name].value / smaller.peak_to_peak[name].value
        assert ratio == pytest.approx(10.0, rel=0.01), "the motion is homogeneous of degree one, not linear"
        predicted = 2 * abs(linear.combined(name, dict(rig.vertical().scaled(1e-4).amplitudes))[0])
        assert predicted < 0.05 * smaller.peak_to_peak[name].value, (
            "by symmetry the linear twist has no heave"
        )
