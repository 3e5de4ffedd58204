"""The report of a study: one self-contained HTML page with its figures, and the data beside it as CSV files.

The picture in the README is ``stiffness_sweeps.png`` of the reference car's report::

    chassym study -o study && cp study/stiffness_sweeps.png docs/report.png
"""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chassym.comparison import Comparison, words
from chassym.data_files import data_files
from chassym.derivation.files import replace_file
from chassym.heave import AMPLITUDE_M, HeaveTest
from chassym.linear.plots import plot_modes
from chassym.nonlinear import plots
from chassym.nonlinear.plots import readable_unit
from chassym.printed import number, parameter_value, with_error
from chassym.rig_tests import TestRecord
from chassym.study_results import StudyResults
from chassym.variants import FACTORS, GROUPS, PLACES, sweep_curves

STYLE: Any = {
    "font.size": 9.5,
    "axes.labelsize": 9.5,
    "axes.titlesize": 10,
    "svg.fonttype": "path",
    "svg.hashsalt": "chassym",
}
"""Of all figures; with a fixed salt equal studies make equal files."""


UNDATED = {"svg": "Date", "png": "Software"}
"""Metadata of a figure to leave out by its format: it would differ between equal studies."""


def write_report(results: StudyResults, folder: Path) -> Path:
    """Write ``report.html``, the CSV files and ``stiffness_sweeps.png`` into a folder, made if need be.

    Existing files are replaced, each at once: a reader sees the old file or the new one.

    Returns
    -------
    pathlib.Path
        Of ``report.html``.

    Raises
    ------
    OSError
        If the folder cannot be made or written to.
    """
    data = data_files(results)
    contents = {name: text.encode("utf-8") for name, text in data.items()}
    contents["stiffness_sweeps.png"] = picture(results)
    contents["report.html"] = render(results, list(data)).encode("utf-8")
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        replace_file(folder / name, content)
    return folder / "report.html"


def picture(results: StudyResults) -> bytes:
    """The body stiffness sweeps of both tests as a PNG file for use elsewhere."""
    with rc_context(STYLE):
        return _saved(sweep_figure(results, list(results.tests)), "png", dpi=95)


def render(results: StudyResults, files: list[str]) -> str:
    """The page; `files` are the names of the data files to mention."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "number": number,
        "with_error": with_error,
        "unit": readable_unit,
        "words": words,
        "value": parameter_value,
        "stamp": lambda moment: moment.strftime("%Y-%m-%d %H:%M UTC"),
    }
    environment.tests["agreeing"] = lambda verdict: verdict.startswith(("inside", "agrees"))
    template = resources.files("chassym").joinpath("templates/report.html").read_text(encoding="utf-8")
    topics = _by_topic(results)
    return environment.from_string(template).render(
        results=results,
        figures=figures(results),
        topics=topics,
        files=files,
        groups=GROUPS,
        places=PLACES,
        factors=FACTORS,
    )


def _by_topic(results: StudyResults) -> dict[str, list[Comparison]]:
    topics: dict[str, list[Comparison]] = {}
    for each in results.comparisons:
        topics.setdefault(each.topic, []).append(each)
    return topics


def figures(results: StudyResults) -> dict[str, str]:
    """Every figure by name, as the address of an image that holds its own data."""
    draw: dict[str, Callable[[], Figure]] = {
        "modes": lambda: modes_figure(results),
        "wheel_rate": lambda: wheel_rate_figure(results),
        "heave": lambda: heave_figure(results.heave),
        "sensitivity": lambda: sensitivity_figure(results),
    }
    for name, record in results.tests.items():
        draw[f"{name}_waveforms"] = lambda record=record: waveform_figure(record)  # type: ignore[misc]
        draw[f"{name}_sweep"] = lambda name=name: sweep_figure(results, [name])  # type: ignore[misc]
    with rc_context(STYLE):
        return {name: _embedded(figure()) for name, figure in draw.items()}


def modes_figure(results: StudyResults) -> Figure:
    """What moves in every mode."""
    figure = Figure(figsize=(9.0, 4.4), layout="constrained")
    plot_modes(figure.subplots(), results.modes)
    return figure


def wheel_rate_figure(results: StudyResults) -> Figure:
    """Force over travel of both axles' right wheels, under the static load."""
    rates = next(iter(results.wheel_rates.values()))
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    for axes, rate in zip(figure.subplots(1, len(rates)), rates.values(), strict=True):
        plots.plot_force_over_travel(axes, rate.travel, rate.force, rate.slope, rate.offset)
        axes.set_title(f"{words(rate.wheel)} wheel", loc="left")
    return figure


def heave_figure(heave: HeaveTest) -> Figure:
    """Amplitudes of body and wheels over frequency, stepped sine and linear response."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    axes = figure.subplots()
    frequencies = [point.frequency_hz for point in heave.points]
    for series, (what, linear) in enumerate(heave.linear_amplitudes.items()):
        amplitudes = [1e3 * point.amplitudes.get(what, float("nan")) for point in heave.points]
        plots.plot_stepped_sine(axes, frequencies, amplitudes, what, series)
        plots.plot_linear_response(axes, heave.linear_frequencies_hz, 1e3 * linear, f"{what}, linear", series)
    step = min(np.diff(frequencies), default=0.0)
    plots.mark_frequencies(axes, heave.without_contact_hz, step, "contact would be lost")
    axes.set_xlim(0, frequencies[-1] + step)
    axes.set_ylim(bottom=0)
    axes.set_ylabel(f"displacement amplitude (mm)\nwith pads at {1e3 * AMPLITUDE_M:g} mm")
    axes.legend(frameon=False, ncols=2)
    return figure


def waveform_figure(record: TestRecord) -> Figure:
    """One period of what the thesis measures in a test."""
    names = record.test.metrics
    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    panels = figure.subplots(len(names), 1, sharex=True)
    for axes, name in zip(panels, names, strict=True):
        plots.plot_waveform(
            axes, record.time_s, record.waveforms[name], words(name), record.metrics[name].unit
        )
        axes.label_outer()
    figure.align_ylabels(panels)
    return figure


def sensitivity_figure(results: StudyResults) -> Figure:
    """Changes of every metric in both tests by each group of parameters."""
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    grid = figure.subplots(len(results.tests), 3, sharey=True)
    found = {(s.outcome.test, s.group, s.factor): s.outcome.changes for s in results.sensitivity}
    groups = [
        group.replace(" stiffness and", " stiffness\nand").replace("patch s", "patch\ns") for group in GROUPS
    ]
    for row, (test, record) in zip(grid, results.tests.items(), strict=True):
        for axes, metric in zip(row, record.test.metrics, strict=True):
            changes = {
                _percent(factor - 1): [_value(found[test, group, factor], metric) for group in GROUPS]
                for factor in FACTORS
            }
            plots.plot_changes(axes, groups, changes, record.metrics[metric].unit)
            axes.set_title(f"{test}: {words(metric)}", loc="left")
            axes.label_outer(remove_inner_ticks=True)
            axes.xaxis.set_tick_params(labelbottom=True)
    figure.legend(*grid[0, 0].get_legend_handles_labels(), frameon=False, loc="outside upper right", ncols=2)
    return figure


def _percent(part: float) -> str:
    return f"{100 * part:+.0f} %".replace("-", "−")


def _value(metrics: Mapping[str, object], name: str) -> float:
    metric = metrics.get(name)
    return float(getattr(metric, "value", "nan"))


def sweep_figure(results: StudyResults, tests: Sequence[str]) -> Figure:
    """Every metric over body stiffness at the front, the rear and both; tests side by side."""
    rows = max(len(results.tests[test].test.metrics) for test in tests)
    figure = Figure(
        figsize=(9.0 + 2.0 * (len(tests) - 1), 7.6 - 1.4 * (len(tests) - 1)), layout="constrained"
    )
    grid = figure.subplots(rows, len(tests), sharex=True, squeeze=False)
    for panels, test in zip(grid.T, tests, strict=True):
        for axes, metric in zip(panels, results.tests[test].test.metrics, strict=True):
            _draw_sweep(axes, results, test, metric)
        panels[0].set_title(f"{test} test", loc="left")
        panels[-1].set_xlabel("body torsional stiffness (N m/rad)")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), frameon=False, ncols=4, loc="outside upper right")
    figure.align_ylabels(grid)
    return figure


def _draw_sweep(axes: Axes, results: StudyResults, test: str, metric: str) -> None:
    curves, nominal = sweep_curves(results.sweep), results.tests[test].metrics[metric]
    for series, place in enumerate(PLACES):
        points = curves.get((test, place), [])
        values = [_value(point.outcome.metrics, metric) for point in points]
        label = "front and rear" if place == "both" else place
        plots.plot_sweep(axes, [point.stiffness for point in points], values, label, series)
    stiffnesses = {float(results.parameters.flat()[name]) for name in PLACES["both"]}
    plots.mark_nominal(axes, sorted(stiffnesses), nominal.value)
    axes.set_ylabel(f"{words(metric)}\npeak to peak ({readable_unit(nominal.unit)})")


def _embedded(figure: Figure) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(_saved(figure, "svg")).decode("ascii")


def _saved(figure: Figure, form: str, dpi: float = 100.0) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format=form, dpi=dpi, metadata={UNDATED[form]: None})
    return buffer.getvalue()
