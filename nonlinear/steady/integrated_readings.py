"""What is read off ever more accurately integrated orbits, and what their movements tell about the error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.steady.integrated_orbit import IntegratedOrbit
from chassym.nonlinear.steady.result import Statistics, SteadyState
from chassym.nonlinear.steady.steady_state import checked_reader, refuse_singular

Array = np.ndarray

FINER = 0.1
"""From one integration to the next, the part of its tolerance and of the transients that is left."""

_FIRST, _LAST = 1e-4, 1e-13
"""Relative tolerances of the integrations: never coarser, never finer."""

_LEAST = 0.1
"""Part of the error of the middle metric that every metric is taken to have at least."""


class IntegratedReadings:
    """Metrics of one orbit after the other, each ten times as accurate as the one before.

    The last movement is about nine times the error that is left; what is stated is all of it, since movements
    scatter.

    Raises
    ------
    KeyError
        If the model lacks an output that is asked for.
    ValueError
        If the tolerance is not a positive number, or there is nothing to measure.
    """

    def __init__(self, model: Model, metrics: Sequence[str] | None, tolerance: float) -> None:
        self._reader = checked_reader(model, metrics, tolerance)
        self._tolerance = tolerance
        self._orbit: IntegratedOrbit | None = None
        self._reading, self._error = np.empty(0), np.empty(0)

    def accuracies(self) -> Iterator[float]:
        """Relative tolerances of the integrations."""
        accuracy = float(np.clip(self._tolerance, 10 * _LAST, _FIRST))
        while accuracy > 0.9 * _LAST:
            yield accuracy
            accuracy *= FINER

    def add(self, orbit: IntegratedOrbit) -> None:
        """Read the metrics off the next orbit."""
        reading = self._reader.read(orbit)
        if self._orbit is not None:
            self._error = self._reader.expected(reading, np.abs(reading - self._reading), _LEAST)
        self._orbit, self._reading = orbit, reading

    @property
    def are_settled(self) -> bool:
        """Whether every error is within the tolerance."""
        return len(self._error) > 0 and self._reader.is_settled(self._reading, self._error, self._tolerance)

    def result(self, method: str, unknowns: int, iterations: int) -> SteadyState:
        """The last orbit and its metrics.

        Raises
        ------
        NoPeriodicOrbitError
            If a rotation sequence comes too near its singularity.
        """
        assert self._orbit is not None
        refuse_singular(self._orbit)
        peaks, contact = self._reader.results(self._reading, self._error)
        statistics = Statistics(method, unknowns, iterations, self._orbit.relative_gap)
        return SteadyState(self._orbit, peaks, contact, statistics)

    def failure(self) -> NoPeriodicOrbitError:
        """Why it is given up."""
        how = f"at an integration tolerance of {_LAST:g}"
        return self._reader.unsettled(self._reading, self._error, how, self._tolerance)
