"""The steady state of a harmonic test: orbit, metrics with their errors, stability and contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from threadpoolctl import ThreadpoolController

from chassym.derivation import Model
from chassym.nonlinear.excitation import Harmonic
from chassym.nonlinear.floquet import multipliers
from chassym.nonlinear.harmonic_balance import (
    Balance,
    Extension,
    NoPeriodicOrbitError,
    at_rest,
    newton,
)
from chassym.nonlinear.metrics import Contact, Metric, Reader
from chassym.nonlinear.orbit import Orbit

_BLAS = ThreadpoolController()
"""The matrices are too small for several threads: handing them out costs more than it saves."""

NEWTON_HARMONICS = 10
"""Harmonics balanced by Newton's method; the chord iteration takes over from there."""

NEWTON_TOLERANCE = 1e-2
"""Relative correction at which Newton's method hands over: from there the chord iteration is cheaper."""

MOST_HARMONICS = 2560
"""Where the refinement gives up."""


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
        Smallest vertical patch force: of the outputs called ``..patch_force_z`` and of the contact forces of
        unilateral elements. None for a system without any.
    harmonics
        Highest harmonic balanced.
    iterations
        Iterations of all solves together.
    correction
        Last relative correction of the orbit's rates.
    """

    orbit: Orbit = field(repr=False)
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
    ExcitationError
        If the model lacks an input that the excitation moves.
    KeyError
        If it lacks an output that is asked for.
    ValueError
        If the tolerance is not a positive number, or there is nothing to measure.
    NoPeriodicOrbitError
        If no periodic orbit is found, the tolerance is not reached, or a rotation sequence comes too near its
        singularity.
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance: {tolerance!r} received; a positive number is needed")
    with _BLAS.limit(limits=1, user_api="blas"):
        return _steady_state(model, excitation, metrics, tolerance, start)


def _steady_state(
    model: Model,
    excitation: Harmonic,
    metrics: Sequence[str] | None,
    tolerance: float,
    start: Orbit | None,
) -> SteadyState:
    reader = Reader(model, measured_names(model) if metrics is None else metrics)
    if not reader.names:
        raise ValueError(
            f"metrics: none to measure; {model.system.name} has "
            f"{', '.join(model.output_names) or 'no outputs'}"
        )
    low = _low_harmonics(model, excitation, start)
    extension = Extension(low)
    balance, iterations = low, low.iterations
    readings: list[np.ndarray] = []
    harmonics = NEWTON_HARMONICS
    while harmonics < MOST_HARMONICS:
        harmonics *= 2
        balance = extension.solve(balance.orbit, harmonics, tolerance=max(1e-2 * tolerance, 1e-12))
        iterations += balance.iterations
        readings.append(reader.read(balance.orbit))
        if reader.is_settled(readings, tolerance):
            _refuse_singular(balance.orbit)
            peaks, contact = reader.results(readings[-1], reader.error(readings))
            return SteadyState(balance.orbit, peaks, contact, harmonics, iterations, balance.correction)
    error = reader.error(readings)
    worst = int(np.argmax(error / reader.scale(readings[-1])))
    raise NoPeriodicOrbitError(
        f"{reader.names[worst]} = {readings[-1][worst]:.6g} {reader.units[worst]} still has an error of "
        f"{error[worst]:.2g} at {harmonics} harmonics, a relative {tolerance:g} was asked for; "
        "ask for less accuracy"
    )


def _refuse_singular(orbit: Orbit) -> None:
    near = orbit.nearest_singularity
    if near is not None and near.is_harmful:
        raise NoPeriodicOrbitError(f"at {orbit.excitation.frequency_hz:g} Hz {near.refusal}")


def measured_names(model: Model) -> list[str]:
    """Outputs that a rig test reports: accelerations and angular rates."""
    return [o.name for o in model.system.outputs if o.unit in ("m/s^2", "rad/s")]


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
