"""State space: some or all signals of a linear model, as python-control takes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chassym.linear.frequency_response import index_of
from chassym.linear.input_conventions import InputConvention, displacements_and_rates
from chassym.linear.linear_model import LinearisationError, LinearModel

if TYPE_CHECKING:
    import control


def select_signals(
    linear: LinearModel, *, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None
) -> LinearModel:
    """The same linear model with only some of its inputs, which rest otherwise, and outputs.

    Parameters
    ----------
    linear
        The linear model.
    inputs, outputs
        Names, in the order wanted; None keeps all.

    Raises
    ------
    LinearisationError
        If there is no such input or output.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> linear = linearise(load_model("quarter_car"))
    >>> ride = select_signals(linear, outputs=["vertical_acceleration", "wheel_travel"])
    >>> ride.outputs, ride.output_by_accelerations.tolist()
    (('vertical_acceleration', 'wheel_travel'), [[1.0, 0.0], [0.0, 0.0]])
    """
    for kind, names in (("inputs", inputs), ("outputs", outputs)):
        if isinstance(names, str) or (names is not None and len(set(names)) != len(names)):
            raise LinearisationError(f"{kind}: {names!r} received; expected a sequence of different names")
    columns = [index_of("input", name, linear.inputs) for name in _all(inputs, linear.inputs)]
    rows = [index_of("output", name, linear.outputs) for name in _all(outputs, linear.outputs)]
    return replace(
        linear,
        input_stiffness=linear.input_stiffness[:, columns],
        input_damping=linear.input_damping[:, columns],
        output_by_coordinates=linear.output_by_coordinates[rows],
        output_by_rates=linear.output_by_rates[rows],
        output_by_accelerations=linear.output_by_accelerations[rows],
        output_by_inputs=linear.output_by_inputs[np.ix_(rows, columns)],
        output_by_input_rates=linear.output_by_input_rates[np.ix_(rows, columns)],
        inputs=tuple(linear.inputs[i] for i in columns),
        outputs=tuple(linear.outputs[i] for i in rows),
        input_units=tuple(linear.input_units[i] for i in columns),
        output_units=tuple(linear.output_units[i] for i in rows),
    )


def to_control(linear: LinearModel, inputs: InputConvention = displacements_and_rates) -> control.StateSpace:
    """The state space as a python-control system with named signals; its name states the slope rule.

    From 0.01 to 1000 Hz, for body stiffnesses from 1e2 to 1e9 N m/rad, the matrices determine every response
    to 1e-9, as `frequency_response` gives it. Evaluated in double precision, as python-control does, they
    lose digits where an acceleration is the small difference of large forces: a response then agrees to 1e-9
    of the output's largest at that frequency. With `rates_from_static_shape` it does so to 1e-9 of itself
    where it is more than a hundredth of the largest.

    Parameters
    ----------
    linear
        The linear model.
    inputs
        `displacements_and_rates`, `rates`, `accelerations`, `displacements` or `rates_from_static_shape`.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular, or the convention impossible.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> from chassym.linear.input_conventions import rates
    >>> system = to_control(linearise(load_model("quarter_car")), rates)
    >>> system.state_labels, system.input_labels
    (['body_bounce', 'wheel_bounce', 'body_bounce_rate', 'wheel_bounce_rate', 'road'], ['road_rate'])
    """
    if not callable(inputs):
        raise LinearisationError(
            f"inputs: {inputs!r} received; expected displacements_and_rates, rates, accelerations, "
            "displacements or rates_from_static_shape"
        )
    import control  # it takes a second to import: only for those who ask for it

    matrices = inputs(linear)
    return control.StateSpace(
        matrices.A,
        matrices.B,
        matrices.C,
        matrices.D,
        states=list(matrices.state_names),
        inputs=list(matrices.input_names),
        outputs=list(matrices.output_names),
        name=f"{linear.name}_{linear.slope_rule}" if linear.slopes else linear.name,
        remove_useless_states=False,
    )


def _all(chosen: Sequence[str] | None, names: tuple[str, ...]) -> Sequence[str]:
    return names if chosen is None else chosen
