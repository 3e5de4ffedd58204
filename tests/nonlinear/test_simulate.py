"""Time simulation: refusals, labelled results, and a closed form."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, SimulationError, rig, simulate

NOT_INCREASING = [[1.0, 0.5, 0.0], [0.0, 0.5, 0.2], [0.0, np.nan], [0.0, np.inf], [0.0], 5.0]


@pytest.mark.parametrize("times", NOT_INCREASING)
def test_instants_must_increase(quarter_car: Model, times: object) -> None:
    with pytest.raises(ValueError, match="time_s: .* increasing instants are needed"):
        simulate(quarter_car, Harmonic(1.0, {}), np.array(times))


def test_start_must_have_the_state_s_shape(quarter_car: Model) -> None:
    with pytest.raises(ValueError, match=r"start: shape \(3,\) received; \(4,\) is needed"):
        simulate(quarter_car, Harmonic(1.0, {}), np.array([0.0, 1.0]), start=np.zeros(3))


def test_rest_stays_rest(sedan: Model) -> None:
    moved = simulate(sedan, Harmonic(1.0, {}), np.linspace(0, 1, 11))
    assert np.abs(moved.states).max() < 1e-9


def test_results_are_labelled_with_names_and_units(quarter_car: Model) -> None:
    told: list[float] = []
    excitation = Harmonic(2.0, {"road": 0.01})
    moved = simulate(quarter_car, excitation, np.linspace(0, 1, 51), progress=told.append)
    data = moved.to_xarray()
    assert data["wheel_travel"].attrs["units"] == "m" and data["time"].attrs["units"] == "s"
    assert data["wheel_travel"].values == pytest.approx(moved.states[1] - moved.states[0])
    assert told == sorted(told) and told[-1] == pytest.approx(1.0)
    assert moved.knots_crossed > 0


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_motion_without_end_is_an_error(sedan: Model) -> None:
    with pytest.raises(SimulationError, match="check the excitation's amplitude"):
        simulate(sedan, rig.vertical(amplitude_m=1e200), np.array([0.0, 1.0]))
