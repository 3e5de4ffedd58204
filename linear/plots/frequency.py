"""Pictures over frequency: amplitude, phase, Bode, Nyquist, singular values, spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

from chassym.linear.frequency_response import FrequencyResponse, continuous_phase_degrees
from chassym.linear.linear_model import LinearisationError
from chassym.linear.plots.amplitude_scale import LOGARITHMIC, AmplitudeScale
from chassym.linear.plots.style import (
    GRADUAL,
    finish,
    line_look,
    next_series,
    over_frequency,
    readable_unit,
    words,
)
from chassym.linear.singular_values import NO_SCALES, singular_values, unit_ratio

PHASE_STEPS = (15, 30, 45, 90, 180, 360, 720)
"""Degrees between ticks."""

ROUNDING = 1e-12
"""Singular values below this part of the largest one at their frequency are rounding errors of zero."""


def plot_frequency_response(
    axes: Axes,
    response: FrequencyResponse,
    output: str,
    input: str,
    label: str | None = None,
    scale: AmplitudeScale = LOGARITHMIC,
) -> Axes:
    """Draw the amplitude of one output per unit of one input over frequency.

    Several responses of one unit may be drawn on the same axes. Make the figure with
    ``layout="constrained"``, so that labels have room.

    Parameters
    ----------
    axes
        Where to draw.
    response
        From `frequency_response` or `heave_response`.
    output, input
        Names.
    label
        Entry in the legend; by default the output's name.
    scale
        `LOGARITHMIC` or `DECIBEL`.

    Raises
    ------
    LinearisationError
        If there is no such output or input, or the axes show another unit already.
    """
    color, style = line_look(next_series(axes))
    drawn = scale.drawn(np.abs(response.select(output, input)))
    unit = scale.unit(readable_unit(unit_ratio(*signal_units(response, output, input))))
    _check_unit(axes, unit)
    axes.plot(response.frequencies_hz, drawn, style, color=color, label=label or words(output))
    axes.set_yscale(scale.axis)
    axes.set_ylabel(f"amplitude per unit of {words(input)}\n({unit})")
    over_frequency(axes)
    finish(axes, response.description)
    axes.legend(frameon=False)
    return axes


def _check_unit(axes: Axes, unit: str) -> None:
    """Refuse a curve in another unit than those that are there."""
    label = axes.get_ylabel()
    if axes.lines and label and not label.endswith(f"({unit})"):
        raise LinearisationError(
            f"axes that show {' '.join(label.split())!r} received for a response in {unit}; draw it on axes "
            "of its own"
        )


def plot_phase(
    axes: Axes, response: FrequencyResponse, output: str, input: str, label: str | None = None
) -> Axes:
    """Draw the phase of one output against one input over frequency, in degrees, without jumps.

    Raises
    ------
    LinearisationError
        If there is no such output or input.
    """
    _draw_phase(axes, response, output, input, label)
    finish(axes, response.description)
    axes.legend(frameon=False)
    return axes


def plot_bode(
    axes_pair: tuple[Axes, Axes],
    response: FrequencyResponse,
    output: str,
    input: str,
    label: str | None = None,
    scale: AmplitudeScale = LOGARITHMIC,
) -> tuple[Axes, Axes]:
    """Draw amplitude and phase of one output against one input over frequency, one above the other.

    Parameters
    ----------
    axes_pair
        Where to draw the amplitude and the phase: ``figure.subplots(2, 1, sharex=True)``.
    response, output, input, label, scale
        As for `plot_frequency_response`.

    Returns
    -------
    tuple of Axes
        The pair.

    Raises
    ------
    LinearisationError
        If there is no such output or input.
    """
    above, below = axes_pair
    plot_frequency_response(above, response, output, input, label, scale)
    above.set_xlabel("")
    _draw_phase(below, response, output, input, label)
    finish(below, "")
    return above, below


def save_bode(path: str | Path, response: FrequencyResponse, output: str, input: str) -> None:
    """Write a Bode plot to a file, whose name's end says in which format.

    Parameters
    ----------
    path
        File to write, such as ``bode.png`` or ``bode.svg``.
    response, output, input
        As for `plot_bode`.

    Raises
    ------
    LinearisationError
        If there is no such output or input.
    ValueError
        If the format is unknown.
    """
    figure = Figure(figsize=(8, 6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    plot_bode((above, below), response, output, input)
    figure.savefig(path, dpi=150)


def plot_singular_values(
    axes: Axes,
    response: FrequencyResponse,
    outputs: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
    scales: Mapping[str, float] = NO_SCALES,
) -> Axes:
    """Draw the singular values of a response over frequency; what is zero but for rounding leaves a gap.

    Parameters
    ----------
    axes
        Where to draw.
    response, outputs, inputs, scales
        As for `singular_values`.

    Raises
    ------
    LinearisationError
        As for `singular_values`.
    """
    values = singular_values(response, outputs, inputs, scales)
    sizes = values.to_numpy().T
    colors = GRADUAL(np.linspace(0, 1, len(sizes)))
    for number, (size, color) in enumerate(zip(sizes, colors, strict=True), start=1):
        drawn = np.where(size > ROUNDING * sizes[0], size, np.nan)
        axes.plot(response.frequencies_hz, drawn, color=color, label=rf"$\sigma_{{{number}}}$")
    axes.set_yscale("log")
    unit = (
        "of scaled signals" if values.attrs["units"] == "1" else f"({readable_unit(values.attrs['units'])})"
    )
    axes.set_ylabel(f"singular values {unit}")
    over_frequency(axes)
    finish(axes, response.description)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, borderaxespad=0)
    return axes


def plot_spectrum(
    axes: Axes, frequencies_hz: ArrayLike, spectrum: ArrayLike, unit: str, label: str, description: str = ""
) -> Axes:
    """Draw a one-sided power spectral density over frequency, both on logarithmic scales.

    Parameters
    ----------
    axes
        Where to draw.
    frequencies_hz, spectrum
        Shape (frequencies,).
    unit
        SI unit of the signal; that of its spectrum is the square of it per Hz.
    label
        Entry in the legend.
    description
        Written above: that of the linear model states the slopes used.
    """
    color, style = line_look(next_series(axes))
    axes.plot(np.asarray(frequencies_hz), np.asarray(spectrum), style, color=color, label=label)
    axes.set_yscale("log")
    squared = f"({readable_unit(unit)})²" if any(sign in unit for sign in "/*^") else f"{unit}²"
    axes.set_ylabel(f"power spectral density ({squared}/Hz)")
    over_frequency(axes)
    finish(axes, description)
    axes.legend(frameon=False)
    return axes


def _draw_phase(axes: Axes, response: FrequencyResponse, output: str, input: str, label: str | None) -> None:
    color, style = line_look(next_series(axes))
    phase = continuous_phase_degrees(response.select(output, input))
    axes.plot(response.frequencies_hz, phase, style, color=color, label=label or words(output))
    axes.set_ylabel(f"phase against {words(input)}\n(degrees)")
    step = next((step for step in PHASE_STEPS if axes.dataLim.height < 7 * step), PHASE_STEPS[-1])
    axes.yaxis.set_major_locator(MultipleLocator(step))
    over_frequency(axes)


def signal_units(response: FrequencyResponse, output: str, input: str) -> tuple[str, str]:
    """The units of two signals that are known to exist."""
    at, by = response.outputs.index(output), response.inputs.index(input)
    return response.output_units[at], response.input_units[by]
