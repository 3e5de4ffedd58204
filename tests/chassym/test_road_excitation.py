"""A random road in time: the sample of the linear stage, between its samples too, under a simulated car."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.linear import LinearisationError
from chassym.linear.road.road_contacts import Passage, road_contacts
from chassym.linear.road.road_profile import sample_profile
from chassym.linear.road.road_surface import iso_8608
from chassym.nonlinear import simulate
from chassym.road_excitation import road_excitation


@pytest.fixture(scope="module")
def passage(sedan: Model) -> Passage:
    return Passage(iso_8608("C"), road_contacts(sedan), speed=20.0)


def test_heights_and_rates_are_those_of_the_sum_of_waves(sedan: Model, passage: Passage) -> None:
    """The same road sampled eight times as often, which is exact at its samples."""
    samples, seed = 12, 5
    road = road_excitation(passage, 10.0, seed, samples)
    exact = sample_profile(passage, 10.0, 8 * (len(road.time_s) - 1) / 10.0, seed)
    rows = [[u.name for u in sedan.system.inputs].index(name) for name in exact.contacts]
    heights, rates = (each[rows] for each in road.signals(sedan, exact.time_s))
    assert np.abs(heights - exact.displacements).max() < 1e-4 * exact.displacements.std()
    assert (rates - exact.rates).std() < 1e-3 * exact.rates.std()


def test_rear_wheels_follow_in_their_tracks_and_sideways_pads_stand_still(
    sedan: Model, passage: Passage
) -> None:
    road = road_excitation(passage, 10.0, 1)
    names = [u.name for u in sedan.system.inputs]
    times, delay = np.linspace(1, 8, 300), passage.contacts["rear_left_pad_z"].x / passage.speed
    now, later = (dict(zip(names, road.signals(sedan, t)[0], strict=True)) for t in (times, times + delay))
    for side in ("left", "right"):
        front, rear = now[f"front_{side}_pad_z"], later[f"rear_{side}_pad_z"]
        assert np.abs(front - rear).max() < 1e-3 * front.std()
    assert not np.allclose(now["front_left_pad_z"], now["front_right_pad_z"], atol=1e-3)
    assert not now["front_left_pad_x"].any()


def test_the_road_repeats_and_depends_on_its_seed(half_car: Model) -> None:
    passage = Passage(iso_8608("A"), road_contacts(half_car), speed=10.0)
    times = np.linspace(0, 12, 50)
    one, same, other = (road_excitation(passage, 12.0, seed) for seed in (1, 1, 2))
    here, again = one.signals(half_car, times), same.signals(half_car, times + 12.0)
    np.testing.assert_allclose(here, again, atol=1e-9)
    assert not np.allclose(here, other.signals(half_car, times), atol=1e-4)


def test_a_road_too_short_is_refused(passage: Passage) -> None:
    with pytest.raises(LinearisationError, match="duration_s 1.0 received"):
        road_excitation(passage, 1.0, 1)


def test_a_car_drives_over_it(sedan: Model, passage: Passage) -> None:
    moved = simulate(sedan, road_excitation(passage, 10.0, 1), np.linspace(0, 2, 201))
    acceleration = moved.to_xarray()["vertical_acceleration"]
    assert 0.1 < float(acceleration.std()) < 5 and moved.events["knot"] > 50
