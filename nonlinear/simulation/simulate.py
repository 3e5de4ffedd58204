"""Time simulation of the full nonlinear equations, accurate about knots, contacts and breaks.

Between two events the equations are smooth, because every law with a kink is held on one of its sides, and
the integrator never sees the kink: it keeps its order, and no step is thrown away for it. After each step the
distances from all knots are looked at on its interpolant; where one is passed, the step ends there and the
integration starts anew with that law on its other side.

The integrator is SciPy's DOP853 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential
Equations I, 2nd ed., section II.10). The reference sedan passes some 75 knots a second, and its fastest
motion turns and decays at 340 rad/s: it is not stiff, and a method has to start anew often. To an error of
1e-9 at 5 s of both thesis tests this takes 26,000 evaluations of the equations; steps across the knots take
30,000 (CVODE, Adams), 46,000 (CVODE, BDF), 58,000 (LSODA), 80,000 (DOP853) and more (RK45), and where CVODE
starts anew at the knots, from first order, 37,000. `tests/benchmarks/test_integrators.py` measures it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853

from chassym.derivation import Model
from chassym.derivation.singularity import LIMIT
from chassym.nonlinear.excitation.excitation import Array, Excitation
from chassym.nonlinear.simulation.crossings import CONTACT_LOST, CONTACT_MADE, KNOT, Crossings
from chassym.nonlinear.simulation.held_motion import HeldMotion, TimeStep
from chassym.nonlinear.simulation.loss_of_contact import ContactWatch
from chassym.nonlinear.simulation.simulation import Simulation

Progress = Callable[[float], None]
"""Told the simulated time reached (s)."""

BREAK = "excitation break"

_SLIDING_EVENTS, _SLIDING_S = 64, 1e-9
"""So many events in so short a time: a force that jumps at a knot drives the motion back to it."""


class SimulationError(RuntimeError):
    """An integration that could not be finished: the message says when and why."""


def simulate(
    model: Model,
    excitation: Excitation,
    time_s: Array,
    *,
    start: Array | None = None,
    relative_tolerance: float = 1e-8,
    progress: Progress = lambda time_s: None,
) -> Simulation:
    """Integrate the equations of motion.

    Parameters
    ----------
    model
        What moves.
    excitation
        What moves its inputs, from the first instant to the last.
    time_s
        Increasing instants (s) to report, shape (samples,); the first is the start.
    start
        Coordinates and rates at the start, shape (2 n,); the design position at rest by default.
    relative_tolerance
        Of a step's error, from 1e-13 to 0.1; for values below 1e-3 (SI units) a thousandth of it counts as an
        absolute error.
    progress
        Called after every step.

    Returns
    -------
    Simulation
        States at the instants, and the events on the way.

    Raises
    ------
    ValueError
        If the instants do not increase, the start has another shape or is not finite, or the tolerance is
        impossible.
    ExcitationError
        If the model lacks an input that the excitation moves, or the excitation ends before the last instant.
    SimulationError
        If the integrator cannot go on, a rotation sequence comes too near its singularity, or the motion
        slides along a knot.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.nonlinear import Step
    >>> car, kerb = load_model("quarter_car"), Step({"road": 0.05}, ramp_s=0.02)
    >>> moved = simulate(car, kerb, np.linspace(0.0, 5.0, 501))
    >>> bool(np.isclose(moved.states[0, -1], 0.05, atol=1e-3)), moved.events["excitation break"]
    (True, 1)
    """
    times = np.asarray(time_s, dtype=float)
    if times.ndim != 1 or len(times) < 2 or not np.all(np.diff(times) > 0) or np.isinf(times).any():
        raise ValueError(f"time_s: {times} received; two or more finite, increasing instants are needed")
    state = np.zeros(2 * model.size) if start is None else np.array(start, dtype=float)
    if state.shape != (2 * model.size,):
        raise ValueError(f"start: shape {state.shape} received; ({2 * model.size},) is needed")
    if not np.isfinite(state).all():
        raise ValueError(f"start: {state} received; finite numbers are needed")
    if not 1e-13 <= relative_tolerance <= 0.1:
        raise ValueError(
            f"relative_tolerance: {relative_tolerance!r} received; a number from 1e-13 to 0.1 is needed"
        )
    excitation.signals(model, times[[0, -1]])
    return _Integration(model, excitation, times, relative_tolerance, progress).run(state)


class _Integration:
    """One run of the integrator."""

    def __init__(
        self, model: Model, excitation: Excitation, times: Array, tolerance: float, progress: Progress
    ) -> None:
        self._model, self._times, self._progress = model, times, progress
        self._relative, self._absolute = tolerance, 1e-3 * tolerance
        self._motion = HeldMotion(model, excitation)
        self._watch = ContactWatch(model)
        self._states = np.empty((2 * model.size, len(times)))
        self._reported, self._steps = 0, 0
        self._size_s: float | None = None
        self._event_times: list[float] = []

    def run(self, state: Array) -> Simulation:
        """Integrate from the first to the last instant."""
        first, last = map(float, self._times[[0, -1]])
        self._crossings = Crossings(self._motion, first, state, self._absolute)
        start = TimeStep(self._motion, first, first, lambda t: np.tile(state[:, None], np.size(t)))
        self._regular_side = np.sign(self._model.singularities(start.arguments)[:, :1])
        self._refuse_singular(start)
        self._report(start)
        breaks = self._motion.excitation.breaks(first, last).tolist()
        for start_s, end_s in zip([first, *breaks], [*breaks, last], strict=True):
            state = self._between_breaks(state, start_s, end_s)
        return Simulation(
            self._model,
            self._motion.excitation,
            self._times,
            self._states,
            {KNOT: 0, CONTACT_LOST: 0, CONTACT_MADE: 0, BREAK: len(breaks)} | self._crossings.counts,
            np.array(self._event_times),
            self._watch.losses(last),
            self._steps,
            self._motion.evaluations,
        )

    def _between_breaks(self, state: Array, start_s: float, end_s: float) -> Array:
        """Integrate while the excitation is smooth; returns the last state."""
        self._motion.latest_s = float(np.nextafter(end_s, -np.inf))
        self._crossings.look_again(start_s, state)
        while start_s < end_s:
            start_s, state = self._to_event(state, start_s, end_s)
        return state

    def _to_event(self, state: Array, start_s: float, end_s: float) -> tuple[float, Array]:
        """Integrate until a knot is passed, or to the end; returns when and where that is."""
        remaining = end_s - start_s
        first = None if self._size_s is None else min(self._size_s, remaining)
        solver = DOP853(
            self._motion,
            start_s,
            state,
            end_s,
            first_step=first,
            rtol=self._relative,
            atol=self._absolute,
        )
        while solver.status == "running":
            step = self._step(solver)
            crossing = self._crossings.first(step)
            if crossing is not None:
                step = step.until(crossing.time_s)
            self._watch.follow(step)
            self._refuse_singular(step)
            self._report(step)
            self._progress(step.end_s)
            if crossing is not None:
                reached = step.curve(step.end_s)
                self._crossings.cross(crossing, reached)
                self._refuse_sliding(step.end_s)
                return step.end_s, reached
        return end_s, solver.y

    def _step(self, solver: DOP853) -> TimeStep:
        message = solver.step()
        if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
            raise SimulationError(
                f"integration stopped at {solver.t:.6g} s: "
                f"{message or 'the motion is no longer finite'}; check the excitation's amplitude"
            )
        self._steps += 1
        self._size_s = solver.step_size
        return TimeStep(self._motion, solver.t_old, solver.t, solver.dense_output())

    def _report(self, step: TimeStep) -> None:
        """Keep the states at the instants asked for."""
        until = int(np.searchsorted(self._times, step.end_s, side="right"))
        if until > self._reported:
            self._states[:, self._reported : until] = step.curve(self._times[self._reported : until])
            self._reported = until

    def _refuse_singular(self, step: TimeStep) -> None:
        """Stop where a step comes near the singularity of a rotation sequence, or to its other side."""
        if not len(self._regular_side):
            return
        distances = self._regular_side * self._model.singularities(step.arguments)
        if np.any(distances < LIMIT):
            near = self._model.nearest_singularity(step.arguments)
            if near is not None and near.is_harmful:
                raise SimulationError(f"integration stopped at {step.end_s:.6g} s: {near.refusal}")

    def _refuse_sliding(self, time_s: float) -> None:
        """Stop where events no longer let time go on."""
        self._event_times.append(time_s)
        latest = self._event_times[-_SLIDING_EVENTS:]
        if len(latest) == _SLIDING_EVENTS and time_s - latest[0] < _SLIDING_S:
            raise SimulationError(
                f"integration stopped at {time_s:.6g} s: the motion slides along a knot, because a force "
                "jumps there and drives it back; give the law a steep slope instead of the jump"
            )
