"""Pictures of rig tests: one period, curves of the K&C rig, or a stepped sine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chassym.nonlinear.orbits.patches import carries_by_contact, patch_of
from chassym.nonlinear.plots.measurements import COLORS, LINE_STYLES, MARKERS, readable_unit
from chassym.nonlinear.rig.running import DOWNWARD, UPWARD, RigResult, RigStep
from chassym.nonlinear.steady.result import SteadyState

_SAMPLES = 720
_WIDTH_IN, _HEIGHT_IN = 8.0, 2.6
"""Of a picture and of one of its panels."""


def save_rig_test(file: Path, result: RigResult) -> None:
    """Draw a result to a file whose name tells the format.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    draw_rig_test(result).savefig(file, dpi=150)


def draw_rig_test(result: RigResult) -> Figure:
    """A stepped sine over frequency, slopes as curves, everything else over one period."""
    if result.test.is_stepped:
        figure = _stepped(result)
    elif result.test.rates:
        figure = _curves(result)
    else:
        figure = _period(result)
    figure.align_ylabels()
    figure.suptitle(_title(result), fontsize="medium", x=0.01, ha="left")
    return figure


def _period(result: RigResult) -> Figure:
    """Panels of metrics by unit and one of the patch forces, over time."""
    step = result.steps[0]
    state = _state(step)
    time_ms, signals = _signals(state)
    units = list(dict.fromkeys(metric.unit for metric in state.peak_to_peak.values()))
    supports = [o.name for o in state.orbit.model.system.outputs if carries_by_contact(o)]
    figure, panels = _panels(len(units) + bool(supports), 1)
    for axes, unit in zip(panels, units, strict=False):
        names = [name for name, metric in state.peak_to_peak.items() if metric.unit == unit]
        for series, name in enumerate(names):
            _line(axes, time_ms, signals[name], _words(name), series)
        _finish(axes, readable_unit(unit))
    if supports:
        for series, name in enumerate(supports):
            label = _words(patch_of(name)) or "patch"
            _line(panels[-1], time_ms, 1e-3 * signals[name], label, series)
        _mark_losses(panels[-1], step, [patch_of(name) for name in supports])
        _finish(panels[-1], "patch force (kN)" + ("\nshaded: no contact" if step.contact_losses else ""))
    for axes in panels:
        axes.set_xlim(time_ms[0], time_ms[-1])
    panels[-1].set_xlabel("time (ms)")
    return figure


def _mark_losses(axes: Axes, step: RigStep, patches: Sequence[str]) -> None:
    """Shade the times without contact, in the colour of the patch."""
    period_ms = 1e3 * _state(step).orbit.period_s
    for loss in step.contact_losses:
        color = COLORS[patches.index(loss.patch) % len(COLORS)]
        for begin, end in loss.intervals_s:
            pieces = [(1e3 * begin, min(1e3 * end, period_ms)), (0.0, 1e3 * end - period_ms)]
            for first, last in pieces:
                if last > first:
                    axes.axvspan(first, last, color=color, alpha=0.15, linewidth=0, zorder=0)
    axes.axhline(0, color="0.4", linewidth=0.8)


def _curves(result: RigResult) -> Figure:
    """Every slope as the curve of a cycle, with its regression line."""
    state = _state(result.steps[0])
    _, signals = _signals(state)
    units = {output.name: output.unit for output in state.orbit.model.system.outputs}
    figure, panels = _panels(len(result.test.rates), 2)
    for axes, rate in zip(panels, result.test.rates, strict=False):
        over, of = signals[rate.over], signals[rate.of]
        axes.plot(over, of, color=COLORS[0], linewidth=2.2)
        ends, found = np.array([over.min(), over.max()]), result.steps[0].rates[rate.name]
        line = found.value * (ends - over[:-1].mean()) + of[:-1].mean()
        label = (
            f"{found.value:.5g} {readable_unit(found.unit)}" if found.unit != "1" else f"{found.value:.5g}"
        )
        axes.plot(ends, line, "--", color=COLORS[1], label=label)
        axes.set_title(_words(rate.name), fontsize="small")
        axes.set_xlabel(f"{_words(rate.over)} ({readable_unit(units[rate.over])})", fontsize="small")
        _finish(axes, f"{_words(rate.of)}\n({readable_unit(units[rate.of])})")
    for axes in panels[len(result.test.rates) :]:
        axes.set_visible(False)
    return figure


def _stepped(result: RigResult) -> Figure:
    """A panel for every metric: upward and downward, hollow where unstable, shaded where contact is lost."""
    names = _measured(result)
    figure, panels = _panels(len(names), 1)
    for axes, (name, unit) in zip(panels, names.items(), strict=True):
        for series, direction in enumerate((UPWARD, DOWNWARD)):
            _draw_run(axes, [step for step in result.steps if step.direction == direction], name, series)
        for jump in result.jumps:
            axes.axvspan(*sorted((jump.value, jump.to_value)), color="0.92", linewidth=0, zorder=0)
        _finish(axes, f"{_words(name)},\npeak to peak ({readable_unit(unit)})")
    panels[-1].set_xlabel("frequency (Hz)" + ("; shaded: jumps" if result.jumps else ""))
    return figure


def _draw_run(axes: Axes, steps: Sequence[RigStep], name: str, series: int) -> None:
    """One direction; frequencies without a steady state leave a gap."""
    frequency = np.array([step.frequency_hz for step in steps])
    values = np.array([step.state.peak_to_peak[name].value if step.state else np.nan for step in steps])
    axes.plot(
        frequency,
        values,
        LINE_STYLES[series],
        color=COLORS[series],
        marker=MARKERS[series],
        markersize=5 - 2 * series,
        linewidth=1.0,
        label=steps[0].direction if steps else "",
    )
    _ring(axes, frequency, values, [_is_unstable(step) for step in steps], "s", "unstable", series)
    _ring(axes, frequency, values, [bool(step.contact_losses) for step in steps], "o", "contact lost", series)


def _ring(
    axes: Axes,
    frequency: np.ndarray,
    values: np.ndarray,
    chosen: Iterable[bool],
    marker: str,
    label: str,
    series: int,
) -> None:
    """A larger hollow marker around some of the points."""
    which = np.fromiter(chosen, dtype=bool, count=len(values))
    if which.any():
        axes.plot(
            frequency[which],
            values[which],
            marker=marker,
            color="0.3",
            markersize=9,
            fillstyle="none",
            linestyle="none",
            label=None if series else label,
        )


def _is_unstable(step: RigStep) -> bool:
    return step.state is not None and not step.state.is_stable


def _panels(count: int, columns: int) -> tuple[Figure, list[Axes]]:
    rows = -(-count // columns)
    figure = Figure(figsize=(_WIDTH_IN, _HEIGHT_IN * rows + 0.4), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(rows, columns)).ravel())


def _signals(state: SteadyState) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time (ms) and every output over one period, both ends included."""
    phases = np.linspace(0, 2 * np.pi, _SAMPLES + 1)
    outputs = state.orbit.outputs_at(phases)
    time_ms = 1e3 * state.orbit.period_s * phases / (2 * np.pi)
    return time_ms, dict(zip(state.orbit.model.output_names, outputs, strict=True))


def _measured(result: RigResult) -> dict[str, str]:
    """Units of the metrics by name."""
    found = next((step.state for step in result.steps if step.state is not None), None)
    return {} if found is None else {name: metric.unit for name, metric in found.peak_to_peak.items()}


def _state(step: RigStep) -> SteadyState:
    assert step.state is not None, "a test of one frequency raises an error instead"
    return step.state


def _line(axes: Axes, time_ms: np.ndarray, values: np.ndarray, label: str, series: int) -> None:
    style = LINE_STYLES[series % len(LINE_STYLES)]
    axes.plot(time_ms, values, style, color=COLORS[series % len(COLORS)], linewidth=1.3, label=label)


def _finish(axes: Axes, label: str) -> None:
    axes.set_ylabel(label, fontsize="small")
    axes.grid(color="0.88", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize="small")
    outside = len(axes.lines) > 2
    axes.legend(
        frameon=False,
        fontsize="small",
        loc="center left" if outside else "best",
        bbox_to_anchor=(1.0, 0.5) if outside else None,
    )


def _title(result: RigResult) -> str:
    test = result.test
    where = f"{test.frequencies_hz[0]:.4g} Hz" if not test.is_stepped else "stepped sine"
    size = f"amplitude {test.amplitude:.4g} {readable_unit(test.amplitude_unit)}"
    vehicle = result.model.parameters.schema.model
    return f"{_words(test.name)} test of {_words(vehicle)}, {where}, {size}{test.peculiarities}"


def _words(name: str) -> str:
    return name.replace("_", " ")
