"""How a response depends on the size of the motion: nonlinear steady states beside describing functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from chassym.derivation import Model
from chassym.linear import LinearisationError, frequency_response, linearise_for_motion
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, SteadyState, steady_state
from chassym.nonlinear.orbits.distortion import distortion

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class AmplitudeResponse:
    """The response of one output to one motion of the inputs, at several amplitudes of the motion.

    Attributes
    ----------
    frequencies_hz
        Shape (frequencies,).
    amplitudes
        Factors on the motion, shape (amplitudes,).
    output, motion
        What is measured, and what the motion is called.
    output_unit, input_unit
        SI units.
    nonlinear
        First harmonic of the steady state per unit of amplitude, complex, shape (amplitudes, frequencies);
        NaN where there is none, as in the other results of the steady state.
    equivalent
        The response of the linear model with the describing functions of that very motion, likewise; NaN
        where their amplitudes do not settle.
    mean
        Of the output in the steady state, in its unit, shape (amplitudes, frequencies).
    distortion
        Total harmonic distortion of the output, likewise.
    smallest_patch_force
        Negative where a tyre would have to pull (N), likewise; NaN for a model without patches.
    reasons
        Why there is no result, by amplitude and frequency (Hz).
    """

    frequencies_hz: Array
    amplitudes: Array
    output: str
    motion: str
    output_unit: str
    input_unit: str
    nonlinear: Array = field(repr=False)
    equivalent: Array = field(repr=False)
    mean: Array = field(repr=False)
    distortion: Array = field(repr=False)
    smallest_patch_force: Array = field(repr=False)
    reasons: Mapping[tuple[float, float], str]


def amplitude_response(
    model: Model,
    inputs: Mapping[str, complex],
    output: str,
    frequencies_hz: Sequence[float] | Array,
    amplitudes: Sequence[float] | Array,
    *,
    motion: str | None = None,
    tolerance: float = 1e-3,
) -> AmplitudeResponse:
    """Find the steady state and the equivalent linear response at every frequency and amplitude.

    Every point stands alone: none depends on its neighbours.

    Parameters
    ----------
    inputs
        Complex share of every input that moves in the motion: an amplitude multiplies them all.
    output
        What is measured.
    frequencies_hz, amplitudes
        Positive.
    motion
        What the motion is called; by default the name of the input, where it is a single one.
    tolerance
        Of the steady states, as for `steady_state`.

    Raises
    ------
    ExcitationError
        If the model has no such input, a frequency is not positive or an amplitude not finite.
    KeyError
        If it has no such output.
    ValueError
        If no input moves, an amplitude is not positive, or the tolerance is not.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> car = load_model("quarter_car")
    >>> found = amplitude_response(car, {"road": 1.0}, "body_displacement", [2.0], [0.001, 0.02])
    >>> [round(float(size), 2) for size in abs(found.nonlinear[:, 0])]
    [0.73, 0.58]
    >>> [round(float(size), 2) for size in abs(found.equivalent[:, 0])]
    [0.72, 0.56]
    """
    if not inputs:
        raise ValueError("inputs: none received; at least one that moves is needed")
    sizes, frequencies = np.asarray(amplitudes, dtype=float), np.asarray(frequencies_hz, dtype=float)
    if sizes.ndim != 1 or not np.all(sizes > 0):
        raise ValueError(f"amplitudes: {amplitudes!r} received; positive numbers are needed")
    units = {each.name: each.unit for each in model.system.inputs}
    test = _Test(model, inputs, output, tolerance)
    points = [[test.point(float(f), float(a)) for f in frequencies] for a in sizes]
    columns = np.array([[point.numbers for point in row] for row in points], dtype=complex)
    return AmplitudeResponse(
        frequencies,
        sizes,
        output,
        motion or (next(iter(inputs)) if len(inputs) == 1 else "the motion"),
        test.unit,
        units[next(iter(inputs))],
        columns[..., 0],
        columns[..., 1],
        columns[..., 2].real,
        columns[..., 3].real,
        columns[..., 4].real,
        {
            (float(a), float(f)): point.reason
            for a, row in zip(sizes, points, strict=True)
            for f, point in zip(frequencies, row, strict=True)
            if point.reason
        },
    )


@dataclass(frozen=True)
class _Point:
    """Numbers in the order of `AmplitudeResponse`, and why some are missing."""

    numbers: tuple[complex, ...]
    reason: str


@dataclass(frozen=True, eq=False)
class _Test:
    model: Model
    inputs: Mapping[str, complex]
    output: str
    tolerance: float

    @property
    def unit(self) -> str:
        """Of the output."""
        return self.model.system.outputs[self._row].unit

    @property
    def _row(self) -> int:
        names = self.model.output_names
        if self.output not in names:
            raise KeyError(f"output {self.output!r}: {self.model.system.name} has {', '.join(names)}")
        return names.index(self.output)

    def point(self, frequency_hz: float, amplitude: float) -> _Point:
        """One frequency at one amplitude."""
        excitation = Harmonic(frequency_hz, self.inputs).scaled(amplitude)
        reasons, equivalent = [], complex(np.nan)
        measured: tuple[complex, ...] = (np.nan,) * 4
        try:
            state = steady_state(self.model, excitation, metrics=[self.output], tolerance=self.tolerance)
            measured = self._measured(state, amplitude)
        except NoPeriodicOrbitError as error:
            reasons.append(str(error))
        try:
            equivalent = self._equivalent(excitation, amplitude)
        except LinearisationError as error:
            reasons.append(str(error))
        return _Point((measured[0], equivalent, *measured[1:]), "; ".join(reasons))

    def _measured(self, state: SteadyState, amplitude: float) -> tuple[complex, ...]:
        """First harmonic per amplitude, mean, distortion, smallest patch force."""
        mean, first = state.orbit.harmonic_content(1)[self._row]
        force = np.nan if state.contact is None else state.contact.value
        return first / amplitude, mean.real, distortion(state.orbit)[self.output], force

    def _equivalent(self, excitation: Harmonic, amplitude: float) -> complex:
        """Response of the equivalent linear model per amplitude."""
        linear = linearise_for_motion(self.model, excitation.frequency_hz, excitation.amplitudes)
        response = frequency_response(linear, [excitation.frequency_hz])
        return complex(response.combined(self.output, excitation.amplitudes)[0]) / amplitude
