"""The command `sweep`: what may be varied, what is refused, files, and going on with a stopped sweep."""

from pathlib import Path

import numpy as np
import pytest
import xarray

from chassym.nonlinear.steady.steady_state import steady_state
from chassym.nonlinear.sweep import sweep as sweep_module
from chassym.requested_sweep import MOST_POINTS, find_points

HEAVE = ("sweep", "heave", "quarter_car", "--jobs", "1")
SAMPLE = ("--latin-hypercube", "9", "--range")


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DASK_SCHEDULER_ADDRESS", raising=False)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ("sprung.mass=300:400:3", [300, 350, 400]),
        ("sprung.mass=0.3:0.4:3 t", [300, 350, 400]),
        ("sprung.mass=300, 310.5,4e2", [300, 310.5, 400]),
        ("sprung.mass=300 , 400 kg", [300, 400]),
        ("tyre.stiffness=1e5:4e5:3log", [1e5, 2e5, 4e5]),
        ("tyre.stiffness=100:400:3 log N/mm", [1e5, 2e5, 4e5]),
        ("frequency_hz=1,2 Hz", [1, 2]),
        ("amplitude_m=5,10 mm", [0.005, 0.01]),
        ("tyre=0.9:1.1:3", [0.9, 1.0, 1.1]),
        ("tyre=90,110%", [0.9, 1.1]),
    ],
)
def test_values_are_understood(run, values, expected):
    name = values.partition("=")[0]
    status, out, err = run(*HEAVE, "--vary", values)
    assert (status, err) == (0, "")
    assert f"{len(expected)} points, 0 failed" in out
    with xarray.open_dataset("sweep.nc") as found:
        np.testing.assert_allclose(found[name], expected)


def test_tyres_lift_in_all_points(run):
    grid = (*HEAVE, "--vary", "frequency_hz=8:9:2", "--vary", "amplitude_m=0.03")
    smallest = {}
    for tyres in ("bonded", "lifting"):
        assert run(*grid, "--tyres", tyres, "-o", f"{tyres}.nc")[0] == 0
        with xarray.open_dataset(f"{tyres}.nc") as found:
            smallest[tyres] = found["minimum_patch_force"].values
    assert np.all(smallest["bonded"] < 0)
    np.testing.assert_array_equal(smallest["lifting"], 0)


def test_percent_of_a_parameter_is_relative_to_its_nominal_value(run, quarter_car):
    assert run(*HEAVE, "--vary", "sprung.mass=50:150:3%")[0] == 0
    nominal = quarter_car.parameters.value("sprung.mass")
    with xarray.open_dataset("sweep.nc") as found:
        np.testing.assert_allclose(found["sprung.mass"], np.array([0.5, 1.0, 1.5]) * nominal)


def test_the_summary_fits_and_tells_extremes_and_failures(run):
    words = (*HEAVE, "--vary", "sprung.mass=-1,300,400", "--vary", "frequency_hz=1,2", "-o", "found.zarr")
    status, out, err = run(*words)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert "6 points, 2 failed" in out and "sprung.mass" in out and "greater than zero" in out
    found = xarray.open_zarr("found.zarr")
    acceleration = found["vertical_acceleration"].values
    assert f"{np.nanmin(acceleration):.5g}" in out and f"{np.nanmax(acceleration):.5g}" in out
    assert found.sizes == {"sprung.mass": 3, "frequency_hz": 2}


def test_one_at_a_time_tells_what_matters_most(run, quarter_car):
    status, out, err = run(*HEAVE, "--one-at-a-time", "25%", "--set", "sprung.mass=350")
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    with xarray.open_dataset("sweep.nc") as found:
        values = found["vertical_acceleration"].values
        effects = np.abs(values / values[0] - 1)
        largest = int(np.nanargmax(effects))
        assert str(found["varied"].values[largest]) in out
        assert f"{100 * (values[largest] / values[0] - 1):+.3g} %" in out
        assert float(found["factor"][0]) == 1


def test_a_hypercube_of_ranges(run):
    ranges = ("--range", "sprung.mass=80:120%", "--range", "tyre.stiffness=1e5:1e6log")
    status, out, err = run(*HEAVE, "--latin-hypercube", "10", *ranges)
    assert (status, err) == (0, "") and "10 points" in out
    with xarray.open_dataset("sweep.nc") as found:
        assert found.sizes == {"point": 10}
        assert int((found["tyre.stiffness"] < np.sqrt(1e11)).sum()) == 5


def test_as_many_points_as_may_be_asked_for_can_be(quarter_car):
    points = find_points(quarter_car, (), None, str(MOST_POINTS), ["frequency_hz=1:9"])
    assert len(points) == MOST_POINTS


def test_the_same_command_goes_on_and_another_one_is_refused(run, monkeypatch):
    calls = []

    def stopped(*arguments, **options):
        calls.append(options)
        if len(calls) == 12:
            raise KeyboardInterrupt
        return steady_state(*arguments, **options)

    monkeypatch.setattr(sweep_module, "steady_state", stopped)
    words = (*HEAVE, "--vary", "frequency_hz=1:3:20")
    kept = "sweep.nc.points: finished points are kept; the same command goes on from there\n"
    assert run(*words) == (130, "", f"{kept}chassym: interrupted\n")
    assert not Path("sweep.nc").exists()
    assert run(*words)[0] == 0
    assert len(calls) == 12 + 12  # eight of the first twelve were kept
    assert run(*words)[0] == 0
    assert len(calls) == 12 + 12
    status, out, err = run(*HEAVE, "--vary", "frequency_hz=1:3:21")
    assert (status, out) == (2, "") and "another table of points" in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["diagonal"], ["'diagonal'", "lateral"]),
        (["lateral", "sedan", "-o", "found.csv"], ["--output", ".nc", ".zarr"]),
        (["lateral", "sedan", "-o", "nowhere/found.nc"], ["--output", "existing folder"]),
        (["lateral", "sedan", "--jobs", "0"], ["--jobs", "'0'", "1 or more"]),
        (["lateral", "sedan", "--jobs", "-1"], ["--jobs", "'-1'", "1 or more"]),
        (["lateral", "sedan", "--jobs", "two"], ["--jobs", "'two'", "a whole number"]),
        (["lateral", "sedan", "--jobs", "2", "--dask", "tcp://x:1"], ["--jobs", "--dask"]),
        (["lateral", "limousine", "--vary", "a=1"], ["'limousine'"]),
        (["lateral", "sedan"], ["nothing to vary", "--vary", "--one-at-a-time", "--latin-hypercube"]),
        (["lateral", "sedan", "--vary", "tyre=1", "--one-at-a-time", "25%"], ["--vary and --one-at-a-time"]),
        (["lateral", "sedan", "--vary", "body.front.mas=1"], ["body.front.mas", "body.front.mass"]),
        (["lateral", "sedan", "--vary", "body.front.mass"], ["--vary", "NAME=VALUES"]),
        (["lateral", "sedan", "--vary", "body.front.mass=heavy"], ["--vary", "from:to:count"]),
        (["lateral", "sedan", "--vary", "body.front.mass=1,2 m"], ["--vary", "body.front.mass", "kg"]),
        (["lateral", "sedan", "--vary", "body.front.mass=0:2:3log"], ["above zero"]),
        (["lateral", "sedan", "--vary", "body.front.mass=1:2:0"], ["0 points"]),
        (["lateral", "sedan", "--vary", f"body.front.mass=1:2:{'9' * 5000}"], ["--vary", "a whole number"]),
        (["heave", "sedan", "--vary", "frequency_hz=0,1"], ["--vary", "'frequency_hz=0,1'", "above zero"]),
        (["heave", "sedan", "--vary", " frequency_hz =-1:1:3 Hz"], ["--vary", "-1:1:3", "above zero"]),
        (["lateral", "sedan", "--vary", "tyre=1", "--vary", "tyre=2"], ["tyre twice"]),
        (["lateral", "sedan", "--vary", "tyre=1", "--range", "tyre=1:2"], ["--range", "--latin-hypercube"]),
        (["lateral", "sedan", "--latin-hypercube", "9"], ["--range"]),
        (["lateral", "sedan", "--latin-hypercube", "9", "--range", "tyre=2:1"], ["tyre", "increasing"]),
        (["lateral", "sedan", *SAMPLE, "frequency_hz=5:1"], ["--range", "frequency_hz=5:1", "increasing"]),
        (["lateral", "sedan", *SAMPLE, "frequency_hz=0:5"], ["--range", "frequency_hz=0:5", "above zero"]),
        (["lateral", "sedan", *SAMPLE, "tyre=0:2 log"], ["--range", "tyre=0:2 log", "above zero"]),
        (["lateral", "sedan", "--latin-hypercube", "1000001"], ["1000001 points", "1 to 1000000"]),
        (["lateral", "sedan", "--latin-hypercube", "-1"], ["-1 points", "1 to 1000000"]),
        (["lateral", "sedan", "--latin-hypercube", "9" * 5000], ["--latin-hypercube", "a whole number"]),
        (["lateral", "sedan", "--one-at-a-time", "150%"], ["--one-at-a-time", "'150%'", "less than 100%"]),
        (["lateral", "sedan", "--one-at-a-time", "0%"], ["--one-at-a-time", "'0%'", "more than 0%"]),
        (["lateral", "sedan", "--one-at-a-time", "1"], ["--one-at-a-time", "'1'", "less than 100%"]),
        (["lateral", "sedan", "--one-at-a-time", "much"], ["--one-at-a-time", "'much'", "25%"]),
        (["lateral", "sedan", "--vary", "frequency=1,2"], ["'frequency'", "frequency_hz"]),
        (["lateral", "sedan", "--vary", "tyre=1", "--metric", "comfort"], ["--metric", "'comfort'"]),
        (["heave_sweep", "sedan", "--vary", "tyre=1"], ["heave_sweep", "--vary frequency_hz"]),
        (["lateral", "quarter_car", "--vary", "tyre.stiffness=1e5"], ["lateral", "front_left_pad_y"]),
    ],
)
def test_wrong_words_are_refused_before_slow_work(refused, words, told):
    message = refused("sweep", *words)
    assert all(each in message for each in told), message
