"""Rig tests as data: patterns of the pads, lags, kinds of amplitude, and files that are refused."""

from pathlib import Path

import numpy as np
import pytest

from chassym.derivation import Model, ParameterError, load_model
from chassym.nonlinear import ExcitationError, Harmonic
from chassym.nonlinear.rig import CORNERS, RigTest, load_rig_test, rig_test_names

WALSH = {"heave": (1, 1, 1, 1), "pitch": (1, 1, -1, -1), "roll": (1, -1, 1, -1), "warp": (1, -1, -1, 1)}

OWN = """
name = "own"
description = "one pad"
source = "own"
frequency = "2 Hz"

[[motion]]
pads = "front_left"
direction = "vertical"
amplitude = "25 mm"
"""


@pytest.fixture
def own(tmp_path: Path):
    """Give a way to load a file with the text of `OWN`, something replaced."""

    def load(old: str = "", new: str = "", more: str = "") -> RigTest:
        assert old in OWN
        file = tmp_path / "own.toml"
        file.write_text(OWN.replace(old, new, 1) + more, encoding="utf-8")
        return load_rig_test(file)

    return load


def vertical(test: RigTest) -> np.ndarray:
    """Complex amplitudes of the vertical pads in the order of the corners."""
    amplitudes = test.harmonic().amplitudes
    assert set(amplitudes) <= {f"{corner}_pad_z" for corner in CORNERS}
    return np.array([amplitudes.get(f"{corner}_pad_z", 0) for corner in CORNERS])


# What the built-in tests do


@pytest.mark.parametrize("name", WALSH)
def test_the_pads_move_in_the_pattern_of_the_name(name: str) -> None:
    test = load_rig_test(name)
    assert np.array_equal(vertical(test) / test.amplitude, WALSH[name])


def test_heave_pitch_roll_and_warp_are_orthogonal_and_complete() -> None:
    patterns = np.array([vertical(load_rig_test(name)) / load_rig_test(name).amplitude for name in WALSH])
    assert np.array_equal(patterns.conj() @ patterns.T, 4 * np.eye(4))


def test_the_vertical_test_of_the_thesis_is_warp_with_25_mm_at_3_hz() -> None:
    warp, thesis = load_rig_test("warp"), load_rig_test("vertical")
    assert thesis.harmonic() == warp.harmonic()
    assert (thesis.harmonic().frequency_hz, thesis.amplitude) == (3.0, 0.025)


def test_the_lateral_test_is_six_tenths_of_gravity_at_3_hz_and_the_rear_is_later() -> None:
    test = load_rig_test("lateral")
    found = test.harmonic()
    assert set(found.amplitudes) == {f"{corner}_pad_y" for corner in CORNERS}
    for corner in CORNERS:
        delay = np.exp(-6j * np.pi * 0.2) if corner.startswith("rear") else 1
        acceleration = found.amplitudes[f"{corner}_pad_y"] * (6 * np.pi) ** 2
        assert acceleration == pytest.approx(0.6 * 9.81 * delay, rel=1e-12)


@pytest.mark.parametrize("frequency", [0.7, 3.0, 11.0])
@pytest.mark.parametrize("lag", [-0.05, 0.13])
def test_a_lag_is_the_same_motion_later(frequency: float, lag: float) -> None:
    early, late = (
        load_rig_test("heave").with_rear_lag(each).harmonic(frequency_hz=frequency) for each in (0, lag)
    )
    times = np.linspace(0, 2, 37)

    def motion(excitation: Harmonic, time: np.ndarray) -> np.ndarray:
        turning = np.exp(1j * excitation.angular_frequency * time)
        return np.real(excitation.amplitudes["rear_left_pad_z"] * turning)

    assert motion(late, times) == pytest.approx(motion(early, times - lag), abs=1e-14)
    assert late.amplitudes["front_left_pad_z"] == early.amplitudes["front_left_pad_z"]


def test_the_sweeps_of_the_thesis() -> None:
    heave, lateral = load_rig_test("heave_sweep"), load_rig_test("lateral_sweep")
    assert heave.frequencies_hz == tuple(np.arange(1, 31) / 2)
    assert set(heave.harmonic().amplitudes.values()) == {0.01}
    for frequency in (lateral.frequencies_hz[0], 3.0, lateral.frequencies_hz[-1]):
        found = lateral.harmonic(frequency_hz=frequency)
        acceleration = np.array([*found.amplitudes.values()]) * found.angular_frequency**2
        assert acceleration == pytest.approx(0.03 * 9.81 * np.ones(4), rel=1e-12)


@pytest.mark.parametrize("name", rig_test_names())
def test_every_built_in_test_has_the_name_of_its_file_and_moves_something(name: str) -> None:
    test = load_rig_test(name)
    assert test.name == name
    assert all(test.harmonic().amplitudes.values())


# What a file may say


@pytest.mark.parametrize(
    ("given", "order"), [("0.1 m/s", 1), ("10 cm/s", 1), ("100 mm/s^2", 2), ("100 mm", 0)]
)
def test_the_unit_of_an_amplitude_says_what_is_constant(own, given: str, order: int) -> None:
    test = own("25 mm", given)
    for frequency in (1.0, 4.0):
        (moved,) = test.harmonic(frequency_hz=frequency).amplitudes.values()
        assert moved * (2 * np.pi * frequency) ** order == pytest.approx(0.1)


def test_a_phase_leads_and_a_lag_delays(own) -> None:
    leading = own('amplitude = "25 mm"', 'amplitude = "25 mm"\nphase = "90 deg"')
    late = own('amplitude = "25 mm"', 'amplitude = "25 mm"\nlag = "125 ms"')
    assert leading.harmonic().amplitudes["front_left_pad_z"] == pytest.approx(0.025j)
    assert late.harmonic().amplitudes["front_left_pad_z"] == pytest.approx(-0.025j)


def test_motions_of_the_same_pad_add_up(own) -> None:
    more = '[[motion]]\npads = ["all"]\ndirection = "vertical"\namplitude = "-10 mm"\n'
    assert vertical(own(more=more)) == pytest.approx([0.015, -0.01, -0.01, -0.01])


def test_a_pad_may_move_in_two_directions(own) -> None:
    more = '[[motion]]\npads = ["front_left"]\ndirection = "lateral"\namplitude = "3 mm"\n'
    assert own(more=more).harmonic().amplitudes == {"front_left_pad_z": 0.025, "front_left_pad_y": 0.003}


def test_a_larger_amplitude_keeps_proportions_and_may_be_of_another_kind(own) -> None:
    more = '[[motion]]\npads = ["rear"]\ndirection = "vertical"\namplitude = "-50 mm"\n'
    assert vertical(own(more=more).with_amplitude(0.1)) == pytest.approx([0.05, 0, -0.1, -0.1])
    faster = own(more=more).with_amplitude(0.1, "m/s")
    assert vertical(faster) * 4 * np.pi == pytest.approx([0.05, 0, -0.1, -0.1])


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ('"[1, 2, 4.5] Hz"', (1, 2, 4.5)),
        ('{ from = "1 Hz", to = "2 Hz", step = "0.5 Hz" }', (1, 1.5, 2)),
        ('{ from = "0.1 Hz", to = "0.7 Hz", step = "0.1 Hz" }', (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)),
        ('{ from = "1 Hz", to = "2 Hz", step = "0.3 Hz" }', (1, 1.3, 1.6, 1.9)),
        ('"2e-3 kHz"', (2,)),
    ],
)
def test_frequencies(own, given: str, expected: tuple[float, ...]) -> None:
    assert own('"2 Hz"', given).frequencies_hz == pytest.approx(expected, rel=1e-12)
    assert own('"2 Hz"', given).is_stepped == (len(expected) > 1)


def test_a_file_extends_a_built_in_test(own) -> None:
    motion = OWN[OWN.index("[[motion]]") :]
    test = own(f'frequency = "2 Hz"\n\n{motion}', 'extends = "lateral"\nfrequency = "2 Hz"\n')
    assert test.name == "own"
    assert test.harmonic() == load_rig_test("lateral").harmonic(frequency_hz=2.0)


MOTION = '[[motion]]\npads = "front_left"'


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('name = "own"', "", ["name:", "nothing"]),
        ('source = "own"', "", ["source:", "nothing"]),
        ('source = "own"', "source = 3", ["source:", "3", "text"]),
        ('description = "one pad"', 'description = " "', ["description:", "text"]),
        ('frequency = "2 Hz"', "", ["frequency:", "nothing"]),
        ("frequency", "frequencies", ["frequencies:", "unknown", "frequency"]),
        ('"2 Hz"', "2", ["frequency:", "2", "'3 Hz'"]),
        ('"2 Hz"', '"2"', ["frequency:", "'2'", "'3 Hz'"]),
        ('"2 Hz"', '"2 rad/s"', ["frequency:", "'2 rad/s'", "Hz"]),
        ('"2 Hz"', '"2 rad*Hz"', ["frequency:", "Hz"]),
        ('"2 Hz"', '"0 Hz"', ["frequency:", "greater than zero"]),
        ('"2 Hz"', '"-2 Hz"', ["frequency:", "greater than zero"]),
        ('"2 Hz"', '"nan Hz"', ["frequency:", "'nan Hz'"]),
        ('"2 Hz"', '"[2, 1] Hz"', ["frequency:", "increasing"]),
        ('"2 Hz"', '"[0, 1] Hz"', ["frequency:", "greater than zero"]),
        ('"2 Hz"', '"[1] Hz"', ["frequency:", "at least 2"]),
        ('"2 Hz"', '{ from = "1 Hz", to = "2 Hz" }', ["frequency.step:", "nothing"]),
        ('"2 Hz"', '{ from = "1 Hz", to = "2 Hz", by = "1 Hz" }', ["frequency.by:", "unknown"]),
        ('"2 Hz"', '{ from = "3 Hz", to = "2 Hz", step = "1 Hz" }', ["frequency.to:", "3 Hz"]),
        ('"2 Hz"', '{ from = "1 Hz", to = "2 Hz", step = "2 Hz" }', ["frequency.step:", "2 to"]),
        ('"2 Hz"', '{ from = "1 Hz", to = "2 Hz", step = "1e-9 Hz" }', ["frequency.step:", "10000"]),
        ('"2 Hz"', '{ from = "1 m", to = "2 Hz", step = "1 Hz" }', ["frequency.from:", "Hz"]),
        (MOTION, "[motion]\npads = 'front_left'", ["motion:", "[[motion]]"]),
        ("[[motion]]", "[[motions]]", ["motions:", "unknown", "motion"]),
        (MOTION, "[[motion]]", ["motion[0].pads:", "nothing"]),
        (MOTION, "[[motion]]\npads = []", ["motion[0].pads:", "names"]),
        ('"vertical"', '"up"', ["motion[0].direction:", "'up'", "vertical"]),
        ("amplitude", "amplitud", ["motion[0].amplitud:", "unknown", "amplitude"]),
        ('"25 mm"', "25", ["motion[0].amplitude:", "25", "'25 mm'"]),
        ('"25 mm"', '"25"', ["motion[0].amplitude:", "'25'", "'25 mm'"]),
        ('"25 mm"', '"25 kg"', ["motion[0].amplitude:", "'25 kg'", "m/s"]),
        ('"25 mm"', '"0 mm"', ["motion[0].amplitude:", "'0 mm'"]),
        ('"25 mm"', '"inf mm"', ["motion[0].amplitude:", "inf"]),
        ('"25 mm"', '"25 mm"\nphase = "3 s"', ["motion[0].phase:", "'s'", "rad"]),
        ('"25 mm"', '"25 mm"\nlag = 3', ["motion[0].lag:", "3", "unit"]),
        ('name = "own"', 'name = "own"\nrear_lag = "3 m"', ["rear_lag:", "'m'", "s"]),
        ('name = "own"', 'name = "own"\nbody = "fixed"', ["body:", "'fixed'", "held"]),
        ('name = "own"', 'name = "own"\ntyres = "glued"', ["tyres:", "'glued'", "lifting"]),
        ('name = "own"', 'name = "own"\nmetrics = "yaw_rate"', ["metrics:", "yaw_rate", "names"]),
        ('name = "own"', 'name = "own"\ntolerance = "1e-3"', ["tolerance:", "'1e-3'", "number"]),
        ('name = "own"', 'name = "own"\ntolerance = 0', ["tolerance:", "0", "from 1e-12 to less than 1"]),
        ('name = "own"', 'name = "own"\nextends = "slalom"', ["extends:", "'slalom'", "lateral"]),
        ('name = "own"', 'name = "own"\nrate = 3', ["rate:", "[[rate]]"]),
        ('name = "own"', 'name = "own"\nname = "twice"', ["not TOML", "line 3"]),
    ],
)
def test_a_wrong_file_is_refused_with_its_name_and_the_key(own, tmp_path, old, new, told) -> None:
    with pytest.raises(ParameterError) as refused:
        own(old, new)
    message = str(refused.value)
    assert all(each in message for each in (str(tmp_path / "own.toml"), *told))
    assert "\n" not in message


@pytest.mark.parametrize(
    "more", ['[[rate]]\nname = "r"\nof = "a"\n', '[[rate]]\nname="r"\nof="a"\nover="b"\nby="c"']
)
def test_a_wrong_rate_is_refused(own, more: str) -> None:
    with pytest.raises(ParameterError, match=r"own\.toml: rate\[0\]\.(over|by): received"):
        own(more=more)


def test_amplitudes_of_different_kinds_are_refused(own) -> None:
    more = '[[motion]]\npads = ["rear"]\ndirection = "vertical"\namplitude = "1 m/s"\n'
    with pytest.raises(ParameterError, match="amplitudes in m, m/s"):
        own(more=more)


@pytest.mark.parametrize("contents", [b"\xff", b"[" * 3000, b""])
def test_files_that_are_no_tests_are_refused(tmp_path: Path, contents: bytes) -> None:
    (tmp_path / "odd.toml").write_bytes(contents)
    with pytest.raises(ParameterError, match=r"odd\.toml"):
        load_rig_test(tmp_path / "odd.toml")


@pytest.mark.parametrize("name", ["diagonal", "", "missing.toml", "a" * 5000, "\x00"])
def test_unknown_tests_are_refused(name: str) -> None:
    with pytest.raises(ParameterError, match="lateral"):
        load_rig_test(name)


# On vehicles


@pytest.mark.parametrize(
    ("test", "vehicle", "expected"),
    [
        ("heave", "quarter_car", {"road": 0.01}),
        ("heave", "half_car", {"front_road": 0.01, "rear_road": 0.01}),
        ("pitch", "half_car", {"front_road": 0.01, "rear_road": -0.01}),
        ("roll", "half_car_roll", {"left_road": 0.01, "right_road": -0.01}),
    ],
)
def test_roads_move_as_pads_do(test: str, vehicle: str, expected: dict[str, float]) -> None:
    assert load_rig_test(test).excitation(load_model(vehicle)).amplitudes == expected


@pytest.mark.parametrize(
    ("test", "vehicle"),
    [
        ("pitch", "quarter_car"),
        ("roll", "half_car"),
        ("warp", "half_car"),
        ("lateral", "ride_model"),
        ("heave", "torsion_chain"),
    ],
)
def test_vehicles_without_the_pads_of_a_test_are_refused(test: str, vehicle: str) -> None:
    model = load_model(vehicle)
    inputs = ", ".join(each.name for each in model.system.inputs) or "none"
    with pytest.raises(ParameterError, match=f"{test} test: vehicle: .*{vehicle}.*{inputs}.*front_left_pad_"):
        load_rig_test(test).excitation(model)


def test_a_vehicle_without_the_outputs_of_a_test_is_refused(quarter_car: Model, own) -> None:
    test = own('name = "own"', 'name = "own"\nmetrics = ["body_displacment"]')
    with pytest.raises(ParameterError, match="'body_displacment'.*quarter_car.*body_displacement"):
        test.mounted(quarter_car)


def test_an_impossible_frequency_is_refused() -> None:
    with pytest.raises(ExcitationError, match="frequency"):
        load_rig_test("heave").harmonic(frequency_hz=-1.0)
