"""The command `chassym test`: profiles of one's own, stepped sines, contact, pictures and files."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
import xarray

from chassym.cli import main
from chassym.derivation import Model, load_model, with_lifting_tyres
from chassym.nonlinear import Harmonic, shooting_steady_state
from chassym.nonlinear.rig import load_rig_test, rig_test_names, run
from chassym.requested_test import TESTS
from chassym.rig_test_answer import print_test

OWN = """
name = "diagonal"
description = "two pads, the second one later"
source = "own"
frequency = "2 Hz"
metrics = ["roll_rate", "pitch_rate"]

[[motion]]
pads = "front_left"
direction = "vertical"
amplitude = "15 mm"

[[motion]]
pads = "rear_right"
direction = "vertical"
amplitude = "5 mm"
lag = "50 ms"
"""

STEPPED = """
name = "few_steps"
description = "three frequencies"
source = "own"
frequency = "[2, 5.5, 7] Hz"

[[motion]]
pads = "all"
direction = "vertical"
amplitude = "40 mm"
"""


@pytest.fixture
def profile(tmp_path):
    """Give a way to write a profile; returns its path."""

    def write(text: str) -> str:
        file = tmp_path / "my_test.toml"
        file.write_text(text, encoding="utf-8")
        return str(file)

    return write


def test_the_names_of_the_help_are_the_built_in_tests():
    assert sorted(TESTS) == rig_test_names()
    assert TESTS[:3] == ("lateral", "vertical", "heave")


def test_a_profile_is_run_as_it_says(answer, profile, sedan: Model):
    found = answer("test", profile(OWN))
    expected = run(sedan, load_rig_test(profile(OWN))).steps[0].state.peak_to_peak
    assert found["test"] == "diagonal"
    assert {n: m["peak_to_peak"] for n, m in found["metrics"].items()} == pytest.approx(
        {name: metric.value for name, metric in expected.items()}, rel=1e-9
    )
    assert set(found["metrics"]) == {"roll_rate", "pitch_rate"}


def test_options_change_a_profile(answer, profile, sedan: Model):
    test = load_rig_test(profile(OWN)).at(3.0).with_amplitude(0.03).with_rear_lag(0.1)
    words = ["--frequency", "3", "--amplitude", "30 mm", "--lag", "0.1", "--tolerance", "1e-5"]
    found = answer("test", profile(OWN), *words)
    expected = run(sedan, test).steps[0].state.peak_to_peak
    assert found["frequency_hz"] == 3.0
    for name, metric in found["metrics"].items():
        assert metric["error"] <= 1e-5 * metric["peak_to_peak"]
        assert metric["peak_to_peak"] == pytest.approx(expected[name].value, rel=2e-3)


def test_the_axes_of_a_profile_are_those_of_the_body_on_request(answer, profile):
    ground, body = (answer("test", profile(OWN), "--axes", axes)["metrics"] for axes in ("ground", "body"))
    assert set(body) == set(ground)
    assert body["roll_rate"]["peak_to_peak"] == pytest.approx(ground["roll_rate"]["peak_to_peak"], rel=1e-2)
    assert body["roll_rate"]["peak_to_peak"] != ground["roll_rate"]["peak_to_peak"]


@pytest.mark.parametrize(("unit", "order"), [("m/s", 1), ("m/s^2", 2)])
def test_an_amplitude_may_be_of_velocity_or_acceleration(answer, unit, order):
    size = 0.01 * (2 * np.pi * 2.0) ** order
    words = ("test", "heave", "quarter_car", "--frequency", "2", "--amplitude")
    by_rate, by_length = (answer(*words, text)["metrics"] for text in (f"{size!r} {unit}", "10 mm"))
    for name, metric in by_length.items():
        assert by_rate[name]["peak_to_peak"] == pytest.approx(metric["peak_to_peak"], rel=1e-6)


def test_a_vehicle_may_be_an_option(answer):
    assert answer("test", "heave", "--vehicle", "quarter_car") == answer("test", "heave", "quarter_car")


def test_tyres_lift_on_request(answer, profile, quarter_car: Model):
    """As an option, as a key of a profile, and as the model that Python makes of it."""
    hop = ("test", "heave", "quarter_car", "--frequency", "8", "--amplitude", "30 mm")
    bonded, lifting = answer(*hop), answer(*hop, "--tyres", "lifting")
    assert answer(*hop, "--tyres", "bonded") == bonded
    assert bonded["minimum_patch_force"]["value"] < 0 == lifting["minimum_patch_force"]["value"]
    assert [loss["in_the_air"] for loss in bonded["lost_contact"]] == [False]
    assert [loss["in_the_air"] for loss in lifting["lost_contact"]] == [True]
    text = 'extends = "heave"\ntyres = "lifting"\nfrequency = "8 Hz"\n'
    motion = '[[motion]]\npads = "all"\ndirection = "vertical"\namplitude = "30 mm"\n'
    assert answer("test", profile(text + motion), "quarter_car") == lifting
    metric = lifting["metrics"]["vertical_acceleration"]
    flying, hopping = with_lifting_tyres(quarter_car), Harmonic(8.0, {"road": 0.03})
    expected = shooting_steady_state(flying, hopping, tolerance=1e-10).peak_to_peak["vertical_acceleration"]
    accuracy = metric["error"] + expected.error
    assert metric["peak_to_peak"] == pytest.approx(expected.value, abs=accuracy)


def test_what_tyres_do_is_said_in_two_words(refused):
    assert "bonded, lifting" in refused("test", "heave", "--tyres", "glued")


def test_a_vehicle_without_tyres_cannot_lift_them(refused, tmp_path):
    assert "no tyre to lift" in refused("test", "roll", "torsion_chain", "--tyres", "lifting")


def test_two_vehicles_are_refused(refused):
    message = refused("test", "heave", "half_car", "--vehicle", "quarter_car")
    assert all(each in message for each in ("--vehicle", "'quarter_car'", "'half_car'"))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("lag", "lagg", ["motion[1].lagg:", "unknown", "lag"]),
        ('"15 mm"', '"15 kg"', ["motion[0].amplitude:", "'15 kg'"]),
        ('frequency = "2 Hz"', "", ["frequency:", "nothing"]),
        ("roll_rate", "rol_rate", ["'rol_rate'", "full_car", "roll_rate"]),
        ('"front_left"', '"front_middle"', ["diagonal test: vehicle:", "full_car"]),
    ],
)
def test_a_wrong_profile_is_refused_in_one_line(refused, profile, old, new, told):
    path = profile(OWN.replace(old, new, 1))
    message = refused("test", path)
    assert all(each in message for each in told)


@pytest.mark.parametrize("words", [["missing.toml"], ["heave.csv"], ["."]])
def test_a_profile_that_is_not_there_is_refused(refused, words):
    assert repr(words[0]) in refused("test", *words)


@pytest.mark.parametrize(("option", "suffixes"), [("--plot", ".png or .svg or .pdf"), ("-o", ".csv or .nc")])
def test_files_of_other_kinds_are_refused(refused, option, suffixes):
    assert suffixes in refused("test", "heave", option, "result.txt")


def test_axes_that_a_profile_lacks_are_refused(refused, profile):
    path = profile(STEPPED.replace("frequency", 'metrics = ["body_displacement"]\nfrequency'))
    message = refused("test", path, "--axes", "body")
    assert all(each in message for each in ("--axes", "body_axes_body_displacement"))


@pytest.mark.parametrize("name", ["kinematics_and_compliance", "kinematics_and_compliance_roll"])
def test_rates_of_the_rig_with_the_body_held(answer, run, name):
    found = answer("test", name)
    assert found["rates"]
    for rate in found["rates"].values():
        assert set(rate) == {"value", "unit", "error"}
        assert 0 <= rate["error"] < 1e-2 * abs(rate["value"])
    status, out, err = run("test", name)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert all(rate.replace("_", " ") in out for rate in found["rates"])


def test_the_wheel_rate_of_the_thesis_is_measured(answer):
    rate = answer("test", "kinematics_and_compliance")["rates"]["front_wheel_rate"]
    assert rate["unit"] == "N/m"
    assert rate["value"] == pytest.approx(15.6e3, rel=0.02)


def test_vehicles_whose_body_cannot_be_held_are_refused(refused):
    assert "full_car or rigid_car" in refused("test", "kinematics_and_compliance", "half_car")


def test_lost_contact_is_told_with_patch_and_time(answer, run):
    words = ["test", "heave", "half_car", "--amplitude", "50 mm", "--frequency", "6"]
    losses = answer(*words)["lost_contact"]
    assert [loss["patch"] for loss in losses] == ["front", "rear"]
    assert not any(loss["in_the_air"] for loss in losses)
    status, out, _ = run(*words)
    assert status == 0
    assert max(map(len, out.splitlines())) <= 80
    flowing = " ".join(out.split())
    for loss in losses:
        ((begin, end),) = loss["intervals_s"]
        assert loss["share_of_period"] == pytest.approx(6 * (end - begin))
        assert f"at {loss['patch']} for {1e3 * (end - begin):.3g} ms" in flowing
        assert f"{100 * loss['share_of_period']:.2g} % of the period" in flowing
        assert f"phase {360 * 6 * begin:.0f} to {360 * 6 * end:.0f} degrees" in flowing


def test_kept_contact_is_an_empty_list(answer):
    assert answer("test", "heave", "half_car")["lost_contact"] == []


def test_a_stepped_sine_as_json(answer, profile, half_car: Model):
    found = answer("test", profile(STEPPED), "half_car")
    assert [(step["direction"], step["frequency_hz"]) for step in found["steps"]] == [
        *(("upward", hertz) for hertz in (2.0, 5.5, 7.0)),
        *(("downward", hertz) for hertz in (7.0, 5.5, 2.0)),
    ]
    assert (found["converged"], found["jumps"], found["coexisting_hz"]) == (True, [], [])
    for step in found["steps"]:
        single = answer("test", profile(STEPPED), "half_car", "--frequency", str(step["frequency_hz"]))
        assert step["metrics"].keys() == single["metrics"].keys()
        for name, metric in step["metrics"].items():
            expected = single["metrics"][name]["peak_to_peak"]
            assert metric["peak_to_peak"] == pytest.approx(expected, rel=2e-3)


def test_a_stepped_sine_as_a_table(run, profile):
    status, out, err = run("test", profile(STEPPED), "half_car")
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert all(f"\n{hertz} " in out for hertz in ("  2", "5.5", "  7"))
    flowing = " ".join(out.split())
    assert "No jumps" in flowing
    assert "no contact" in flowing
    assert "WARNING: contact would have been lost at 2 frequencies from 5.5 to 7 Hz" in flowing
    assert "Vertical acceleration: largest" in flowing


def test_six_metrics_over_frequency_fit_80_columns(run, profile):
    text = STEPPED.replace("[2, 5.5, 7] Hz", "[2, 2.5] Hz").replace("40 mm", "10 mm")
    status, out, err = run("test", profile(text))
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert out.count("longitudinal") == 1
    assert all(
        out.count(f"{turning}\n") or f"{turning} rate: largest" in out.lower() for turning in ("yaw", "roll")
    )


def test_a_table_in_a_file(run, answer, profile, tmp_path):
    file = tmp_path / "steps.csv"
    status, out, _ = run("test", profile(STEPPED), "half_car", "-o", str(file))
    assert status == 0
    assert "steps.csv" in out
    with file.open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    steps = answer("test", profile(STEPPED), "half_car")["steps"]
    assert len(rows) == len(steps)
    for row, step in zip(rows, steps, strict=True):
        assert (row["direction"], float(row["frequency (Hz)"])) == (step["direction"], step["frequency_hz"])
        for name, metric in step["metrics"].items():
            assert float(row[f"{name} ({metric['unit']})"]) == metric["peak_to_peak"]
            assert float(row[f"error of {name} ({metric['unit']})"]) == metric["error"]
        assert row["patch"] == step["minimum_patch_force"]["patch"]


def test_labelled_arrays_in_a_file(run, answer, tmp_path):
    file = tmp_path / "heave.nc"
    assert run("test", "heave", "quarter_car", "-o", str(file))[0] == 0
    metric = answer("test", "heave", "quarter_car")["metrics"]["vertical_acceleration"]
    with xarray.open_dataset(file, engine="scipy") as data:
        assert data["vertical_acceleration"].item() == metric["peak_to_peak"]
        assert data["vertical_acceleration"].attrs["units"] == "m/s^2"
        assert np.ptp(data["vertical_acceleration_signal"].values) == pytest.approx(
            metric["peak_to_peak"], rel=1e-3
        )
        assert data.attrs["test"] == "heave"


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_picture_beside_json(tmp_path, capsys, suffix):
    file = tmp_path / f"period{suffix}"
    assert main(["test", "heave", "quarter_car", "--json", "--plot", str(file)]) == 0
    assert json.loads(capsys.readouterr().out)["test"] == "heave"
    start = file.read_bytes()[:200]
    assert b"PNG" in start if suffix == ".png" else b"<svg" in start or b"<?xml" in start


def test_steps_that_are_not_found_are_told_with_their_reason(monkeypatch, capsys, quarter_car: Model):
    from chassym.nonlinear import NoPeriodicOrbitError
    from chassym.nonlinear.continuation import stepped_sine

    def failing(model, excitation, **options):
        raise NoPeriodicOrbitError("nothing here")

    test = load_rig_test("heave_sweep")
    monkeypatch.setattr(stepped_sine, "steady_state", failing)
    test = replace(test, frequencies_hz=(1.0, 2.0), metrics=("vertical_acceleration",))
    print_test(run(quarter_car, test), {"vertical_acceleration": "vertical_acceleration"})
    out = capsys.readouterr().out
    assert "Not found, upward: nothing here" in out
    assert "no steady state found" in out


def test_all_built_in_tests_have_the_inputs_of_the_sedan():
    sedan = load_model("sedan")
    for name in TESTS:
        test = load_rig_test(name)
        assert test.excitation(test.mounted(sedan)).amplitudes
