"""The steady state of a harmonic test: orbit, metrics with their errors, stability and contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation import Harmonic
from chassym.nonlinear.floquet import multipliers
from chassym.nonlinear.harmonic_balance import (
    Balance,
    Extension,
    NoPeriodicOrbitError,
    at_rest,
    newton,
    samples_for,
)
from chassym.nonlinear.orbit import Orbit
from chassym.nonlinear.peaks import extremes

NEWTON_HARMONICS = 10
"""Harmonics balanced by Newton's method; the chord iteration takes over from there."""

NEWTON_TOLERANCE = 1e-5
"""Where Newton's method stops: its next correction would be of the square of this."""

MOST_HARMONICS = 2048
"""Where the refinement gives up."""

_ROUNDING = 1e-12
"""Movements below this (SI units) are those of rounding: forces of thousands of newtons cancel at rest."""

_NEGLIGIBLE = 1e-3
"""A metric below this share of the largest one of its unit is asked for to the same absolute accuracy as that
share.
"""


@dataclass(frozen=True)
class Metric:
    """A peak-to-peak value or an extreme with an estimate of its error, both in the unit."""

    value: float
    unit: str
    error: float


@dataclass(frozen=True)
class Contact:
    """The smallest vertical patch force and where it acts; negative if contact would have been lost."""

    value: float
    error: float
    patch: str

    @property
    def is_kept(self) -> bool:
        """Whether every tyre stays on its pad."""
        return self.value > 0


@dataclass(frozen=True, eq=False)
class SteadyState:
    """The periodic response to a harmonic excitation.

    Attributes
    ----------
    orbit
        The orbit, with as many harmonics as the tolerance took.
    peak_to_peak
        Metric of every output asked for, by the output's name.
    contact
        Smallest vertical patch force; None for a mechanism without patches.
    harmonics
        Highest harmonic balanced.
    iterations
        Iterations of all solves together.
    correction
        Last relative correction of the orbit's rates.
    """

    orbit: Orbit
    peak_to_peak: Mapping[str, Metric]
    contact: Contact | None
    harmonics: int
    iterations: int
    correction: float

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, largest magnitude first."""
        return multipliers(self.orbit)

    @property
    def is_stable(self) -> bool:
        """Whether small deviations die out."""
        return bool(np.abs(self.multipliers[0]) < 1)


def steady_state(
    model: Model,
    excitation: Harmonic,
    *,
    metrics: Sequence[str] | None = None,
    tolerance: float = 1e-3,
    start: Orbit | None = None,
) -> SteadyState:
    """Find the periodic response and measure it.

    The number of harmonics is doubled until no metric moves by more than the tolerance. Corners of the forces
    make errors fall as 1/H^2, so what remains is about a third of a metric's last movement; but the movements
    scatter. The error stated is therefore twice the largest of the last three movements, the earlier ones
    counted by a quarter and a sixteenth.

    Parameters
    ----------
    metrics
        Outputs whose peak-to-peak value is wanted; all accelerations and angular rates by default.
    tolerance
        Largest stated error, relative to the metric.
    start
        A neighbouring orbit to start from.

    Raises
    ------
    NoPeriodicOrbitError
        If no periodic orbit is found, or the tolerance not reached.
    """
    names = list(metrics) if metrics is not None else measured_names(model)
    reader = _Reader(model, names)
    low = _low_harmonics(model, excitation, start)
    extension = Extension(low)
    balance, iterations = low, low.iterations
    readings = [reader.read(low.orbit)]
    harmonics = NEWTON_HARMONICS
    while harmonics <= MOST_HARMONICS:
        harmonics *= 2
        balance = extension.solve(balance.orbit, harmonics, tolerance=max(1e-2 * tolerance, 1e-12))
        iterations += balance.iterations
        readings.append(reader.read(balance.orbit))
        error = reader.error(readings)
        if len(readings) > 3 and np.all(error <= tolerance * reader.scale(readings[-1]) + 2 * _ROUNDING):
            peaks, contact = reader.results(readings[-1], error)
            return SteadyState(balance.orbit, peaks, contact, harmonics, iterations, balance.correction)
    worst = int(np.argmax(error / reader.scale(readings[-1])))
    raise NoPeriodicOrbitError(
        f"{reader.names[worst]} = {readings[-1][worst]:.6g} {reader.units[worst]} still has an error of "
        f"{error[worst]:.2g} at {harmonics} harmonics, a relative {tolerance:g} was asked for; "
        "ask for less accuracy"
    )


def measured_names(model: Model) -> list[str]:
    """Outputs that a rig test reports: accelerations and angular rates."""
    return [o.name for o in model.mechanism.outputs if o.unit in ("m/s^2", "rad/s")]


def _low_harmonics(model: Model, excitation: Harmonic, start: Orbit | None) -> Balance:
    """The low harmonics by Newton's method; where it fails, by way of a smaller amplitude."""
    initial = at_rest(model, excitation, NEWTON_HARMONICS)
    if start is not None:
        kept = min(start.harmonics, NEWTON_HARMONICS) + 1
        initial.coefficients[:, :kept] = start.coefficients[:, :kept]
    factor, step = 1.0, 1.0
    while True:
        try:
            balance = newton(Orbit(model, excitation.scaled(factor), initial.coefficients), NEWTON_TOLERANCE)
        except NoPeriodicOrbitError:
            step *= 0.5
            if step < 1 / 64:
                raise
            factor -= step
            continue
        if factor == 1.0:
            return balance
        initial, factor = balance.orbit, min(1.0, factor + step)


class _Reader:
    """Reads the extremes of outputs off an orbit and judges how they moved."""

    def __init__(self, model: Model, names: Sequence[str]) -> None:
        outputs = {output.name: (row, output.unit) for row, output in enumerate(model.mechanism.outputs)}
        for name in names:
            if name not in outputs:
                raise KeyError(f"output {name!r}: {model.mechanism.name} has {', '.join(outputs)}")
        self.patches = [name for name in outputs if name.endswith("patch_force_z")]
        self.names = [*names, *self.patches]
        self.units = [outputs[name][1] for name in self.names]
        self._rows = [outputs[name][0] for name in self.names]
        self._peaks = len(names)

    def read(self, orbit: Orbit) -> np.ndarray:
        """Peak-to-peak values, then smallest patch forces."""
        low, high = extremes(orbit, self._rows, samples_for(orbit.harmonics))
        return np.concatenate([(high - low)[: self._peaks], low[self._peaks :]])

    def scale(self, reading: np.ndarray) -> np.ndarray:
        """What an error of every value is compared with."""
        sizes = np.abs(reading)
        largest = {
            unit: max(s for s, u in zip(sizes, self.units, strict=True) if u == unit) for unit in self.units
        }
        return np.maximum(sizes, _NEGLIGIBLE * np.array([largest[unit] for unit in self.units]))

    def error(self, readings: Sequence[np.ndarray]) -> np.ndarray:
        """Error estimate of the last reading, as `steady_state` describes it."""
        moved = np.abs(np.diff(readings[-4:], axis=0))[::-1]
        expected = moved * 0.25 ** np.arange(len(moved))[:, None]
        return np.asarray(2 * expected.max(axis=0) + _ROUNDING)

    def results(self, reading: np.ndarray, error: np.ndarray) -> tuple[dict[str, Metric], Contact | None]:
        """The values by name, and the worst patch."""
        values = [Metric(float(v), u, float(e)) for v, u, e in zip(reading, self.units, error, strict=True)]
        by_name = dict(zip(self.names, values, strict=True))
        forces = {name: by_name.pop(name) for name in self.patches}
        if not forces:
            return by_name, None
        worst = min(forces, key=lambda name: forces[name].value)
        patch = worst.removesuffix("_patch_force_z").removesuffix("patch_force_z")
        return by_name, Contact(forces[worst].value, forces[worst].error, patch)
