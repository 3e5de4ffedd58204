"""Ride comfort on a random road: weighted accelerations against one-third octaves and against simulation."""

import numpy as np
import pytest
from scipy.signal import lsim

from chassym.derivation import Model
from chassym.linear import LinearisationError, LinearModel
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.road.random_road import random_response
from chassym.linear.road.ride_comfort import SEAT_PITCH, SEAT_Z, WE, WK, ride_comfort
from chassym.linear.road.road_contacts import Passage, road_contacts
from chassym.linear.road.road_profile import sample_profile
from chassym.linear.road.road_surface import iso_8608

AXES = {"vertical_acceleration": SEAT_Z, "pitch_rate": SEAT_PITCH}


@pytest.fixture(scope="module")
def passage(half_car: Model) -> Passage:
    return Passage(iso_8608("B"), road_contacts(half_car), 20.0)


def test_weighted_accelerations_are_integrals_of_weighted_spectra(
    half_linear: LinearModel, passage: Passage
) -> None:
    """ISO 2631-1, 6.4.2, with bands so narrow that the sum over them is an integral."""
    frequencies = np.linspace(*passage.band_hz, 40001)
    response = random_response(half_linear, passage, frequencies)
    heave, pitch = (response.spectra[response.outputs.index(name)] for name in AXES)
    comfort = ride_comfort(half_linear, passage, AXES)
    weighted = np.sqrt(np.trapezoid(np.abs(WK.response(frequencies)) ** 2 * heave, frequencies))
    assert comfort.weighted["vertical_acceleration"].value == pytest.approx(weighted, rel=1e-4)
    turning = pitch * (2 * np.pi * frequencies) ** 2
    about = np.sqrt(np.trapezoid(np.abs(WE.response(frequencies)) ** 2 * turning, frequencies))
    assert comfort.weighted["pitch_rate"].value == pytest.approx(about, rel=1e-4)
    assert comfort.total == pytest.approx(np.hypot(weighted, 0.4 * about), rel=1e-4)


def test_a_simulated_signal_through_the_filter_has_the_weighted_value(
    half_linear: LinearModel, passage: Passage
) -> None:
    """The car, then the weighting: within 3.5 standard errors of 30 batches of 10 s."""
    profile = sample_profile(passage, 320.0, 400.0, seed=5)
    inputs = np.vstack([profile.displacements, profile.rates])
    car = displacements_and_rates(half_linear)
    _, outputs, _ = lsim((car.A, car.B, car.C, car.D), inputs.T, profile.time_s)
    acceleration = outputs[:, half_linear.outputs.index("vertical_acceleration")]
    _, signal, _ = lsim(WK.polynomials(), acceleration, profile.time_s)
    means = (signal[8000:].reshape(30, -1) ** 2).mean(axis=1)
    expected = ride_comfort(half_linear, passage, {"vertical_acceleration": SEAT_Z}).total ** 2
    standard_error = means.std(ddof=1) / np.sqrt(30)
    assert abs(means.mean() - expected) < 3.5 * standard_error < 0.35 * expected


def test_a_rougher_road_is_less_comfortable(half_linear: LinearModel, half_car: Model) -> None:
    smooth, rough = (
        ride_comfort(half_linear, Passage(iso_8608(c), road_contacts(half_car), 20.0), AXES) for c in "AD"
    )
    assert rough.total == pytest.approx(8 * smooth.total, rel=1e-9)
    assert smooth.words == ("not uncomfortable",) and "very uncomfortable" in rough.words


def test_outputs_that_nobody_feels_are_refused(half_linear: LinearModel, passage: Passage) -> None:
    with pytest.raises(LinearisationError, match=r"'front_wheel_travel' is in m; m/s\^2 is needed"):
        ride_comfort(half_linear, passage, {"front_wheel_travel": SEAT_Z})
    with pytest.raises(LinearisationError, match=r"'pitch_rate' is in rad/s; m/s\^2 is needed"):
        ride_comfort(half_linear, passage, {"pitch_rate": SEAT_Z})
    with pytest.raises(LinearisationError, match="output 'seat' is unknown"):
        ride_comfort(half_linear, passage, {"seat": SEAT_Z})
