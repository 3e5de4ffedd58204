"""The command line's linear part: modes, frequency responses and the rules for slopes."""

import errno
import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.io import loadmat

from chassym.derivation import load_model, vehicle_names
from chassym.linear import (
    damped_modes,
    find_slope_rule,
    frequency_response,
    heave_response,
    linearise,
    undamped_modes,
)

UNSTABLE = ("--set", "damper.force=[2000, 300, 0, -200, -2000]")
WITH_INPUTS = [name for name in vehicle_names() if name != "torsion_chain"]


def quarter_car(slope):
    """Polynomials of the quarter car in s: body per road, and the characteristic one; by hand."""
    value = load_model("quarter_car").parameters.value
    spring, tyre = [slope, value("spring.rate")], [value("tyre.damping"), value("tyre.stiffness")]
    body = np.polyadd([value("sprung.mass"), 0, 0], spring)
    wheel = np.polyadd([value("unsprung.mass"), 0, 0], np.polyadd(spring, tyre))
    return np.polymul(spring, tyre), np.polysub(np.polymul(body, wheel), np.polymul(spring, spring))


def slopes_at_zero():
    """Slopes of the quarter car's damper before and behind zero."""
    value = load_model("quarter_car").parameters.value
    return np.diff(value("damper.force"))[1:3] / np.diff(value("damper.velocity"))[1:3]


def closed_form(frequencies_hz):
    """Acceleration of the quarter car's body per displacement of the road."""
    through, characteristic = quarter_car(slopes_at_zero().mean())
    s = 2j * np.pi * np.asarray(frequencies_hz)
    return s**2 * np.polyval(through, s) / np.polyval(characteristic, s)


# Refusals


@pytest.mark.parametrize("command", [["modes"], ["bode"], ["export", "plant.mat"]])
@pytest.mark.parametrize(
    "rule",
    [
        *(
            "",
            "meen",
            "mean(1)",
            "secant",
            "secant()",
            "secant(x)",
            "secant(0)",
            "secant(nan)",
            "secant(inf)",
        ),
        *(
            "describing_function(-1)",
            "describing_function(0.1 m/s)",
            "statistical(0)",
            "secant(1)(2)",
            "a\nb",
        ),
    ],
)
def test_unknown_rules_are_refused(refused, tmp_path, monkeypatch, command, rule):
    monkeypatch.chdir(tmp_path)
    message = refused(*command, "--slopes", rule)
    expected = ("--slopes", repr(rule), "left", "right", "mean", "secant(NUMBER)", "not zero", "in SI")
    assert all(each in message for each in expected)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--from", "x"], ["--from", "'x'", "Hz"]),
        (["--from", "0"], ["--from", "0.0", "greater than zero"]),
        (["--from", "-1"], ["--from", "-1.0", "greater than zero"]),
        (["--to", "nan"], ["--to", "nan", "finite"]),
        (["--to", "inf"], ["--to", "inf", "finite"]),
        (["--to", "3 m"], ["--to", "'m'", "Hz"]),
        (["--to", "3 rad/s"], ["--to", "'3 rad/s'", "Hz"]),
        (["--to", "1e300"], ["--to", "'1e300'", "0.0001 to 1e+06 Hz"]),
        (["--from", "1e-320"], ["--from", "'1e-320'", "0.0001 to 1e+06 Hz"]),
        (["--from", "3", "--to", "2"], ["--to", "'2'", "above 3 Hz"]),
        (["--from", "3", "--to", "3e-3 kHz"], ["--to", "'3e-3 kHz'", "above 3 Hz"]),
        (["--points", "1"], ["--points", "'1'", "2 to 10000"]),
        (["--points", "999999"], ["--points", "'999999'", "2 to 10000"]),
        (["--points", "2.5"], ["--points", "'2.5'", "whole number"]),
        (["--points", "-3"], ["--points", "'-3'", "whole number"]),
        (["--output", "comfort"], ["--output", "'comfort'", "vertical_acceleration, body_displacement"]),
        (["--output", ""], ["--output", "''", "wheel_travel"]),
        (["--input", "pad"], ["--input", "'pad'", "heave, road"]),
        (["--plot", "a.gif"], ["--plot", "'a.gif'", ".png or .svg or .pdf"]),
        (["--plot", ""], ["--plot", "''", ".png"]),
        (["--plot", "missing/a.png"], ["--plot", "'missing/a.png'", "existing folder"]),
    ],
)
def test_wrong_settings_of_a_response_are_refused(refused, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    message = refused("bode", "quarter_car", *words)
    assert all(each in message for each in told)


@pytest.mark.parametrize("input", ["heave", "road"])
def test_a_vehicle_without_inputs_has_no_response(refused, input):
    message = refused("bode", "torsion_chain", "--input", input)
    assert all(each in message for each in ("VEHICLE", "torsion_chain", "no inputs"))


def test_a_picture_of_nothing_is_refused(run, tmp_path):
    path = tmp_path / "nothing.png"
    status, out, err = run("bode", "ride_model", "--output", "roll_rate", "--plot", str(path))
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert all(each in err for each in ("--plot", "roll_rate", "heave", "zero"))
    assert not path.exists()


def test_refusals_import_nothing_that_takes_long():
    code = """
import sys
from chassym.cli import main
def loaded(words, *names):
    assert main(words) == 2
    return [(words, name) for name in names if name in sys.modules]
slow = ["xarray", "scipy", "control", "matplotlib"]
found = loaded(["bode", "--plot", "a.gif"], "numpy", "sympy", "pint", *slow)
found += loaded(["bode", "--points", "1"], "numpy", "sympy", "pint", *slow)
found += loaded(["bode", "--from", "x"], *slow)
found += loaded(["bode", "--from", "3", "--to", "2"], *slow)
found += loaded(["modes", "limousine"], *slow)
sys.exit(", ".join(map(str, found)) or 0)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_export_with_other_inputs(run, tmp_path):
    """Rates drive the plant, and the displacements that they integrate are states."""
    path = tmp_path / "plant.mat"
    assert run("export", str(path), "quarter_car", "--inputs", "rates")[0] == 0
    plant = loadmat(path)["plant"][0, 0]
    assert (plant["A"].shape, plant["B"].shape) == ((5, 5), (5, 1))
    assert "inputs are rates" in plant["description"].item()
    status, _, err = run("export", str(path), "quarter_car", "--inputs", "displacements")
    assert status == 2 and "answer the rate of an input directly" in err


def test_export_with_unknown_inputs_is_refused(refused):
    assert "--inputs: received 'speed', expected one of displacements_and_rates, rates" in refused(
        "export", "plant.mat", "quarter_car", "--inputs", "speed"
    )


@pytest.mark.parametrize("command", ["modes", "bode", "export"])
def test_help_fits_80_columns(run, command):
    status, out, err = run(command, "--help")
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert all(rule in " ".join(out.split()) for rule in ("left, right, mean", "describing_function(A)"))


# Modes


def test_modes_of_the_quarter_car_are_roots_of_its_polynomial(answer):
    found = answer("modes", "quarter_car")
    roots = np.roots(quarter_car(slopes_at_zero().mean())[1])
    roots = sorted(roots[roots.imag > 0], key=abs)
    assert [complex(*mode["eigenvalue"]) for mode in found["modes"]] == pytest.approx(roots, rel=1e-9)
    assert [mode["frequency_hz"] for mode in found["modes"]] == pytest.approx(np.abs(roots) / (2 * np.pi))
    assert [mode["damping_ratio"] for mode in found["modes"]] == pytest.approx(-np.cos(np.angle(roots)))
    value = load_model("quarter_car").parameters.value
    body, wheel, spring = (value(name) for name in ("sprung.mass", "unsprung.mass", "spring.rate"))
    both = spring + value("tyre.stiffness")
    squares = np.roots([body * wheel, -(body * both + wheel * spring), spring * (both - spring)])
    undamped = np.sort(np.sqrt(squares)) / (2 * np.pi)
    assert found["undamped_frequencies_hz"] == pytest.approx(undamped, rel=1e-9)


@pytest.mark.parametrize("vehicle", vehicle_names())
def test_modes_are_those_of_the_linear_model(answer, run, vehicle):
    found, linear = answer("modes", vehicle), linearise(load_model(vehicle))
    modes = damped_modes(linear)
    for one, mode in zip(found["modes"], modes, strict=True):
        assert list(one)[:3] == ["frequency_hz", "damping_ratio", "name"]
        assert (one["name"], one["kind"]) == (mode.name, str(mode.kind))
        assert one["frequency_hz"] == pytest.approx(mode.frequency_hz)
        assert one["damping_ratio"] == pytest.approx(mode.damping_ratio)
        assert sum(one["kinetic_energy"].values()) == pytest.approx(1)
    frequencies = found["undamped_frequencies_hz"]
    assert frequencies == sorted(frequencies) == pytest.approx(undamped_modes(linear).frequencies_hz)
    status, out, err = run("modes", vehicle)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert all(f"{mode.frequency_hz:.3f}" in out and mode.name in out for mode in modes)
    assert "WARNING" not in out


@pytest.mark.slow
def test_modes_of_many_sections_fit_80_columns(run):
    status, out, err = run("modes", "--sections", "12")
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert "body torsion, 11 nodes" in out


def test_what_does_not_oscillate_has_a_time_constant(run, answer):
    words = ["modes", "quarter_car", "--set", "damper.force=[-30000, -6000, 0, 6000, 30000]"]
    decays = [mode for mode in answer(*words)["modes"] if mode["kind"] == "decay"]
    assert len(decays) == 2
    _, out, _ = run(*words)
    lines = [line for line in out.splitlines() if line.startswith("decay ")]
    for decay, line in zip(decays, lines, strict=True):
        assert line.split()[1:3] == [f"{-1 / decay['eigenvalue'][0]:.3g}", "s"]
        assert decay["name"] in line
    assert "WARNING" not in out


def test_modes_that_grow_are_told(run, answer):
    kinds = {mode["name"]: mode["kind"] for mode in answer("modes", "quarter_car", *UNSTABLE)["modes"]}
    assert kinds == dict.fromkeys(("bounce", "wheel hop"), "growing oscillation")
    _, out, _ = run("modes", "quarter_car", *UNSTABLE)
    assert "WARNING: unstable: bounce, wheel hop would grow." in out


def test_no_damping_is_no_instability(run):
    _, out, _ = run("modes", "torsion_chain", "--set", "damping.front=0", "--set", "damping.rear=0")
    assert "WARNING" not in out
    assert "-0.0000" not in out


def test_a_car_that_falls_over_has_no_undamped_frequencies(run, answer):
    words = ["modes", "rigid_sedan", "--set", "body.mass_centre.z=8"]
    found = answer(*words)
    assert found["undamped_frequencies_hz"] is None
    assert "divergence" in [mode["kind"] for mode in found["modes"]]
    assert "WARNING: unstable" in run(*words)[1]


def test_shares_above_one_are_explained(run):
    assert "Shares above 100 %" in run("modes", "rigid_sedan")[1]
    assert "Shares above 100 %" not in run("modes", "quarter_car")[1]


# Rules for slopes


def rules():
    """Rules for the quarter car's damper with the slopes that they have, by hand."""
    left, right = slopes_at_zero()
    value = load_model("quarter_car").parameters.value
    velocities, forces = value("damper.velocity"), value("damper.force")
    return {
        "left": ("left_slope", left),
        "right_slope": ("right_slope", right),
        "mean": ("mean_slope", (left + right) / 2),
        f"secant({velocities[0]})": (f"secant_slope({velocities[0]:g})", forces[0] / velocities[0]),
        f"secant({velocities[-1]})": (f"secant_slope({velocities[-1]:g})", forces[-1] / velocities[-1]),
        "describing_function(0.05)": ("describing_function(0.05)", (left + right) / 2),
        "statistical(1e-3)": ("statistical_slope(0.001)", (left + right) / 2),
    }


@pytest.mark.parametrize(("text", "name", "slope"), [(text, *told) for text, told in rules().items()])
def test_rules_are_applied_and_stated(answer, run, tmp_path, text, name, slope):
    words = ["quarter_car", "--slopes", text]
    found = answer("modes", *words)
    assert found["damper_slope_rule"] == name
    assert found["damper_slopes"] == pytest.approx({"damper": slope})
    roots = np.roots(quarter_car(slope)[1])
    frequencies = np.sort(np.abs(roots[roots.imag >= 0])) / (2 * np.pi)
    assert [mode["frequency_hz"] for mode in found["modes"]] == pytest.approx(frequencies)
    assert answer("bode", *words, "--points", "2")["damper_slope_rule"] == name
    status, out, _ = run("export", str(tmp_path / "plant.mat"), *words)
    plant = loadmat(tmp_path / "plant.mat", simplify_cells=True)["plant"]
    assert (status, name in out, name in plant["description"]) == (0, True, True)
    assert sorted(np.abs(np.linalg.eigvals(plant["A"]))) == pytest.approx(sorted(np.abs(roots)))


def test_a_model_without_tables_has_no_rule(answer):
    for command in ("modes", "bode"):
        assert answer(command, "half_car", "--slopes", "left")["damper_slope_rule"] is None


# Frequency responses


def test_the_response_of_the_quarter_car_has_its_closed_form(answer):
    found = answer("bode", "quarter_car", "--from", "0.01", "--to", "0.1 kHz", "--points", "1201")
    frequencies = found["frequencies_hz"]
    assert frequencies == pytest.approx(np.geomspace(0.01, 100, 1201))
    expected = closed_form(frequencies)
    phase = np.degrees(np.unwrap(np.angle(expected)))
    assert found["magnitude"] == pytest.approx(np.abs(expected), rel=1e-9)
    assert np.exp(1j * np.radians(found["phase_degrees"])) == pytest.approx(expected / np.abs(expected))
    assert found["phase_degrees"] == pytest.approx(phase - phase[0] + 180, abs=0.1)
    assert (found["output"], found["input"]) == ("vertical_acceleration", "heave")
    assert (found["unit"], found["stable"]) == ("(m/s^2)/m", True)


@pytest.mark.parametrize("vehicle", WITH_INPUTS)
def test_responses_are_those_of_the_linear_model(answer, run, vehicle):
    linear = linearise(load_model(vehicle), find_slope_rule("left"))
    words = ["bode", vehicle, "--slopes", "left", "--points", "7"]
    heave = answer(*words)
    expected = heave_response(linear, heave["frequencies_hz"]).select(heave["output"], "heave")
    assert heave["magnitude"] == pytest.approx(np.abs(expected), rel=1e-9)
    words += ["--output", linear.outputs[-1], "--input", linear.inputs[-1]]
    found = answer(*words)
    one = frequency_response(linear, found["frequencies_hz"]).select(linear.outputs[-1], linear.inputs[-1])
    assert found["magnitude"] == pytest.approx(np.abs(one), rel=1e-9)
    assert found["unit"].endswith("/m")
    for each in (words, words[:6]):
        status, out, err = run(*each)
        assert (status, err) == (0, "")
        assert max(map(len, out.splitlines())) <= 80
        assert linear.description[:20] in out
    assert all(f"{size:.4g}" in out for size in heave["magnitude"])


def test_few_frequencies_have_the_phase_of_many(answer):
    words = ["bode", "half_car", "--output", "pitch_rate", "--input", "rear_road"]
    few, many = (answer(*words, "--points", points)["phase_degrees"] for points in ("2", "1001"))
    assert few == pytest.approx(many[::1000], abs=1e-6)
    assert abs(few[1] - few[0]) > 180


def test_peaks_are_maxima_of_the_closed_form(run):
    _, out, _ = run("bode", "quarter_car", "--points", "2")
    frequencies = np.geomspace(0.1, 30, 1_000_001)
    size = np.abs(closed_form(frequencies))
    peak = size.argmax()
    assert f"Peaks: {size[peak]:.4g} (m/s^2)/m at {frequencies[peak]:.3g} Hz\n" in out


def test_rounding_makes_no_peaks(run):
    _, out, _ = run("bode", "quarter_car", "--from", "999999", "--to", "1e6", "--points", "3")
    assert "Peaks" not in out
    _, out, _ = run("bode", "ride_model", "--output", "roll_rate", "--points", "2")
    assert "Peaks" not in out
    assert "Zero but for rounding" in out
    assert {line.split()[1] for line in out.splitlines() if line.strip().endswith(" 0.0")} == {"0"}


def test_wheel_travel_in_heave_is_small_at_low_frequencies_and_not_nothing(answer):
    words = ["ride_model", "--output", "front_left_wheel_travel", "--from", "1e-4", "--to", "1e-3"]
    magnitude = answer("bode", *words, "--points", "3")["magnitude"]
    slopes = np.diff(np.log(magnitude)) / (math.log(10) / 2)
    assert slopes == pytest.approx([2, 2], abs=1e-3)


def test_a_response_of_what_grows_is_told_to_be_none(run, answer):
    assert answer("bode", "quarter_car", *UNSTABLE)["stable"] is False
    _, out, _ = run("bode", "quarter_car", *UNSTABLE)
    assert "WARNING: unstable: bounce, wheel hop would grow." in out
    assert "would not settle" in out


@pytest.mark.parametrize(("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_a_picture_is_written(run, tmp_path, suffix, start):
    path = tmp_path / f"bode{suffix}"
    status, out, err = run("bode", "quarter_car", "--plot", str(path))
    assert (status, err) == (0, "")
    assert str(path) in out.replace("\n", "")
    assert path.read_bytes().startswith(start)
    if suffix == ".svg":  # matplotlib keeps every text as a comment beside its outline
        text = path.read_text(encoding="utf-8")
        assert all(each in text for each in ("frequency (Hz)", "(m/s²)/m", "degrees", "mean_slope"))


def test_a_picture_that_cannot_be_written_is_one_line_and_status_1(run, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "no space left")

    monkeypatch.setattr("chassym.linear.plots.save_bode", full)
    path = tmp_path / "bode.png"
    assert run("bode", "quarter_car", "--plot", str(path)) == (1, "", f"chassym: {path}: no space left\n")


def test_a_picture_is_written_beside_json(answer, tmp_path):
    found = answer("bode", "quarter_car", "--points", "2", "--plot", str(tmp_path / "bode.svg"))
    assert len(found["magnitude"]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["bode.svg"]
