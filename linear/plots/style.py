"""What all pictures share: colours, units, titles, grids and labels that do not overlap."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps, font_manager
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import ListedColormap
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from scipy.optimize import isotonic_regression

Array = np.ndarray

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
"""For lines, distinct also for colour-blind readers. M. Okabe and K. Ito, Color Universal Design, 2008."""

AREA_COLORS = (
    "#332288", "#88ccee", "#44aa99", "#117733", "#999933",
    "#ddcc77", "#cc6677", "#882255", "#aa4499", "#dddddd",
)  # fmt: skip
"""For areas, likewise. P. Tol, Colour Schemes, SRON/EPS/TN/09-002, 2021, scheme "muted"."""

GRADUAL = ListedColormap(colormaps["viridis"](np.linspace(0, 0.9, 256)), "gradual")
"""For numbers; without the end of viridis that is too light on white."""

LINE_STYLES = ("-", "--", "-.", ":")

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

LINE_SPACING = 1.35
"""Distance of labels over their font size."""


def readable_unit(unit: str) -> str:
    """A unit as it is printed.

    Examples
    --------
    >>> readable_unit("m/s^2"), readable_unit("N*m/rad"), readable_unit("m^-1")
    ('m/s²', 'N m/rad', 'm⁻¹')
    """
    raised = re.sub(r"(?:\^|\*\*)(-?\d+)", lambda match: match[1].translate(SUPERSCRIPTS), unit)
    return raised.replace("*", " ")


def with_unit(name: str, unit: str) -> str:
    """A name with its unit in brackets, if it has one."""
    return name if unit in ("", "1") else f"{name} ({readable_unit(unit)})"


def words(name: str) -> str:
    """A name as it is printed.

    Examples
    --------
    >>> words("body.front.torsional_stiffness")
    'body front torsional stiffness'
    """
    return re.sub(r"[._]+", " ", name)


def line_look(series: int) -> tuple[str, str]:
    """Colour and line style of a series on its axes: after the last colour the next line style."""
    return COLORS[series % len(COLORS)], LINE_STYLES[series // len(COLORS) % len(LINE_STYLES)]


def next_series(axes: Axes) -> int:
    """How many lines with an entry for the legend the axes hold."""
    return len(axes.get_legend_handles_labels()[0])


def finish(axes: Axes, description: str) -> None:
    """Grid behind the data, no frame, and above in small print what was linearised, with the slopes used."""
    axes.grid(which="major", color="0.85")
    axes.grid(which="minor", color="0.93", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    said, drawn_before = textwrap.fill(description, 90), axes.get_title(loc="left")
    if drawn_before not in ("", said):
        said = ""  # curves of several models: no description holds for all
    axes.set_title(said, loc="left", fontsize="x-small", color="0.4")


def over_frequency(axes: Axes) -> None:
    """The horizontal axis of everything drawn over frequency: logarithmic, in Hz."""
    axes.set_xscale("log")
    axes.set_xlabel("frequency (Hz)")
    write_numbers(axes.xaxis)


def write_numbers(axis: Axis) -> None:
    """Numbers instead of powers of ten on a logarithmic axis; few decades have 2 and 5 between them."""
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 300 * low else (1,), numticks=30))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def spans_decades(values: Array) -> bool:
    """Whether values are positive and the largest is at least ten times the smallest."""
    return bool(values.min() > 0 and values.max() >= 10 * values.min())


def label_at_right(
    axes: Axes, points: Sequence[tuple[float, float]], labels: Sequence[str], colors: Sequence[str]
) -> None:
    """Write labels in a column to the right of the axes, without overlap, each joined to its point.

    The limits of the axes are fixed at what they are: the places of the labels depend on them.

    Parameters
    ----------
    axes
        Where the points are drawn.
    points
        In data coordinates.
    labels, colors
        One for each point.
    """
    axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim())
    if not points:
        return
    size = font_manager.FontProperties(size="small").get_size_in_points()
    heights = axes.transAxes.inverted().transform(axes.transData.transform(points))[:, 1]
    distance = LINE_SPACING * size * axes.figure.dpi / 72 / axes.get_window_extent().height
    for point, label, color, height in zip(points, labels, colors, spread(heights, distance), strict=True):
        axes.annotate(
            label,
            xy=point,
            xytext=(1.04, height),
            textcoords="axes fraction",
            fontsize=size,
            color=color,
            verticalalignment="center",
            arrowprops={"arrowstyle": "-", "color": "0.6", "linewidth": 0.5, "relpos": (0, 0.5)},
        )


def spread(heights: Array, distance: float) -> Array:
    """Heights between 0 and 1 in the same order, at least a distance apart, and as near as can be.

    Where they do not fit, the distance is what fits. Least squares with h[i + 1] >= h[i] + d is isotonic
    regression of h[i] - i d.

    Examples
    --------
    >>> spread(np.array([0.5, 0.5, 0.0]), 0.2).round(6)
    array([0.4, 0.6, 0. ])
    """
    distance = min(distance, 1 / max(len(heights) - 1, 1))
    order = np.argsort(heights, kind="stable")
    offsets = distance * np.arange(len(heights))
    placed = np.empty(len(heights))
    placed[order] = np.clip(isotonic_regression(heights[order] - offsets).x, 0, 1 - offsets[-1]) + offsets
    return placed
