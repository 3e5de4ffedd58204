"""Excitations and the tests of the rig: what the pads do, and what is refused."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import ExcitationError, Harmonic, rig


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan, np.inf])
def test_impossible_frequency_is_refused(frequency: float) -> None:
    with pytest.raises(ExcitationError, match="frequency"):
        Harmonic(frequency, {})


@pytest.mark.parametrize("amplitude", [np.nan, np.inf, complex(0, np.nan)])
def test_impossible_amplitude_is_refused_by_name(amplitude: complex) -> None:
    with pytest.raises(ExcitationError, match="'road'"):
        Harmonic(1.0, {"road": amplitude})


def test_unknown_input_is_refused_by_name(quarter_car: Model) -> None:
    with pytest.raises(ExcitationError, match="'rode'.*road"):
        Harmonic(1.0, {"rode": 0.01}).vector(quarter_car)


def test_lateral_pads_reach_six_tenths_of_gravity_and_the_rear_lags() -> None:
    test = rig.lateral()
    front, rear = test.amplitudes["front_left_pad_y"], test.amplitudes["rear_right_pad_y"]
    assert abs(front) * test.angular_frequency**2 == pytest.approx(0.6 * 9.81)
    assert abs(front) == pytest.approx(0.01657, abs=5e-6)
    assert rear / front == pytest.approx(np.exp(-1j * test.angular_frequency * 0.2))


def test_twist_and_heave_move_the_pads_as_named() -> None:
    twist = {name: value.real for name, value in rig.vertical().amplitudes.items()}
    assert twist == {
        "front_left_pad_z": 0.025,
        "front_right_pad_z": -0.025,
        "rear_left_pad_z": -0.025,
        "rear_right_pad_z": 0.025,
    }
    assert set(rig.heave().amplitudes.values()) == {0.01}
