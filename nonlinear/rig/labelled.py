"""The result of a rig test as labelled arrays."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import xarray

from chassym.nonlinear.orbits.metrics import Metric
from chassym.nonlinear.orbits.patches import carries_by_contact
from chassym.nonlinear.steady.result import SteadyState

if TYPE_CHECKING:
    from chassym.nonlinear.rig.running import RigResult, RigStep

Column: TypeAlias = "tuple[str, str, Callable[[RigStep], float]]"
"""Name, unit and reader of one number of a step."""

_DIMENSIONS = ("direction", "frequency")
_SAMPLES = 720
"""Instants of a period."""


def labelled(result: RigResult) -> xarray.Dataset:
    """Every metric and rate with its error over direction and frequency, contact and stability beside them.

    A test of one frequency has its metrics' signals and patch forces over one period, too, named
    ``.._signal``. Values that were not found are NaN.
    """
    found = xarray.Dataset(
        coords={
            "direction": list(dict.fromkeys(step.direction for step in result.steps)),
            "frequency": ("frequency", np.array(result.test.frequencies_hz), {"units": "Hz"}),
        },
        attrs={
            "vehicle": result.model.parameters.description,
            "description": result.test.description,
            **result.test.conditions,
        },
    )
    for name, unit, read in _columns(result):
        found[name] = (_DIMENSIONS, _filled(result, read), {"units": unit})
    if len(result.steps) == 1 and result.steps[0].state is not None:
        found = found.merge(_period(result.steps[0].state))
    return found


def _columns(result: RigResult) -> list[Column]:
    """What there is of every step."""
    units = {output.name: output.unit for output in result.model.system.outputs}
    columns = []
    for name in result.test.measured(result.model):
        columns += _with_error(name, units[name], partial(_peak, name=name))
    for rate in result.test.rates:
        unit = next((step.rates[rate.name].unit for step in result.steps if step.rates), "")
        columns += _with_error(rate.name, unit, partial(_rate, name=rate.name))
    return [
        *columns,
        ("minimum_patch_force", "N", _lowest),
        ("time_without_contact", "s", _longest_loss),
        ("is_stable", "1", lambda step: np.nan if step.state is None else float(step.state.is_stable)),
    ]


def _with_error(name: str, unit: str, read: Callable[[RigStep], Metric | None]) -> list[Column]:
    def value(step: RigStep) -> float:
        metric = read(step)
        return np.nan if metric is None else metric.value

    def error(step: RigStep) -> float:
        metric = read(step)
        return np.nan if metric is None else metric.error

    return [(name, unit, value), (f"{name}_error", unit, error)]


def _peak(step: RigStep, name: str) -> Metric | None:
    return None if step.state is None else step.state.peak_to_peak[name]


def _rate(step: RigStep, name: str) -> Metric | None:
    return step.rates.get(name)


def _longest_loss(step: RigStep) -> float:
    if step.state is None:
        return np.nan
    return max((loss.duration_s for loss in step.contact_losses), default=0.0)


def _lowest(step: RigStep) -> float:
    return np.nan if step.state is None or step.state.contact is None else step.state.contact.value


def _filled(result: RigResult, read: Callable[[RigStep], float]) -> np.ndarray:
    """A number of every step, shape (directions, frequencies)."""
    directions = list(dict.fromkeys(step.direction for step in result.steps))
    table = np.full((len(directions), len(result.test.frequencies_hz)), np.nan)
    for step in result.steps:
        column = int(np.argmin(np.abs(np.array(result.test.frequencies_hz) - step.frequency_hz)))
        table[directions.index(step.direction), column] = read(step)
    return table


def _period(state: SteadyState) -> xarray.Dataset:
    """Signals of one period over time, both ends included."""
    model, phases = state.orbit.model, np.linspace(0, 2 * np.pi, _SAMPLES + 1)
    time_s = phases / (2 * np.pi) * state.orbit.period_s
    chosen = {
        output.name: (output.unit, values)
        for output, values in zip(model.system.outputs, state.orbit.outputs_at(phases), strict=True)
        if output.name in state.peak_to_peak or carries_by_contact(output)
    }
    signals = {f"{name}_signal": ("time", values, {"units": unit}) for name, (unit, values) in chosen.items()}
    return xarray.Dataset(signals, coords={"time": ("time", time_s, {"units": "s"})})
