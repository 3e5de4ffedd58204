"""What `chassym bode` answers: as one JSON object, as a table, and as a picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from chassym.arguments import ArgumentError, choice
from chassym.linear import (
    FrequencyResponse,
    LinearModel,
    damped_modes,
    frequency_response,
    heave_response,
)
from chassym.linear.frequency_response import VERTICAL_INPUT, continuous_phase_degrees
from chassym.linear.singular_values import unit_ratio
from chassym.requested_modes import GROWING, print_growing
from chassym.tables import print_paragraph, print_table

if TYPE_CHECKING:
    from chassym.derivation import Model

Array = np.ndarray

HEAVE = "heave"
"""The input that stands for all pads, or the road, up and down together."""

USUAL_OUTPUTS = ("vertical_acceleration", "body_displacement")
"""Outputs looked at first, if a vehicle measures them."""

SEARCHED = 4000
"""Frequencies among which peaks are looked for, and between which the phase is followed."""

AROUND = 201
"""Frequencies among which a peak is then placed."""

STANDS_OUT = 1e-3
"""Least rise of a peak above what surrounds it, as a part of it."""

DRAWN = 1000
"""Frequencies of a picture."""

BLOCK = 500
"""Frequencies solved for at once: large models would otherwise take gigabytes."""


@dataclass(frozen=True, eq=False)
class Channel:
    """One output per unit of one input of a linear model."""

    linear: LinearModel
    output: str
    input: str

    def response(self, frequencies_hz: Array) -> FrequencyResponse:
        """The frequency response that holds this channel."""
        blocks = np.split(frequencies_hz, range(BLOCK, len(frequencies_hz), BLOCK))
        solved = [self._block(block) for block in blocks]
        together = np.concatenate([each.response for each in solved], axis=-1)
        return replace(solved[0], frequencies_hz=frequencies_hz, response=together)

    def values(self, frequencies_hz: Array) -> Array:
        """Complex, shape (frequencies,)."""
        return self.response(frequencies_hz).select(self.output, self.input)

    def phase_degrees(self, frequencies_hz: Array) -> Array:
        """Without jumps from the lowest frequency on, as in a picture, however few frequencies there are."""
        dense = np.union1d(frequencies_hz, np.geomspace(frequencies_hz[0], frequencies_hz[-1], SEARCHED))
        phase = continuous_phase_degrees(self.values(dense))
        return phase[np.searchsorted(dense, frequencies_hz)]

    def peaks(self, frequencies_hz: Array) -> list[tuple[float, float]]:
        """Frequency and size of the peaks between the first and the last frequency."""
        from scipy.signal import find_peaks

        searched = np.geomspace(frequencies_hz[0], frequencies_hz[-1], SEARCHED)
        size = np.abs(self.values(searched))
        if not size.all():
            return []
        found = []
        for place in find_peaks(np.log(size), prominence=STANDS_OUT)[0]:
            around = np.geomspace(searched[place - 1], searched[place + 1], AROUND)
            near = np.abs(self.values(around))
            found.append((float(around[near.argmax()]), float(near.max())))
        return found

    @property
    def unit(self) -> str:
        """Unit of the response."""
        units = dict(zip(self.linear.inputs, self.linear.input_units, strict=True)) | {HEAVE: "m"}
        output = self.linear.output_units[self.linear.outputs.index(self.output)]
        return unit_ratio(output, units[self.input])

    def _block(self, frequencies_hz: Array) -> FrequencyResponse:
        respond = frequency_response if self.input in self.linear.inputs else heave_response
        return respond(self.linear, frequencies_hz)


def find_signals(model: Model, output: str | None, input: str) -> tuple[str, str]:
    """The output and the input that are meant; without an output one that is usual.

    Raises
    ------
    ArgumentError
        If there is no such output or input.
    """
    inputs, outputs = (
        [each.name for each in signals] for signals in (model.system.inputs, model.system.outputs)
    )
    if not (inputs and outputs):
        lacks = "outputs" if inputs else "inputs"
        raise ArgumentError("VEHICLE", f"a {model.system.name}, which has no {lacks}", f"one with {lacks}")
    heave = [HEAVE] if any(map(VERTICAL_INPUT.fullmatch, inputs)) else []
    usual = [name for name in USUAL_OUTPUTS if name in outputs] or outputs
    return choice("--output", usual[0] if output is None else output, outputs), choice(
        "--input", input, list(dict.fromkeys([*heave, *inputs]))
    )


def as_data(channel: Channel, frequencies_hz: Array) -> dict[str, Any]:
    """The answer as one JSON object."""
    return {
        "output": channel.output,
        "input": channel.input,
        "unit": channel.unit,
        "stable": not any(mode.kind in GROWING for mode in damped_modes(channel.linear)),
        "damper_slope_rule": channel.linear.slope_rule if channel.linear.slopes else None,
        "frequencies_hz": frequencies_hz.tolist(),
        "magnitude": np.abs(channel.values(frequencies_hz)).tolist(),
        "phase_degrees": channel.phase_degrees(frequencies_hz).tolist(),
    }


def print_bode(channel: Channel, frequencies_hz: Array, picture: Path | None) -> None:
    """The answer as a table, with the peaks between its rows."""
    print_paragraph(f"{_words(channel.output)} per unit of {_words(channel.input)}")
    size, phase = np.abs(channel.values(frequencies_hz)), channel.phase_degrees(frequencies_hz)
    with np.errstate(divide="ignore"):
        columns = zip(frequencies_hz, size, 20 * np.log10(size), phase, strict=True)
    rows = [
        (f"{hertz:.4g}", f"{g:.4g}", f"{decibel:z.1f}", f"{lag:z.1f}") for hertz, g, decibel, lag in columns
    ]
    print_table([">frequency, Hz", f">amplitude, {channel.unit}", ">dB", ">phase, degrees"], rows)
    peaks = [f"{size:.4g} {channel.unit} at {hertz:.3g} Hz" for hertz, size in channel.peaks(frequencies_hz)]
    if peaks:
        print_paragraph(f"Peaks: {', '.join(peaks)}")
    if not size.any():
        print_paragraph("Zero but for rounding: this output does not respond to this input.")
    print_paragraph(channel.linear.description)
    if print_growing(damped_modes(channel.linear)):
        print_paragraph("The vehicle would not settle into this motion.")
    if picture is not None:
        print_paragraph(f"{picture}: the same as a Bode plot")


def draw(channel: Channel, frequencies_hz: Array, picture: Path) -> None:
    """Write a Bode plot over the same band.

    Raises
    ------
    ArgumentError
        If there is nothing to see: the output does not respond to the input.
    OSError
        If it cannot be written.
    """
    from chassym.linear.plots import save_bode

    response = channel.response(np.geomspace(frequencies_hz[0], frequencies_hz[-1], DRAWN))
    if not response.select(channel.output, channel.input).any():
        received = f"{channel.output} of {channel.input}, which is zero but for rounding"
        raise ArgumentError("--plot", received, "an output that responds to the input")
    try:
        save_bode(picture, response, channel.output, channel.input)
    except OSError as error:  # a full disk does not say whose file it could not hold
        raise OSError(error.errno, error.strerror, str(picture)) from None


def _words(name: str) -> str:
    return name.replace("_", " ")
