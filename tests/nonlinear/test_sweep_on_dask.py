"""A sweep on a Dask cluster of two workers on this machine, of which one is killed on the way."""

import json
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic
from chassym.nonlinear.sweep.sampling import grid
from chassym.nonlinear.sweep.sweep import Sweep, run_sweep
from chassym.nonlinear.sweep.workers import in_this_process, on_dask, usual_workers

pytest.importorskip("distributed")
pytestmark = pytest.mark.slow

COUNT, NEIGHBOURS, PATIENCE_S = 120, 4, 60.0
FREQUENCIES = np.linspace(1.0, 5.0, COUNT)


class Cluster:
    """A scheduler and two workers, each a process."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0")
        file = folder / "scheduler.json"
        _wait_until(lambda: file.exists() and bool(file.read_text()))
        self.address: str = json.loads(file.read_text())["address"]
        self.workers = [self._start("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]

    def _start(self, *words: str) -> subprocess.Popen:
        program = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
        program += ["--scheduler-file", str(self._folder / "scheduler.json")]
        log = (self._folder / "log").open("a")
        return subprocess.Popen(program, stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self._folder)

    def stop(self) -> None:
        for process in (*self.workers, self._scheduler):
            process.kill()
            process.wait()


def _wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    from distributed import Client

    running = Cluster(tmp_path)
    try:
        with Client(running.address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=PATIENCE_S)
        yield running
    finally:
        running.stop()


def _logging_sweep(car: Model, log: Path | None) -> Sweep:
    """A sweep whose points note that they are computed, and by whom; the caller's own calls do not count."""
    here = os.getpid()

    def noted(frequency_hz: float = 1.0) -> Harmonic:
        if log is not None and os.getpid() != here:
            with log.open("a") as file:
                file.write(f"{frequency_hz!r} {os.getpid()}\n")
            time.sleep(0.03)
        return Harmonic(frequency_hz, {"road": 0.01})

    return Sweep(car, noted, grid(car, {"frequency_hz": FREQUENCIES}), neighbours=NEIGHBOURS)


@pytest.mark.parametrize("victim", [0, 1])
def test_a_killed_worker_loses_only_what_was_in_flight(
    quarter_car: Model, cluster: Cluster, tmp_path: Path, victim: int
) -> None:
    log = tmp_path / "computed"

    def kill_midway(state) -> None:
        if 40 <= state.finished < 40 + NEIGHBOURS:
            cluster.workers[victim].kill()

    sweep = _logging_sweep(quarter_car, log)
    found = run_sweep(
        sweep, store=tmp_path / "points", workers=on_dask(cluster.address), progress=kill_midway
    )
    assert cluster.workers[victim].wait() != 0 and cluster.workers[1 - victim].poll() is None
    lines = [line.split() for line in log.read_text().splitlines()]
    times = Counter(frequency for frequency, _ in lines)
    assert len(times) == COUNT and {process for _, process in lines} <= {str(w.pid) for w in cluster.workers}
    # One call of the dead worker was under way, and one may have been finished and not fetched.
    assert sum(times.values()) <= COUNT + 2 * NEIGHBOURS and max(times.values()) <= 2
    assert not found["reason"].values.any()
    assert found.identical(run_sweep(_logging_sweep(quarter_car, None), workers=in_this_process))


def test_the_environment_names_the_cluster(
    quarter_car: Model, cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "computed"
    monkeypatch.setenv("DASK_SCHEDULER_ADDRESS", cluster.address)
    run_sweep(_logging_sweep(quarter_car, log), workers=usual_workers())
    processes = {line.split()[1] for line in log.read_text().splitlines()}
    assert processes == {str(worker.pid) for worker in cluster.workers}
