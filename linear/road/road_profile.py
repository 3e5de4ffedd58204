"""A random road as a motion in time, for simulation: every contact's height and its rate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chassym.linear.linear_model import LinearisationError
from chassym.linear.road.road_contacts import Passage

if TYPE_CHECKING:
    import xarray

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class RoadProfile:
    """Heights of a road under its contacts, periodic: after the last sample comes the first.

    Attributes
    ----------
    time_s
        Shape (samples,), from zero.
    displacements, rates
        Height of every contact (m) and its rate (m/s), shape (contacts, samples).
    contacts
        Names of the inputs that move, in order.
    """

    time_s: Array
    displacements: Array
    rates: Array
    contacts: tuple[str, ...]

    def to_xarray(self) -> xarray.Dataset:
        """`displacement` and `rate` over `input` and `time`, with units."""
        import xarray  # it takes a second to import: only for those who ask for it

        over = ("input", "time")
        return xarray.Dataset(
            {
                "displacement": (over, self.displacements, {"units": "m"}),
                "rate": (over, self.rates, {"units": "m/s"}),
            },
            coords={"input": list(self.contacts), "time": ("time", self.time_s, {"units": "s"})},
        )


def sample_profile(
    passage: Passage, duration_s: float, sample_rate_hz: float, seed: int | np.random.Generator
) -> RoadProfile:
    """A Gaussian sample of a road with its spectrum, its tracks' coherence and its contacts' delays.

    Harmonics of the duration get independent complex amplitudes with the covariance that the spectra have
    there (M. Shinozuka and C.-M. Jan, Digital simulation of random processes and its applications, Journal of
    Sound and Vibration 25 (1972) 111-128, with random amplitudes beside the random phases); their sum is
    exact at and between the samples, and so is its rate.

    Parameters
    ----------
    passage
        The road, its contacts and the speed.
    duration_s
        Period (s); longer than the longest wave takes to pass.
    sample_rate_hz
        More than twice the frequency of the shortest waves (Hz).
    seed
        Of the random numbers: the same one gives the same road.

    Raises
    ------
    LinearisationError
        If the duration is too short or the sample rate too low for the road at this speed.

    Examples
    --------
    >>> from chassym.linear.road.road_contacts import Contact
    >>> from chassym.linear.road.road_surface import iso_8608
    >>> passage = Passage(iso_8608("A"), {"front": Contact(0, 0), "rear": Contact(2.5, 0)}, speed=10)
    >>> profile = sample_profile(passage, duration_s=60, sample_rate_hz=100, seed=1)
    >>> front, rear = profile.displacements
    >>> bool(np.allclose(rear, np.roll(front, 25)))
    True
    """
    samples = _samples(passage, duration_s, sample_rate_hz)
    frequencies = np.arange(samples // 2 + 1) * (sample_rate_hz / samples)
    low, high = passage.band_hz
    inside = (frequencies >= low) & (frequencies <= high)
    band = frequencies[inside]
    amplitudes = np.zeros((len(passage.contacts), len(frequencies)), dtype=complex)
    amplitudes[:, inside] = _amplitudes(passage, band, sample_rate_hz / samples, np.random.default_rng(seed))
    displacements, rates = (
        np.fft.irfft(each * samples / 2, samples)
        for each in (amplitudes, 2j * np.pi * frequencies * amplitudes)
    )
    return RoadProfile(np.arange(samples) / sample_rate_hz, displacements, rates, tuple(passage.contacts))


def _samples(passage: Passage, duration_s: float, sample_rate_hz: float) -> int:
    low, high = passage.band_hz
    if not (math.isfinite(sample_rate_hz) and sample_rate_hz > 2 * high):
        raise LinearisationError(
            f"sample_rate_hz {sample_rate_hz!r} received; more than {2 * high:g} Hz, twice the frequency of "
            "the shortest waves at this speed, is needed"
        )
    if not (math.isfinite(duration_s) and duration_s * low > 1):
        raise LinearisationError(
            f"duration_s {duration_s!r} received; more than {1 / low:g} s, which the longest wave takes to "
            "pass, is needed"
        )
    return round(duration_s * sample_rate_hz)


def _amplitudes(passage: Passage, band: Array, spacing_hz: float, random: np.random.Generator) -> Array:
    """Complex amplitudes a in u = Re sum a exp(2 pi j f t), shape (contacts, frequencies).

    A harmonic carries the spectrum of its spacing: E[a a^H] = 2 S df.
    """
    values, vectors = np.linalg.eigh(passage.coherence(band))
    root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    normal = random.standard_normal((2, len(band), len(passage.tracks), 1))
    tracks = root @ (normal[0] + 1j * normal[1])
    contacts = (passage.from_tracks(band) @ tracks)[:, :, 0].T
    return contacts * np.sqrt(passage.spectrum(band) * spacing_hz)
