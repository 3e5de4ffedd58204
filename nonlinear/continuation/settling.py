"""The periodic orbit that a motion settles to in time: what a rig would show after a jump."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.collocation.floquet import is_stable
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_balance import newton
from chassym.nonlinear.harmonics.harmonic_equations import samples_at_knots
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.simulation.simulate import simulate

Array = np.ndarray

_PERIODS, _ROUNDS = 20, 25
"""Periods that are integrated before the last one is compared with an orbit, and how often that is done.

Deviations with a multiplier of 0.89 fall to `_NEAR` in one round, those with 0.995 in all of them.
"""

_TOLERANCE = 1e-7
"""Relative, of the integration."""

_DISTURBANCE = 1e-3
"""Relative to the state: without any, a motion would stay on an unstable orbit. Its square is added."""

_NEAR = 0.1
"""Distance from a motion to an orbit, relative to the orbit, at which it has come to it."""


def settle(
    model: Model, excitation: Harmonic, state: Array, harmonics: int, tolerance: float = 1e-9
) -> FourierOrbit:
    """Integrate from a state until the motion is close to a stable periodic orbit, and balance that.

    Parameters
    ----------
    state
        Coordinates and rates when the excitation's phase is zero, shape (2 n,).
    harmonics
        Of the orbit.
    tolerance
        Relative correction of the rates at which the orbit is balanced.

    Raises
    ------
    NoPeriodicOrbitError
        If the motion does not come to repeat itself with the excitation.
    SimulationError
        If it cannot be integrated.
    """
    state = (1 + _DISTURBANCE) * state + _DISTURBANCE**2
    count, fewest = fourier.samples_for(harmonics), samples_at_knots(model)
    last = np.arange(count) / count + _PERIODS - 1
    times = excitation.period_s * np.concatenate([[0.0], last, [_PERIODS]])
    for _ in range(_ROUNDS):
        moved = simulate(model, excitation, times, start=state, relative_tolerance=_TOLERANCE).states
        state = moved[:, -1]
        guess = fourier.coefficients(moved[: model.size, 1:-1], harmonics)
        with suppress(NoPeriodicOrbitError):
            found = newton(FourierOrbit(model, excitation, guess), tolerance, fewest_samples=fewest).orbit
            if _is_near(found.coefficients, guess) and is_stable(found):
                return found
    raise NoPeriodicOrbitError(
        f"at {excitation.frequency_hz:g} Hz the motion did not come to repeat itself in "
        f"{_PERIODS * _ROUNDS} periods; it may be sub-harmonic, or not periodic at all: look at it in time"
    )


def _is_near(found: Array, guess: Array) -> bool:
    orders = np.maximum(np.arange(found.shape[1]), 1)
    return float(np.abs(orders * (found - guess)).max()) <= _NEAR * float(np.abs(orders * found).max())
