"""Steady response to harmonic inputs, by dynamic stiffness."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.refinement import refined_solve

Array = np.ndarray

VERTICAL_INPUT = re.compile(r"(.+_)?(pad_z|road)")
"""Names of the inputs that move the road or a pad up and down."""

_FIRST_PHASE = -170.0
"""Least first phase (degrees)."""

_CANCELLED = 1e-11
"""Sum of responses, as a part of the sum of their sizes, that is rounding of zero."""

_DETERMINED = 1e-3
"""Largest relative correction by refinement: three digits of a response have to be determined."""


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

    def __repr__(self) -> str:
        size = (
            f"{len(self.outputs)} outputs, {len(self.inputs)} inputs, {len(self.frequencies_hz)} frequencies"
        )
        return f"<FrequencyResponse of {size}: {self.description}>"

    def select(self, output: str, input: str) -> Array:
        """The response of one output to one input, complex, shape (frequencies,).

        Raises
        ------
        LinearisationError
            If there is no such output or input.
        """
        return self.response[index_of("output", output, self.outputs), index_of("input", input, self.inputs)]

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
        columns = [index_of("input", name, self.inputs) for name in amplitudes]
        row = self.response[index_of("output", output, self.outputs), columns]
        return np.array(list(amplitudes.values()), dtype=complex) @ row


def frequency_response(linear: LinearModel, frequencies_hz: ArrayLike) -> FrequencyResponse:
    """Response of every output to every prescribed displacement.

    Solves (-w^2 M + j w C + K) q = (B_u + j w B_u') u for all frequencies together; no matrix is inverted.
    One step of iterative refinement keeps the digits of responses that are small beside others.

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
    frequencies = checked_frequencies(frequencies_hz)
    s = 2j * np.pi * frequencies[:, None, None]
    motion = motion_per_input(linear, frequencies)
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
    """Response of every output to all pads, or the road, up and down in phase: its one input is ``heave``.

    Where symmetry makes the parts cancel, it is zero.

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
    parts = full.response[:, [full.inputs.index(name) for name in pads]]
    total = parts.sum(axis=1, keepdims=True)
    total[np.abs(total) < _CANCELLED * np.abs(parts).sum(axis=1, keepdims=True)] = 0
    return replace(full, response=total, inputs=("heave",), input_units=("m",))


def continuous_phase_degrees(response: Array) -> Array:
    """Phase of a complex response over frequency, without jumps, its first value from -170 degrees on.

    An acceleration per displacement then begins at 180 degrees, never at -180.

    Examples
    --------
    >>> continuous_phase_degrees(np.exp(1j * np.radians([-179.0, -185.0, -365.0])))
    array([181., 175.,  -5.])
    """
    phase = np.degrees(np.unwrap(np.angle(response)))
    return np.asarray(phase - 360 * np.floor((phase[0] - _FIRST_PHASE) / 360))


def checked_frequencies(frequencies_hz: ArrayLike) -> Array:
    """Frequencies (Hz) as an array of one dimension; what is none is refused.

    Raises
    ------
    LinearisationError
        If one is negative or not finite, or there is more than one dimension.
    """
    frequencies = np.array(frequencies_hz, dtype=float, ndmin=1)
    if frequencies.ndim != 1:
        raise LinearisationError(f"frequencies_hz has shape {frequencies.shape}; one dimension is needed")
    wrong = frequencies[~(np.isfinite(frequencies) & (frequencies >= 0))]
    if len(wrong):
        raise LinearisationError(
            f"frequencies_hz holds {wrong[0]:g}; finite frequencies of zero or more are needed"
        )
    return frequencies


def motion_per_input(linear: LinearModel, frequencies: Array) -> Array:
    """Coordinates per unit of every input at frequencies (Hz), complex, shape (frequencies, n, inputs).

    Raises
    ------
    LinearisationError
        If the response is infinite at one of them.
    """
    s = (2j * np.pi * frequencies)[:, None, None].astype(np.clongdouble)
    stiffness = s**2 * linear.mass + s * linear.damping + linear.stiffness
    try:
        motion, correction = refined_solve(stiffness, linear.input_stiffness + s * linear.input_damping)
    except np.linalg.LinAlgError:
        worst = np.linalg.cond(stiffness.astype(complex)).argmax()
    else:
        if (correction < _DETERMINED).all():
            return motion.astype(complex)
        worst = correction.argmax()
    raise LinearisationError(
        f"frequencies_hz holds {frequencies[worst]:g}, where {linear.name!r} has an undamped mode and its "
        "response is infinite; leave this frequency out or add damping"
    )


def index_of(kind: str, name: str, names: tuple[str, ...]) -> int:
    """Where a name stands.

    Raises
    ------
    LinearisationError
        If it is not there; the message names the kind and what is near.
    """
    if name in names:
        return names.index(name)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0)
    hint = f"the nearest is {near[0]!r}" if near else "there are none"
    raise LinearisationError(f"{kind} {name!r} is unknown; {hint}")
