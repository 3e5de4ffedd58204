"""Steady response to harmonic inputs, by dynamic stiffness."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from chassym.linear.state_space import LinearisationError, LinearModel

Array = np.ndarray

VERTICAL_INPUT = re.compile(r"(.+_)?(pad_z|road)")
"""Names of the inputs that move the road or a pad up and down."""

DISPLACEMENT_OUTPUT = re.compile(r"(.+_)?displacement")
"""Names of the outputs that tell how far a point has moved from its design position."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """G in y = Re(G U exp(j w t)) for u = Re(U exp(j w t)): outputs per unit amplitude of inputs.

    Attributes
    ----------
    frequencies_hz
        Shape (frequencies,).
    response
        G, complex, shape (outputs, inputs, frequencies), in output unit per input unit. The rate of an input,
        j w U, is included.
    outputs, inputs, output_units, input_units
        Names and SI units.
    description
        The linear model, with the slopes used.
    """

    frequencies_hz: Array
    response: Array
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    output_units: tuple[str, ...]
    input_units: tuple[str, ...]
    description: str

    def select(self, output: str, input: str) -> Array:
        """The response of one output to one input, complex, shape (frequencies,).

        Raises
        ------
        LinearisationError
            If there is no such output or input.
        """
        return self.response[_index("output", output, self.outputs), _index("input", input, self.inputs)]

    def combined(self, output: str, amplitudes: Mapping[str, complex]) -> Array:
        """The response of one output to several inputs at once, complex, shape (frequencies,).

        Parameters
        ----------
        output
            Name of the output.
        amplitudes
            Complex amplitude of every input that moves, by its name: a phase lead of phi is a factor exp(j
            phi).

        Raises
        ------
        LinearisationError
            If there is no such output or input.
        """
        columns = [_index("input", name, self.inputs) for name in amplitudes]
        row = self.response[_index("output", output, self.outputs), columns]
        return np.array(list(amplitudes.values()), dtype=complex) @ row


def frequency_response(linear: LinearModel, frequencies_hz: ArrayLike) -> FrequencyResponse:
    """Response of every output to every prescribed displacement.

    Solves (-w^2 M + j w C + K) q = (B_u + j w B_u') u for all frequencies together; no matrix is inverted.

    Parameters
    ----------
    linear
        The linear model.
    frequencies_hz
        Frequencies (Hz), zero or greater, shape (frequencies,).

    Raises
    ------
    LinearisationError
        If a frequency is negative or not finite, or the response is infinite there.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> response = frequency_response(linearise(load_model("quarter_car")), [0.0, 1.0])
    >>> float(abs(response.select("body_displacement", "road")[0]))
    1.0...
    """
    frequencies = _checked(frequencies_hz)
    s = 2j * np.pi * frequencies[:, None, None]
    stiffness = s**2 * linear.mass + s * linear.damping + linear.stiffness
    motion = _solve(linear, frequencies, stiffness, linear.input_stiffness + s * linear.input_damping)
    outputs = (
        linear.output_by_coordinates + s * linear.output_by_rates + s**2 * linear.output_by_accelerations
    )
    response = outputs @ motion + linear.output_by_inputs + s * linear.output_by_input_rates
    return FrequencyResponse(
        frequencies_hz=frequencies,
        response=np.moveaxis(response, 0, -1),
        outputs=linear.outputs,
        inputs=linear.inputs,
        output_units=linear.output_units,
        input_units=linear.input_units,
        description=linear.description,
    )


def heave_response(linear: LinearModel, frequencies_hz: ArrayLike) -> FrequencyResponse:
    """Displacement of body and wheels per unit displacement of all pads, or the road, up and down in phase.

    The result has one input, ``heave``, and as outputs the displacements that the mechanism measures.

    Raises
    ------
    LinearisationError
        As for `frequency_response`, or if nothing moves vertically under the mechanism.
    """
    pads = [name for name in linear.inputs if VERTICAL_INPUT.fullmatch(name)]
    if not pads:
        raise LinearisationError(
            f"heave of {linear.name!r}: none of its inputs {list(linear.inputs)} moves it vertically; "
            "one named 'road', '..._road' or '..._pad_z' is needed"
        )
    full = frequency_response(linear, frequencies_hz)
    measured = [i for i, name in enumerate(full.outputs) if DISPLACEMENT_OUTPUT.fullmatch(name)]
    rows = [full.combined(full.outputs[i], dict.fromkeys(pads, 1.0)) for i in measured]
    return FrequencyResponse(
        frequencies_hz=full.frequencies_hz,
        response=np.array(rows).reshape(len(measured), 1, -1),
        outputs=tuple(full.outputs[i] for i in measured),
        inputs=("heave",),
        output_units=tuple(full.output_units[i] for i in measured),
        input_units=("m",),
        description=full.description,
    )


def _checked(frequencies_hz: ArrayLike) -> Array:
    frequencies = np.array(frequencies_hz, dtype=float, ndmin=1)
    if frequencies.ndim != 1:
        raise LinearisationError(f"frequencies_hz has shape {frequencies.shape}; one dimension is needed")
    wrong = frequencies[~(np.isfinite(frequencies) & (frequencies >= 0))]
    if len(wrong):
        raise LinearisationError(
            f"frequencies_hz holds {wrong[0]:g}; finite frequencies of zero or more are needed"
        )
    return frequencies


def _solve(linear: LinearModel, frequencies: Array, stiffness: Array, right: Array) -> Array:
    try:
        return np.linalg.solve(stiffness, right)
    except np.linalg.LinAlgError:
        worst = frequencies[np.linalg.cond(stiffness).argmax()]
        raise LinearisationError(
            f"frequencies_hz holds {worst:g}, where {linear.name!r} has an undamped mode and its response is "
            "infinite; leave this frequency out or add damping"
        ) from None


def _index(kind: str, name: str, names: tuple[str, ...]) -> int:
    if name in names:
        return names.index(name)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0)
    hint = f"the nearest is {near[0]!r}" if near else "there are none"
    raise LinearisationError(f"{kind} {name!r} is unknown; {hint}")
