"""A random road surface: its displacement spectrum and the coherence between parallel tracks.

Sources: ISO 8608:1995, Mechanical vibration - Road surface profiles - Reporting of measured data; C. J. Dodds
and J. D. Robson, The description of road surface roughness, Journal of Sound and Vibration 31 (1973) 175-183;
K. M. A. Kamash and J. D. Robson, The application of isotropy in road surface modelling, ibid. 57 (1978)
89-100.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gamma, kv

from chassym.linear.linear_model import LinearisationError

Array = np.ndarray

Coherence = Callable[[Array, Array], Array]
"""Of spatial frequencies (cycles/m) and distances between tracks (m), which broadcast: cross spectrum over
spectrum, real, 1 at no distance. It is the amplitude; the coherence of signal processing is its square."""

CLASSES = "ABCDEFGH"

ROUNDING = 1e-12
"""Relative error of a spatial frequency that was made from a frequency and a speed."""


def full_coherence(spatial_frequency: Array, distance: Array) -> Array:
    """All tracks alike: a cylindrical road, which does not roll the car."""
    return np.ones(np.broadcast_shapes(np.shape(spatial_frequency), np.shape(distance)))


def no_coherence(spatial_frequency: Array, distance: Array) -> Array:
    """Tracks that know nothing of each other."""
    return np.where(np.broadcast_arrays(distance, spatial_frequency)[0] == 0, 1.0, 0.0)


def isotropic_coherence(waviness: float = 2.0) -> Coherence:
    """Coherence of a surface whose profiles have the same spectrum in every direction.

    A surface spectrum in proportion to (n_x^2 + n_y^2)^-(w + 1)/2 has profiles with the spectrum n^-w, and
    its cross spectrum between tracks a distance d apart, the integral over n_y with cos(2 pi n_y d), is
    Basset's: 2 / Gamma(w/2) (pi n d)^(w/2) K_(w/2)(2 pi n d), with K the modified Bessel function.

    Parameters
    ----------
    waviness
        The exponent w of the profile's spectrum, greater than zero.

    Raises
    ------
    LinearisationError
        If the waviness is not greater than zero.

    Examples
    --------
    Tracks of a car hardly know of each other in waves shorter than the track is wide:

    >>> isotropic_coherence()(np.array([0.05, 1 / 1.5]), np.array(1.5)).round(2)
    array([0.84, 0.01])
    """
    _check("waviness", waviness)
    order = waviness / 2

    def coherence(spatial_frequency: Array, distance: Array) -> Array:
        half = np.pi * np.asarray(spatial_frequency) * np.asarray(distance)
        apart = np.where(half > 0, half, 1.0)
        return np.where(half > 0, 2 / gamma(order) * apart**order * kv(order, 2 * apart), 1.0)

    return coherence


def exponential_coherence(decay: float) -> Coherence:
    """Coherence exp(-decay n d), fitted to measured tracks.

    Source: K. Bogsjö, Coherence of road roughness in left and right wheel-path, Vehicle System Dynamics 46
    (2008) supplement, 599-609.

    Parameters
    ----------
    decay
        Greater than zero, without a unit.

    Raises
    ------
    LinearisationError
        If the decay is not greater than zero.
    """
    _check("decay", decay)

    def coherence(spatial_frequency: Array, distance: Array) -> Array:
        return np.exp(-decay * np.asarray(spatial_frequency) * np.asarray(distance))

    return coherence


@dataclass(frozen=True)
class Road:
    """A stationary Gaussian surface; profiles along the road have the one-sided spectrum G (n / n0)^-w.

    Attributes
    ----------
    roughness
        G, the displacement spectrum at the reference (m^3, that is m^2 per cycle/m).
    waviness
        w; at 2 the slope of the profile, and at any speed the vertical velocity of the road, is white noise.
    reference
        n0 (cycles/m).
    longest, shortest
        Spatial frequencies of the longest and the shortest waves (cycles/m). There are none beyond: a
        displacement would grow without limit with the longest, an acceleration often with the shortest ones.
    coherence
        Between parallel tracks; by default that of an isotropic surface of this waviness.

    Raises
    ------
    LinearisationError
        If a number is not greater than zero, or the longest wave is not longer than the shortest one.
    """

    roughness: float
    waviness: float = 2.0
    reference: float = 0.1
    longest: float = 0.011
    shortest: float = 2.83
    coherence: Coherence | None = None

    def __post_init__(self) -> None:
        for each in fields(self)[:-1]:
            _check(each.name, getattr(self, each.name))
        if self.longest >= self.shortest:
            raise LinearisationError(
                f"longest {self.longest:g} received; a spatial frequency below that of the shortest wave, "
                f"{self.shortest:g} cycles/m, is needed"
            )

    def displacement_spectrum(self, spatial_frequency: ArrayLike) -> Array:
        """One-sided spectrum of the height of a profile (m^3); zero beyond the longest and shortest wave.

        Examples
        --------
        >>> iso_8608("A").displacement_spectrum([0.1, 1.0])
        array([1.6e-05, 1.6e-07])
        """
        n = np.asarray(spatial_frequency, dtype=float)
        inside = (n >= self.longest * (1 - ROUNDING)) & (n <= self.shortest * (1 + ROUNDING))
        ratio = np.where(inside, n, self.reference) / self.reference
        return np.where(inside, self.roughness * ratio**-self.waviness, 0.0)

    def track_coherence(self, spatial_frequency: ArrayLike, tracks: ArrayLike) -> Array:
        """Coherence of every track with every other, shape (frequencies, tracks, tracks).

        Parameters
        ----------
        spatial_frequency
            Greater than zero (cycles/m), shape (frequencies,).
        tracks
            Lateral places (m), shape (tracks,).
        """
        places = np.asarray(tracks, dtype=float)
        distances = np.abs(places[:, None] - places[None, :])
        coherence = self.coherence or isotropic_coherence(self.waviness)
        return coherence(np.asarray(spatial_frequency, dtype=float)[:, None, None], distances[None])


def iso_8608(road_class: str) -> Road:
    """The road in the middle of a class of ISO 8608, from "A" (very good) to "H".

    The geometric mean of the roughness is 16e-6 m^3 at 0.1 cycles/m in class A and four times as much in
    every further class; the waviness is 2, and waves are between 0.011 and 2.83 cycles/m. The standard says
    nothing of parallel tracks: the surface is taken to be isotropic; `dataclasses.replace` gives it another
    coherence.

    Raises
    ------
    LinearisationError
        If there is no such class.

    Examples
    --------
    >>> iso_8608("C").roughness
    0.000256
    """
    if road_class not in tuple(CLASSES):
        raise LinearisationError(
            f"road_class {road_class!r} is unknown; ISO 8608 has {', '.join(map(repr, CLASSES))}"
        )
    return Road(roughness=16e-6 * 4 ** CLASSES.index(road_class))


def _check(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise LinearisationError(f"{name} {value!r} received; a finite number greater than zero is needed")
