"""Pictures of frequency responses and modes, drawn on axes that are handed in."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator, NullFormatter

from chassym.linear.frequency_response import FrequencyResponse
from chassym.linear.modes import Mode


def plot_frequency_response(
    axes: Axes, response: FrequencyResponse, output: str, input: str, label: str | None = None
) -> Axes:
    """Draw the amplitude of one output per unit of one input over frequency, both on logarithmic scales.

    Several responses may be drawn on the same axes.

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

    Raises
    ------
    LinearisationError
        If there is no such output or input.
    """
    amplitude = np.abs(response.select(output, input))
    axes.loglog(response.frequencies_hz, amplitude, label=label or _words(output))
    units = (
        response.output_units[response.outputs.index(output)],
        response.input_units[response.inputs.index(input)],
    )
    axes.set_ylabel(f"amplitude per unit of {_words(input)} ({_ratio(*units)})")
    _finish(axes, response)
    return axes


def plot_phase(
    axes: Axes, response: FrequencyResponse, output: str, input: str, label: str | None = None
) -> Axes:
    """Draw the phase of one output against one input over frequency, in degrees, without jumps.

    Raises
    ------
    LinearisationError
        If there is no such output or input.
    """
    phase = np.degrees(np.unwrap(np.angle(response.select(output, input))))
    axes.semilogx(response.frequencies_hz, phase, label=label or _words(output))
    axes.set_ylabel(f"phase against {_words(input)} (degrees)")
    axes.yaxis.set_major_locator(MultipleLocator(45))
    _finish(axes, response)
    return axes


def plot_modes(axes: Axes, modes: Sequence[Mode], description: str = "") -> Axes:
    """Draw for every mode a bar of what moves: its shares of the kinetic energy, lowest frequency on top.

    Shares below zero, where a part lags behind its carrier, are small and left out; the others fill the bar.

    Parameters
    ----------
    axes
        Where to draw.
    modes
        From `damped_modes`.
    description
        Written above: that of the linear model states the slopes used.
    """
    groups = list(dict.fromkeys(group for mode in modes for group in mode.energy))
    shares = np.array([[max(mode.energy[group], 0.0) for group in groups] for mode in modes])
    shares *= 100 / shares.sum(axis=1, keepdims=True)
    rows, left = np.arange(len(modes)), np.zeros(len(modes))
    for column, group in enumerate(groups):
        color = colormaps["tab10" if len(groups) <= 10 else "tab20"](column)
        axes.barh(rows, shares[:, column], left=left, height=0.72, color=color, label=group)
        left += shares[:, column]
    axes.set_yticks(rows, [_row_label(mode) for mode in modes])
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of kinetic energy (%)")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, borderaxespad=0)
    _describe(axes, description)
    return axes


def _row_label(mode: Mode) -> str:
    return f"{mode.name}   {mode.frequency_hz:.2f} Hz, ζ = {mode.damping_ratio:.3f}"


def _finish(axes: Axes, response: FrequencyResponse) -> None:
    """What every drawing over frequency shares."""
    axes.set_xlabel("frequency (Hz)")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", color="0.85")
    axes.grid(which="minor", color="0.93", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    _describe(axes, response.description)


def _describe(axes: Axes, description: str) -> None:
    axes.set_title(textwrap.fill(description, 90), loc="left", fontsize="x-small", color="0.4")


def _ratio(output_unit: str, input_unit: str) -> str:
    """The unit of a response: N/m, (rad/s)/m."""
    numerator = f"({output_unit})" if "/" in output_unit else output_unit
    return f"{numerator}/{input_unit}".replace("^2", "²")


def _words(name: str) -> str:
    return name.replace("_", " ")
