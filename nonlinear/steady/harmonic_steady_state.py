"""The steady state by harmonic balance alone: what a Fourier series makes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.continuation.continuation import first_orbit
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics.harmonic_balance import Extension
from chassym.nonlinear.orbits.metrics import ROUNDING
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.steady.result import Statistics, SteadyState
from chassym.nonlinear.steady.steady_state import checked_reader, refuse_singular
from chassym.nonlinear.threads import one_thread

Array = np.ndarray

NEWTON_HARMONICS = 10
"""Harmonics balanced by Newton's method; the chord iteration takes over from there."""

NEWTON_TOLERANCE = 1e-2
"""Relative correction at which Newton's method hands over: from there the chord iteration is cheaper."""

MOST_HARMONICS = 2560
"""Where the refinement gives up."""


def harmonic_steady_state(
    model: Model,
    excitation: Harmonic,
    *,
    metrics: Sequence[str] | None = None,
    tolerance: float = 1e-3,
    start: PeriodicOrbit | None = None,
    subharmonic: int = 1,
) -> SteadyState:
    """Find the periodic response as a Fourier series and measure it: an independent check of `steady_state`.

    The number of harmonics is doubled until no metric moves by more than the tolerance. Corners of the forces
    make errors fall as 1/H^2, so what remains is about a third of a metric's last movement; but the movements
    scatter. The error stated is therefore twice the largest of the last three movements, the earlier ones
    counted by a quarter and a sixteenth.

    Parameters and results are those of `steady_state`.

    Raises
    ------
    ExcitationError
        If the model lacks an input that the excitation moves.
    KeyError, ValueError
        As for `steady_state`.
    NoPeriodicOrbitError
        If no harmonics balance, the tolerance is not reached, or a rotation sequence comes too near its
        singularity.
    """
    reader = checked_reader(model, metrics, tolerance)
    with one_thread():
        first = NEWTON_HARMONICS * subharmonic
        low = first_orbit(
            model, excitation, first, start, subharmonic=subharmonic, tolerance=NEWTON_TOLERANCE
        )
        extension = Extension(low)
        balance, iterations = low, low.iterations
        readings: list[Array] = []
        harmonics = first
        while harmonics < MOST_HARMONICS * subharmonic:
            harmonics *= 2
            balance = extension.solve(balance.orbit, harmonics, tolerance=max(1e-2 * tolerance, 1e-12))
            iterations += balance.iterations
            readings.append(reader.read(balance.orbit))
            error = algebraic_error(readings)
            if len(readings) > 2 and reader.is_settled(readings[-1], error, tolerance):
                refuse_singular(balance.orbit)
                peaks, contact = reader.results(readings[-1], error)
                unknowns = model.size * (2 * harmonics + 1)
                statistics = Statistics("harmonic balance", unknowns, iterations, balance.correction)
                return SteadyState(balance.orbit, peaks, contact, statistics)
    raise reader.unsettled(readings[-1], error, f"at {harmonics} harmonics", tolerance)


def algebraic_error(readings: Sequence[Array]) -> Array:
    """Error estimate of the last of some readings, each with twice the harmonics of the one before."""
    moved = np.abs(np.diff(readings[-4:], axis=0))[::-1]
    expected = moved * 0.25 ** np.arange(len(moved))[:, None]
    return np.asarray(2 * expected.max(axis=0, initial=0.0) + ROUNDING)
