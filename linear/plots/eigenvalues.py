"""Eigenvalues in the complex plane: pole maps and root loci."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import MaxNLocator

from chassym.linear.modal.modes import Mode
from chassym.linear.plots.style import (
    COLORS,
    GRADUAL,
    finish,
    label_at_right,
    spans_decades,
    with_unit,
    words,
)

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

DAMPING_RATIOS = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9)
"""Of the straight lines of constant damping ratio."""

GRID_COLOR = "0.8"

LABEL_SIZE = np.array([34.0, 12.0])
"""Room for the label of a line of constant damping ratio (points, 1/72 inch)."""


def plot_poles(axes: Axes, modes: Sequence[Mode], description: str = "") -> Axes:
    """Draw the eigenvalues of modes, with lines of constant damping ratio and of constant frequency (Hz).

    The upper half of the complex plane is drawn; an oscillation has a second eigenvalue, the mirror image.
    Where low modes lie too close together beside high ones, draw them alone, or set the limits of the axes
    first: limits that are set are kept.

    Parameters
    ----------
    axes
        Where to draw; the labels stand to the right of it.
    modes
        From `damped_modes`, or some of them.
    description
        Written above: that of the linear model states the slopes used.
    """
    values = np.array([mode.eigenvalue for mode in modes])
    axes.plot(values.real, values.imag, "x", color=COLORS[0], markersize=7, markeredgewidth=1.6, zorder=4)
    _upper_half(axes, values)
    _grid(axes, description)
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    seen = [m for m in modes if left <= m.eigenvalue.real <= right and bottom <= m.eigenvalue.imag <= top]
    points = [(mode.eigenvalue.real, mode.eigenvalue.imag) for mode in seen]
    label_at_right(axes, points, [mode.name for mode in seen], ["black"] * len(seen))
    return axes


def plot_root_locus(axes: Axes, locus: xarray.DataArray) -> Axes:
    """Draw how eigenvalues move with a parameter, coloured by its value, with a colour bar.

    Crosses mark the first value, circles the last one. The upper half of the complex plane is drawn, with the
    lower one folded onto it; limits of the axes that are set before are kept.

    Parameters
    ----------
    axes
        Where to draw.
    locus
        From `root_locus`.
    """
    values = locus["value"].to_numpy()
    roots = locus.to_numpy().real + 1j * np.abs(locus.to_numpy().imag)
    norm = (LogNorm if spans_decades(values) else Normalize)(values[0], values[-1])
    lines = LineCollection(_segments(roots), cmap=GRADUAL, norm=norm, zorder=3)
    lines.set_array(np.tile(values[1:], roots.shape[1]))
    axes.add_collection(lines, autolim=False)
    for row, marker in ((0, "x"), (-1, "o")):
        color = GRADUAL(norm(values[row]))
        axes.plot(roots[row].real, roots[row].imag, marker, color=color, markerfacecolor="none", zorder=4)
    _upper_half(axes, roots.ravel())
    _grid(axes, locus.attrs["description"])
    name = with_unit(words(locus.attrs["parameter"]), locus.attrs["parameter_units"])
    axes.figure.colorbar(lines, ax=axes, label=f"{name}, from × to ○")
    return axes


def _segments(roots: Array) -> list[Array]:
    """The steps of every branch, one branch after the other, as pairs of points."""
    points = np.stack([roots.T.real, roots.T.imag], axis=-1)
    return list(np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2))


def _upper_half(axes: Axes, values: Array) -> None:
    """Limits around eigenvalues with room for labels; those that are set already are kept."""
    height = values.imag.max() or np.abs(values.real).max() or 1.0
    width = max(-values.real.min(), 0.15 * height)
    if axes.get_autoscaley_on():
        axes.set_ylim(-0.03 * height, 1.08 * height)
    if axes.get_autoscalex_on():
        axes.set_xlim(-1.1 * width, max(1.1 * values.real.max(), 0.14 * width))


def _grid(axes: Axes, description: str) -> None:
    """Axes, rays of constant damping ratio and circles of constant frequency."""
    finish(axes, description)
    axes.grid(visible=False, which="both")
    axes.axhline(0, color="0.5", linewidth=0.8, zorder=1)
    axes.axvline(0, color="0.5", linewidth=0.8, zorder=1)
    axes.set_xlabel("real part (1/s)")
    axes.set_ylabel("imaginary part (rad/s)")
    left, top = axes.get_xlim()[0], axes.get_ylim()[1]
    _rays(axes, -left, top)
    _circles(axes, top)


def _rays(axes: Axes, width: float, top: float) -> None:
    """Lines of constant damping ratio from the origin to the edge of the picture, with labels there."""
    labelled: list[Array] = []
    for ratio in DAMPING_RATIOS:
        slope = np.sqrt(1 - ratio**2) / ratio
        end = -min(width, top / slope), min(top, width * slope)
        axes.plot([0, end[0]], [0, end[1]], ":", color=GRID_COLOR, linewidth=0.9, zorder=1)
        place = axes.transData.transform(end) * 72 / axes.figure.dpi
        if all(np.abs((place - other) / LABEL_SIZE).max() > 1 for other in labelled):
            labelled.append(place)
            sides = ("center", "top") if end[1] == top else ("left", "center")
            _write(axes, f"ζ {ratio:g}", end, sides)


def _circles(axes: Axes, top: float) -> None:
    """Lines of constant natural frequency, with labels at the imaginary axis."""
    angle = np.linspace(np.pi / 2, np.pi, 91)
    for frequency in MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(0, top / (2 * np.pi))[1:]:
        radius = 2 * np.pi * frequency
        if radius < 0.97 * top:
            x, y = radius * np.cos(angle), radius * np.sin(angle)
            axes.plot(x, y, color=GRID_COLOR, linewidth=0.7, zorder=1)
            _write(axes, f"{frequency:g} Hz", (0, radius), ("left", "center"))


def _write(axes: Axes, text: str, place: tuple[float, float], sides: tuple[str, str]) -> None:
    """A label of a grid line, on a background that interrupts the line."""
    axes.annotate(
        text,
        place,
        (3, 0) if sides[0] == "left" else (0, -2),
        textcoords="offset points",
        fontsize="x-small",
        color="0.4",
        horizontalalignment=sides[0],
        verticalalignment=sides[1],
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
        zorder=2,
    )
