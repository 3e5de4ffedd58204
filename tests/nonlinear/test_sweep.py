"""Sweeps: every point is the steady state by itself, however it was computed, stopped and gone on with."""

import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

from chassym.derivation import CompiledEquations, Model
from chassym.nonlinear import Harmonic, rig, steady_state
from chassym.nonlinear.rig import load_rig_test
from chassym.nonlinear.sweep import sweep as sweep_module
from chassym.nonlinear.sweep.sampling import Points, SamplingError, grid, joined, table
from chassym.nonlinear.sweep.store import Row, Store, StoreError
from chassym.nonlinear.sweep.sweep import Sweep, SweepProgress, run_sweep
from chassym.nonlinear.sweep.sweep_results import ResultFileError, write_results
from chassym.nonlinear.sweep.workers import WorkersError, in_this_process, on_dask, on_processes

BUMP = Harmonic(1.5, {"road": 0.01})
FREQUENCIES = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0]
MASSES = [350.0, 400.0]


@pytest.fixture(scope="module")
def sweep(quarter_car: Model) -> Sweep:
    metrics = [o.name for o in quarter_car.system.outputs if o.unit == "m/s^2"]
    points = grid(quarter_car, {"sprung.mass": MASSES, "frequency_hz": FREQUENCIES})
    return Sweep(quarter_car, BUMP, points, metrics=metrics, neighbours=3)


@pytest.fixture(scope="module")
def uninterrupted(sweep: Sweep) -> xarray.Dataset:
    return run_sweep(sweep, workers=in_this_process)


def stopping_after(count: int):
    """Workers that are interrupted after some results."""

    def workers(function, arguments) -> Generator:
        for place, argument in enumerate(arguments):
            if place == count:
                raise KeyboardInterrupt
            yield function(argument)

    return workers


def backwards(function, arguments) -> Generator:
    yield from map(function, reversed([*arguments]))


# What a point is


def test_a_sweep_of_one_point_is_the_steady_state(quarter_car: Model) -> None:
    points = grid(quarter_car, {"sprung.mass": [380.0], "frequency_hz": [2.0], "amplitude": [0.5]})
    found = run_sweep(Sweep(quarter_car, BUMP, points, tolerance=1e-4), workers=in_this_process).squeeze()
    variant = quarter_car.with_parameters({"sprung.mass": 380.0})
    alone = steady_state(variant, Harmonic(2.0, {"road": 0.005}), tolerance=1e-4)
    for name, metric in alone.peak_to_peak.items():
        assert (float(found[name]), float(found[f"{name}_error"])) == (metric.value, metric.error)
        assert found[name].attrs["units"] == metric.unit
    assert float(found["largest_multiplier"]) == abs(alone.multipliers[0])
    if alone.contact is not None:
        assert float(found["minimum_patch_force"]) == alone.contact.value
        assert str(found["patch"].values) == alone.contact.patch


def test_every_point_has_its_place_in_the_results(
    sweep: Sweep, quarter_car: Model, uninterrupted: xarray.Dataset
) -> None:
    name = sweep.measured[0]
    for mass in MASSES:
        for frequency in FREQUENCIES:
            variant = quarter_car.with_parameters({"sprung.mass": mass})
            alone = steady_state(variant, Harmonic(frequency, BUMP.amplitudes)).peak_to_peak[name]
            there = uninterrupted.sel({"sprung.mass": mass, "frequency_hz": frequency})
            allowed = alone.error + float(there[f"{name}_error"])
            assert abs(float(there[name]) - alone.value) <= 3 * allowed


def test_entries_of_lists_are_set(sedan: Model) -> None:
    force = "suspension.front.damper.force"
    points = grid(sedan, {f"{force}[0]": [-900.0], f"{force}[4]": [700.0]})
    variant = Sweep(sedan, rig.lateral, points).variant(0)
    nominal = sedan.parameters.value(force)
    assert isinstance(nominal, tuple)
    assert variant.parameters.value(force) == (-900.0, *nominal[1:4], 700.0)


def test_fields_of_a_rig_test_are_set(sedan: Model) -> None:
    points = grid(sedan, {"frequency_hz": [2.0], "amplitude_m": [0.01], "lag_s": [0.1]})
    of_function = Sweep(sedan, rig.lateral, points).excitation_at(0)
    of_data = Sweep(sedan, load_rig_test("lateral"), points).excitation_at(0)
    expected = rig.lateral(frequency_hz=2.0, amplitude_m=0.01, lag_s=0.1)
    np.testing.assert_allclose(of_function.vector(sedan), expected.vector(sedan))
    np.testing.assert_allclose(of_data.vector(sedan), expected.vector(sedan))
    assert of_function.frequency_hz == of_data.frequency_hz == 2.0


def test_points_start_from_the_orbit_before_within_their_neighbours(
    sweep: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts = []

    def watched(*arguments, start, **options):
        starts.append(None if start is None else start.excitation.frequency_hz)
        return steady_state(*arguments, start=start, **options)

    monkeypatch.setattr(sweep_module, "steady_state", watched)
    run_sweep(sweep, workers=in_this_process)
    assert starts == [None, 1.0, 1.5, None, 2.5, 3.0] * 2


def test_points_that_do_not_follow_each_other_start_from_rest(
    quarter_car: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts = []

    def watched(*arguments, start, **options):
        starts.append(start)
        return steady_state(*arguments, start=start, **options)

    monkeypatch.setattr(sweep_module, "steady_state", watched)
    scattered = table(quarter_car, {"frequency_hz": [1.0, 2.0]})
    rows = grid(quarter_car, {"sprung.mass": [350.0, 400.0], "frequency_hz": [1.0]})
    run_sweep(Sweep(quarter_car, BUMP, joined([scattered, rows])), workers=in_this_process)
    assert starts == [None] * 4


def test_what_is_not_found_from_a_neighbour_is_looked_for_from_rest(
    sweep: Sweep, uninterrupted: xarray.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    def only_from_rest(*arguments, start, **options):
        if start is not None:
            raise RuntimeError("too far")
        return steady_state(*arguments, start=None, **options)

    monkeypatch.setattr(sweep_module, "steady_state", only_from_rest)
    found = run_sweep(sweep, workers=in_this_process)
    assert not found["reason"].values.any()
    expected = run_sweep(replace(sweep, neighbours=1), workers=in_this_process)
    np.testing.assert_array_equal(found[sweep.measured[0]], expected[sweep.measured[0]])


# Points that fail


def test_a_failed_point_keeps_its_reason_and_stops_no_other(quarter_car: Model) -> None:
    rows = {"sprung.mass": [350.0, -1.0, 350.0, 350.0], "frequency_hz": [2.0, 2.0, -3.0, 2.0]}
    found = run_sweep(Sweep(quarter_car, BUMP, table(quarter_car, rows)), workers=in_this_process)
    reasons = found["reason"].values
    assert reasons[0] == reasons[3] == ""
    assert "sprung.mass" in reasons[1] and "-1.0" in reasons[1] and "frequency" in reasons[2]
    name = next(iter(found.data_vars))
    np.testing.assert_array_equal(np.isnan(found[name]), [False, True, True, False])


def test_an_unforeseen_failure_is_a_reason_too(sweep: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments, **options):
        raise ZeroDivisionError("by\nnothing")

    monkeypatch.setattr(sweep_module, "steady_state", broken)
    found = run_sweep(sweep, workers=in_this_process)
    assert set(found["reason"].values.ravel()) == {"ZeroDivisionError: by nothing"}


# The store


def test_the_order_of_computing_does_not_matter(
    sweep: Sweep, uninterrupted: xarray.Dataset, tmp_path: Path
) -> None:
    found = run_sweep(sweep, store=tmp_path / "points", workers=backwards)
    assert found.identical(uninterrupted)


@pytest.mark.parametrize("done", [0, 1, 3, 4])
def test_a_resumed_sweep_is_the_uninterrupted_one(
    sweep: Sweep, uninterrupted: xarray.Dataset, tmp_path: Path, done: int
) -> None:
    store = tmp_path / "points"
    if done < 4:
        with pytest.raises(KeyboardInterrupt):
            run_sweep(sweep, store=store, workers=stopping_after(done))
    else:
        run_sweep(sweep, store=store, workers=in_this_process)
    computed: list[int] = []

    def counting(function, arguments: Sequence[Sequence[int]]) -> Generator:
        for numbers in arguments:
            computed.extend(numbers)
            yield function(numbers)

    found = run_sweep(sweep, store=store, workers=counting)
    assert computed == [*range(3 * done, len(sweep.points))]
    assert found.identical(uninterrupted)


def test_identity_is_the_same_in_another_process_and_for_an_equal_sweep(sweep: Sweep) -> None:
    ((theirs,),) = on_processes(2)(lambda _: [dict(sweep.identity)], [0])
    assert theirs == sweep.identity
    assert Sweep(sweep.model, BUMP, sweep.points, sweep.metrics, neighbours=3).identity == sweep.identity


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda s: replace(s, model=s.model.with_parameters({"tyre.stiffness": 2e5})), "another model"),
        (lambda s: replace(s, excitation=s.excitation.scaled(1.01)), "another excitation"),
        (lambda s: replace(s, tolerance=1e-5), "choice of metrics or accuracy"),
        (lambda s: replace(s, points=_moved(s.points)), "another table of points"),
    ],
)
def test_the_store_of_another_sweep_is_refused_in_one_line(
    sweep: Sweep, tmp_path: Path, change, named: str
) -> None:
    store = tmp_path / "points"
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, store=store, workers=stopping_after(1))
    with pytest.raises(StoreError) as refusal:
        run_sweep(change(sweep), store=store, workers=in_this_process)
    message = str(refusal.value)
    assert named in message and "points" in message and "\n" not in message
    assert (" and another " in message) == (named == "another table of points")  # it sets the frequency


def _moved(points: Points) -> Points:
    numbers = {name: column.copy() for name, column in points.numbers.items()}
    numbers["frequency_hz"][-1] += 1e-9
    return replace(points, numbers=numbers)


@pytest.mark.parametrize("content", [b"not a database, but long enough to be taken for one" * 40, "sqlite"])
def test_a_file_that_is_no_store_is_refused_and_left_alone(sweep: Sweep, tmp_path: Path, content) -> None:
    file = tmp_path / "points"
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        with sqlite3.connect(file) as other:
            other.execute("CREATE TABLE mine (a)")
        other.close()
    before = file.read_bytes()
    with pytest.raises(StoreError, match="choose another name"):
        run_sweep(sweep, store=file)
    assert file.read_bytes() == before


def test_two_runs_do_not_share_a_store(sweep: Sweep, tmp_path: Path) -> None:
    with Store(tmp_path / "points", sweep.identity), pytest.raises(StoreError, match="another run"):
        run_sweep(sweep, store=tmp_path / "points")


def test_a_store_that_cannot_be_made_is_refused(sweep: Sweep, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="a file in a folder"):
        run_sweep(sweep, store=tmp_path / "nowhere" / "points")


def test_numbers_come_back_from_the_store_bit_by_bit(tmp_path: Path) -> None:
    numbers = (np.pi, -0.0, np.inf, 5e-324, 1.7976931348623157e308)
    rows = [Row(2, numbers, "front_left", ""), Row(0, (np.nan,) * 5, "", "why not – é")]
    with Store(tmp_path / "s", {}) as store:
        store.add(rows)
    with Store(tmp_path / "s", {}) as store:
        found = [*store.rows()]
    assert [row.number for row in found] == [0, 2]
    assert found[0].reason == "why not – é" and np.isnan(found[0].numbers).all()
    assert np.array(found[1].numbers).tobytes() == np.array(numbers).tobytes()


# Progress


def test_progress_counts_from_what_is_there_to_the_end(sweep: Sweep, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, store=tmp_path / "s", workers=stopping_after(1))
    told: list[SweepProgress] = []
    run_sweep(sweep, store=tmp_path / "s", workers=in_this_process, progress=told.append)
    assert [state.finished for state in told] == [3, 6, 9, 12]
    assert {state.count for state in told} == {12} and {state.failed for state in told} == {0}
    assert told[0].remaining_s == np.inf and told[-1].remaining_s == 0
    assert all(state.remaining_s > 0 for state in told[1:-1])


# Workers


def test_processes_give_the_same_numbers(sweep: Sweep, uninterrupted: xarray.Dataset) -> None:
    assert run_sweep(sweep, workers=on_processes(2)).identical(uninterrupted)


def test_the_machine_code_travels_along(quarter_car: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    import cloudpickle

    fresh = replace(quarter_car, compiled=CompiledEquations(quarter_car.system))
    there = cloudpickle.loads(cloudpickle.dumps(Sweep(fresh, BUMP, grid(fresh, {"frequency_hz": [1.0]}))))

    def compile_again(*_):
        raise AssertionError("a worker would have compiled")

    monkeypatch.setattr(CompiledEquations, "_function", compile_again)
    (row,) = there.evaluate([0])
    assert row.reason == ""


class Travelling:
    """A function that notes where it is unpacked."""

    def __init__(self, log: Path) -> None:
        self.log = log

    def __setstate__(self, state) -> None:
        vars(self).update(state)
        with self.log.open("a") as file:
            file.write(f"{os.getpid()}\n")

    def __call__(self, number: int) -> int:
        time.sleep(0.01)
        return number


def by_value(kind):
    """Take a class of this module along instead of its name, which workers cannot import."""
    import cloudpickle

    module = sys.modules[kind.__module__]
    cloudpickle.register_pickle_by_value(module)
    return module


def test_a_function_travels_to_every_process_once(tmp_path: Path) -> None:
    import cloudpickle

    module = by_value(Travelling)
    try:
        found = sorted(on_processes(2)(Travelling(tmp_path / "log"), range(40)))
    finally:
        cloudpickle.unregister_pickle_by_value(module)
    assert found == [*range(40)]
    unpacked = Counter((tmp_path / "log").read_text().split())
    assert len(unpacked) <= 2 and set(unpacked.values()) == {1}


def test_what_a_dead_process_had_not_finished_is_done_again(tmp_path: Path) -> None:
    marker = str(tmp_path / "died")

    def dying_once(number: int) -> int:
        if number == 3 and not os.path.exists(marker):
            open(marker, "w").close()
            os._exit(1)
        return number

    assert sorted(on_processes(2)(dying_once, range(8))) == [*range(8)]


def test_processes_that_keep_dying_are_given_up() -> None:
    def dying(number: int) -> int:
        os._exit(1)

    with pytest.raises(WorkersError, match="died 3 times"):
        [*on_processes(2)(dying, range(4))]


@pytest.mark.parametrize("address", [None, "tcp://127.0.0.1:9"])
def test_a_cluster_that_is_not_there_is_refused_in_one_line(
    address: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.delenv("DASK_SCHEDULER_ADDRESS", raising=False)
    monkeypatch.setattr("chassym.nonlinear.sweep.workers.PATIENCE_S", 1)
    with pytest.raises(WorkersError) as refusal:
        [*on_dask(address)(abs, [1])]
    assert "scheduler" in str(refusal.value) and "\n" not in str(refusal.value)


# A process that is killed or interrupted

PROGRAM = """
import os, sys, time
from chassym.derivation import load_model
from chassym.nonlinear import Harmonic
from chassym.nonlinear.sweep.sampling import grid
from chassym.nonlinear.sweep.sweep import Sweep, run_sweep
from chassym.nonlinear.sweep.sweep_results import write_results
from chassym.nonlinear.sweep.workers import on_processes

folder = sys.argv[1]
log, parent = os.path.join(folder, "log"), os.getpid()

def logged(frequency_hz=1.0):
    if os.getpid() != parent:
        with open(log, "a") as file:
            file.write(f"{frequency_hz!r}\\n")
        time.sleep(0.05)
    return Harmonic(frequency_hz, {"road": 0.01})

if __name__ == "__main__":
    car = load_model("quarter_car")
    points = grid(car, {"frequency_hz": [1 + 0.1 * step for step in range(40)]})
    asked = Sweep(car, logged, points, neighbours=2)
    store = os.path.join(folder, "points")
    found = run_sweep(asked, store=store, workers=on_processes(2))
    write_results(found, os.path.join(folder, "found.nc"))
"""


def _start(folder: Path, cache: str) -> subprocess.Popen:
    program = folder / "program.py"
    program.write_text(PROGRAM)
    environment = os.environ | {"CHASSYM_CACHE_DIR": cache}
    words = [sys.executable, str(program), str(folder)]
    return subprocess.Popen(words, env=environment, start_new_session=True, stderr=subprocess.DEVNULL)


def _logged(folder: Path) -> list[str]:
    log = folder / "log"
    return log.read_text().split() if log.exists() else []


def _stop_midway(folder: Path, cache: str, how: signal.Signals) -> int:
    process = _start(folder, cache)
    deadline = time.monotonic() + 120
    while len(_logged(folder)) < 12 and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    os.killpg(process.pid, how)
    threading.Timer(60, process.kill).start()
    return process.wait()


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_stopped_process_loses_only_what_was_in_flight(
    tmp_path: Path, cache_directory: str, quarter_car: Model, how: signal.Signals
) -> None:
    stopped, whole = tmp_path / "stopped", tmp_path / "whole"
    stopped.mkdir()
    whole.mkdir()
    assert _stop_midway(stopped, cache_directory, how) != 0
    assert 12 <= len(_logged(stopped)) < 36
    assert _start(stopped, cache_directory).wait() == _start(whole, cache_directory).wait() == 0
    computed = Counter(_logged(stopped))
    assert len(computed) == 40 and max(computed.values()) <= 2
    assert sum(computed.values()) <= 40 + 4 * 2  # two calls were handed to each of two processes
    assert Counter(_logged(whole)).total() == 40
    with (
        xarray.open_dataset(stopped / "found.nc") as found,
        xarray.open_dataset(whole / "found.nc") as all_at_once,
    ):
        assert found.identical(all_at_once)


# Files


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_results_come_back_from_their_file(
    uninterrupted: xarray.Dataset, tmp_path: Path, suffix: str
) -> None:
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    file = tmp_path / f"results{suffix}"
    for _ in range(2):  # what was there before is replaced
        assert write_results(uninterrupted, file) == file
    with xarray.open_dataset(file, engine=None if suffix == ".nc" else "zarr") as found:
        assert set(found.variables) == set(uninterrupted.variables) and found.attrs == uninterrupted.attrs
        for name, variable in uninterrupted.variables.items():
            np.testing.assert_array_equal(found[name].values.astype(variable.dtype), variable.values)
            assert found[name].attrs == variable.attrs
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_a_file_stays_where_a_new_one_cannot_take_its_place(
    uninterrupted: xarray.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "results.nc"
    file.write_bytes(b"before")

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(PermissionError):
        write_results(uninterrupted, file)
    assert file.read_bytes() == b"before"
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_another_suffix_is_refused(uninterrupted: xarray.Dataset, tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match=".nc or .zarr"):
        write_results(uninterrupted, tmp_path / "results.csv")


# What is refused before any work


@pytest.mark.parametrize(
    ("change", "error", "told"),
    [
        ({"tolerance": 0.0}, ValueError, "tolerance"),
        ({"neighbours": 0}, ValueError, "neighbours"),
        ({"metrics": []}, ValueError, "metrics"),
        ({"metrics": ["wobble"]}, KeyError, "wobble"),
    ],
)
def test_impossible_sweeps_are_refused(sweep: Sweep, change: dict, error: type[Exception], told: str) -> None:
    with pytest.raises(error, match=told):
        replace(sweep, **change)


def test_a_field_that_the_excitation_lacks_is_refused(quarter_car: Model) -> None:
    points = grid(quarter_car, {"frequency": [1.0]})
    with pytest.raises(SamplingError) as refusal:
        Sweep(quarter_car, BUMP, points)
    assert "'frequency'" in str(refusal.value) and "frequency_hz, amplitude" in str(refusal.value)
