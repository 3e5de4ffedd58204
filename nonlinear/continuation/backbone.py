"""The backbone: where the resonance of an output goes as the excitation grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize_scalar

from chassym.nonlinear.continuation.arclength import Tracer
from chassym.nonlinear.continuation.branch import amplitudes, output_row
from chassym.nonlinear.continuation.branch_steps import Step
from chassym.nonlinear.continuation.continuation import first_orbit
from chassym.nonlinear.continuation.paths import FrequencyPath
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.harmonics.harmonic_equations import samples_at_knots
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.threads import one_thread

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

_TOLERANCE = 1e-9

_LONGEST, _MOST_STEPS = 0.05, 1000
"""Longest step along a branch, relative to the range, and how many it may take."""


@dataclass(frozen=True, eq=False)
class Backbone:
    """Peaks of an output over frequency, one for each strength of the excitation.

    Attributes
    ----------
    factors
        On the amplitudes of the excitation, shape (peaks,).
    frequencies_hz, amplitudes
        Of the peaks; amplitudes are half peak-to-peak values in the unit, shape (peaks,).
    output, unit
        What peaks.
    """

    factors: Array = field(repr=False)
    frequencies_hz: Array
    amplitudes: Array
    output: str
    unit: str

    def to_xarray(self) -> xarray.Dataset:
        """Frequency and amplitude of the peak over the factor."""
        import xarray

        return xarray.Dataset(
            {
                "frequency": ("factor", self.frequencies_hz, {"units": "Hz"}),
                self.output: ("factor", self.amplitudes, {"units": self.unit}),
            },
            coords={"factor": ("factor", self.factors, {"units": "1"})},
        )


def backbone(
    path: FrequencyPath,
    factors: Sequence[float] | Array,
    start_hz: float,
    stop_hz: float,
    *,
    output: str,
    harmonics: int = 7,
) -> Backbone:
    """Find the peak of an output between two frequencies for several strengths of the excitation.

    The branch is followed around its folds, so that the peak is found wherever it leans.

    Parameters
    ----------
    path
        The test.
    factors
        Positive, on the amplitudes of the path's excitation, shape (peaks,).
    start_hz, stop_hz
        Range in which to look for the peaks, ascending.
    output
        Name of the output that peaks.
    harmonics
        Of the orbits.

    Returns
    -------
    Backbone
        Frequency and amplitude of the peak for every factor.

    Raises
    ------
    KeyError
        If the model has no such output.
    ValueError
        If a factor is not positive or the frequencies are no range.
    NoPeriodicOrbitError
        If a branch is lost, or highest at an end of the range.
    """
    strengths = np.asarray(factors, dtype=float)
    if strengths.ndim != 1 or not len(strengths) or not np.all(strengths > 0):
        raise ValueError(f"factors: {factors!r} received; positive numbers are needed")
    if not 0 < start_hz < stop_hz:
        raise ValueError(
            f"frequencies: {start_hz!r} to {stop_hz!r} Hz received; an ascending range is needed"
        )
    row = output_row(path.model, output)
    with one_thread():
        peaks = np.array(
            [
                _peak(
                    replace(path, excitation=path.excitation.scaled(factor)),
                    start_hz,
                    stop_hz,
                    row,
                    harmonics,
                )
                for factor in map(float, strengths)
            ]
        )
    unit = path.model.system.outputs[row].unit
    return Backbone(strengths, peaks[:, 0], peaks[:, 1], output, unit)


def _peak(
    path: FrequencyPath, start_hz: float, stop_hz: float, row: int, harmonics: int
) -> tuple[float, float]:
    """Frequency (Hz) and amplitude of the highest point of a branch."""
    fewest = samples_at_knots(path.model)
    tracer = Tracer(path, stop_hz - start_hz, harmonics, tolerance=_TOLERANCE, fewest_samples=fewest)
    first = first_orbit(*path.at(start_hz), harmonics, tolerance=_TOLERANCE, fewest_samples=fewest).orbit
    steps, heights = [], [_amplitude(first, row)]
    march = tracer.march(tracer.begin(first, start_hz, 1.0), _LONGEST)
    for step in islice(march, _MOST_STEPS):
        steps.append(step)
        heights.append(_amplitude(tracer.orbit(step.end), row))
        if not start_hz < step.end.value < stop_hz:
            break
    best = int(np.argmax(heights))
    if best in (0, len(steps)):
        raise NoPeriodicOrbitError(
            f"backbone: the output is largest where the range from {start_hz:g} to {stop_hz:g} Hz "
            f"{'ends' if best else 'begins'}; widen it, or start elsewhere"
        )
    return max((_top(tracer, step, row) for step in steps[best - 1 : best + 1]), key=lambda top: top[1])


def _top(tracer: Tracer, step: Step, row: int) -> tuple[float, float]:
    """Frequency (Hz) and amplitude of the highest point of a step."""

    def depth(length: float) -> float:
        return -_amplitude(tracer.orbit(tracer.step(step.begin, length)[0]), row)

    length = float(minimize_scalar(depth, bounds=(0.0, step.length), options={"xatol": 1e-7 * step.length}).x)
    point, _ = tracer.step(step.begin, length)
    return point.value, _amplitude(tracer.orbit(point), row)


def _amplitude(orbit: FourierOrbit, row: int) -> float:
    return float(amplitudes(orbit, [row])[0])
