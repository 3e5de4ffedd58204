"""The steady state by plain shooting: integrate one period, and correct the start until it closes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.steady.integrated_orbit import closed_orbit
from chassym.nonlinear.steady.integrated_readings import IntegratedReadings
from chassym.nonlinear.steady.result import SteadyState
from chassym.nonlinear.threads import one_thread


def shooting_steady_state(
    model: Model,
    excitation: Harmonic,
    *,
    metrics: Sequence[str] | None = None,
    tolerance: float = 1e-3,
    start: PeriodicOrbit | None = None,
    subharmonic: int = 1,
) -> SteadyState:
    """Find the periodic response as a start that comes back: an independent check of `steady_state`.

    x(T; x0) - x0 = 0 is solved by Newton's method from a neighbouring orbit or from rest. The motion is
    integrated accurately about knots, and so is its variational equation, which gives the derivative. It is
    integrated ever more accurately until no metric moves by more than the tolerance.

    Parameters and results are those of `steady_state`.

    Raises
    ------
    ExcitationError
        If the model lacks an input that the excitation moves.
    KeyError, ValueError
        As for `steady_state`.
    NoPeriodicOrbitError
        If the orbit does not come to close, nothing brings a deviation back, the tolerance is not reached, or
        a rotation sequence comes too near its singularity.
    SimulationError
        If a motion on the way cannot be integrated.
    """
    readings = IntegratedReadings(model, metrics, tolerance)
    state = np.zeros(2 * model.size) if start is None else start.state()
    iterations = 0
    with one_thread():
        for accuracy in readings.accuracies():
            orbit, corrections = closed_orbit(model, excitation, state, accuracy, subharmonic)
            state, iterations = orbit.starts[0], iterations + corrections
            readings.add(orbit)
            if readings.are_settled:
                return readings.result("shooting", 2 * model.size, iterations)
    raise readings.failure()
