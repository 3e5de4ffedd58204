"""Measured motions: samples of inputs, and a smooth curve through them whose slope is the rate."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import NO_BREAKS, Array, Excitation, ExcitationError, input_rows

ROUNDING = 1e-9
"""Part of the duration by which an instant may lie outside of it."""


@dataclass(frozen=True, eq=False)
class TimeSeries(Excitation):
    """Inputs by their samples, on cubic splines through them.

    Tyres feel the rate, and accelerations follow it: a spline's value, rate and acceleration are continuous,
    and those of a smooth motion it meets to fourth, third and second order of the sample interval. A
    monotone interpolation (PCHIP) has a rate that bends at every sample and cuts every crest. What moves
    within a few samples, a jump above all, overshoots on a spline: filter it, or sample it faster.

    Parameters
    ----------
    time_s
        Increasing instants, shape (samples,); four or more.
    values
        Samples of every moving input, by its name, in its SI unit, each of shape (samples,).
    units
        SI units of values, by the input's name, to be compared with those of the model's inputs.

    Raises
    ------
    ExcitationError
        If the instants do not increase, or there are not as many values, or one is not finite.
    """

    time_s: Array = field(repr=False)
    values: Mapping[str, Array] = field(repr=False)
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        times = np.asarray(self.time_s, dtype=float)
        if times.ndim != 1 or len(times) < 4 or not np.isfinite(times).all() or np.diff(times).min() <= 0:
            raise ExcitationError(
                f"time_s: shape {times.shape} received; four or more finite, increasing instants are needed"
            )
        for name, samples in self.values.items():
            given = np.asarray(samples, dtype=float)
            if given.shape != times.shape:
                raise ExcitationError(
                    f"values of {name!r}: shape {given.shape} received; {times.shape} as of time_s is needed"
                )
            if not np.isfinite(given).all():
                first = int(np.flatnonzero(~np.isfinite(given))[0])
                raise ExcitationError(
                    f"values of {name!r}: {given[first]!r} received at {times[first]:g} s; "
                    "finite numbers are needed"
                )

    @cached_property
    def _curve(self) -> CubicSpline:
        """Values over time, shape (samples, moving inputs) at shape (samples,)."""
        return self._spline(np.asarray(self.time_s, dtype=float), self._samples)

    @property
    def _samples(self) -> Array:
        """Shape (samples, moving inputs)."""
        return np.reshape([*self.values.values()], (len(self.values), len(self.time_s))).T

    def _spline(self, times: Array, samples: Array) -> CubicSpline:
        """The third derivative is continuous at the second and the last but one sample, too."""
        return CubicSpline(times, samples)

    def _within(self, time_s: Array) -> Array:
        """Instants on the curve, moved onto it where rounding put them beside."""
        first, last = self._curve.x[0], self._curve.x[-1]
        slack = ROUNDING * (last - first)
        outside = (time_s < first - slack) | (time_s > last + slack)
        if np.any(outside):
            raise ExcitationError(
                f"time series: {np.asarray(time_s)[outside].flat[0]:g} s asked for; it is known from "
                f"{first:g} to {last:g} s"
            )
        return np.clip(time_s, first, last)

    def _rows(self, model: Model) -> list[int]:
        rows = input_rows(model, self.values)
        for row, name in zip(rows, self.values, strict=True):
            unit = model.system.inputs[row].unit
            if self.units.get(name, unit) != unit:
                raise ExcitationError(
                    f"values of {name!r}: in {self.units[name]}; {model.system.name} takes it in {unit}"
                )
        return rows

    def signals(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Value and rate of every input, as `Excitation` says."""
        rows, instants = self._rows(model), self._within(np.asarray(time_s, dtype=float))
        found = np.zeros((2, len(model.system.inputs), len(instants)))
        found[0, rows] = self._curve(instants).T
        found[1, rows] = self._curve(instants, 1).T
        return found[0], found[1]

    def at(self, model: Model) -> Callable[[float], Array]:
        """A function of one instant, as `Excitation` says."""
        inputs, rows = len(model.system.inputs), self._rows(model)
        places = np.concatenate([rows, np.add(rows, inputs)]).astype(int)
        knots, pieces = self._curve.x.tolist(), _with_rates(self._curve)
        last = len(knots) - 2

        def moved(time_s: float) -> Array:
            instant = float(self._within(np.array([time_s]))[0])
            piece = min(bisect_right(knots, instant) - 1, last)
            x, (cubic, square, slope, value) = instant - knots[piece], pieces[piece]
            found = np.zeros(2 * inputs)
            found[places] = ((cubic * x + square) * x + slope) * x + value
            return found

        return moved

    def breaks(self, start_s: float, end_s: float) -> Array:
        """None: rate and acceleration are continuous."""
        return NO_BREAKS


class PeriodicTimeSeries(TimeSeries):
    """A time series that repeats: its last sample is its first one, a period later."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, samples in self.values.items():
            if samples[0] != samples[-1]:
                raise ExcitationError(
                    f"values of {name!r}: begin with {samples[0]:g} and end with {samples[-1]:g}; those of a "
                    "periodic time series end as they begin"
                )

    def _spline(self, times: Array, samples: Array) -> CubicSpline:
        return CubicSpline(times, samples, bc_type="periodic")

    def _within(self, time_s: Array) -> Array:
        first, last = self._curve.x[0], self._curve.x[-1]
        return first + np.mod(time_s - first, last - first)


def _with_rates(curve: CubicSpline) -> Array:
    """Coefficients of values, then rates, by falling powers, shape (pieces, 4, 2 moving inputs)."""
    cubic, square, slope, value = curve.c
    rates = np.stack([np.zeros_like(cubic), 3 * cubic, 2 * square, slope])
    return np.ascontiguousarray(np.concatenate([curve.c, rates], axis=2).swapaxes(0, 1))
