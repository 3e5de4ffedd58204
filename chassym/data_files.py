"""The numbers of a study as tables for CSV files: one header row with units, SI unless it says otherwise."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from chassym.nonlinear import Metric
from chassym.rig_tests import TESTS, Outcome, TestRecord
from chassym.study_results import StudyResults

Row = Sequence[object]
NOT_SOLVED = Metric(float("nan"), "", float("nan"))


def data_files(results: StudyResults) -> dict[str, str]:
    """Contents of every CSV file by its name."""
    return {name: _text(table(results)) for name, table in TABLES.items()}


def modes(results: StudyResults) -> Iterator[Row]:
    """Damped modes, lowest first, with the shares of kinetic energy."""
    groups = list(dict.fromkeys(group for mode in results.modes for group in mode.energy))
    shares = [f"energy share of {group} (1)" for group in groups]
    yield (
        "mode",
        "frequency (Hz)",
        "damping ratio (1)",
        "eigenvalue real (1/s)",
        "eigenvalue imaginary (rad/s)",
        *shares,
    )
    for mode in results.modes:
        eigenvalue = complex(mode.eigenvalue)
        numbers = mode.frequency_hz, mode.damping_ratio, eigenvalue.real, eigenvalue.imag
        yield mode.name, *numbers, *(mode.energy[group] for group in groups)


def wheel_rate(results: StudyResults) -> Iterator[Row]:
    """Cycles of the kinematics and compliance test."""
    yield "loading", "wheel", "wheel travel (m)", "vertical patch force (N)"
    for loading, rates in results.wheel_rates.items():
        for rate in rates.values():
            for travel, force in zip(rate.travel, rate.force, strict=True):
                yield loading, rate.wheel, travel, force


def heave(results: StudyResults) -> Iterator[Row]:
    """Amplitudes over frequency: the stepped sine of the nonlinear car, then the linear response."""
    test = results.heave
    names = list(test.linear_amplitudes)
    columns = (f"{name} displacement amplitude (m)" for name in names)
    yield "model", "frequency (Hz)", *columns, "minimum patch force (N)", "reason of failure"
    for point in test.points:
        amplitudes = (point.amplitudes.get(name, float("nan")) for name in names)
        yield "nonlinear", point.frequency_hz, *amplitudes, point.minimum_patch_force, point.reason
    for index, frequency in enumerate(test.linear_frequencies_hz):
        yield "linear", frequency, *(test.linear_amplitudes[name][index] for name in names), float("nan"), ""


def waveforms(test: str) -> Callable[[StudyResults], Iterator[Row]]:
    """One period of every measured signal of a test."""

    def table(results: StudyResults) -> Iterator[Row]:
        record = results.tests[test]
        yield "time (s)", *(f"{name} ({record.metrics[name].unit})" for name in record.waveforms)
        yield from np.column_stack([record.time_s, *record.waveforms.values()]).tolist()

    return table


def metrics(results: StudyResults) -> Iterator[Row]:
    """What was measured in both nominal tests."""
    yield "test", "quantity", "unit", "value", "error estimate"
    for name, record in results.tests.items():
        for metric, value in record.metrics.items():
            yield name, f"{metric} peak to peak", value.unit, value.value, value.error
        patch = f"minimum vertical patch force ({record.contact.patch})"
        yield name, patch, "N", record.contact.value, record.contact.error
        yield name, "largest Floquet multiplier", "1", record.largest_multiplier, float("nan")
        yield name, "unknowns", "1", record.unknowns, 0


def sensitivity(results: StudyResults) -> Iterator[Row]:
    """What 25 % less or more of a group of parameters does."""
    yield "test", "group", "factor (1)", *_CHANGE_COLUMNS
    for each in results.sensitivity:
        for row in _changes(each.outcome, results.tests):
            yield each.outcome.test, each.group, each.factor, *row


def readings(results: StudyResults) -> Iterator[Row]:
    """What each alternative reading does."""
    yield "test", "reading", *_CHANGE_COLUMNS
    for each in results.rereadings:
        for row in _changes(each.outcome, results.tests):
            yield each.outcome.test, each.reading, *row


def stiffness_sweeps(results: StudyResults) -> Iterator[Row]:
    """The body stiffness sweeps, with the points at half the nominal stiffness after them."""
    yield "test", "place", "stiffness (N m/rad)", *_CHANGE_COLUMNS
    for each in (*results.sweep, *results.halved):
        for row in _changes(each.outcome, results.tests):
            yield each.outcome.test, each.placement, each.stiffness, *row


def thesis(results: StudyResults) -> Iterator[Row]:
    """Every statement of the thesis beside what was computed."""
    yield (
        "topic",
        "quantity",
        "unit",
        "thesis",
        "thesis low",
        "thesis high",
        "computed",
        "error estimate",
        "deviation (%)",
        "verdict",
        "source",
    )
    for each in results.comparisons:
        stated = each.published, each.low, each.high
        found = each.computed, each.error, 100 * each.deviation
        yield each.topic, each.quantity, each.unit, *stated, *found, each.verdict, each.source


TABLES: Mapping[str, Callable[[StudyResults], Iterator[Row]]] = {
    "modes.csv": modes,
    "wheel_rate.csv": wheel_rate,
    "heave.csv": heave,
    **{f"{test}_waveforms.csv": waveforms(test) for test in TESTS},
    "metrics.csv": metrics,
    "sensitivity.csv": sensitivity,
    "stiffness_sweeps.csv": stiffness_sweeps,
    "readings.csv": readings,
    "thesis.csv": thesis,
}
"""The files of a report and what fills them."""

_CHANGE_COLUMNS = (
    "metric",
    "unit",
    "value",
    "error estimate",
    "change from nominal",
    "error estimate of the change",
    "minimum patch force (N)",
    "largest Floquet multiplier (1)",
    "reason of failure",
)


def _changes(outcome: Outcome, tests: Mapping[str, TestRecord]) -> Iterator[Row]:
    """A row for every metric of a variant, also where it was not solved."""
    record = tests[outcome.test]
    for name in record.test.metrics:
        value, changed = outcome.metrics.get(name, NOT_SOLVED), outcome.changes.get(name, NOT_SOLVED)
        found = value.value, value.error, changed.value, changed.error
        yield (
            name,
            record.metrics[name].unit,
            *found,
            outcome.minimum_patch_force,
            outcome.largest_multiplier,
            outcome.reason,
        )


def _text(rows: Iterator[Row]) -> str:
    """Rows as CSV; numbers with all their digits."""
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows([[_plain(cell) for cell in row] for row in rows])
    return buffer.getvalue()


def _plain(cell: object) -> object:
    """A number of numpy as one of Python, which CSV writes with all its digits."""
    return cell.item() if isinstance(cell, np.generic) else cell
