"""The Nyquist plot: a frequency response as a curve in the complex plane."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from matplotlib.ticker import LogLocator, MaxNLocator

from chassym.linear.frequency_response import FrequencyResponse
from chassym.linear.linear_model import LinearisationError
from chassym.linear.plots.frequency import signal_units
from chassym.linear.plots.style import finish, line_look, next_series, readable_unit, words
from chassym.linear.singular_values import unit_ratio

Array = np.ndarray

NEAR = 14.0
"""Marks closer together than this share a label (points, 1/72 inch)."""

DISTANCES = (6.0, 18.0, 30.0)
"""From a mark to its label, the next one where there is no room (points, 1/72 inch)."""

TURNS = (0, 50, -50, 100, -100)
"""Directions of the label from straight outwards (degrees)."""


def plot_nyquist(
    axes: Axes,
    response: FrequencyResponse,
    output: str,
    input: str,
    label: str | None = None,
    marked_frequencies_hz: Sequence[float] | None = None,
) -> Axes:
    """Draw the imaginary over the real part of one output per unit of one input, with frequencies marked.

    Only positive frequencies are drawn; negative ones give the mirror image about the real axis. Where output
    and input have one unit, the critical point -1 of a loop closed from one to the other is shown.

    Parameters
    ----------
    axes
        Where to draw; both axes have the same scale.
    response
        From `frequency_response` or `heave_response`.
    output, input
        Names.
    label
        Entry in the legend; by default the output's name.
    marked_frequencies_hz
        Frequencies to mark within those of the response; by default 1, 2, 5, 10, 20, 50 ... Hz. Marks that
        coincide share a label.

    Raises
    ------
    LinearisationError
        If there is no such output or input, or a marked frequency is outside the response.
    """
    curve = response.select(output, input)
    if marked_frequencies_hz is None:
        marks = _round_frequencies(response.frequencies_hz)
    else:
        marks = _checked(marked_frequencies_hz, response.frequencies_hz)
    color, style = line_look(next_series(axes))
    axes.plot(curve.real, curve.imag, style, color=color, label=label or words(output))
    axes.axhline(0, color="0.6", linewidth=0.7, zorder=1)
    axes.axvline(0, color="0.6", linewidth=0.7, zorder=1)
    output_unit, input_unit = signal_units(response, output, input)
    if output_unit == input_unit:
        axes.plot([-1], [0], "+", color="black", markersize=9)
        axes.annotate("−1", (-1, 0), (4, 4), textcoords="offset points", fontsize="small")
    axes.set_aspect("equal", adjustable="datalim")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
    unit = readable_unit(unit_ratio(output_unit, input_unit))
    axes.set_xlabel(f"real part per unit of {words(input)} ({unit})")
    axes.set_ylabel(f"imaginary part ({unit})")
    finish(axes, response.description)
    _mark(axes, response.frequencies_hz, curve, marks, color)
    axes.legend(frameon=False)
    return axes


def _round_frequencies(frequencies: Array) -> Array:
    positive = frequencies[frequencies > 0]
    if not len(positive):
        return positive
    ticks = LogLocator(subs=(1, 2, 5), numticks=1000).tick_values(positive.min(), positive.max())
    return ticks[(ticks >= positive.min()) & (ticks <= positive.max())]


def _checked(marks: Sequence[float], frequencies: Array) -> Array:
    for mark in marks:
        if not frequencies.min() <= mark <= frequencies.max():
            raise LinearisationError(
                f"marked_frequencies_hz holds {mark:g}; the response is known from {frequencies.min():g} to "
                f"{frequencies.max():g} Hz"
            )
    return np.sort(np.array(marks, dtype=float))


def _mark(axes: Axes, frequencies: Array, curve: Array, marks: Array, color: str) -> None:
    """Dots on the curve; their labels outside of it, seen from its middle."""
    order = np.argsort(frequencies)
    places = np.interp(marks, frequencies[order], curve[order])
    axes.plot(places.real, places.imag, "o", color=color, markersize=3.5)
    axes.apply_aspect()  # the limits change with it, and the distances between the dots
    points = _on_paper(axes, places)
    outwards = points - _on_paper(axes, curve).mean(axis=0)
    outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-9)
    for first, members in _near(points):
        label = axes.annotate(
            _ranges(marks, members) + " Hz",
            (places[first].real, places[first].imag),
            (0, 0),
            textcoords="offset points",
            fontsize="small",
            color=color,
            verticalalignment="center",
        )
        _put_in_free_place(axes, label, complex(*outwards[first]))


def _on_paper(axes: Axes, numbers: Array) -> Array:
    """Complex numbers as places in points, 1/72 inch, shape (numbers, 2)."""
    return axes.transData.transform(np.column_stack([numbers.real, numbers.imag])) * 72 / axes.figure.dpi


def _near(points: Array) -> list[tuple[int, list[int]]]:
    """Points that share a label: the first of them, and all."""
    groups: list[tuple[int, list[int]]] = []
    for index, point in enumerate(points):
        for first, members in groups:
            if np.linalg.norm(point - points[first]) < NEAR:
                members.append(index)
                break
        else:
            groups.append((index, [index]))
    return groups


def _ranges(marks: Array, members: Sequence[int]) -> str:
    """The marks, with neighbours as a range."""
    ends: list[list[int]] = []
    for index in members:
        if ends and ends[-1][1] == index - 1:
            ends[-1][1] = index
        else:
            ends.append([index, index])
    return ", ".join(f"{marks[i]:g}" if i == j else f"{marks[i]:g}–{marks[j]:g}" for i, j in ends)


def _put_in_free_place(axes: Axes, label: Annotation, outwards: complex) -> None:
    """Move a label from its point outwards, or to a side, until it covers no other one."""
    others = [text.get_window_extent() for text in axes.texts if text is not label]
    for distance, turn in itertools.product(DISTANCES, TURNS):
        offset = distance * outwards * np.exp(1j * np.radians(turn))
        label.xyann = offset.real, offset.imag
        label.set_horizontalalignment("left" if offset.real > 0 else "right")
        if not any(label.get_window_extent().overlaps(other) for other in others):
            return
