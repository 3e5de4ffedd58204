"""Pictures of modes: what moves in them, and how their frequencies depend on a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from chassym.linear.modal.modes import Mode
from chassym.linear.plots.style import (
    AREA_COLORS,
    finish,
    label_at_right,
    line_look,
    spans_decades,
    with_unit,
    words,
    write_numbers,
)

if TYPE_CHECKING:
    import xarray


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
        color, hatch = AREA_COLORS[column % len(AREA_COLORS)], "/" * (3 * (column // len(AREA_COLORS)))
        axes.barh(rows, shares[:, column], left=left, height=0.72, color=color, hatch=hatch, label=group)
        left += shares[:, column]
    finish(axes, description)
    axes.grid(visible=False, which="both")
    axes.set_yticks(rows, [_row_label(mode) for mode in modes])
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of kinetic energy (%)")
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, borderaxespad=0)
    return axes


def plot_tracked_modes(axes: Axes, tracked: xarray.Dataset) -> Axes:
    """Draw the frequencies of modes over a parameter, each line with its name at its end.

    Scales are logarithmic where the numbers are positive and span a decade.

    Parameters
    ----------
    axes
        Where to draw; the names stand to the right of it.
    tracked
        From `track_modes`.
    """
    tracked = tracked.sortby("value")
    values, frequencies = tracked["value"].to_numpy(), tracked["frequency_hz"].to_numpy().T
    names = [str(name) for name in tracked["mode"].to_numpy()]
    looks = [line_look(series) for series in range(len(names))]
    for name, frequency, (color, style) in zip(names, frequencies, looks, strict=True):
        axes.plot(values, frequency, style, color=color, label=name)
    if spans_decades(values):
        axes.set_xscale("log")
    if spans_decades(frequencies):
        axes.set_yscale("log")
        write_numbers(axes.yaxis)
    axes.set_xlim(values[0], values[-1])
    axes.set_xlabel(with_unit(words(tracked.attrs["parameter"]), tracked.attrs["unit"]))
    axes.set_ylabel("undamped natural frequency (Hz)")
    finish(axes, tracked.attrs.get("description", ""))
    ends = [(float(values[-1]), float(frequency[-1])) for frequency in frequencies]
    label_at_right(axes, ends, names, [color for color, _ in looks])
    return axes


def _row_label(mode: Mode) -> str:
    return f"{mode.name}   {mode.frequency_hz:.2f} Hz, ζ = {mode.damping_ratio:.3f}"
