"""Stability where forces jump, against the motion of neighbours integrated from event to event."""

import numpy as np
import pytest
import sympy

from chassym.derivation import ForceLaw, Model
from chassym.nonlinear import Harmonic, simulate, steady_state
from chassym.nonlinear.collocation.floquet import monodromy

from .oscillator import oscillator

DEFLECTION, RATE = sympy.symbols("deflection rate", real=True)
STEP = 1e-6


def carried_around(model: Model, excitation: Harmonic, state: np.ndarray) -> np.ndarray:
    """The map of small deviations from a state over a period, by differences of integrated motions."""

    def after(start: np.ndarray) -> np.ndarray:
        times = np.array([0.0, excitation.period_s])
        return simulate(model, excitation, times, start=start, relative_tolerance=1e-11).states[:, -1]

    steps = STEP * np.eye(len(state))
    return np.array([(after(state + step) - after(state - step)) / (2 * STEP) for step in steps]).T


@pytest.mark.parametrize(
    "law",
    [
        ForceLaw(0.4 * sympy.sign(RATE), rate=RATE),
        ForceLaw(-2.0 * sympy.Heaviside(DEFLECTION - 0.005), deflection=DEFLECTION),
        ForceLaw(-4.0 * sympy.Heaviside(DEFLECTION - 0.005), deflection=DEFLECTION),
        ForceLaw(3.0 * sympy.Max(DEFLECTION - 0.005, 0) / 0.005, deflection=DEFLECTION),
    ],
    ids=["dry friction", "a pull that destabilises", "a stronger one", "no jump"],
)
def test_multipliers_where_a_force_jumps(law: ForceLaw) -> None:
    model, excitation = oscillator(800.0, 4.0, law), Harmonic(2.0, {"road": 0.01})
    steady = steady_state(model, excitation, tolerance=1e-8)
    expected = carried_around(model, excitation, steady.orbit.state())
    np.testing.assert_allclose(np.trace(monodromy(steady.orbit)), np.trace(expected), atol=2e-3)
    largest = np.abs(np.linalg.eigvals(expected)).max()
    assert np.abs(steady.multipliers[0]) == pytest.approx(largest, rel=1e-3)
    assert steady.is_stable == (largest < 1)
