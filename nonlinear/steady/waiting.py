"""The steady state by waiting for it: integrate until the transients have died out, then measure a period."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.collocation.floquet import multipliers
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.simulation.simulate import simulate
from chassym.nonlinear.steady.integrated_orbit import IntegratedOrbit, integrated_orbit
from chassym.nonlinear.steady.integrated_readings import FINER, IntegratedReadings
from chassym.nonlinear.steady.result import SteadyState
from chassym.nonlinear.threads import one_thread

Array = np.ndarray

_MOST_PERIODS = 10_000
"""Periods that are waited at most."""

_LEFT = 1.0
"""Transients that may be left, relative to the rates and divided by the integration's relative tolerance."""

_UNKNOWN = 20
"""Periods to wait at first where deviations are seen to grow; then as many again as were waited so far."""


def waited_steady_state(
    model: Model,
    excitation: Harmonic,
    *,
    metrics: Sequence[str] | None = None,
    tolerance: float = 1e-3,
    start: PeriodicOrbit | None = None,
    subharmonic: int = 1,
) -> SteadyState:
    """Wait for the periodic response, as a rig does: an independent check of `steady_state`.

    Integration goes on from a neighbouring orbit or from rest until what is left of the transients is as
    small as the integration's own error; the Floquet multipliers of the last period tell how much is left,
    and how long it takes. Both are made ever smaller until no metric moves by more than the tolerance.

    Unstable orbits are not found. Parameters and results are those of `steady_state`.

    Raises
    ------
    ExcitationError
        If the model lacks an input that the excitation moves.
    KeyError, ValueError
        As for `steady_state`.
    NoPeriodicOrbitError
        If the transients do not die out in time, nothing brings a deviation back, the tolerance is not
        reached, or a rotation sequence comes too near its singularity.
    SimulationError
        If a motion on the way cannot be integrated.
    """
    readings = IntegratedReadings(model, metrics, tolerance)
    state = np.zeros(2 * model.size) if start is None else start.state()
    waited = 0
    with one_thread():
        for accuracy in readings.accuracies():
            orbit = integrated_orbit(model, excitation, state, accuracy, subharmonic)
            while (periods := _to_wait(orbit, accuracy, waited)) > 0:
                waited += periods
                if waited > _MOST_PERIODS:
                    raise _not_settled(orbit, waited)
                until = np.array([0.0, periods * orbit.period_s])
                moved = simulate(model, excitation, until, start=orbit.end, relative_tolerance=accuracy)
                orbit = integrated_orbit(model, excitation, moved.states[:, -1], accuracy, subharmonic)
            state = orbit.end
            readings.add(orbit)
            if readings.are_settled:
                return readings.result("integration", 2 * model.size, waited)
    raise readings.failure()


def _to_wait(orbit: IntegratedOrbit, accuracy: float, waited: int) -> int:
    """Periods until what is left of the transients is as small as the accuracy; 0 if it is."""
    n = orbit.model.size
    left = float(np.abs(orbit.closing[n:]).max() / orbit.largest_rate)
    if left <= _LEFT * accuracy:
        return 0
    slowest = float(np.abs(multipliers(orbit)[0]))
    if slowest >= 1:
        return max(_UNKNOWN, waited)
    wanted = np.log(FINER * accuracy / left) / np.log(max(slowest, 1e-6))
    return max(1, int(np.ceil(wanted)))


def _not_settled(orbit: IntegratedOrbit, periods: int) -> NoPeriodicOrbitError:
    return NoPeriodicOrbitError(
        f"integration at {orbit.excitation.frequency_hz:g} Hz: transients take {periods} periods or more to "
        f"die out, {_MOST_PERIODS} are waited at most; give it more damping, or look for the orbit itself "
        "with steady_state"
    )
