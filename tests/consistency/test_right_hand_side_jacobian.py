"""The right-hand side's Jacobian at the design position is the linear model's state matrix."""

import numpy as np
import pytest

from chassym.derivation import load_model, vehicle_names
from chassym.linear import displacements_and_rates, linearise, mean_slope
from chassym.nonlinear import Harmonic
from chassym.nonlinear.simulation.right_hand_side import RightHandSide


@pytest.mark.parametrize("name", vehicle_names())
def test_state_matrix(name: str) -> None:
    """With the mean of both slopes at the dampers' knots, as both stages take it."""
    model = load_model(name)
    expected = displacements_and_rates(linearise(model, mean_slope))
    found = RightHandSide(model, Harmonic(1.0, {})).jacobian(0.0, np.zeros(2 * model.size))
    assert np.abs(found - expected.A).max() < 1e-10 * np.abs(found).max()
