"""Polynomials on the interval 0 to 1, given by their values at Gauss points, and their repeated integrals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

Array = np.ndarray
Weights = tuple[Array, Array, Array]


@dataclass(frozen=True, eq=False)
class Places:
    """Places that are used again and again, so that what belongs to them is computed once.

    Attributes
    ----------
    values
        Between 0 and 1, ascending, shape (places,).
    """

    values: Array


class GaussPoints:
    """Collocation points of the Gauss methods, with the weights of values there for values elsewhere.

    A polynomial of degree count - 1 is a sum of Legendre polynomials P_k(2 x - 1), whose integrals are again
    sums of them, as (2 k + 1) P_k = P'_{k+1} - P'_{k-1}.

    Parameters
    ----------
    count
        Number of points, at least one.

    Attributes
    ----------
    count
        Number of points.
    places
        The points.
    series
        Matrix from the values to the coefficients of the Legendre polynomials, shape (count, count).
    first, second
        Weights of the values for their integral, and its own, from 0 to every point, shape (count, count).
    first_to_end, second_to_end
        The same from 0 to 1, shape (count,).

    Examples
    --------
    >>> points = gauss_points(3)
    >>> fourth_powers = points.places.values**4
    >>> round(float(points.first_to_end @ fourth_powers), 12)
    0.2
    """

    def __init__(self, count: int) -> None:
        self.count = count
        nodes, _ = legendre.leggauss(count)
        self.places = Places((nodes + 1) / 2)
        self.series = np.linalg.inv(legendre.legvander(nodes, count - 1))
        once = legendre.legint(self.series, lbnd=-1, scl=0.5)
        self._integrals = (once, legendre.legint(once, lbnd=-1, scl=0.5))
        _, self.first, self.second = self.weights(self.places.values)
        _, first, second = self.weights(np.ones(1))
        self.first_to_end, self.second_to_end = first[0], second[0]

    def weights(self, places: Array) -> Weights:
        """Weights of the values for those at places, and for both integrals there, (places, count) each."""
        polynomials = legendre.legvander(2 * places - 1, self.count + 1)
        once, twice = self._integrals
        return polynomials[:, :-2] @ self.series, polynomials[:, :-1] @ once, polynomials @ twice

    def moved_by_end(self, accelerations: Array, durations: Array) -> Array:
        """What accelerations add to coordinates and rates by the end of a piece.

        Parameters
        ----------
        accelerations
            Several sets, shape (pieces, points, n, sets).
        durations
            Shape (pieces,).

        Returns
        -------
        numpy.ndarray
            Shape (pieces, 2 n, sets).
        """
        pieces, count, n, sets = accelerations.shape
        weights = np.stack([self.second_to_end, self.first_to_end])
        moved = (weights @ accelerations.reshape(pieces, count, n * sets)).reshape(pieces, 2, n, sets)
        moved[:, 0] *= durations[:, None, None] ** 2
        moved[:, 1] *= durations[:, None, None]
        return moved.reshape(pieces, 2 * n, sets)


@lru_cache
def gauss_points(count: int) -> GaussPoints:
    """Gauss points, computed once for every count."""
    return GaussPoints(count)


@lru_cache
def weights_at(count: int, places: Places) -> Weights:
    """`GaussPoints.weights`, computed once."""
    return gauss_points(count).weights(places.values)


@lru_cache
def equidistant_places(count: int) -> Places:
    """Places from 0 to 1, both among them."""
    return Places(np.linspace(0, 1, count))


@lru_cache
def lobatto_places(count: int) -> Places:
    """Chebyshev's extreme points on 0 to 1, both ends among them."""
    return Places((1 - np.cos(np.pi * np.arange(count) / (count - 1))) / 2)


@lru_cache
def lobatto_series(count: int) -> Array:
    """Matrix from values at `lobatto_places` to Legendre coefficients, shape (count, count)."""
    return np.linalg.inv(legendre.legvander(2 * lobatto_places(count).values - 1, count - 1))


@lru_cache
def lobatto_integrals(count: int) -> tuple[Array, Array]:
    """Weights of values at inner `lobatto_places` for their integral, and its own, (count, count - 2) each.

    Of an outer place nobody knows to which piece a value belongs that jumps there.
    """
    places = 2 * lobatto_places(count).values - 1
    series = np.linalg.inv(legendre.legvander(places[1:-1], count - 3))
    once = legendre.legint(series, lbnd=-1, scl=0.5)
    polynomials = legendre.legvander(places, count - 1)
    return polynomials[:, :-1] @ once, polynomials @ legendre.legint(once, lbnd=-1, scl=0.5)


@lru_cache
def interpolation(count: int, places: Places) -> Array:
    """Matrix from values at `lobatto_places(count)` to those at places, shape (places, count)."""
    return np.asarray(legendre.legvander(2 * places.values - 1, count - 1) @ lobatto_series(count))
