"""How fast sweeps are: many random variants of the reference car beside a single one, in one run.

The number of variants is that of the environment variable CHASSYM_SWEEP_POINTS, 10,000 by default.
"""

import multiprocessing
import os
import resource
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import joblib
import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import rig
from chassym.nonlinear.sweep.sampling import random_sample
from chassym.nonlinear.sweep.sweep import Sweep, run_sweep
from chassym.nonlinear.sweep.workers import on_processes
from chassym.rig_tests import TESTS
from chassym.thesis_grid import thesis_grid

pytestmark = pytest.mark.benchmark

COUNT = int(os.environ.get("CHASSYM_SWEEP_POINTS", "10000"))
VARIED = (
    "tyre.front.stiffness",
    "tyre.rear.stiffness",
    "tyre.front.damping",
    "tyre.rear.damping",
    "suspension.front.damper.force",
    "suspension.rear.damper.force",
    "suspension.front.spring",
    "suspension.rear.spring",
    "suspension.front.anti_roll_bar",
    "suspension.rear.anti_roll_bar",
    "body.front.mass",
    "body.rear.mass",
    "body.front.torsional_stiffness",
    "body.rear.torsional_stiffness",
)
RANGE = 0.85, 1.15


@pytest.fixture
def say(capsys: pytest.CaptureFixture[str]) -> Callable[[str], None]:
    def write(words: str) -> None:
        with capsys.disabled():
            print(f"\n  {words}")

    return write


def _random_variants(model: Model, count: int) -> Sweep:
    nominal = model.parameters.flat()
    ranges = {name: (RANGE[0] * nominal.get(name, 1.0), RANGE[1] * nominal.get(name, 1.0)) for name in VARIED}
    points = random_sample(model, count, ranges)
    return Sweep(model, rig.lateral, points, metrics=TESTS["lateral"].metrics)


def _resident_mb(process: int) -> float:
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_many_random_variants(sedan: Model, say: Callable[[str], None], tmp_path: Path) -> None:
    """Throughput beside what the cores do one point at a time, and memory that stays.

    Single points are computed on as many processes at once, before and after: cores that share their caches
    and their power, and machines that others use, are then the same for both.
    """
    sweep, cores = _random_variants(sedan, COUNT), joblib.cpu_count()
    on_cores, tenth = on_processes(cores), max(COUNT // 10, 1)
    first = range(min(cores * 4, COUNT))
    [*on_cores(sweep.evaluate, [[number] for number in first])]  # processes are there and warm
    workers = [child.pid for child in multiprocessing.active_children()] or _children()
    memory: list[list[float]] = []

    def watch(state) -> None:
        if state.finished and state.finished % tenth < sweep.neighbours:
            memory.append([_resident_mb(process) for process in (os.getpid(), *workers)])

    single = [_single_point_s(sweep, cores)]
    start = time.perf_counter()
    found = run_sweep(sweep, store=tmp_path / "points", workers=on_cores, progress=watch)
    taken = time.perf_counter() - start
    single.append(_single_point_s(sweep, cores))
    failed = int((found["reason"] != "").sum())
    ratio = COUNT / taken / (cores / statistics.mean(single))
    grown = np.array(memory[-1]) - np.array(memory[len(memory) // 5])
    say(
        f"{COUNT} random variants on {cores} processes: {taken:.1f} s, {COUNT / taken:.0f} a second, "
        f"{failed} failed; one by itself {1e3 * statistics.mean(single):.1f} ms: "
        f"{ratio:.2f} of single points times cores"
    )
    say(
        f"resident memory, parent and workers: {', '.join(f'{each:.0f}' for each in memory[-1])} MB, "
        f"{', '.join(f'{each:+.1f}' for each in grown)} MB over the last four fifths"
    )
    assert failed <= 0.01 * COUNT
    assert ratio > 0.5  # what others do on the machine meanwhile moves it by a third
    assert grown.max() < 0.05 * max(memory[-1])


def _children() -> list[int]:
    """Processes that loky started."""
    tasks = Path(f"/proc/{os.getpid()}/task").iterdir()
    found = [int(child) for task in tasks for child in (task / "children").read_text().split()]
    return [child for child in found if b"LokyProcess" in Path(f"/proc/{child}/cmdline").read_bytes()]


def _single_point_s(sweep: Sweep, cores: int) -> float:
    """Mean time of one variant by itself, all cores being at it."""

    def timed(number: int) -> float:
        start = time.perf_counter()
        sweep.evaluate([number])
        return time.perf_counter() - start

    numbers = range(min(40 * cores, len(sweep.points)))
    return statistics.fmean(on_processes(cores)(timed, numbers))


def test_the_thesis_grid(sedan: Model, say: Callable[[str], None]) -> None:
    """Two tests, three stiffness sweeps of 29 values each, every group of parameters 25 % less and more."""
    grid = thesis_grid(sedan)
    count = sum(len(sweep.points) for sweep in grid.values())
    start = time.perf_counter()
    results = {name: run_sweep(sweep, workers=on_processes()) for name, sweep in grid.items()}
    taken = time.perf_counter() - start
    failed = [reason for found in results.values() for reason in found["reason"].values if reason]
    say(
        f"the thesis grid, {count} points on {joblib.cpu_count()} processes: {taken:.1f} s, "
        f"{len(failed)} failed"
    )
    assert len(failed) < 0.1 * count
