"""Input conventions: what a state space takes for the prescribed displacements u of a linear model.

Pads and roads push through springs and dampers, so that the equations hold u and u'. A state space may take
the two as inputs of their own, integrate u' or u'' itself, or take u alone where the outputs allow it. All of
these conventions have the same response.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from chassym.linear.linear_model import LinearisationError, LinearModel, StateMatrices
from chassym.linear.refinement import refined_solve

Array = np.ndarray

InputConvention: TypeAlias = Callable[[LinearModel], StateMatrices]
"""What the inputs of a state space are."""

_ROUNDING = 1e-13
"""Part of the terms of a sum below which the sum is taken for zero."""

_SHOWN = 4
"""Most names in a message."""


def displacements_and_rates(linear: LinearModel) -> StateMatrices:
    """Inputs u, u': the prescribed displacements and, as inputs of their own, their rates.

    States are q, q'. Who simulates has to feed u' consistently with u.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular.
    """
    n, p = _sizes(linear)
    return _cut(linear, 2 * n, 2 * p)


def rates(linear: LinearModel) -> StateMatrices:
    """Inputs u': the rates, which the states q, q', u integrate; white noise for the road, say.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular.
    """
    n, p = _sizes(linear)
    return _cut(linear, 2 * n + p, p)


def accelerations(linear: LinearModel) -> StateMatrices:
    """Inputs u'': the accelerations, which the states q, q', u, u' integrate twice; nothing passes directly.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular.
    """
    n, p = _sizes(linear)
    return _cut(linear, 2 * n + 2 * p, p)


def displacements(linear: LinearModel) -> StateMatrices:
    """Inputs u alone: the prescribed displacements, whose rates are not needed.

    States are q and the rates without what jumps when u jumps, z = q' - M^-1 B_u' u. From the equations of
    the linear model follows M z' = -K q - C z + (B_u - C M^-1 B_u') u. Where nothing jumps z is q' and has
    its name.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular, or an output answers u' directly, so that its transfer function is
        improper: a force of a tyre with damping, say, or the acceleration of what it carries.
    """
    pairs = displacements_and_rates(linear)
    n, p = _sizes(linear)
    jump, direct = _answers_to_rates(linear)
    improper = [name for name, row in zip(linear.outputs, direct, strict=True) if row.any()]
    if improper:
        raise LinearisationError(
            f"displacements alone cannot be the inputs of {linear.name!r}: improper, as of its outputs "
            f"{_listed(improper)} answer the rate of an input directly; leave these out of the linear model "
            "with select_signals, or take displacements_and_rates, rates or accelerations"
        )
    jumps = np.vstack([np.zeros((n, p)), jump])
    suffixes = ["_rate_without_jump" if row.any() else "_rate" for row in jump]
    rate_names = [name + suffix for name, suffix in zip(linear.coordinates, suffixes, strict=True)]
    return replace(
        pairs,
        B=pairs.B[:, :p] + pairs.A @ jumps,
        D=pairs.D[:, :p] + pairs.C @ jumps,
        state_names=(*linear.coordinates, *rate_names),
        input_names=linear.inputs,
        input_units=linear.input_units,
    )


def rates_from_static_shape(linear: LinearModel) -> StateMatrices:
    """Inputs u', with coordinates measured from the shape into which u at rest brings the system.

    States are q', q - T u, u in this order, where K T = B_u. For a quarter car q - T u are the heights of
    body and wheel over the road, as ride control has them. They vanish when a car at rest has followed its
    road, and u drops out of the dynamics: slow accelerations are no small differences of large forces, and
    keep their digits; that the rates come first keeps those of fast motions. Where K is singular T is the
    least-squares solution, and what it leaves of B_u u acts as before.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular.
    """
    absolute = rates(linear)
    n, p = _sizes(linear)
    shape, left = _static_shape(linear)
    pushed = _over_mass(linear, left)
    through = linear.output_by_inputs + linear.output_by_coordinates @ shape
    changes, inputs, outputs = (each.copy() for each in (absolute.A, absolute.B, absolute.C))
    changes[n : 2 * n, 2 * n :] = pushed
    inputs[:n] = -shape
    outputs[:, 2 * n :] = through + linear.output_by_accelerations @ pushed
    names = tuple(f"{name}_from_static_shape" for name in linear.coordinates)
    order = np.r_[n : 2 * n, :n, 2 * n : 2 * n + p]
    return replace(
        absolute,
        A=changes[np.ix_(order, order)],
        B=inputs[order],
        C=outputs[:, order],
        state_names=(*absolute.state_names[n : 2 * n], *names, *linear.inputs),
        state_units=tuple(absolute.state_units[i] for i in order),
    )


def _static_shape(linear: LinearModel) -> tuple[Array, Array]:
    """T in K T = B_u and B_u - K T, shapes (n, p), in extended precision; what is rounding is zero."""
    stiffness, force = (each.astype(np.longdouble) for each in (linear.stiffness, linear.input_stiffness))
    diagonal = np.abs(np.diag(linear.stiffness))
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))[:, None]
    inverse = scale * np.linalg.pinv(linear.stiffness * scale * scale.T, rcond=_ROUNDING) * scale.T
    shape = (inverse @ linear.input_stiffness).astype(np.longdouble)
    shape += inverse @ (force - stiffness @ shape).astype(float)
    left = force - stiffness @ shape
    terms = np.abs(force) + np.abs(stiffness) @ np.abs(shape)
    return shape, np.where(np.abs(left) > _ROUNDING * terms, left, 0.0)


def _sizes(linear: LinearModel) -> tuple[int, int]:
    return len(linear.coordinates), len(linear.inputs)


def _cut(linear: LinearModel, states: int, inputs: int) -> StateMatrices:
    """The state space with the first of q, q', u, u', u'' as its states and the next as its inputs."""
    changes, outputs = _chain(linear)
    end = states + inputs
    names = (
        *linear.coordinates,
        *(f"{name}_rate" for name in linear.coordinates),
        *linear.inputs,
        *(f"{name}_rate" for name in linear.inputs),
        *(f"{name}_acceleration" for name in linear.inputs),
    )
    units = (
        *linear.coordinate_units,
        *(f"{unit}/s" for unit in linear.coordinate_units),
        *linear.input_units,
        *(f"{unit}/s" for unit in linear.input_units),
        *(f"{unit}/s^2" for unit in linear.input_units),
    )
    return StateMatrices(
        A=changes[:states, :states],
        B=changes[:states, states:end],
        C=outputs[:, :states],
        D=outputs[:, states:end],
        state_names=names[:states],
        input_names=names[states:end],
        output_names=linear.outputs,
        state_units=units[:states],
        input_units=units[states:end],
        output_units=linear.output_units,
    )


def _chain(linear: LinearModel) -> tuple[Array, Array]:
    """Derivatives of the rates of change of q, q', u, u', and of the outputs, by q, q', u, u', u''.

    Rows of A and C that are small beside the terms they are made of keep their digits, on which the response
    of soft parts far above their resonance depends.
    """
    n, p = _sizes(linear)
    moved = np.hstack([-linear.stiffness, -linear.damping, linear.input_stiffness, linear.input_damping])
    accelerations = _over_mass(linear, moved)
    outputs = np.hstack(
        [
            linear.output_by_coordinates,
            linear.output_by_rates,
            linear.output_by_inputs,
            linear.output_by_input_rates,
        ]
    )
    outputs = outputs + linear.output_by_accelerations @ accelerations
    changes = np.zeros((2 * n + 2 * p, 2 * n + 3 * p))
    changes[:n, n : 2 * n] = np.eye(n)
    changes[n : 2 * n, : 2 * n + 2 * p] = accelerations
    changes[2 * n :, 2 * n + p :] = np.eye(2 * p)
    return changes, np.hstack([outputs, np.zeros((len(linear.outputs), p))]).astype(float)


def _over_mass(linear: LinearModel, forces: Array) -> Array:
    """Accelerations that forces make, in extended precision.

    Raises
    ------
    LinearisationError
        If the mass matrix is singular.
    """
    linear.mass_factor  # noqa: B018 - refuses a singular mass matrix by the name of the coordinate
    return refined_solve(linear.mass.astype(np.longdouble), forces.astype(np.longdouble))[0]


def _answers_to_rates(linear: LinearModel) -> tuple[Array, Array]:
    """How q'' and the outputs answer u' directly, shapes (n, p), (outputs, p); what is rounding is zero."""
    n, _ = _sizes(linear)
    inverse = np.abs(_over_mass(linear, np.eye(n)))
    found = _over_mass(linear, linear.input_damping)
    terms = inverse @ np.abs(linear.input_damping)
    direct = linear.output_by_input_rates + linear.output_by_accelerations @ found
    direct_terms = np.abs(linear.output_by_input_rates) + np.abs(linear.output_by_accelerations) @ terms
    jump, through = (
        np.where(np.abs(each) > _ROUNDING * size, each, 0.0).astype(float)
        for each, size in ((found, terms), (direct, direct_terms))
    )
    return jump, through


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(map(repr, names[:_SHOWN]))
    return shown if len(names) <= _SHOWN else f"{shown} and {len(names) - _SHOWN} more"
