"""Time simulation of the full nonlinear equations, exact about the knots of tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from chassym.derivation import Model, Singularity
from chassym.derivation.singularity import LIMIT
from chassym.nonlinear.excitation import Harmonic

if TYPE_CHECKING:
    import xarray

Progress = Callable[[float], None]
"""Told the simulated time reached (s)."""


class SimulationError(RuntimeError):
    """An integration that could not be finished."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A motion in time.

    Attributes
    ----------
    model, excitation
        What moves and what moves it.
    time_s
        Shape (samples,).
    states
        Coordinates, then rates, shape (2 n, samples).
    knots_crossed
        How many times a rate passed a knot of its table; the integration was restarted at each.
    evaluations
        Evaluations of the accelerations.
    """

    model: Model
    excitation: Harmonic
    time_s: np.ndarray = field(repr=False)
    states: np.ndarray = field(repr=False)
    knots_crossed: int
    evaluations: int

    @cached_property
    def nearest_singularity(self) -> Singularity | None:
        """The nearest approach to the singularity of a rotation sequence; None if there is no sequence."""
        return self.model.nearest_singularity(self._arguments())

    def _arguments(self) -> np.ndarray:
        return _arguments(self.model, self.excitation, self.time_s, self.states)

    def outputs(self) -> np.ndarray:
        """Every output of the system, shape (outputs, samples)."""
        n = self.model.size
        arguments = self._arguments()
        arguments[2 * n : 3 * n] = self.model.accelerations(arguments)
        return self.model.outputs(arguments)

    def to_xarray(self) -> xarray.Dataset:
        """Outputs by name over `time`, each with its unit."""
        import xarray

        signals = {
            output.name: ("time", values, {"units": output.unit})
            for output, values in zip(self.model.system.outputs, self.outputs(), strict=True)
        }
        return xarray.Dataset(signals, coords={"time": ("time", self.time_s, {"units": "s"})})


def simulate(
    model: Model,
    excitation: Harmonic,
    time_s: np.ndarray,
    *,
    start: np.ndarray | None = None,
    relative_tolerance: float = 1e-8,
    progress: Progress = lambda time_s: None,
) -> Simulation:
    """Integrate the equations of motion by SciPy's DOP853.

    A step after which a rate is beyond a knot of its table ends at the knot, found on the step's interpolant,
    and the integration restarts there. Passing a knot and coming back within one step is left to the
    integrator's error control.

    Parameters
    ----------
    time_s
        Increasing instants to report, shape (samples,); the first is the start.
    start
        Coordinates and rates at the start, shape (2 n,); the design position at rest by default.
    progress
        Called after every step.

    Raises
    ------
    ValueError
        If the instants do not increase or the start has another shape.
    SimulationError
        If the integrator cannot go on, or a rotation sequence comes too near its singularity.
    """
    return _Integration(model, excitation, relative_tolerance).run(
        np.asarray(time_s, dtype=float), start, progress
    )


def _arguments(model: Model, excitation: Harmonic, time_s: np.ndarray, states: np.ndarray) -> np.ndarray:
    """The equations' arguments, with accelerations zero."""
    turning = np.exp(1j * excitation.angular_frequency * time_s)
    amplitude = excitation.vector(model)[:, None]
    inputs = (amplitude * turning).real, (1j * excitation.angular_frequency * amplitude * turning).real
    return np.concatenate([states, np.zeros((model.size, len(time_s))), *inputs])


class _Integration:
    """One run of the integrator."""

    def __init__(self, model: Model, excitation: Harmonic, relative_tolerance: float) -> None:
        self._model, self._excitation, self._tolerance = model, excitation, relative_tolerance
        self._n = model.size
        self._amplitudes = excitation.vector(model)
        self._buffer = np.zeros(model.argument_count)
        self._accelerations = model.accelerations.single()
        self._distances = model.knot_distances.single()
        self._singularities = model.singularities.single()
        self._evaluations = 0

    def _load(self, time_s: float, state: np.ndarray) -> np.ndarray:
        turned = self._amplitudes * np.exp(1j * self._excitation.angular_frequency * time_s)
        n, inputs = self._n, len(turned)
        self._buffer[: 2 * n] = state
        self._buffer[3 * n : 3 * n + inputs] = turned.real
        self._buffer[3 * n + inputs :] = -self._excitation.angular_frequency * turned.imag
        return self._buffer

    def _rates(self, time_s: float, state: np.ndarray) -> np.ndarray:
        self._evaluations += 1
        return np.concatenate([state[self._n :], self._accelerations(self._load(time_s, state))])

    def _knots(self, time_s: float, state: np.ndarray) -> np.ndarray:
        return self._distances(self._load(time_s, state))

    def run(self, times: np.ndarray, start: np.ndarray | None, progress: Progress) -> Simulation:
        """Integrate from the first to the last instant."""
        if times.ndim != 1 or len(times) < 2 or not np.all(np.diff(times) > 0) or np.isinf(times).any():
            raise ValueError(f"time_s: {times} received; two or more finite, increasing instants are needed")
        state = np.zeros(2 * self._n) if start is None else np.asarray(start, dtype=float)
        if state.shape != (2 * self._n,):
            raise ValueError(f"start: shape {state.shape} received; ({2 * self._n},) is needed")
        states = np.empty((len(state), len(times)))
        states[:, 0] = state
        regular_side = np.sign(self._singularities(self._load(times[0], state)))
        self._refuse_singular(regular_side, (times[0], times[0]), (state, state))
        sides = np.sign(self._knots(times[0], state))
        solver = self._solver(times[0], state, times[-1])
        crossed, reported = 0, 1
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                raise SimulationError(
                    f"integration stopped at {solver.t:.6g} s: "
                    f"{message or 'the motion is no longer finite'}; check the excitation's amplitude"
                )
            self._refuse_singular(regular_side, (solver.t_old, solver.t), (solver.y_old, solver.y))
            interpolant, end = solver.dense_output(), solver.t
            passed = self._first_passed(interpolant, sides, solver.t_old, end)
            if passed is not None:
                end, which = passed
                crossed += 1
                sides[which] *= -1
            until = int(np.searchsorted(times, end, side="right"))
            states[:, reported:until] = interpolant(times[reported:until])
            reported = max(reported, until)
            if passed is not None:
                solver = self._solver(end, interpolant(end), times[-1])
            progress(end)
        return Simulation(self._model, self._excitation, times, states, crossed, self._evaluations)

    def _refuse_singular(
        self, regular_side: np.ndarray, times_s: tuple[float, float], states: tuple[np.ndarray, np.ndarray]
    ) -> None:
        """Stop where a step came near the singularity of a rotation sequence, or to its other side."""
        distances = regular_side * self._singularities(self._load(times_s[1], states[1]))
        if np.any(distances < LIMIT):
            arguments = _arguments(self._model, self._excitation, np.array(times_s), np.stack(states, axis=1))
            near = self._model.nearest_singularity(arguments)
            if near is not None and near.is_harmful:
                raise SimulationError(f"integration stopped at {times_s[1]:.6g} s: {near.refusal}")

    def _solver(self, time_s: float, state: np.ndarray, end: float) -> DOP853:
        return DOP853(self._rates, time_s, state, end, rtol=self._tolerance, atol=1e-3 * self._tolerance)

    def _first_passed(
        self, interpolant: Callable[[float], np.ndarray], sides: np.ndarray, start: float, end: float
    ) -> tuple[float, int] | None:
        """The earliest instant of a step at which a rate passes a knot, and which."""
        now = np.sign(self._knots(end, interpolant(end)))
        sides[sides == 0] = now[sides == 0]
        found = []
        for which in np.flatnonzero(now * sides < 0):

            def distance(time_s: float, which: int = int(which)) -> float:
                return float(self._knots(time_s, interpolant(time_s))[which])

            if distance(start) * distance(end) < 0:
                found.append((brentq(distance, start, end, xtol=1e-13, rtol=1e-14), int(which)))
            else:
                # The rate left the knot it was restarted at on the side it came from.
                sides[which] = now[which]
        return min(found, default=None)
