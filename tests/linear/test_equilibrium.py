"""Static equilibrium against closed forms, statics by hand, motions that settle and difference quotients."""

import json
from dataclasses import replace

import numpy as np
import pytest
import sympy
from scipy.linalg import null_space
from scipy.optimize import brentq

from chassym.derivation import (
    Characteristic,
    CombinedPort,
    ForceLaw,
    JointPort,
    Linear,
    Mechanism,
    Model,
    ParameterError,
    Polynomial,
    Unilateral,
    build_model,
    prismatic,
    revolute,
    spherical,
)
from chassym.derivation.table import HELD, SpringTable
from chassym.linear import LinearModel, OperatingPointError, linearise, undamped_modes
from chassym.linear.operating_point import OperatingPoint, position
from chassym.linear.statics.equilibrium import find_equilibrium, hold_position
from chassym.linear.statics.static_stability import find_divergence
from chassym.nonlinear import Harmonic, simulate

GRAVITY = 9.81
MASS, LENGTH = 2.0, 0.5
MOMENT = MASS * GRAVITY * LENGTH
S = sympy.Symbol("s", real=True)
SPRINGS = [f"{axle}_{side}_spring" for axle in ("front", "rear") for side in ("left", "right")]


def slider(law: Characteristic, *, preloaded: bool = False, gravity: float = GRAVITY) -> Model:
    """A mass of 10 kg that slides vertically on a spring."""
    mechanism = Mechanism("slider", gravity)
    mechanism.add_body("block", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=10)
    port = JointPort(mechanism.coordinate("z"))
    mechanism.add_force_element("spring", port, law, preloaded=preloaded)
    return build_model(mechanism, {})


def pendulum(height: float, stiffness: float = 0.0) -> Model:
    """A bob above or below its pivot with a torsion spring, in a wind."""
    mechanism = Mechanism("pendulum", GRAVITY)
    joint, centre = revolute("tilt", "y"), (0, 0, height)
    bob = mechanism.add_body("bob", mechanism.ground, joint, (0, 0, 0), mass=MASS, mass_centre=centre)
    mechanism.add_force_element("spring", JointPort(mechanism.coordinate("tilt")), Linear(stiffness))
    mechanism.add_applied_force("wind", mechanism.point("centre", bob, centre), "x", mechanism.ground)
    return build_model(mechanism, {})


def value(point: OperatingPoint, coordinate: str) -> float:
    return float(point.coordinates[[c.name for c in point.model.system.coordinates].index(coordinate)])


def output(point: OperatingPoint, ending: str) -> dict[str, float]:
    """Outputs at rest whose names end so."""
    values = point.model.outputs(point.arguments[:, None])[:, 0]
    return {n: float(v) for n, v in zip(point.model.output_names, values, strict=True) if n.endswith(ending)}


def heavier(sedan: Model, mass: float) -> dict[str, float]:
    """The sedan's rear section with so much more mass (kg)."""
    return {"body.rear.mass": sedan.values["body.rear.mass"] + mass}


@pytest.fixture(scope="module")
def loaded_sedan(sedan: Model) -> OperatingPoint:
    return find_equilibrium(sedan, changes=heavier(sedan, 200.0))


# Closed forms of one coordinate


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (Linear(1e4), -98.1 / 1e4),
        (Polynomial((1e3, 0, 4e6)), brentq(lambda z: 1e3 * z + 4e6 * z**3 + 98.1, -1, 0, xtol=1e-15)),
        (ForceLaw(150 * sympy.tanh(S / 0.01), S), -0.01 * np.arctanh(98.1 / 150)),
        (SpringTable((-0.1, -0.02, 0, 0.05), (-500, -50, 0, 1000)), -0.02 - 48.1 * 0.08 / 450),
        (SpringTable((-0.1, 0), (-98.1, 0)), -0.1),  # at the table's end, where the slope goes on
        (Unilateral(Linear(1e4)), -98.1 / 1e4),
        (ForceLaw(1e6 * S**3, S), -np.cbrt(98.1 / 1e6)),  # without stiffness where it starts
    ],
)
@pytest.mark.parametrize("start", [0.0, -0.3, 0.3])
def test_a_mass_settles_where_its_spring_carries_it(
    law: Characteristic, expected: float, start: float
) -> None:
    """From 0.3 m above, the one on the unilateral spring falls first."""
    found = find_equilibrium(slider(law), start={"z": start})
    assert value(found, "z") == pytest.approx(expected, rel=1e-9)
    assert found.relative_residual < 1e-10


def test_a_loaded_progressive_spring_gives_its_frequency_there() -> None:
    linear = linearise(find_equilibrium(slider(Polynomial((1e3, 0, 4e6))), loads={"z": -300}))
    z = brentq(lambda z: 1e3 * z + 4e6 * z**3 + 398.1, -1, 0, xtol=1e-15)
    expected = np.sqrt((1e3 + 12e6 * z**2) / 10) / (2 * np.pi)
    np.testing.assert_allclose(undamped_modes(linear).frequencies_hz, [expected], rtol=1e-10)


def test_a_preloaded_support_lifts_as_far_as_the_load_goes() -> None:
    model = slider(Unilateral(Linear(1e4)), preloaded=True)
    assert value(find_equilibrium(model, loads={"z": 90}), "z") == pytest.approx(0.009, rel=1e-12)


@pytest.mark.parametrize("wind", [-30.0, 5.0, 400.0])
def test_a_pendulum_hangs_along_gravity_and_wind(wind: float) -> None:
    """At atan(F / m g), and swings there as under sqrt(g^2 + (F / m)^2)."""
    found = find_equilibrium(pendulum(-LENGTH), inputs={"wind": wind})
    assert value(found, "tilt") == pytest.approx(-np.arctan(wind / (MASS * GRAVITY)), rel=1e-12)
    swing = np.sqrt(np.hypot(GRAVITY, wind / MASS) / LENGTH) / (2 * np.pi)
    np.testing.assert_allclose(undamped_modes(linearise(found)).frequencies_hz, [swing], rtol=1e-12)


# Buckling and falling over


@pytest.mark.parametrize("share", [0.5, 0.99])
def test_beyond_buckling_only_the_tilted_pendulum_rests(share: float) -> None:
    """Upright it needs k > m g l; with less it rests where k tilt = m g l sin(tilt)."""
    model = pendulum(LENGTH, share * MOMENT)
    rate = np.sqrt((1 - share) * GRAVITY / LENGTH)
    with pytest.raises(OperatingPointError, match=f"falls over along 'tilt', e-fold in {1 / rate:.3g} s"):
        find_equilibrium(model)
    tilted = brentq(lambda tilt: share * tilt - np.sin(tilt), 0.1, 3, xtol=1e-15)
    for start in (0.01, 0.2, 2.0):  # from 0.01 least squares alone goes back upright
        assert value(find_equilibrium(model, start={"tilt": start}), "tilt") == pytest.approx(
            tilted, rel=1e-9
        )
        assert value(find_equilibrium(model, start={"tilt": -start}), "tilt") == pytest.approx(-tilted)


def test_a_stiff_spring_keeps_the_pendulum_upright() -> None:
    for share in (1.01, 3.0):
        found = find_equilibrium(pendulum(LENGTH, share * MOMENT), start={"tilt": 0.3})
        assert value(found, "tilt") == pytest.approx(0, abs=1e-9)


def test_a_known_unstable_position_is_linearised() -> None:
    upright = position(pendulum(LENGTH))
    divergence = find_divergence(upright)
    assert divergence is not None
    assert divergence.rate == pytest.approx(np.sqrt(GRAVITY / LENGTH), rel=1e-12)
    np.testing.assert_allclose(linearise(upright).stiffness, [[-MOMENT]])


def ziegler_column() -> Model:
    """Two equal links of 1 m, springs of 1 N m/rad, masses 2 and 1 kg at their tips, a follower force."""
    column = Mechanism("column", gravity=0)
    lower = column.add_body(
        "lower", column.ground, revolute("lean", "y"), (0, 0, 0), mass=2, mass_centre=(0, 0, 1)
    )
    upper = column.add_body("upper", lower, revolute("bend", "y"), (0, 0, 1), mass=1, mass_centre=(0, 0, 2))
    for name in ("lean", "bend"):
        column.add_force_element(f"{name}_spring", JointPort(column.coordinate(name)), Linear(1))
    column.add_applied_force("follower", column.point("tip", upper, (0, 0, 2)), (0, 0, -1), upper)
    return build_model(column, {})


def test_ziegler_s_column_diverges_beyond_its_second_critical_load() -> None:
    """It flutters from 7/2 - sqrt(2) to 7/2 + sqrt(2) k/l and diverges above (Ziegler, Ing.-Arch. 20, 1952).

    Beyond 2 k/l the symmetric part of the stiffness in absolute angles is indefinite, which is no divergence.
    """
    absolute = np.array([[1, 0], [-1, 1]])
    for load, definite in ((1.99, True), (2.01, False)):
        stiffness = absolute.T @ linearise(position(ziegler_column(), inputs={"follower": load})).stiffness
        assert (np.linalg.eigvalsh(stiffness @ absolute + (stiffness @ absolute).T)[0] > 0) == definite
    column = ziegler_column()
    for load in (2.05, 3.5 - 1.4142, 3.5, 3.5 + 1.4142):
        assert find_divergence(find_equilibrium(column, inputs={"follower": load})) is None
    for load in (3.5 + 1.4143, 6.0):
        assert find_divergence(position(column, inputs={"follower": load})) is not None
        with pytest.raises(OperatingPointError, match="falls over"):
            find_equilibrium(column, inputs={"follower": load})


# Vehicles


def test_a_loaded_quarter_car_sinks_on_its_springs_in_series(quarter_car: Model) -> None:
    v = quarter_car.values
    found = find_equilibrium(quarter_car, changes={"sprung.mass": v["sprung.mass"] + 100})
    tyre, spring = 981 / v["tyre.stiffness"], 981 / v["spring.rate"]
    np.testing.assert_allclose(found.coordinates, [-tyre - spring, -tyre], rtol=1e-12)
    mass = np.diag([v["sprung.mass"] + 100, v["unsprung.mass"]])
    k, t = v["spring.rate"], v["tyre.stiffness"]
    squares = np.linalg.eigvals(np.linalg.solve(mass, [[k, -k], [-k, k + t]]))
    expected = np.sort(np.sqrt(squares)) / (2 * np.pi)
    np.testing.assert_allclose(undamped_modes(linearise(found)).frequencies_hz, expected, rtol=1e-12)


def test_a_motion_settles_where_the_equilibrium_is(quarter_car: Model) -> None:
    found = find_equilibrium(quarter_car, changes={"sprung.mass": "450 kg"}, inputs={"road": 0.05})
    # The road cannot be held away from zero in a simulation: its height is added to the start and to the end.
    settled = simulate(found.model, Harmonic(1.0, {}), np.array([0.0, 30.0])).states[:2, -1]
    np.testing.assert_allclose(found.coordinates - 0.05, settled, rtol=1e-9)


@pytest.mark.slow
def test_a_sedan_settles_where_the_equilibrium_is(loaded_sedan: OperatingPoint) -> None:
    """The load does not excite yaw, the least damped mode; the next one decays by exp(-0.8 t)."""
    settled = simulate(loaded_sedan.model, Harmonic(1.0, {}), np.array([0.0, 45.0])).states[:12, -1]
    np.testing.assert_allclose(settled, loaded_sedan.coordinates, atol=1e-9)


def test_patches_of_a_loaded_sedan_carry_its_weight(sedan: Model, loaded_sedan: OperatingPoint) -> None:
    v = loaded_sedan.model.values
    mass = sum(v[f"body.{s}.mass"] for s in ("front", "middle", "rear"))
    mass += 2 * sum(v[f"suspension.{axle}.unsprung.mass"] for axle in ("front", "rear"))
    assert v["body.rear.mass"] == sedan.values["body.rear.mass"] + 200
    forces = output(loaded_sedan, "patch_force_z")
    assert sum(forces.values()) == pytest.approx(mass * GRAVITY, rel=1e-12)
    assert sum(output(loaded_sedan, "patch_force_x").values()) == pytest.approx(0, abs=1e-9)
    assert loaded_sedan.relative_residual < 1e-12 and loaded_sedan.pulling == {}
    assert forces["rear_left_patch_force_z"] == pytest.approx(forces["rear_right_patch_force_z"], rel=1e-12)


def test_a_small_load_lowers_the_car_as_the_linear_model_says(
    sedan: Model, sedan_linear: LinearModel
) -> None:
    """The difference is of second order: a quarter for half the load."""
    stiffness = sedan_linear.stiffness
    at_rest = np.zeros((sedan.argument_count, 1))
    differences = []
    for mass in (20.0, 10.0):
        found = find_equilibrium(sedan, changes=heavier(sedan, mass))
        predicted = -np.linalg.solve(stiffness, found.model.residual(at_rest)[:, 0])
        differences.append(np.linalg.norm(found.coordinates - predicted) / np.linalg.norm(predicted))
    assert differences[0] < 0.01
    assert differences[0] / differences[1] == pytest.approx(2, rel=0.05)


def test_linearised_there_it_is_what_difference_quotients_of_the_residual_say(
    loaded_sedan: OperatingPoint,
) -> None:
    """Richardson's extrapolation of central differences; about a knot they give the mean of both slopes."""
    linear, model = linearise(loaded_sedan), loaded_sedan.model
    exact = np.hstack([linear.stiffness, linear.damping, linear.mass])
    found = []
    for step in (1e-3, 5e-4):
        steps = step * np.eye(model.argument_count)[:, : 3 * model.size]
        there = loaded_sedan.arguments[:, None]
        found.append((model.residual(there + steps) - model.residual(there - steps)) / (2 * step))
    extrapolated = (4 * found[1] - found[0]) / 3
    for block, expected in zip(np.hsplit(extrapolated, 3), np.hsplit(exact, 3), strict=True):
        np.testing.assert_allclose(block, expected, atol=1e-10 * np.abs(expected).max())
    assert np.abs(linear.stiffness - linearise(replace(model, given_preloads=None)).stiffness).max() > 100


def test_patches_of_a_half_car_carry_a_load_where_it_lies(half_car: Model) -> None:
    """Forces and moments about the mass centre, in the deflected geometry.

    Pitch turns z towards x; what is a behind the mass centre and h above lies a cos + h sin behind it.
    """
    v, load, behind = half_car.values, 1500.0, 0.8
    found = find_equilibrium(half_car, loads={"bounce": -load, "pitch": load * behind})
    pitch = value(found, "pitch")
    total = v["body.mass"] * GRAVITY + load
    moment = -load * behind
    for axle in ("front", "rear"):
        a = v[f"axle.{axle}.x"] - v["body.mass_centre.x"]
        h = value(found, f"{axle}_travel") - v["body.mass_centre.z"]
        carried = output(found, "patch_force_z")[f"{axle}_patch_force_z"] - v[f"axle.{axle}.mass"] * GRAVITY
        total -= carried
        moment += carried * (a * np.cos(pitch) + h * np.sin(pitch))
    assert total == pytest.approx(0, abs=1e-8) and moment == pytest.approx(0, abs=1e-8)
    assert 0.001 < abs(pitch) < 0.1


def test_inputs_carry_the_whole_car(sedan: Model) -> None:
    """All pads raised by 30 mm raise the car by 30 mm and strain nothing."""
    pads = {each.name: 0.03 for each in sedan.system.inputs if each.name.endswith("_z")}
    found = find_equilibrium(sedan, inputs=pads)
    np.testing.assert_allclose(found.coordinates, 0.03 * np.eye(12)[2], atol=1e-12)


def test_the_design_position_is_its_own_equilibrium(sedan: Model) -> None:
    np.testing.assert_array_equal(find_equilibrium(sedan).coordinates, np.zeros(12))


def test_no_stiffness_is_no_harm_where_no_force_is(torsion_chain: Model) -> None:
    chain = find_equilibrium(torsion_chain, loads={"front_torsion": 1000})
    assert value(chain, "front_torsion") == pytest.approx(1000 / torsion_chain.values["stiffness.front"])
    assert value(chain, "roll") == 0 and chain.condition == np.inf
    turned = find_equilibrium(torsion_chain, start={"roll": 0.3, "front_torsion": 0.1})
    np.testing.assert_allclose(turned.coordinates, [0.3, 0, 0], atol=1e-12)
    floating = find_equilibrium(slider(Linear(0), gravity=0.0), start={"z": 1.0})
    assert value(floating, "z") == 1 and floating.condition == np.inf


def test_a_stiffness_is_singular_whatever_its_coordinates_are() -> None:
    """Three masses joined by two springs: their absolute displacements hide the free one among rounding."""
    train = Mechanism("train", gravity=0)
    names = ("front", "middle", "rear")
    for name in names:
        train.add_body(f"{name}_car", train.ground, prismatic(name, "x"), (0, 0, 0), mass=1)
    ports = [JointPort(train.coordinate(name)) for name in names]
    for i, stiffness in enumerate((0.7, 1.3e3)):
        stretch = CombinedPort(((ports[i], 1), (ports[i + 1], -1)))
        train.add_force_element(f"spring_{i}", stretch, Linear(stiffness))
    found = find_equilibrium(build_model(train, {}), loads={"front": 2.1, "rear": -2.1})
    stretched = [
        value(found, "front") - value(found, "middle"),
        value(found, "middle") - value(found, "rear"),
    ]
    np.testing.assert_allclose(stretched, [3.0, 2.1 / 1.3e3], rtol=1e-10)
    assert found.condition == np.inf and np.abs(found.coordinates).max() < 4


# Ride height


def test_a_lowered_sedan_stands_where_it_should_with_the_same_weight(sedan: Model) -> None:
    found = hold_position(sedan, {"z": -0.02, "pitch": 0.0, "roll": 0.0}, SPRINGS)
    assert [value(found, name) for name in ("z", "pitch", "roll")] == [-0.02, 0, 0]
    before, after = output(position(sedan), "patch_force_z"), output(found, "patch_force_z")
    assert sum(after.values()) == pytest.approx(sum(before.values()), rel=1e-12)
    change = {n: found.model.preloads[n] - p for n, p in sedan.preloads.items()}
    assert all(change[name] == 0 for name in change if "tyre" in name)
    for axle in ("front", "rear"):
        left, right = (change[f"{axle}_{side}_spring.preload"] for side in ("left", "right"))
        assert left == pytest.approx(right, rel=1e-8) and left < -300
    again = find_equilibrium(found.model)
    np.testing.assert_allclose(again.coordinates, found.coordinates, atol=1e-9)


def test_of_several_preloads_those_change_that_have_to_change_least(sedan: Model) -> None:
    """The change is at right angles to every change of preloads that leaves the height as it is."""
    found = hold_position(sedan, {"z": -0.02}, SPRINGS)
    names = [f"{name}.preload" for name in SPRINGS]
    change = np.array([found.model.preloads[name] - sedan.preloads[name] for name in names])
    moved = [
        replace(
            found, model=replace(found.model, given_preloads={**found.model.preloads, name: 0.0})
        ).residual
        for name in names
    ]
    by_preload = [(found.residual - r) / found.model.preloads[n] for r, n in zip(moved, names, strict=True)]
    free = np.hstack([np.delete(found.stiffness, 2, axis=1), np.transpose(by_preload)])
    scale = np.append(np.full(11, 1e-4), np.full(4, 1.0))
    idle = null_space(free * scale, rcond=1e-10)[11:]
    assert idle.shape == (4, 3)
    assert np.abs(idle.T @ change).max() < 1e-7 * np.linalg.norm(change)


def test_spring_and_tyre_of_a_quarter_car_share_a_change_by_their_compliances(quarter_car: Model) -> None:
    """z = p_s / k - p_t / t = -20 mm has its shortest solution along (1 / k, -1 / t)."""
    found = hold_position(quarter_car, {"body_bounce": -0.02}, ["spring", "tyre"])
    along = np.array([1 / quarter_car.values["spring.rate"], -1 / quarter_car.values["tyre.stiffness"]])
    change = [found.model.preloads[n] - quarter_car.preloads[n] for n in ("spring.preload", "tyre.preload")]
    np.testing.assert_allclose(change, -0.02 * along / (along @ along), rtol=1e-7)


def test_a_levelled_quarter_car_has_its_load_in_the_spring(quarter_car: Model) -> None:
    """The tyre gives way by W / t, which the spring follows: its preload grows by W (1 + k / t)."""
    v = quarter_car.values
    changes = {"sprung.mass": v["sprung.mass"] + 50}
    found = hold_position(quarter_car, {"body_bounce": 0.0}, ["spring"], changes=changes)
    grown = found.model.preloads["spring.preload"] - quarter_car.preloads["spring.preload"]
    assert grown == pytest.approx(490.5 * (1 + v["spring.rate"] / v["tyre.stiffness"]), rel=1e-10)
    assert value(found, "wheel_bounce") == pytest.approx(-490.5 / v["tyre.stiffness"], rel=1e-10)


# What is said of it


def test_it_says_where_it_is_and_how_good(torsion_chain: Model, quarter_car: Model) -> None:
    chain = find_equilibrium(torsion_chain, loads={"front_torsion": 1000})
    assert "under 1000 N m on front_torsion: residual" in str(chain) and "singular" in str(chain)
    told = json.loads(json.dumps(chain.summary, allow_nan=False))
    assert told["loads"]["front_torsion"] == 1000 and told["condition"] is None
    assert told["residual"]["unit"] == "N m" and told["relative_residual"] < 1e-12
    lifted = find_equilibrium(quarter_car, loads={"wheel_bounce": 5000})
    weight = (quarter_car.values["sprung.mass"] + quarter_car.values["unsprung.mass"]) * GRAVITY
    assert lifted.pulling == {"patch_force_z": pytest.approx(weight - 5000)}
    assert "patch_force_z is" in str(lifted) and "a pull" in str(lifted)
    assert "under 5000 N on wheel_bounce" in linearise(lifted).description


@pytest.mark.parametrize(
    ("model", "arguments", "message"),
    [
        (slider(Linear(0)), {}, "98.1 N on 'z' .* is left; lessen the loads"),
        (slider(Unilateral(Linear(1e4)), preloaded=True), {"loads": {"z": 150}}, "51.9 N on 'z'"),
        (slider(SpringTable((-0.1, 0), (-50, 0), outer_slopes=HELD)), {}, "48.1 N on 'z'"),
        (slider(ForceLaw(50 * sympy.tanh(S / 0.01), S)), {}, "48.1 N on 'z'"),
        (slider(ForceLaw(sympy.sqrt(S), S)), {"start": {"z": -1}}, "not finite; check"),
        (slider(Linear(1)), {"loads": {"y": 1}}, "loads: coordinate 'y' is unknown"),
        (slider(Linear(1)), {"start": {"x": 1}}, "start: coordinate 'x' is unknown"),
        (slider(Linear(1)), {"loads": {"z": np.nan}}, "loads: coordinate 'z': nan received"),
        (slider(Linear(1)), {"loads": {"z": "3 N"}}, "loads: coordinate 'z': '3 N' received"),
        (pendulum(1), {"inputs": {"rain": 1}}, "inputs: input 'rain' is unknown; .* wind"),
    ],
)
def test_without_an_equilibrium_it_says_what_is_left(
    model: Model, arguments: dict[str, dict[str, float]], message: str
) -> None:
    with pytest.raises(OperatingPointError, match=message) as error:
        find_equilibrium(model, **arguments)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("moment", [1e3, 1e-6])
def test_a_moment_on_a_free_shaft_is_refused_however_small(torsion_chain: Model, moment: float) -> None:
    with pytest.raises(OperatingPointError, match=f"{moment:.3g} N m on 'roll'".replace("+", "[+]")):
        find_equilibrium(torsion_chain, loads={"roll": moment})
    held = find_equilibrium(torsion_chain, loads={"front_torsion": moment})
    assert value(held, "front_torsion") == pytest.approx(moment / torsion_chain.values["stiffness.front"])


def test_an_equilibrium_at_a_singular_rotation_sequence_is_refused() -> None:
    gimbal = Mechanism("gimbal", gravity=0)
    gimbal.add_body("rotor", gimbal.ground, spherical("zyx"), (0, 0, 0), mass=1, inertia=(1, 2, 3))
    for name in ("yaw", "pitch", "roll"):
        gimbal.add_force_element(f"{name}_spring", JointPort(gimbal.coordinate(name)), Linear(10))
    model = build_model(gimbal, {})
    with pytest.raises(OperatingPointError, match="singularity.*choose another sequence"):
        find_equilibrium(model, loads={"pitch": 5 * np.pi})
    assert value(find_equilibrium(model, loads={"pitch": 4.0}), "pitch") == pytest.approx(0.4)


def test_a_position_that_cannot_be_held_is_refused(half_car: Model) -> None:
    with pytest.raises(OperatingPointError, match="is left; adjust more elements"):
        hold_position(half_car, {"bounce": 0.02, "pitch": 0.0}, ["front_suspension"])
    with pytest.raises(OperatingPointError, match="element 'front_damper' has no preload .* front_"):
        hold_position(half_car, {"bounce": 0.02}, ["front_damper"])
    with pytest.raises(OperatingPointError, match="held: coordinate 'z' is unknown"):
        hold_position(half_car, {"z": 0.02}, ["front_suspension"])
    with pytest.raises(TypeError, match="the string 'front_suspension'"):
        hold_position(half_car, {"bounce": 0.02}, "front_suspension")
    with pytest.raises(ParameterError, match="'body.weight'|body.weight"):
        find_equilibrium(half_car, changes={"body.weight": 3})
