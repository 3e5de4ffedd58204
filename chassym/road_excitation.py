"""A random road as an excitation in time: the road of the linear stage moves the nonlinear car."""

from __future__ import annotations

import numpy as np

from chassym.linear.road.road_contacts import Passage
from chassym.linear.road.road_profile import sample_profile
from chassym.nonlinear.excitation.time_series import PeriodicTimeSeries

SAMPLES_PER_WAVE = 12
"""Samples of the shortest wave: a spline through so many misses the rate by a few parts in ten thousand."""


def road_excitation(
    passage: Passage,
    duration_s: float,
    seed: int | np.random.Generator,
    samples_per_wave: float = SAMPLES_PER_WAVE,
) -> PeriodicTimeSeries:
    """A sample of a random road that moves every contact of a vehicle: spectrum, tracks and delays as given.

    Parameters
    ----------
    passage
        The road, the contacts of the vehicle and its speed.
    duration_s
        After which the road repeats (s); longer than its longest wave takes to pass.
    seed
        Of the random numbers: the same one gives the same road.
    samples_per_wave
        Samples of the shortest wave; more than two. The curve through them is a cubic spline.

    Raises
    ------
    LinearisationError
        If the duration is too short or there are too few samples.

    Examples
    --------
    >>> import chassym
    >>> from chassym.linear.road.road_contacts import road_contacts
    >>> from chassym.linear.road.road_surface import iso_8608
    >>> car = chassym.load_model("half_car")
    >>> passage = Passage(iso_8608("C"), road_contacts(car), speed=20.0)
    >>> road = road_excitation(passage, duration_s=10.0, seed=1)
    >>> heights, rates = road.signals(car, np.array([1.0, 1.0 + 2.766 / 20.0]))
    >>> bool(np.isclose(heights[0, 0], heights[1, 1], rtol=1e-3))
    True
    """
    samples = np.ceil(samples_per_wave * passage.band_hz[1] * duration_s)
    profile = sample_profile(passage, duration_s, samples / duration_s, seed)
    heights = np.concatenate([profile.displacements, profile.displacements[:, :1]], axis=1)
    return PeriodicTimeSeries(
        np.append(profile.time_s, duration_s),
        dict(zip(profile.contacts, heights, strict=True)),
        dict.fromkeys(profile.contacts, "m"),
    )
