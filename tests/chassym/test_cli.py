"""The command line: one line and status 2 for every wrong input, the JSON agreed on, and tables that fit."""

import io
import math
import os
import re
import subprocess
import sys
from importlib import resources
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.io import loadmat

from chassym import study as study_module
from chassym.comparison import Comparison
from chassym.derivation import Model, load_model, vehicle_names
from chassym.nonlinear import Harmonic, rig, steady_state

SEDAN = (resources.files("chassym.derivation.vehicles") / "sedan.toml").read_text(encoding="utf-8")
COMMANDS = ("study", "parameters", "equations", "modes", "bode", "test", "export")
METRICS = {f"{direction}_acceleration": "m/s^2" for direction in ("longitudinal", "lateral", "vertical")} | {
    f"{rotation}_rate": "rad/s" for rotation in ("roll", "pitch", "yaw")
}
PROGRAM = [sys.executable, "-c", "import sys; from chassym.cli import main; sys.exit(main())"]


# Wrong words


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], ["command", *COMMANDS]),
        (["animate_me"], ["animate_me", *COMMANDS]),
        (["--fast"], ["--fast", *COMMANDS]),
        (["modes", "--fast"], ["--fast", "chassym modes", "[VEHICLE]", "--set NAME=VALUE", "--json"]),
        (["modes", "--set"], ["--set", "NAME=VALUE"]),
        (["study", "-o"], ["-o", "DIR"]),
        (["test"], ["lateral|vertical|heave"]),
        (["export"], ["FILE.mat"]),
        (["modes", "sedan", "half_car"], ["half_car", "[VEHICLE]"]),
        (["test", "diagonal"], ["'diagonal'", "lateral, vertical, heave"]),
        (["test", "lateral", "--axes", "wheel"], ["--axes", "'wheel'", "ground, body"]),
    ],
)
def test_wrong_words_are_refused(refused, words, told):
    message = refused(*words)
    assert all(each in message for each in told)


@pytest.mark.parametrize(
    "words", [["parameters"], ["equations"], ["modes"], ["bode"], ["test", "lateral"], ["study"]]
)
def test_an_unknown_vehicle_is_refused_by_every_command(refused, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    message = refused(*words, "limousine")
    assert all(each in message for each in ("'limousine'", *vehicle_names()))


@pytest.mark.parametrize("name", ["", "a" * 5000, "a\nb", "\x00"])
def test_odd_names_of_vehicles_are_refused(refused, name):
    assert "vehicle" in refused("modes", name)


# Wrong parameters, as an override and in a file


@pytest.mark.parametrize(
    ("assignment", "told"),
    [
        ("body.front.mass", ["'body.front.mass'", "NAME=VALUE"]),
        ("body.front.mass=", ["'body.front.mass='", "NAME=VALUE"]),
        ("=475", ["'=475'", "NAME=VALUE"]),
        ("body.front.mas=475", ["body.front.mas:", "unknown", "body.front.mass"]),
        ("body.front=475", ["body.front:", "unknown"]),
        ("body.front.mass=heavy", ["body.front.mass:", "'heavy'", "kg"]),
        ("body.front.mass=475 m", ["body.front.mass:", "'m'", "[length]", "kg"]),
        ("body.front.mass=475 stones_throw", ["body.front.mass:", "stones_throw", "kg"]),
        ("body.front.mass=nan", ["body.front.mass:", "nan", "finite"]),
        ("body.front.mass=inf", ["body.front.mass:", "inf", "finite"]),
        ("body.front.mass=-inf kg", ["body.front.mass:", "-inf", "finite"]),
        ("body.front.mass=1e999", ["body.front.mass:", "inf", "finite"]),
        ("body.front.mass=0", ["body.front.mass:", "0.0", "greater than zero"]),
        ("body.front.mass=-475", ["body.front.mass:", "-475.0", "greater than zero"]),
        ("body.front.mass=[475]", ["body.front.mass:", "[475.0]", "one finite number"]),
        ("body.front.inertia.xx=0", ["body.front.inertia.xx:", "0.0", "greater than zero"]),
        ("body.front.inertia.xx=-126", ["body.front.inertia.xx:", "-126.0", "greater than zero"]),
        (
            "body.front.inertia.xx=300",
            ["body.front.inertia:", "xx = 300", "yy = 132", "sum of the other two"],
        ),
        ("suspension.front.unsprung.inertia.yy=9", ["unsprung.inertia:", "yy = 9", "sum of the other two"]),
        ("tyre.front.stiffness.z=-1", ["tyre.front.stiffness.z:", "-1.0", "zero or greater"]),
        ("suspension.front.damper.velocity=[-1, 0, 0, 1, 2]", ["damper.velocity:", "strictly increasing"]),
        (
            "suspension.front.damper.velocity=[2, 1, 0, -1, -2] mm/s",
            ["damper.velocity:", "strictly increasing"],
        ),
        ("suspension.front.damper.velocity=[-1, 0, nan, 1, 2]", ["damper.velocity:", "nan", "finite"]),
        ("suspension.front.damper.velocity=[-1, 0, 1]", ["damper.force:", "5 values", "has: 3"]),
        ("suspension.front.damper.velocity=1", ["damper.velocity:", "1.0", "a list"]),
    ],
)
def test_a_wrong_override_is_refused(refused, assignment, told):
    message = refused("modes", "--set", assignment)
    assert all(each in message for each in ("--set: ", *told))


def test_two_values_for_one_parameter_are_refused(refused):
    message = refused("modes", "--set", "gravity=9.8", "--set", "gravity=1.6")
    assert all(each in message for each in ("--set", "gravity", "'9.8'", "'1.6'"))


MASS = 'mass = { value = 475, unit = "kg", description = "mass of the front body section", '
SOURCE = 'source = "Liu 2016, table 1, assumed" }'


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('model = "full_car"', "", ["model:", "nothing", "full_car"]),
        ('model = "full_car"', 'model = "lorry"', ["model:", "'lorry'", "full_car"]),
        ('model = "full_car"', 'model = "half_car"', ["unknown"]),
        ('model = "full_car"', "model = ", ["not TOML", "line 14"]),
        (MASS + SOURCE, "", ["body.front.mass:", "nothing", "kg"]),
        (MASS, MASS.replace("mass =", "masse ="), ["body.front.masse:", "unknown", "body.front.mass"]),
        (MASS, MASS.replace('unit = "kg", ', ""), ["body.front.mass.unit:", "nothing"]),
        (MASS, MASS.replace("unit", "units"), ["body.front.mass.units:", "unknown", "unit"]),
        (MASS, MASS.replace("value = 475, ", ""), ["body.front.mass.value:", "nothing"]),
        (f", {SOURCE}", " }", [".source:", "nothing"]),
        (MASS, MASS.replace('"kg"', '"m"'), ["body.front.mass:", "'m'", "kg"]),
        (MASS, MASS.replace('"kg"', '"kgs!"'), ["body.front.mass:", "'kgs!'", "kg"]),
        (MASS, MASS.replace("475", '"475"'), ["body.front.mass:", "'475'", "number"]),
        (MASS, MASS.replace("475", "true"), ["body.front.mass:", "True", "number"]),
        (MASS, MASS.replace("475", "nan"), ["body.front.mass:", "nan", "finite"]),
        (MASS, MASS.replace("475", "inf"), ["body.front.mass:", "inf", "finite"]),
        (MASS, MASS.replace("475", "1" + 400 * "0"), ["body.front.mass:", "finite"]),
        (MASS, MASS.replace("475", "0"), ["body.front.mass:", "0 kg", "greater than zero"]),
        (MASS, MASS.replace("475", "-475"), ["body.front.mass:", "-475 kg", "greater than zero"]),
        (
            "xx = { value = 126",
            "xx = { value = -126",
            ["body.front.inertia.xx:", "-126", "greater than zero"],
        ),
        (
            "xx = { value = 126",
            "xx = { value = 0",
            ["body.front.inertia.xx:", "0 kg*m^2", "greater than zero"],
        ),
        ("xx = { value = 126", "xx = { value = 265", ["body.front.inertia:", "265", "sum of the other two"]),
        ("-1000, -150, 0", "-1000, 0, 0", ["suspension.front.damper.velocity:", "strictly increasing"]),
        ("-1000, -150, 0", "-1000, 0", ["suspension.front.damper.force:", "5 values", "has: 4"]),
    ],
)
def test_a_wrong_file_is_refused(refused, tmp_path, old, new, told):
    assert old in SEDAN
    file = tmp_path / "wrong.toml"
    file.write_text(SEDAN.replace(old, new, 1), encoding="utf-8")
    message = refused("modes", str(file))
    assert all(each in message for each in (str(file), *told))


@pytest.mark.parametrize("contents", [b"", b"\xff\xfe", b"\x00", b"[" * 5000, b"model = 1\ndescription = 2"])
def test_files_that_are_no_vehicles_are_refused(refused, tmp_path, contents):
    file = tmp_path / "odd.toml"
    file.write_bytes(contents)
    assert str(file) in refused("parameters", str(file))


def test_folders_are_no_vehicles(refused, tmp_path):
    assert str(tmp_path) in refused("parameters", str(tmp_path))


# Wrong arguments of tests and files


@pytest.mark.parametrize(
    ("option", "value", "told"),
    [
        ("--frequency", "nan", ["nan", "finite"]),
        ("--frequency", "inf", ["inf", "finite"]),
        ("--frequency", "0", ["0.0", "greater than zero"]),
        ("--frequency", "-3", ["-3.0", "greater than zero"]),
        ("--frequency", "fast", ["'fast'", "Hz"]),
        ("--frequency", "", ["''", "Hz"]),
        ("--frequency", "[1, 2]", ["[1.0, 2.0]", "one finite number"]),
        ("--frequency", "3 m", ["'m'", "Hz"]),
        ("--frequency", "3 rad/s", ["'3 rad/s'", "Hz"]),
        ("--frequency", "180 rpm", ["'180 rpm'", "Hz"]),
        ("--frequency", "3 1/s", ["'3 1/s'", "Hz"]),
        ("--frequency", "3 rad*s^-1", ["'3 rad*s^-1'", "Hz"]),
        ("--frequency", "3 rad*Hz", ["'3 rad*Hz'", "Hz"]),
        ("--amplitude", "25 kg", ["'kg'", "m"]),
        ("--amplitude", "0", ["0.0 m", "greater than zero"]),
        ("--amplitude", "-25 mm", ["-25.0 mm", "greater than zero"]),
        ("--amplitude", "nan mm", ["nan mm", "finite"]),
        ("--lag", "inf", ["inf", "finite"]),
        ("--lag", "0.2 m", ["'m'", "s"]),
        ("--tolerance", "0", ["0.0", "greater than zero"]),
        ("--tolerance", "1 mm", ["'mm'", "1"]),
    ],
)
def test_wrong_settings_of_a_test_are_refused(refused, option, value, told):
    message = refused("test", "lateral", option, value)
    assert all(each in message for each in (option, *told))


@pytest.mark.parametrize(
    ("test", "vehicle", "told"),
    [
        ("lateral", "quarter_car", ["quarter_car", "road", "front_left_pad_y"]),
        ("vertical", "half_car", ["half_car", "front_road, rear_road", "front_left_pad_z"]),
        ("heave", "torsion_chain", ["torsion_chain", "none", "front_left_pad_z"]),
    ],
)
def test_a_vehicle_without_the_inputs_of_a_test_is_refused(refused, test, vehicle, told):
    message = refused("test", test, vehicle)
    assert all(each in message for each in (f"{test} test", *told))


def test_axes_along_which_nothing_is_measured_are_refused(refused):
    message = refused("test", "heave", "half_car", "--axes", "body")
    assert all(each in message for each in ("--axes", "'body'", "ground"))


def test_files_that_cannot_be_written_are_refused(refused, tmp_path):
    (tmp_path / "folder.mat").mkdir()
    (tmp_path / "file").touch()
    assert all(each in refused("export", "plant.csv") for each in ("'plant.csv'", ".mat"))
    for path in (tmp_path / "missing" / "a.mat", tmp_path / "folder.mat", tmp_path / "file" / "a.mat"):
        assert repr(str(path)) in refused("export", str(path))
    for path in (tmp_path / "file", tmp_path / "file" / "report"):
        assert all(each in refused("study", "-o", str(path)) for each in ("--output", repr(str(path))))
    assert "--output" in refused("study", "-o", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.mat"]


def test_a_study_of_another_model_is_refused(refused, tmp_path):
    message = refused("study", "quarter_car", "-o", str(tmp_path / "report"))
    assert all(each in message for each in ("'quarter_car'", "'full_car'"))
    assert not (tmp_path / "report").exists()


def test_a_car_that_cannot_stand_is_refused(run):
    status, out, err = run(
        "modes", "--set", "suspension.front.wheel_centre.y=1364 mm"
    )  # above the arm's pivot
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "no preload holds the design position" in err


# Other endings


def test_a_motion_that_is_not_found_is_one_line_and_status_1(run):
    status, out, err = run("test", "vertical", "--amplitude", "50 m")
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert "smaller amplitude" in err


def test_an_interrupt_is_one_line_and_status_130(run, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("chassym.derivation.load_model", interrupted)
    assert run("modes") == (130, "", "chassym: interrupted\n")


def test_errors_of_the_program_itself_are_not_hidden(run, monkeypatch):
    def broken(*_, **__):
        raise ValueError("a mistake")

    monkeypatch.setattr("chassym.derivation.load_model", broken)
    with pytest.raises(ValueError, match="a mistake"):
        run("modes")


@pytest.mark.parametrize("words", [["parameters"], ["parameters", "torsion_chain", "--json"], ["--help"]])
def test_a_reader_that_has_seen_enough_is_no_error(words):
    process = subprocess.Popen([*PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    assert process.stderr.read() == b""
    process.wait(timeout=60)
    process.stderr.close()


def test_refusals_of_a_process():
    done = subprocess.run([*PROGRAM, "modes", "--set", "body.front.mass=-1"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(
        r"chassym: --set: body\.front\.mass: received -1\.0 kg, expected .* greater than zero.*\n",
        done.stderr,
    )


def test_output_in_a_pipe_is_plain_and_survives_a_poor_encoding():
    words = ["test", "heave", "quarter_car"]
    environment = {"PYTHONIOENCODING": "ascii", "COLUMNS": "80"}
    done = subprocess.run([*PROGRAM, *words], capture_output=True, env=os.environ | environment)
    assert (done.returncode, done.stderr) == (0, b"")
    assert not re.search(rb"[\x1b\r]", done.stdout)
    assert done.stdout.isascii()


def test_help_imports_nothing_that_takes_long():
    heavy = ("numpy", "scipy", "sympy", "control", "matplotlib", "pint", "xarray")
    code = f"""
import sys
from chassym.cli import main
status = main(["--help"])
found = [name for name in {heavy} if name in sys.modules]
sys.exit(status or ", ".join(found) or 0)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert all(command in done.stdout for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(run, command):
    status, out, err = run(command, "--help")
    assert (status, err) == (0, "")
    assert f"chassym {command}" in out


# Answers


@pytest.mark.parametrize("vehicle", vehicle_names())
def test_parameters_as_json(answer, vehicle):
    parameters = load_model(vehicle).parameters
    found = answer("parameters", vehicle)
    assert list(found) == list(parameters)
    for name, fields in found.items():
        assert list(fields) == ["value", "unit", "description", "source", "reading"]
        assert np.array_equal(fields["value"], parameters[name].value)
        assert fields["unit"] == parameters[name].unit


def test_overrides_are_told_as_their_source(answer):
    found = answer(
        "parameters", "--set", "body.front.torsional_stiffness=200 N*m/deg", "--set", "gravity=1.62"
    )
    assert math.isclose(found["body.front.torsional_stiffness"]["value"], 200 * 180 / math.pi)
    assert found["gravity"]["value"] == 1.62
    assert [name for name, fields in found.items() if fields["source"] == "--set"] == [
        "gravity",
        "body.front.torsional_stiffness",
    ]


def test_a_file_is_a_vehicle(answer, tmp_path):
    (tmp_path / "own.toml").write_text(SEDAN.replace("value = 9.81", "value = 9.80665"), encoding="utf-8")
    assert answer("parameters", str(tmp_path / "own.toml"))["gravity"]["value"] == 9.80665


def test_parameters_fit_80_columns_with_their_names_whole_and_their_readings(run):
    status, out, err = run("parameters")
    assert (status, err) == (0, "")
    parameters = load_model("sedan").parameters
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    for name, parameter in parameters.items():
        (line,) = (each for each in lines if each.startswith(f"{name} "))
        assert parameter.unit in line
        assert line.rstrip().endswith("*") == bool(parameter.reading)
    flowing = " ".join(out.split())
    assert all(" ".join(each.reading.split()) in flowing for each in parameters.values())


def test_equations_as_json(answer):
    found = answer("equations", "quarter_car")
    operations = load_model("quarter_car").equations.operations
    assert found.pop("derivation_s") > 0
    assert found == {"degrees_of_freedom": 2, "operations": operations}


def test_equations_of_small_models_are_written_out(run):
    status, out, err = run("equations", "quarter_car")
    assert (status, err) == (0, "")
    body, wheel = (coordinate.name for coordinate in load_model("quarter_car").system.coordinates)
    assert f"M[{wheel}, {wheel}] = unsprung.mass\n" in out
    assert f"f[{body}] = F_damper + F_spring - gravity*sprung.mass\n" in out
    assert max(map(len, out.splitlines())) <= 80


def test_equations_of_large_models_are_not(run):
    status, out, err = run("equations")
    assert (status, err) == (0, "")
    assert "M[" not in out
    assert max(map(len, out.splitlines())) <= 80


def test_modes_as_json(answer):
    found = answer("modes", "torsion_chain", "--set", "damping.front=0", "--set", "damping.rear=0")
    parameters = load_model("torsion_chain").parameters
    first = math.sqrt(parameters.value("stiffness.front") / parameters.value("inertia.front")) / (2 * math.pi)
    assert found["undamped_frequencies_hz"] == pytest.approx([0, first, math.sqrt(3) * first], abs=1e-6)
    assert [mode["frequency_hz"] for mode in found["modes"]] == pytest.approx(
        [0, first, math.sqrt(3) * first], abs=1e-6
    )
    assert all(list(mode)[:3] == ["frequency_hz", "damping_ratio", "name"] for mode in found["modes"])
    assert found["damper_slope_rule"] is None


def test_modes_state_the_rule_for_the_slope_of_dampers(answer, run):
    found = answer("modes", "quarter_car")
    assert found["damper_slope_rule"] == "mean_slope"
    status, out, err = run("modes", "quarter_car")
    assert (status, err) == (0, "")
    assert "mean_slope" in out
    assert all(f"{mode['frequency_hz']:.3f}" in out and mode["name"] in out for mode in found["modes"])


def expected(model: Model, excitation: Harmonic, prefix: str = "") -> dict[str, float]:
    """Peak-to-peak values by name, asked for without the command line."""
    state = steady_state(model, excitation, metrics=[prefix + name for name in METRICS])
    return {name.removeprefix(prefix): metric.value for name, metric in state.peak_to_peak.items()}


@pytest.mark.parametrize(
    ("words", "excitation", "prefix"),
    [
        (["lateral"], rig.lateral(), ""),
        (["vertical", "--axes", "body"], rig.vertical(), "body_axes_"),
        (
            ["lateral", "--frequency", "2e-3kHz", "--amplitude", "25 mm", "--lag", "100 ms"],
            rig.lateral(2.0, 0.025, 0.1),
            "",
        ),
        (["heave", "sedan", "--frequency", "9.5", "--amplitude", "0.005"], rig.heave(9.5, 0.005), ""),
    ],
)
def test_tests_as_json(answer, sedan, words, excitation, prefix):
    found = answer("test", *words)
    assert set(found) == {
        *("test", "metrics", "minimum_patch_force", "converged", "stable"),
        *("frequency_hz", "method", "unknowns", "iterations", "lost_contact"),
        *("vehicle", "amplitude", "amplitude_unit", "rear_lag_s", "body", "tyres", "tolerance"),
    }
    assert (found["vehicle"], found["body"], found["tyres"]) == ("full_car", "free", "bonded")
    assert (found["test"], found["frequency_hz"]) == (words[0], excitation.frequency_hz)
    assert (found["converged"], found["stable"]) == (True, True)
    values = {name: metric["peak_to_peak"] for name, metric in found["metrics"].items()}
    assert values == pytest.approx(expected(sedan, excitation, prefix), rel=1e-9, abs=1e-9)
    assert {name: metric["unit"] for name, metric in found["metrics"].items()} == METRICS
    assert all(0 < metric["error"] < 1e-2 for metric in found["metrics"].values())
    force = found["minimum_patch_force"]
    assert set(force) == {"value", "unit", "patch", "error"}
    assert force["unit"] == "N"
    assert force["patch"] in rig.CORNERS
    assert 0 < force["value"] < 6000


def test_a_smaller_tolerance_makes_smaller_errors(answer):
    rough, fine = (answer("test", "heave", "quarter_car", "--tolerance", each) for each in ("1e-2", "1e-5"))
    (rough_metric,), (fine_metric,) = rough["metrics"].values(), fine["metrics"].values()
    assert fine_metric["error"] <= 1e-5 * fine_metric["peak_to_peak"]
    assert abs(rough_metric["peak_to_peak"] - fine_metric["peak_to_peak"]) <= rough_metric["error"]


def test_heave_moves_roads_too_the_rear_one_later(answer, half_car):
    found = answer("test", "heave", "half_car", "--amplitude", "5 mm", "--lag", "0.1", "--frequency", "2")
    roads = Harmonic(2.0, {"front_road": 0.005, "rear_road": 0.005 * np.exp(-2j * np.pi * 2.0 * 0.1)})
    state = steady_state(half_car, roads)
    values = {name: metric["peak_to_peak"] for name, metric in found["metrics"].items()}
    assert values == pytest.approx({name: metric.value for name, metric in state.peak_to_peak.items()})
    assert set(values) == {"vertical_acceleration", "pitch_rate"}
    assert found["minimum_patch_force"]["patch"] in ("front", "rear")


def test_a_test_as_a_table(run):
    status, out, err = run("test", "lateral")
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert all(name.replace("_", " ") in out for name in METRICS)
    assert "±" in out
    assert "patch force" in out
    assert "WARNING" not in out


def test_lost_contact_is_told(answer, run):
    words = ["test", "heave", "half_car", "--amplitude", "50 mm", "--frequency", "6"]
    force = answer(*words)["minimum_patch_force"]
    assert force["value"] < 0
    status, out, _ = run(*words)
    assert status == 0
    assert f"WARNING: contact would have been lost at {force['patch']}" in out


def test_instability_is_told(answer, run):
    words = ["test", "heave", "quarter_car", "--set", "damper.force=[2000, 300, 0, -200, -2000]"]
    assert answer(*words)["stable"] is False
    status, out, _ = run(*words)
    assert status == 0
    assert "WARNING: unstable" in out


def test_export_holds_the_modes(run, answer, tmp_path):
    path = tmp_path / "plant.mat"
    status, out, err = run("export", str(path), "quarter_car", "--set", "sprung.mass=400")
    assert (status, err) == (0, "")
    assert "plant.mat" in out
    assert "mean_slope" in out
    plant = loadmat(path, simplify_cells=True)["plant"]
    frequencies = sorted(np.abs(np.linalg.eigvals(plant["A"])) / (2 * np.pi))[::2]
    modes = answer("modes", "quarter_car", "--set", "sprung.mass=400")["modes"]
    assert [mode["frequency_hz"] for mode in modes] == pytest.approx(frequencies)


# The study, without its work


@pytest.fixture
def quick_study(monkeypatch):
    """Put a study in place that announces itself and finds one thing."""
    found = Comparison(
        *("tests", "lateral acceleration", "m/s^2", "6.2 to 6.4", 6.2, 6.4),
        *(5.71827, 0.0002, -0.0777, "outside by 7.77 % (below)", "section 3.1"),
    )
    many = [
        Comparison(*("trend", "a", "%", "increases", 0, 0, 1, 0, 0), verdict, "")
        for verdict in 9 * ["differs"]
    ]

    def run_study(model, progress):
        progress("an announcement", 0.5)
        return SimpleNamespace(comparisons=(found, *many))

    def write_report(results, folder):
        folder.mkdir()
        (folder / "report.html").touch()
        return folder / "report.html"

    monkeypatch.setattr(study_module, "run_study", run_study)
    monkeypatch.setattr("chassym.report.write_report", write_report)


def test_a_study_tells_what_it_found_and_where(run, quick_study, tmp_path):
    status, out, err = run("study", "-o", str(tmp_path / "report"))
    assert (status, err) == (0, "")
    flowing = " ".join(out.split())
    assert all(each in flowing for each in ("6.2 to 6.4", "5.7183 ± 0.0002", "trend: 0 of 9"))
    assert str(tmp_path / "report" / "report.html") in out.replace("\n", "")
    assert not re.search(r"[\x1b\r]|announcement", out)


def test_the_progress_of_a_study_shows_on_terminals(run, quick_study, tmp_path, monkeypatch):
    terminal = io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", terminal)
    status, out, _ = run("study", "-o", str(tmp_path / "report"))
    assert status == 0
    assert "announcement" in terminal.getvalue()
    assert "announcement" not in out
