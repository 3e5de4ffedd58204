"""Pictures of periodic orbits and branches of them, drawn on axes that are handed in."""

from __future__ import annotations

from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from chassym.nonlinear.continuation.branch import Branch, amplitudes, output_row
from chassym.nonlinear.continuation.stepped_sine import UPWARD, Run, SteppedResponse
from chassym.nonlinear.orbits.knots import knot_phases
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.plots.measurements import COLORS, finish, readable_unit

Array = np.ndarray

_SAMPLES = 1440
"""Instants of one orbit that are drawn."""

_LEAST = 1e-6
"""Part of the largest harmonic below which others count as zero."""

_SHOWN = {"m": (1e3, "mm"), "N": (1e-3, "kN"), "rad": (180 / np.pi, "deg"), "rad/s": (180 / np.pi, "deg/s")}
"""Units that are drawn for those of SI, and how many of them make one."""


def shown_unit(unit: str) -> tuple[float, str]:
    """A factor, and the unit that is drawn instead.

    Examples
    --------
    >>> shown_unit("m"), shown_unit("m/s^2")
    ((1000.0, 'mm'), (1.0, 'm/s²'))
    """
    factor, name = _SHOWN.get(unit, (1.0, unit))
    return factor, readable_unit(name)


def plot_orbit(axes: Axes, orbit: PeriodicOrbit, output: str, *, label: str | None = None) -> Axes:
    """Draw an output over one orbit, and ticks at the lower edge where the motion passes knots of tables.

    Parameters
    ----------
    axes
        Where to draw. Other outputs of the same unit may be drawn on the same axes.
    label
        Entry in the legend; the output's name by default.

    Raises
    ------
    KeyError
        If there is no such output.
    """
    row = output_row(orbit.model, output)
    factor, unit = shown_unit(orbit.model.system.outputs[row].unit)
    phases = np.linspace(0, 2 * np.pi, _SAMPLES + 1)
    time_ms = 1e3 * orbit.period_s * phases / (2 * np.pi)
    series = len(axes.get_legend_handles_labels()[0])
    values = factor * orbit.outputs_at(phases)[row]
    axes.plot(time_ms, values, color=COLORS[series % len(COLORS)], label=label or _words(output))
    if not series:
        at = time_ms[-1] / (2 * np.pi) * knot_phases(orbit)
        axes.plot(
            at,
            np.full(len(at), 0.02),
            "|",
            color="0.35",
            markersize=8,
            transform=axes.get_xaxis_transform(),
            label="_knots",
        )
    axes.set_xlim(time_ms[0], time_ms[-1])
    axes.set_xlabel("time (ms)")
    axes.set_ylabel(f"{_words(output) if not series else ''}\n({unit})".strip())
    finish(axes)
    return axes


def plot_harmonics(axes: Axes, orbit: PeriodicOrbit, output: str, harmonics: int = 20) -> Axes:
    """Draw the amplitudes of an output's harmonics as bars; those of zero, but for rounding, are left out.

    Parameters
    ----------
    axes
        Where to draw.
    harmonics
        Order of the highest one, in multiples of the orbit's own frequency.

    Raises
    ------
    KeyError
        If there is no such output.
    """
    row = output_row(orbit.model, output)
    factor, unit = shown_unit(orbit.model.system.outputs[row].unit)
    sizes = factor * np.abs(orbit.harmonic_content(harmonics)[row, 1:])
    orders = np.arange(1, harmonics + 1)
    there = sizes > _LEAST * sizes.max()
    axes.bar(orders[there], sizes[there], color=COLORS[0])
    axes.set_yscale("log")
    axes.set_xlim(0.2, harmonics + 0.8)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=11, integer=True, steps=[1, 2, 5, 10]))
    axes.set_xlabel(f"harmonic of {orbit.angular_frequency / (2 * np.pi):.4g} Hz")
    axes.set_ylabel(f"{_words(output)}\n({unit})")
    finish(axes)
    return axes


def plot_multipliers(axes: Axes, multipliers: Array, label: str | None = None) -> Axes:
    """Draw Floquet multipliers with the unit circle, inside which deviations die out.

    Parameters
    ----------
    axes
        Where to draw.
    multipliers
        Complex.
    label
        Entry in the legend.
    """
    axes.add_patch(Circle((0, 0), 1.0, fill=False, color="0.5", linewidth=0.8))
    axes.plot(multipliers.real, multipliers.imag, "o", markersize=5, label=label, markerfacecolor="none")
    reach = 1.1 * max(1.0, float(np.abs(multipliers).max()))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_xlabel("real part of multiplier")
    axes.set_ylabel("imaginary part")
    finish(axes)
    return axes


def plot_branch(axes: Axes, branch: Branch, output: str, label: str = "", series: int = 0) -> Axes:
    """Draw half the peak-to-peak value of an output along a branch: unstable parts dotted, folds as diamonds.

    Parameters
    ----------
    axes
        Where to draw.
    label
        Before the words of the legend.
    series
        Number of the branch on these axes: it has its own colour.

    Raises
    ------
    KeyError
        If there is no such output.
    """
    row = output_row(branch.orbits[0].model, output)
    factor, unit = shown_unit(branch.orbits[0].model.system.outputs[row].unit)
    heights, color = factor * branch.amplitude(output), COLORS[series % len(COLORS)]
    said = set()
    for is_stable, part in _stretches(branch.is_stable):
        words = f"{label} {'stable' if is_stable else 'unstable'}".strip()
        style = "-" if is_stable else ":"
        axes.plot(
            branch.values[part], heights[part], style, color=color, label=None if words in said else words
        )
        said.add(words)
    if branch.folds:
        at = [fold.value for fold in branch.folds]
        tops = [factor * amplitudes(fold.orbit, [row])[0] for fold in branch.folds]
        axes.plot(at, tops, "D", color=color, markersize=6, label=f"{label} fold".strip())
    axes.set_xlabel(f"{_words(branch.path.name)} ({readable_unit(branch.path.unit)})")
    axes.set_ylabel(f"{_words(output)}, half peak-to-peak\n({unit})")
    finish(axes)
    return axes


def _stretches(is_stable: Array) -> list[tuple[bool, slice]]:
    """Parts of a branch of one kind, each up to the first point of the next, so that lines meet."""
    parts, start = [], 0
    for kind, members in groupby(is_stable):
        stop = start + len(list(members))
        parts.append((bool(kind), slice(start, stop + 1)))
        start = stop
    return parts


def plot_steps(axes: Axes, test: SteppedResponse, output: str) -> Axes:
    """Draw both ways of a stepped sine as triangles that point where the steps go, jumps as arrows.

    Parameters
    ----------
    axes
        Where to draw: those of a branch of the same output, for instance.

    Raises
    ------
    KeyError
        If there are steady states, but the output was not measured.
    """
    runs = (test.upward, test.downward)
    amplitudes_of_runs = [run.peak_to_peak(output) / 2 for run in runs]
    units = [state.peak_to_peak[output].unit for run in runs for state in run.states if state is not None]
    factor, unit = shown_unit(units[0]) if units else (1.0, "")
    for run, heights, marker, color in zip(runs, amplitudes_of_runs, "><", COLORS[1:3], strict=True):
        words = "steps upward" if marker == ">" else "steps downward"
        axes.plot(
            run.values, factor * heights, marker, color=color, markersize=5, fillstyle="none", label=words
        )
        _arrows(axes, run, output, factor, color)
    axes.set_xlabel(f"{_words(test.path.name)} ({readable_unit(test.path.unit)})")
    axes.set_ylabel(f"{_words(output)}, half peak-to-peak\n({unit})")
    finish(axes)
    return axes


def _arrows(axes: Axes, run: Run, output: str, factor: float, color: str) -> None:
    for jump in run.jumps:
        step = -1 if jump.direction == UPWARD else 1
        after = int(np.argmin(np.abs(run.values - jump.to_value)))
        before, heights = after + step, factor / 2 * run.peak_to_peak(output)
        axes.annotate(
            "",
            xy=(run.values[after], heights[after]),
            xytext=(run.values[before], heights[before]),
            arrowprops={"arrowstyle": "->", "color": color, "shrinkA": 4, "shrinkB": 4},
        )


def _words(name: str) -> str:
    return name.replace("_", " ")
