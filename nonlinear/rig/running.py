"""Running a test of the rig: one steady state, or one at every step of a stepped sine, and what is read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.continuation.paths import ACCELERATION, DISPLACEMENT, VELOCITY, FrequencyPath
from chassym.nonlinear.continuation.stepped_sine import Jump, Progress, Run, stepped_sine
from chassym.nonlinear.orbits.metrics import Metric
from chassym.nonlinear.rig.contact import PeriodicLossOfContact, contact_losses
from chassym.nonlinear.rig.pads import pads_of
from chassym.nonlinear.rig.rig_test import Rate, RigTest
from chassym.nonlinear.steady.result import SteadyState
from chassym.nonlinear.steady.steady_state import SMALLEST_TOLERANCE, steady_state

if TYPE_CHECKING:
    import xarray

UPWARD, DOWNWARD = "upward", "downward"

_HELD = {"m": DISPLACEMENT, "m/s": VELOCITY, "m/s^2": ACCELERATION}
_SAMPLES = 512
"""Phases that a regression line goes through."""

_FINER = 0.01
"""Tolerance of the orbit that slopes are read off, relative to the test's."""


@dataclass(frozen=True, eq=False)
class RigStep:
    """One frequency of a test.

    Attributes
    ----------
    frequency_hz
        Of the pads.
    direction
        `UPWARD` or `DOWNWARD`: where a stepped sine came from; a single frequency is upward.
    state
        The steady state; None if none was found.
    reason
        Why none was found; empty otherwise.
    rates
        Slope of every rate of the test by its name, with unit and error.
    """

    frequency_hz: float
    direction: str
    state: SteadyState | None = field(repr=False)
    reason: str = ""
    rates: dict[str, Metric] = field(default_factory=dict)

    @cached_property
    def contact_losses(self) -> tuple[PeriodicLossOfContact, ...]:
        """Every patch without contact for a time, the worst first; only where there is a steady state."""
        return () if self.state is None else contact_losses(self.state.orbit)


@dataclass(frozen=True, eq=False)
class RigResult:
    """What a vehicle does in a test.

    Attributes
    ----------
    test, model
        The test, and the vehicle as it stands on the rig.
    steps
        One, or those of a stepped sine: upward in their order, then downward in theirs.
    jumps
        Where a stepped sine leaves one motion for another.
    coexisting_hz
        Frequencies at which it finds another motion downward than upward.
    """

    test: RigTest
    model: Model = field(repr=False)
    steps: tuple[RigStep, ...] = field(repr=False)
    jumps: tuple[Jump, ...] = ()
    coexisting_hz: tuple[float, ...] = ()

    def to_xarray(self) -> xarray.Dataset:
        """Metrics over direction and frequency with their errors and units; of one step also its period."""
        from chassym.nonlinear.rig.labelled import labelled

        return labelled(self)


def run(model: Model, test: RigTest, *, progress: Progress = lambda share: None) -> RigResult:
    """Put a vehicle on the rig and measure its steady state.

    Parameters
    ----------
    model
        A vehicle that has what the test moves and measures.
    test
        The test.
    progress
        Told the share of a stepped sine's steps that are done, after each of them.

    Raises
    ------
    ParameterError
        If the vehicle lacks the pads or the outputs of the test.
    NoPeriodicOrbitError
        If a test of one frequency has no steady state to be found. A stepped sine goes on; its step keeps the
        reason.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.nonlinear.rig import load_rig_test
    >>> found = run(load_model("quarter_car"), load_rig_test("heave"))
    >>> metric = found.steps[0].state.peak_to_peak["vertical_acceleration"]
    >>> metric.unit, metric.error < 1e-3 * metric.value
    ('m/s^2', True)
    """
    mounted = test.mounted(model)
    return _stepped(mounted, test, progress) if test.is_stepped else _single(mounted, test)


def _single(mounted: Model, test: RigTest) -> RigResult:
    excitation = test.excitation(mounted)
    state = steady_state(mounted, excitation, metrics=test.measured(mounted), tolerance=test.tolerance)
    return RigResult(test, mounted, (_step(test, excitation.frequency_hz, UPWARD, state, ""),))


def _stepped(mounted: Model, test: RigTest, progress: Progress) -> RigResult:
    lags = test.lags_s(pads_of(each.name for each in mounted.system.inputs))
    path = FrequencyPath(mounted, test.excitation(mounted), _HELD[test.amplitude_unit], lags)
    found = stepped_sine(
        path, test.frequencies_hz, metrics=test.measured(mounted), tolerance=test.tolerance, progress=progress
    )
    steps = [*_steps(test, found.upward, UPWARD), *_steps(test, found.downward, DOWNWARD)]
    coexisting = tuple(float(value) for value in found.coexisting)
    return RigResult(test, mounted, tuple(steps), tuple(found.jumps), coexisting)


def _steps(test: RigTest, run: Run, direction: str) -> list[RigStep]:
    found = [
        _step(test, float(value), direction, state, reason)
        for value, state, reason in zip(run.values, run.states, run.reasons, strict=True)
    ]
    return sorted(found, key=lambda step: step.frequency_hz, reverse=direction == DOWNWARD)


def _step(
    test: RigTest, frequency_hz: float, direction: str, state: SteadyState | None, reason: str
) -> RigStep:
    rates = {} if state is None else _rates(state, test)
    return RigStep(frequency_hz, direction, state, reason, rates)


def _rates(state: SteadyState, test: RigTest) -> dict[str, Metric]:
    """Slopes of regression lines; each error is the change from those of a rougher orbit, or more.

    A slope asks for the whole orbit, of which the errors of the extremes say little.
    """
    if not test.rates:
        return {}
    orbit, tolerance = state.orbit, max(_FINER * test.tolerance, SMALLEST_TOLERANCE)
    measured = test.measured(orbit.model)
    finer = steady_state(orbit.model, orbit.excitation, metrics=measured, tolerance=tolerance, start=orbit)
    units = {output.name: output.unit for output in orbit.model.system.outputs}
    rough, fine = (_slopes(each, test.rates) for each in (state, finer))
    found = {}
    for rate in test.rates:
        slope = fine[rate.name]
        share = sum(_relative_error(finer.peak_to_peak[name]) for name in (rate.of, rate.over))
        unit = f"{units[rate.of]}/{units[rate.over]}" if units[rate.of] != units[rate.over] else "1"
        found[rate.name] = Metric(slope, unit, abs(slope - rough[rate.name]) + abs(slope) * share)
    return found


def _slopes(state: SteadyState, rates: Sequence[Rate]) -> dict[str, float]:
    signals = dict(zip(state.orbit.model.output_names, state.orbit.outputs(_SAMPLES), strict=True))
    return {rate.name: float(np.polyfit(signals[rate.over], signals[rate.of], 1)[0]) for rate in rates}


def _relative_error(metric: Metric) -> float:
    return metric.error / metric.value if metric.value > 0 else np.inf
