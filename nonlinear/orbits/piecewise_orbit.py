"""A periodic orbit in pieces: polynomials between the instants at which a force bends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.polynomial import legendre

from chassym.derivation import Model, Singularity
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.orbits.gauss_points import (
    Places,
    equidistant_places,
    gauss_points,
    interpolation,
    lobatto_integrals,
    lobatto_places,
    lobatto_series,
    weights_at,
)
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit

Array = np.ndarray

_DENSE, _ZOOMS, _NARROWER = 33, 3, 8.0
"""Places of a piece where an extreme is looked for, how many parabolas are laid around the best one, and by
how much each is narrower than the one before.
"""

_CANDIDATES = 3
"""Pieces in which an extreme is looked for: peaks may be too alike for places to tell which is higher."""

_BEYOND = 3
"""An output, no polynomial itself, is interpolated at so many more places than accelerations have points."""


_AT_REST = 1e-9
"""Largest rate of what does not move (m/s or rad/s)."""


@dataclass(frozen=True, eq=False)
class PiecewiseOrbit(PeriodicOrbit):
    """Accelerations that are polynomials between boundaries; rates and coordinates are their integrals.

    Attributes
    ----------
    model, excitation
        What moves and what moves it.
    boundaries
        Phases (rad) between which the motion is smooth, ascending, shape (pieces + 1,); the last is the first
        one 2 pi later.
    starts
        Coordinates and rates at the beginning of every piece, shape (pieces, 2 n).
    accelerations
        At the Gauss points of every piece, shape (pieces, points, n).
    subharmonic
        Periods of the excitation after which the orbit repeats.
    """

    model: Model
    excitation: Harmonic
    boundaries: Array = field(repr=False)
    starts: Array = field(repr=False)
    accelerations: Array = field(repr=False)
    subharmonic: int = 1

    @property
    def points(self) -> int:
        """Gauss points of a piece."""
        return self.accelerations.shape[1]

    @property
    def highest_coefficient(self) -> Array:
        """Weights of a piece's accelerations for their Legendre coefficient of highest order, (points,)."""
        return gauss_points(self.points).series[-1]

    @cached_property
    def durations_s(self) -> Array:
        """Length of every piece in time (s)."""
        return np.diff(self.boundaries) / self.angular_frequency

    @property
    def largest_rate(self) -> float:
        """Of all coordinates (m/s or rad/s), not less than rounding may make of a motion at rest."""
        return max(float(np.abs(self.starts[:, self.model.size :]).max()), _AT_REST)

    @property
    def jumps(self) -> Array:
        """By how much the end of every piece misses the start of the next, shape (pieces, 2 n)."""
        n, durations = self.model.size, self.durations_s
        ends = (
            self.starts
            + gauss_points(self.points).moved_by_end(self.accelerations[..., None], durations)[..., 0]
        )
        ends[:, :n] += durations[:, None] * self.starts[:, n:]
        return np.asarray(ends - np.roll(self.starts, -1, axis=0))

    @property
    def iterated_jumps(self) -> Array:
        """The same after an iteration of Picard's (see `iterated_extremes`), shape (pieces, 2 n)."""
        return self.jumps + np.concatenate([each[:, :, -1] for each in self._iterated]).T

    @cached_property
    def _iterated(self) -> tuple[Array, Array]:
        """What an iteration of Picard's adds to coordinates and rates, (n, pieces, Lobatto places) each."""
        n, count = self.model.size, self.points + _BEYOND
        polynomials = self.motion_in_pieces(lobatto_places(count))[2 * n :]
        change = (self._sampled[2 * n : 3 * n].reshape(polynomials.shape) - polynomials)[:, :, 1:-1]
        once, twice = lobatto_integrals(count)
        duration = self.durations_s[:, None]
        return duration**2 * (change @ twice.T), duration * (change @ once.T)

    def phases_of(self, places: Places) -> Array:
        """Phases of places in every piece, shape (pieces, places)."""
        return self.boundaries[:-1, None] + np.diff(self.boundaries)[:, None] * places.values

    def motion_in_pieces(self, places: Places) -> Array:
        """Coordinates, then rates, then accelerations at places of every piece, (3 n, pieces, places)."""
        n = self.model.size
        value, first, second = weights_at(self.points, places)
        duration = self.durations_s[:, None, None]
        rate = self.starts[:, None, n:]
        moved = (
            self.starts[:, None, :n]
            + duration * places.values[:, None] * rate
            + duration**2 * (second @ self.accelerations),
            rate + duration * (first @ self.accelerations),
            value @ self.accelerations,
        )
        return np.concatenate([part.transpose(2, 0, 1) for part in moved])

    def arguments_in_pieces(self, places: Places) -> Array:
        """The equations' arguments at places of every piece, accelerations those of the polynomials.

        Returns
        -------
        numpy.ndarray
            Shape (arguments, pieces * places).
        """
        moved = self.motion_in_pieces(places)
        inputs = self.inputs_at(self.phases_of(places).ravel())
        return np.concatenate([moved.reshape(len(moved), -1), inputs])

    def located(self, phases: Array) -> tuple[Array, Array]:
        """The piece that holds every phase, and the place in it, 0 to 1."""
        first, last = self.boundaries[0], self.boundaries[-1]
        inside = first + np.mod(phases - first, last - first)
        piece = np.clip(np.searchsorted(self.boundaries, inside, side="right") - 1, 0, len(self.starts) - 1)
        return piece, (inside - self.boundaries[piece]) / np.diff(self.boundaries)[piece]

    def motion_in(self, piece: Array, places: Array) -> Array:
        """Coordinates, then rates, then accelerations at one place each of some pieces, (3 n, places)."""
        n = self.model.size
        duration, start = self.durations_s[piece][:, None], self.starts[piece]
        weights = np.stack(gauss_points(self.points).weights(places), axis=1)
        value, first, second = np.moveaxis(weights @ self.accelerations[piece], 1, 0)
        rates = start[:, n:] + duration * first
        coordinates = start[:, :n] + duration * (places[:, None] * start[:, n:] + duration * second)
        return np.concatenate([coordinates, rates, value], axis=1).T

    def motion_at(self, phases: Array) -> Array:
        """Coordinates, then rates, shape (2 n, phases)."""
        return self.motion_in(*self.located(phases))[: 2 * self.model.size]

    @cached_property
    def nearest_singularity(self) -> Singularity | None:
        """The nearest approach to the singularity of a rotation sequence; None if there is no sequence."""
        return self.model.nearest_singularity(self._sampled)

    def extremes(self, rows: list[int]) -> tuple[Array, Array]:
        """Smallest and largest value of some outputs over the orbit, shape (len(rows),) each.

        Outputs are interpolated in every piece; the best of many places brackets an extreme, a parabola
        through the best of a finer set gives it.
        """
        return self._extremes(rows, self._sampled)

    def iterated_extremes(self, rows: list[int], deviations: Array) -> tuple[Array, Array]:
        """The extremes of the motion after an iteration of Picard's, which tells how far off they are.

        The accelerations that the equations of motion ask for between the points take the place of the
        polynomials', and are integrated in every piece from its start.

        Parameters
        ----------
        deviations
            What the starts lack, shape (pieces, 2 n).
        """
        n, moved = self.model.size, self._sampled.copy()
        away, drift = deviations.T[:n, :, None], deviations.T[n:, :, None]
        elapsed = self.durations_s[:, None] * lobatto_places(self.points + _BEYOND).values
        coordinates, rates = self._iterated
        moved[:n] += (coordinates + away + elapsed * drift).reshape(n, -1)
        moved[n : 2 * n] += (rates + drift).reshape(n, -1)
        return self._extremes(rows, self._accelerated(moved))

    @cached_property
    def _sampled(self) -> Array:
        """Arguments at Lobatto places, accelerations those that the equations of motion ask for."""
        return self._accelerated(self.arguments_in_pieces(lobatto_places(self.points + _BEYOND)))

    def values_in_pieces(self, function: Callable[[Array], Array]) -> Array:
        """Results of a function of the equations' arguments at Lobatto places, (results, pieces, places)."""
        values = function(self._sampled)
        return values.reshape(len(values), len(self.starts), -1)

    def _extremes(self, rows: list[int], arguments: Array) -> tuple[Array, Array]:
        count = self.points + _BEYOND
        values = self.model.outputs(arguments)[rows].reshape(len(rows), -1, count)
        dense = np.tensordot(interpolation(count, equidistant_places(_DENSE)), values, axes=(1, 2))
        tops = np.stack([-dense.min(axis=0), dense.max(axis=0)])
        candidates = min(_CANDIDATES, tops.shape[2])
        pieces = np.argpartition(tops, -candidates, axis=2)[:, :, -candidates:]
        signs, signals = np.array([-1.0, 1.0])[:, None, None], np.arange(len(rows))[:, None]
        places = (signs * dense[:, signals, pieces]).argmax(axis=0) / (_DENSE - 1)
        chosen = signs[..., None] * values[signals, pieces]
        best = _refined(chosen.reshape(-1, count), places.ravel(), 1 / (_DENSE - 1)).reshape(pieces.shape)
        low, high = best.max(axis=2)
        return -low, high

    def under(self, model: Model, excitation: Harmonic) -> Self:
        """The same motion over phases in another test: rates grow with its frequency."""
        factor = excitation.frequency_hz / self.excitation.frequency_hz
        starts = self.starts.copy()
        starts[:, self.model.size :] *= factor
        return replace(
            self,
            model=model,
            excitation=excitation,
            starts=starts,
            accelerations=factor**2 * self.accelerations,
        )


def _refined(values: Array, place: Array, width: float) -> Array:
    """The largest value of every interpolated signal within a width of a place: of parabolas ever narrower.

    Parameters
    ----------
    values
        At Lobatto places, shape (signals, count).
    place
        Shape (signals,).
    """
    series = lobatto_series(values.shape[1]) @ values.T
    for _ in range(_ZOOMS):
        centre = np.clip(place, width, 1 - width)
        places = centre + width * np.array([[-1.0], [0.0], [1.0]])
        before, at, after = legendre.legval(2 * places - 1, series[:, None, :], tensor=False)
        slope, curvature = (after - before) / 2, 2 * at - before - after
        is_inside = np.abs(slope) < curvature
        vertex = np.divide(slope, curvature, out=np.sign(slope), where=is_inside)
        place, width = centre + width * vertex, width / _NARROWER
    top = np.where(is_inside, at + 0.5 * slope * vertex, -np.inf)
    return np.asarray(np.maximum.reduce([before, at, after, top]))
