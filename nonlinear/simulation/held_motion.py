"""The equations of motion between two knots: every law goes on smoothly on the side on which it is held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Excitation

Array = np.ndarray

PLACES = np.linspace(0.0, 1.0, 8)
"""Where a step is looked at: as many samples as one pass of a compiled function takes."""


class HeldMotion:
    """Rates of a model's state, its coordinates and then their rates, with every kink held open.

    Attributes
    ----------
    sides
        1.0 for every knot whose law is held on the side of positive distances, 0.0 on the other;
        shape (knots,). To be written to.
    latest_s
        Inputs of later instants are those of this one: just before a break of the excitation.
    evaluations
        Evaluations so far.
    """

    def __init__(self, model: Model, excitation: Excitation) -> None:
        self.model, self.excitation = model, excitation
        self.latest_s = np.inf
        self.evaluations = 0
        function, distances = model.held_right_hand_side, model.state_knot_distances
        self._arguments = np.zeros(len(function.arguments))
        first, last = 2 * model.size, len(distances.arguments)
        self._state, self._inputs, self.sides = np.split(self._arguments, [first, last])
        self._inputs_at = excitation.at(model)
        self._rates, self._distances = np.empty(first), np.empty(distances.size)
        self._evaluate = function.between(self._arguments, self._rates)
        self._measure = distances.between(self._arguments[:last], self._distances)

    def __call__(self, time_s: float, state: Array) -> Array:
        """Rates of the state, shape (2 n,)."""
        self.evaluations += 1
        self._load(time_s, state)
        self._evaluate()
        return self._rates.copy()

    def distances(self, time_s: float, state: Array) -> Array:
        """Distances from all knots, shape (knots,)."""
        self._load(time_s, state)
        self._measure()
        return self._distances.copy()

    def _load(self, time_s: float, state: Array) -> None:
        self._state[:] = state
        self._inputs[:] = self._inputs_at(min(time_s, self.latest_s))

    def arguments(self, times_s: Array, states: Array) -> Array:
        """The equations' arguments with accelerations zero, shape (arguments, samples)."""
        inputs = self.excitation.signals(self.model, np.minimum(times_s, self.latest_s))
        return np.concatenate([states, np.zeros((self.model.size, len(times_s))), *inputs])


@dataclass(frozen=True, eq=False)
class TimeStep:
    """A step of the integrator.

    Attributes
    ----------
    motion
        What was integrated.
    start_s, end_s
        Where it begins and ends.
    curve
        The state at instants of it: shape (2 n,) of one, (2 n, samples) of several.
    """

    motion: HeldMotion
    start_s: float
    end_s: float
    curve: Callable[[float | Array], Array]

    @cached_property
    def times_s(self) -> Array:
        """Instants at which it is looked at, from start to end."""
        return self.start_s + (self.end_s - self.start_s) * PLACES

    @cached_property
    def arguments(self) -> Array:
        """The equations' arguments there, with accelerations zero."""
        return self.motion.arguments(self.times_s, self.curve(self.times_s))

    def outputs(self, arguments: Array) -> Array:
        """Every output of the system, shape (outputs, samples), with accelerations of the held laws' motion.

        At an instant of the step the laws are not beyond their knots, so these are the equations' own.
        """
        model, n = self.motion.model, self.motion.model.size
        moved = arguments.copy()
        moved[2 * n : 3 * n] = model.accelerations(arguments)
        return model.outputs(moved)

    def outputs_at(self, time_s: float) -> Array:
        """Every output at one instant, shape (outputs,)."""
        instant = np.array([time_s])
        return self.outputs(self.motion.arguments(instant, self.curve(instant)))[:, 0]

    def until(self, end_s: float) -> TimeStep:
        """Its first part."""
        return TimeStep(self.motion, self.start_s, end_s, self.curve)
