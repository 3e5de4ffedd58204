"""Single numbers that a linear model is judged by, with their exact derivatives by parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from chassym.linear.frequency_response import frequency_response, index_of
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.mode_tracking import track_modes
from chassym.linear.modal.modes import Mode, damped_modes
from chassym.linear.road.random_road import mean_square_nodes, root_mean_squares
from chassym.linear.road.road_contacts import Passage
from chassym.linear.variation.sensitivity import Sensitivity

Array = np.ndarray


LinearAt = Callable[[float], LinearModel]
"""The linear model with some parameters multiplied by a factor."""


class Metric(Protocol):
    """A number that a linear model is judged by."""

    @property
    def name(self) -> str:
        """In words."""

    def unit(self, linear: LinearModel) -> str:
        """SI unit, or Hz."""

    def of(self, linear: LinearModel) -> float:
        """Its value."""

    def followed(self, linear_at: LinearAt, factor: float) -> float:
        """Its value at a factor, of the same motion as at factor one."""

    def derivative(self, sensitivity: Sensitivity) -> Array:
        """Its derivatives by the parameters of a sensitivity, shape (p,)."""


@dataclass(frozen=True)
class _OfMode:
    """What is measured of one mode.

    Attributes
    ----------
    mode
        Its name, as `damped_modes` gives it.
    """

    mode: str

    quantity: ClassVar[str]
    """Attribute of `Mode`, and variable of `track_modes`."""

    words: ClassVar[str]
    """What it is called."""

    @property
    def name(self) -> str:
        """In words."""
        return f"{self.words} of {self.mode}"

    def of(self, linear: LinearModel) -> float:
        """Its value; a mode that is not there is refused with a LinearisationError."""
        return float(getattr(find_mode(linear, self.mode), self.quantity))

    def followed(self, linear_at: LinearAt, factor: float) -> float:
        """Its value at a factor: the mode may have another name there."""
        eigenvalue = find_mode(linear_at(1.0), self.mode).eigenvalue
        found = track_modes(linear_at, [1.0, factor])
        distances = np.abs(found["eigenvalue"].values[0] - eigenvalue).min(axis=1)
        return float(found[self.quantity].values[1, distances.argmin()])


class NaturalFrequency(_OfMode):
    """|eigenvalue| / (2 pi) of a mode (Hz), given by its name."""

    quantity = "frequency_hz"
    words = "natural frequency"

    def unit(self, linear: LinearModel) -> str:
        """Hz."""
        return "Hz"

    def derivative(self, sensitivity: Sensitivity) -> Array:
        """Its derivatives, shape (p,)."""
        return sensitivity.frequencies_hz([find_mode(sensitivity.linear, self.mode).eigenvalue])[0]


class DampingRatio(_OfMode):
    """-Re(eigenvalue) / |eigenvalue| of a mode, given by its name."""

    quantity = "damping_ratio"
    words = "damping ratio"

    def unit(self, linear: LinearModel) -> str:
        """Dimensionless."""
        return "1"

    def derivative(self, sensitivity: Sensitivity) -> Array:
        """Its derivatives, shape (p,)."""
        return sensitivity.damping_ratios([find_mode(sensitivity.linear, self.mode).eigenvalue])[0]


@dataclass(frozen=True)
class ResponseAmplitude:
    """Amplitude of an output when inputs move harmonically.

    Attributes
    ----------
    output
        Name of the output.
    amplitudes
        Complex amplitude of every input that moves, by its name.
    frequency_hz
        Frequency (Hz).
    """

    output: str
    amplitudes: Mapping[str, complex]
    frequency_hz: float

    @property
    def name(self) -> str:
        """In words."""
        return f"amplitude of {self.output.replace('_', ' ')} at {self.frequency_hz:g} Hz"

    def unit(self, linear: LinearModel) -> str:
        """That of the output."""
        return linear.output_units[index_of("output", self.output, linear.outputs)]

    def of(self, linear: LinearModel) -> float:
        """Its value; an unknown output or input is refused with a LinearisationError."""
        return float(abs(self._complex(linear)))

    def followed(self, linear_at: LinearAt, factor: float) -> float:
        """Its value at a factor."""
        return self.of(linear_at(factor))

    def derivative(self, sensitivity: Sensitivity) -> Array:
        """Its derivatives, shape (p,)."""
        value = self._complex(sensitivity.linear)
        if value == 0:
            raise LinearisationError(f"{self.name} is zero: its amplitude has no derivative there")
        moved = np.array(list(self.amplitudes.values()))
        changes = sensitivity.response(self.output, list(self.amplitudes), [self.frequency_hz])[:, :, 0]
        return (np.conj(value) * (changes @ moved)).real / abs(value)

    def _complex(self, linear: LinearModel) -> complex:
        response = frequency_response(linear, [self.frequency_hz])
        return complex(response.combined(self.output, self.amplitudes)[0])


@dataclass(frozen=True)
class RoadVibration:
    """Root mean square of an output on a random road.

    Attributes
    ----------
    output
        Name of the output.
    passage
        The road, its contacts and the speed.
    """

    output: str
    passage: Passage

    @property
    def name(self) -> str:
        """In words."""
        return f"root mean square of {self.output.replace('_', ' ')}"

    def unit(self, linear: LinearModel) -> str:
        """That of the output."""
        return linear.output_units[index_of("output", self.output, linear.outputs)]

    def of(self, linear: LinearModel) -> float:
        """Its value; refused as by `random_response`."""
        return root_mean_squares(linear, self.passage, {self.output: np.ones_like})[self.output].value

    def followed(self, linear_at: LinearAt, factor: float) -> float:
        """Its value at a factor."""
        return self.of(linear_at(factor))

    def derivative(self, sensitivity: Sensitivity) -> Array:
        """Its derivatives, shape (p,), by quadrature over the road's band; contacts stay where they are."""
        linear = sensitivity.linear
        frequencies, weights = mean_square_nodes(linear, self.passage)
        inputs = list(self.passage.contacts)
        row = index_of("output", self.output, linear.outputs)
        columns = [index_of("input", name, linear.inputs) for name in inputs]
        response = frequency_response(linear, frequencies).response[row, columns].T
        spectra = self.passage.input_spectra(frequencies) * weights[:, None, None]
        back = (spectra @ response.conj()[:, :, None])[:, :, 0]
        mean_square = (response * back).sum().real
        changes = sensitivity.response(self.output, inputs, frequencies)
        return np.einsum("pif,fi->p", changes, back).real / np.sqrt(mean_square)


def find_mode(linear: LinearModel, name: str) -> Mode:
    """The damped mode of a name.

    Raises
    ------
    LinearisationError
        If there is none.
    """
    modes = damped_modes(linear)
    return modes[index_of("mode", name, tuple(mode.name for mode in modes))]
