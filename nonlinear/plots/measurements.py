"""Pictures of steady states: waveforms, stepped sines, sweeps, changes; drawn on axes that are handed in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
"""Distinct also for colour-blind readers. Source: M. Okabe and K. Ito, Color Universal Design, 2008."""

LINE_STYLES = ("-", "--", "-.", ":")
MARKERS = ("o", "s", "^", "v")


def plot_waveform(axes: Axes, time_s: np.ndarray, values: np.ndarray, name: str, unit: str) -> Axes:
    """Draw one signal over time.

    Parameters
    ----------
    axes
        Where to draw.
    time_s, values
        Shape (samples,).
    name, unit
        Of the signal.
    """
    axes.plot(time_s, values, color=COLORS[0])
    axes.set_xlim(time_s[0], time_s[-1])
    axes.axhline(0, color="0.6", linewidth=0.7)
    axes.set_ylabel(f"{name}\n({readable_unit(unit)})")
    axes.set_xlabel("time (s)")
    finish(axes)
    return axes


def plot_stepped_sine(
    axes: Axes, frequencies_hz: Sequence[float], amplitudes: Sequence[float], label: str, series: int = 0
) -> Axes:
    """Draw amplitudes measured frequency by frequency; what is not a number leaves a gap.

    Parameters
    ----------
    axes
        Where to draw.
    frequencies_hz, amplitudes
        Equally long.
    label
        In the legend.
    series
        Number of the series on these axes: it has its own colour and marker.
    """
    axes.plot(
        frequencies_hz,
        amplitudes,
        color=COLORS[series % len(COLORS)],
        marker=MARKERS[series % len(MARKERS)],
        markersize=4,
        linewidth=0.8,
        label=label,
    )
    axes.set_xlabel("frequency (Hz)")
    finish(axes)
    return axes


def plot_linear_response(
    axes: Axes, frequencies_hz: np.ndarray, amplitudes: np.ndarray, label: str, series: int = 0
) -> Axes:
    """Draw the linear response beside a stepped sine of the same series, as a dashed line."""
    axes.plot(
        frequencies_hz, amplitudes, "--", color=COLORS[series % len(COLORS)], linewidth=1.2, label=label
    )
    return axes


def mark_frequencies(axes: Axes, frequencies_hz: Sequence[float], step_hz: float, label: str) -> Axes:
    """Shade half a step to both sides of each of some ascending frequencies, neighbours together."""
    bands: list[list[float]] = []
    for frequency in frequencies_hz:
        if bands and frequency - bands[-1][1] < 1.01 * step_hz:
            bands[-1][1] = frequency
        else:
            bands.append([frequency, frequency])
    for index, (first, last) in enumerate(bands):
        span = first - 0.5 * step_hz, last + 0.5 * step_hz
        axes.axvspan(*span, color="0.88", linewidth=0, zorder=0, label=None if index else label)
    return axes


def plot_force_over_travel(
    axes: Axes, travel_m: np.ndarray, force_n: np.ndarray, slope: float, offset: float
) -> Axes:
    """Draw a cycle of force (kN) over travel (mm), and its regression line (slope in N/m, offset in N)."""
    ends = np.array([travel_m.min(), travel_m.max()])
    axes.plot(1e3 * travel_m, 1e-3 * force_n, color=COLORS[0], linewidth=2.2, label="computed cycle")
    line = f"regression: {1e-3 * slope:.2f} N/mm"
    axes.plot(1e3 * ends, 1e-3 * (offset + slope * ends), "--", color=COLORS[1], label=line)
    axes.set_xlabel("wheel travel, jounce positive (mm)")
    axes.set_ylabel("vertical patch force (kN)")
    axes.legend(frameon=False)
    finish(axes)
    return axes


def plot_sweep(
    axes: Axes, parameter: Sequence[float], values: Sequence[float], label: str, series: int = 0
) -> Axes:
    """Draw a metric over a parameter, both on logarithmic scales; what is not a number leaves a gap.

    Parameters
    ----------
    axes
        Where to draw.
    parameter, values
        Equally long, positive.
    label
        In the legend.
    series
        Number of the series on these axes: it has its own colour, line style and marker.
    """
    axes.plot(
        parameter,
        values,
        LINE_STYLES[series % len(LINE_STYLES)],
        color=COLORS[series % len(COLORS)],
        marker=MARKERS[series % len(MARKERS)],
        markersize=3,
        linewidth=1.2,
        label=label,
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    if np.nansum(values) > 0:
        _few_decades(axes)
    finish(axes)
    return axes


def mark_nominal(axes: Axes, parameters: Sequence[float], value: float) -> Axes:
    """Mark the nominal case of a sweep with a diamond at each of its parameters."""
    axes.plot(
        parameters,
        [value] * len(parameters),
        linestyle="none",
        marker="D",
        markersize=7,
        color="black",
        markeredgecolor="white",
        zorder=5,
        label="nominal",
    )
    return axes


def plot_changes(
    axes: Axes, groups: Sequence[str], changes: Mapping[str, Sequence[float]], unit: str
) -> Axes:
    """Draw by how much groups of parameters change a metric, as bars with their numbers.

    Parameters
    ----------
    axes
        Where to draw.
    groups
        Names, first on top.
    changes
        For every kind of change, such as ``"−25 %"``, the change that each group makes; nan where it is not
        known.
    unit
        Of the changes.
    """
    rows, height = np.arange(len(groups)), 0.8 / max(len(changes), 1)
    for index, (kind, sizes) in enumerate(changes.items()):
        at = rows - 0.4 + height * (index + 0.5)
        bars = axes.barh(at, np.nan_to_num(sizes), height, color=COLORS[index % len(COLORS)], label=kind)
        axes.bar_label(bars, [_change(size) for size in sizes], padding=3, fontsize="x-small", color="0.25")
    axes.set_yticks(rows, groups)
    axes.set_ylim(len(groups) - 0.5, -0.5)
    axes.margins(x=0.32)
    axes.axvline(0, color="0.4", linewidth=0.8)
    axes.set_xlabel(f"change ({readable_unit(unit)})")
    finish(axes)
    axes.grid(visible=False, axis="y")
    return axes


def readable_unit(unit: str) -> str:
    """A unit as it is printed.

    Examples
    --------
    >>> readable_unit("m/s^2")
    'm/s²'
    """
    return unit.replace("^2", "²").replace("*", " ")


def _change(size: float) -> str:
    return f"{size:+.2g}".replace("-", "−") if np.isfinite(size) else "not solved"


def _few_decades(axes: Axes) -> None:
    """Ticks on logarithmic axes, on the vertical one as many as its decades leave room for, written out."""
    low, high = axes.get_ylim()
    decades = np.log10(high / low)
    steps = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if decades < 1.2 else (1.0, 2.0, 5.0) if decades < 2.5 else (1.0,)
    axes.yaxis.set_major_locator(LogLocator(subs=steps, numticks=30))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: _power_of_ten(value)))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())


def _power_of_ten(value: float) -> str:
    exponent = f"{np.log10(value):.0f}"
    return "10" + exponent.translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def finish(axes: Axes) -> None:
    """What every drawing shares."""
    axes.grid(which="major", color="0.88", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
