"""The report of a study: one self-contained HTML page with its figures, and the data beside it as CSV files.

The picture in the README is one of its figures, written by::

    python -c "from pathlib import Path; from chassym.derivation import load_model; from chassym.report import write_picture; \\
        from chassym.study import run_study; write_picture(run_study(load_model()), Path('docs/report.png'))"
"""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path

import jinja2
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from chassym.comparison import Comparison, words
from chassym.data_files import data_files
from chassym.derivation import Parameter
from chassym.heave import AMPLITUDE_M, HeaveTest
from chassym.linear.plots import plot_modes
from chassym.nonlinear import plots
from chassym.nonlinear.plots import readable_unit
from chassym.rig_tests import TestRecord
from chassym.study import StudyResults
from chassym.variants import FACTORS, GROUPS, PLACES, sweep_curves

STYLE: Mapping[str, object] = {
    "font.size": 9.5,
    "axes.labelsize": 9.5,
    "axes.titlesize": 10,
    "svg.fonttype": "path",
    "svg.hashsalt": "chassym",
}
"""Of all figures; with a fixed salt equal studies make equal files."""


def write_report(results: StudyResults, folder: Path) -> Path:
    """Write ``report.html`` and the CSV files into a folder, which is made if it is not there.

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
    files = data_files(results)
    page = render(results, list(files))
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        _replace(folder / name, text.encode("utf-8"))
    _replace(folder / "report.html", page.encode("utf-8"))
    return folder / "report.html"


def write_picture(results: StudyResults, path: Path) -> None:
    """Write the figure of the body stiffness sweep in the lateral test as a PNG file."""
    with rc_context(dict(STYLE)):
        buffer = io.BytesIO()
        sweep_figure(results, "lateral").savefig(buffer, format="png", dpi=110)
    _replace(path, buffer.getvalue())


def render(results: StudyResults, files: list[str]) -> str:
    """The page; `files` are the names of the data files to mention."""
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {
        "number": number,
        "with_error": with_error,
        "unit": readable_unit,
        "words": words,
        "value": parameter_value,
        "stamp": lambda moment: moment.strftime("%Y-%m-%d %H:%M UTC"),
    }
    template = resources.files("chassym").joinpath("templates/report.html").read_text(encoding="utf-8")
    topics = _by_topic(results)
    return environment.from_string(template).render(
        results=results, figures=figures(results), topics=topics, files=files, groups=GROUPS, places=PLACES, factors=FACTORS
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
        draw[f"{name}_sweep"] = lambda name=name: sweep_figure(results, name)  # type: ignore[misc]
    with rc_context(dict(STYLE)):
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
        plots.plot_waveform(axes, record.time_s, record.waveforms[name], words(name), record.metrics[name].unit)
        axes.label_outer()
    figure.align_ylabels(panels)
    return figure


def sensitivity_figure(results: StudyResults) -> Figure:
    """Changes of every metric in both tests by each group of parameters."""
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    grid = figure.subplots(len(results.tests), 3, sharey=True)
    found = {(s.outcome.test, s.group, s.factor): s.outcome.changes for s in results.sensitivity}
    groups = [group.replace(" stiffness and", " stiffness\nand").replace("patch s", "patch\ns") for group in GROUPS]
    for row, (test, record) in zip(grid, results.tests.items(), strict=True):
        for axes, metric in zip(row, record.test.metrics, strict=True):
            changes = {
                _percent(factor - 1): [_value(found[test, group, factor], metric) for group in GROUPS] for factor in FACTORS
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


def sweep_figure(results: StudyResults, test: str) -> Figure:
    """Every metric of a test over body stiffness at the front, the rear and both."""
    record, curves = results.tests[test], sweep_curves(results.sweep)
    figure = Figure(figsize=(9.0, 7.6), layout="constrained")
    panels = figure.subplots(len(record.test.metrics), 1, sharex=True)
    nominal = float(results.parameters.flat()[PLACES["front"][0]])
    for axes, metric in zip(panels, record.test.metrics, strict=True):
        for series, place in enumerate(PLACES):
            points = curves.get((test, place), [])
            values = [_value(point.outcome.metrics, metric) for point in points]
            label = "front and rear" if place == "both" else place
            plots.plot_sweep(axes, [point.stiffness for point in points], values, label, series)
        plots.mark_nominal(axes, nominal, record.metrics[metric].value)
        axes.set_ylabel(f"{words(metric)}\npeak to peak ({readable_unit(record.metrics[metric].unit)})")
    panels[-1].set_xlabel("body torsional stiffness (N m/rad)")
    panels[0].legend(frameon=False, ncols=4, loc="lower left", bbox_to_anchor=(0, 1))
    figure.align_ylabels(panels)
    return figure


def _embedded(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def number(value: float, digits: int = 5) -> str:
    """A number with so many significant digits, and a minus sign as it is printed.

    Examples
    --------
    >>> number(-0.123456)
    '−0.12346'
    """
    if not np.isfinite(value):
        return "–" if np.isnan(value) else "∞"
    return f"{value:.{digits}g}".replace("-", "−")


def with_error(value: float, error: float) -> str:
    """A value and its error in as many digits as the error allows, six at most.

    Examples
    --------
    >>> with_error(5.718281, 0.00005), with_error(0.75, 0.0)
    ('5.71828 ± 0.00005', '0.75')
    """
    if not np.isfinite(value) or not error > 0:
        return number(value)
    leading = np.floor(np.log10(abs(value))) if value else 0.0
    decimals = int(min(-np.floor(np.log10(error)), 5 - leading))
    return f"{value:.{max(decimals, 0)}f} ± {error:.1g}".replace("-", "−")


def parameter_value(parameter: Parameter) -> str:
    """A parameter's value in SI.

    Examples
    --------
    >>> parameter_value(Parameter("k", (1.0, 2.5), "N/m", "rate", "measured"))
    '[1, 2.5]'
    """
    if isinstance(parameter.value, tuple):
        return "[" + ", ".join(number(each, 8) for each in parameter.value) + "]"
    return number(parameter.value, 8)


def _replace(target: Path, data: bytes) -> None:
    """Write a file under another name in the same folder, then put it in place at once."""
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
