"""The equations of motion as x' = f(t, x) for integrators: one state at a time, with the exact Jacobian."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Excitation

Array = np.ndarray


class RightHandSide:
    """Rates of a model's state, its coordinates and then their rates, under an excitation.

    Buffers are used again from call to call: one object serves one thread. For loops in machine code see
    `Model.right_hand_side` and `Model.right_hand_side_jacobian`, whose arguments are the state, the inputs
    and the input rates.

    Parameters
    ----------
    model
        What moves.
    excitation
        What moves it.

    Attributes
    ----------
    evaluations
        Evaluations of x' so far.

    Raises
    ------
    ExcitationError
        If the model lacks an input that the excitation moves.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.nonlinear import Harmonic
    >>> rates = RightHandSide(load_model("quarter_car"), Harmonic(1.5, {"road": 0.01}))
    >>> rates(0.0, np.zeros(4)).round(3).tolist()
    [0.0, 0.0, 0.0, 31.25]
    """

    def __init__(self, model: Model, excitation: Excitation) -> None:
        self.evaluations = 0
        self._model = model
        self._arguments = np.zeros(len(model.right_hand_side.arguments))
        state, inputs = np.split(self._arguments, [2 * model.size])
        # To fill a memory view takes half the time of filling an array.
        self._state: Any = state.data
        self._inputs: Any = inputs.data
        self._inputs_at = excitation.at(model)
        self._rates = np.empty(2 * model.size)
        self._evaluate = model.right_hand_side.between(self._arguments, self._rates)

    def __call__(self, time_s: float, state: Array) -> Array:
        """Evaluate x' at an instant, shape (2 n,).

        Raises
        ------
        ValueError
            If the state has another shape.
        """
        self.evaluations += 1
        self._load(time_s, state)
        self._evaluate()
        return self._rates.copy()

    def jacobian(self, time_s: float, state: Array) -> Array:
        """Exact derivatives of x' by the state, shape (2 n, 2 n).

        At a knot of a table they are the mean of both sides'.
        """
        entries, evaluate = self._jacobian
        self._load(time_s, state)
        evaluate()
        return entries.reshape(len(state), -1).copy()

    def knot_distances(self, time_s: float, state: Array) -> Array:
        """Expressions whose change of sign along a motion makes x' jump or bend."""
        distances, evaluate = self._distances
        self._load(time_s, state)
        evaluate()
        return distances.copy()

    def _load(self, time_s: float, state: Array) -> None:
        try:
            self._state[:] = state
        except (TypeError, ValueError):
            self._state[:] = self._as_needed(state)
        self._inputs[:] = self._inputs_at(time_s)

    def _as_needed(self, state: Array) -> Array:
        """What a memory view does not take: lists, whole numbers; refused where the shape is another."""
        converted = np.array(state, dtype=float)
        if converted.shape != self._rates.shape:
            raise ValueError(f"state: shape {converted.shape} received; {self._rates.shape} is needed")
        return converted

    @cached_property
    def _jacobian(self) -> tuple[Array, Callable[[], object]]:
        function = self._model.right_hand_side_jacobian
        entries = np.empty(function.size)
        return entries, function.between(self._arguments, entries)

    @cached_property
    def _distances(self) -> tuple[Array, Callable[[], object]]:
        function = self._model.state_knot_distances
        distances = np.empty(function.size)
        return distances, function.between(self._arguments, distances)
