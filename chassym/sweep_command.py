"""What `chassym sweep` does: checks what is asked for, computes it with progress, and writes it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from chassym import arguments
from chassym.arguments import ArgumentError
from chassym.requested_test import find_metrics, find_test

if TYPE_CHECKING:
    from chassym.derivation import Model
    from chassym.nonlinear.rig import RigTest
    from chassym.nonlinear.sweep.sampling import Points
    from chassym.nonlinear.sweep.sweep import Progress, SweepProgress
    from chassym.nonlinear.sweep.workers import Workers

STORE = ".points"
"""What the name of a store adds to that of the results."""


@dataclass(frozen=True)
class SweepRequest:
    """The words of the command, as they were typed."""

    test: str
    varied: Sequence[str]
    change: str | None
    hypercube: str | None
    ranges: Sequence[str]
    output: str
    metrics: Sequence[str] | None
    tolerance: str | None
    tyres: str | None
    jobs: str | None
    dask: str | None


def run_requested(asked: SweepRequest, load: Callable[[], Model]) -> None:
    """Run the sweep, print its summary and write its results.

    Parameters
    ----------
    load
        Loads the vehicle; called after what can be refused without it.

    Raises
    ------
    ArgumentError, ParameterError, SamplingError, StoreError, WorkersError
        If something cannot be accepted, or the work cannot be done.
    """
    file = _new_results(asked.output)
    jobs = None if asked.jobs is None else _at_least_one(asked.jobs)
    test = find_test(asked.test, tolerance=asked.tolerance, tyres=asked.tyres)
    if asked.dask is not None and jobs is not None:
        raise ArgumentError("--jobs", f"{jobs} beside --dask", "one of them")
    from chassym.nonlinear.sweep.sweep import Sweep, run_sweep
    from chassym.nonlinear.sweep.sweep_results import write_results
    from chassym.requested_sweep import find_points, print_sweep
    from chassym.tables import print_paragraph

    workers = _workers(jobs, asked.dask)
    model = test.mounted(load())
    points = find_points(model, asked.varied, asked.change, asked.hypercube, asked.ranges)
    _check_frequency(test, points)
    usual = find_metrics(model, test, "ground")
    chosen = tuple(usual) if asked.metrics is None else _outputs(model, asked.metrics)
    sweep = Sweep(model, test, points, metrics=chosen, tolerance=test.tolerance)
    store = file.with_name(f"{file.name}{STORE}")
    try:
        with _shown_progress() as progress:
            results = run_sweep(sweep, store=store, workers=workers, progress=progress)
    except KeyboardInterrupt:
        typer.echo(f"{store}: finished points are kept; the same command goes on from there", err=True)
        raise
    write_results(results, file)
    print_sweep(sweep, results)
    print_paragraph(f"{file}: results; {store}: finished points, no longer needed", indent="  ")


def _new_results(output: str) -> Path:
    """A netCDF file, or a folder for Zarr, which may be there already."""
    from chassym.nonlinear.sweep.sweep_results import SUFFIXES, refuse_unwritable

    file = Path(output)
    if file.suffix in SUFFIXES:
        refuse_unwritable(file)
    if file.suffix == ".zarr" and file.is_dir():
        arguments.new_folder("--output", output)
        return file
    return arguments.new_file("--output", output, *SUFFIXES)


def _at_least_one(text: str) -> int:
    count = arguments.whole("--jobs", text)
    if count < 1:
        raise ArgumentError("--jobs", repr(text), "1 or more")
    return count


def _workers(jobs: int | None, dask: str | None) -> Workers:
    from chassym.nonlinear.sweep.workers import on_dask, on_processes, usual_workers

    if dask is not None:
        return on_dask(dask)
    return usual_workers() if jobs is None else on_processes(jobs)


def _check_frequency(test: RigTest, points: Points) -> None:
    if test.is_stepped and "frequency_hz" not in points.numbers:
        expected = "a test of one frequency, or --vary frequency_hz=.."
        raise ArgumentError("test", f"{test.name}, which steps its frequency", expected)


def _outputs(model: Model, names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        arguments.choice("--metric", name, model.output_names)
    return tuple(dict.fromkeys(names))


@contextmanager
def _shown_progress() -> Iterator[Progress]:
    """Give what is told how far a sweep is, and draws it with an estimate of the remaining time."""
    from chassym.tables import progress_bar

    with progress_bar() as draw:

        def show(state: SweepProgress) -> None:
            failed = f", {state.failed} failed" if state.failed else ""
            words = f"{state.finished} of {state.count} points{failed}{_left(state.remaining_s)}"
            draw(words, state.finished / state.count)

        yield show


def _left(seconds: float) -> str:
    """How long it will take, in words.

    Examples
    --------
    >>> _left(8.2), _left(3700.0)
    (', 9 s left', ', 1:01:40 left')
    """
    if not math.isfinite(seconds):
        return ""
    whole = math.ceil(seconds)
    hours, minutes = whole // 3600, whole // 60 % 60
    if whole < 60:
        return f", {whole} s left"
    return (
        f", {hours}:{minutes:02}:{whole % 60:02} left" if hours else f", {minutes}:{whole % 60:02} min left"
    )
