"""Modes: eigenvalue problems solved otherwise, normalisation, rigid bodies, decay and growth, and names."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, eigvals

from chassym.derivation import Model, load_model
from chassym.linear import (
    LinearisationError,
    LinearModel,
    damped_modes,
    energy_shares,
    linearise,
    undamped_modes,
)
from chassym.linear.modal.modes import ModeKind, energy_table
from chassym.linear.modal.motion import dissipation_shares, mode_names, potential_shares

Shares = Callable[[LinearModel, np.ndarray], dict[str, float]]

VEHICLES = ["sedan", "quarter_car", "half_car", "torsion_chain"]

SEDAN_NAMES = {
    "longitudinal",
    "lateral",
    "bounce",
    "yaw",
    "pitch",
    "roll",
    "front wheel hop, in phase",
    "front wheel hop, opposite",
    "rear wheel hop, in phase",
    "rear wheel hop, opposite",
    "body torsion, in phase",
    "body torsion, opposite",
}


@pytest.fixture(params=VEHICLES)
def linear(request: pytest.FixtureRequest) -> LinearModel:
    return linearise(request.getfixturevalue(request.param))


def one_mass(linear: LinearModel, damping: float, stiffness: float) -> LinearModel:
    """Two unit masses, not coupled: one on the given spring and dashpot, one that oscillates at 2 rad/s."""
    return replace(
        linear,
        mass=np.eye(2),
        damping=np.diag([damping, 0.4]),
        stiffness=np.diag([stiffness, 4.0]),
        slopes={},
    )


def test_torsion_chain_has_its_textbook_frequencies(torsion_chain: Model) -> None:
    """Three equal inertias on two equal shafts: 0, sqrt(k / I) and sqrt(3 k / I)."""
    value = torsion_chain.parameters.flat()
    first = np.sqrt(value["stiffness.front"] / value["inertia.front"]) / (2 * np.pi)
    assert first == pytest.approx(31.70, abs=0.01)
    modes = undamped_modes(linearise(torsion_chain))
    assert modes.frequencies_hz[0] == 0.0
    np.testing.assert_allclose(modes.frequencies_hz[1:], [first, np.sqrt(3) * first], rtol=1e-12)
    assert modes.names == ("roll", "body torsion, opposite", "body torsion, in phase")


def test_unequal_torsion_chain_against_absolute_angles(torsion_chain: Model) -> None:
    """Inertia diag(I1, I2, I3), stiffness [[kF, -kF, 0], [-kF, kF + kR, -kR], [0, -kR, kR]]."""
    inertias, front, rear = {"front": 80.0, "middle": 210.0, "rear": 140.0}, 2e6, 7e6
    changes = {f"inertia.{name}": value for name, value in inertias.items()}
    chain = torsion_chain.with_parameters(changes | {"stiffness.front": front, "stiffness.rear": rear})
    stiffness = np.array([[front, -front, 0], [-front, front + rear, -rear], [0, -rear, rear]])
    expected = eigh(stiffness, np.diag(list(inertias.values())), eigvals_only=True)
    found = (2 * np.pi * undamped_modes(linearise(chain)).frequencies_hz) ** 2
    np.testing.assert_allclose(found[1:], expected[1:], rtol=1e-11)
    assert found[0] == 0.0


def test_undamped_modes_are_the_generalised_eigenvectors(linear: LinearModel) -> None:
    modes = undamped_modes(linear)
    squared = (2 * np.pi * modes.frequencies_hz) ** 2
    expected = eigh(linear.stiffness, linear.mass, eigvals_only=True)
    np.testing.assert_allclose(squared, expected, rtol=1e-9, atol=1e-10 * expected[-1])
    left = linear.stiffness @ modes.shapes - linear.mass @ modes.shapes * squared
    np.testing.assert_allclose(left, 0, atol=1e-11 * np.abs(linear.stiffness @ modes.shapes).max())
    identity = modes.shapes.T @ linear.mass @ modes.shapes
    np.testing.assert_allclose(identity, np.eye(len(squared)), atol=1e-12)
    for shape in modes.shapes.T:
        assert shape[np.abs(shape) > (1 - 1e-9) * np.abs(shape).max()][0] > 0


def test_damped_modes_make_the_dynamic_stiffness_singular(linear: LinearModel) -> None:
    for mode in damped_modes(linear):
        terms = [
            mode.eigenvalue**2 * linear.mass @ mode.shape,
            mode.eigenvalue * linear.damping @ mode.shape,
            linear.stiffness @ mode.shape,
        ]
        size = max(np.abs(term).max() for term in terms)
        np.testing.assert_allclose(sum(terms), 0, atol=1e-10 * max(size, 1.0))
        assert (mode.shape.conj() @ linear.mass @ mode.shape).real == pytest.approx(1, rel=1e-12)


def test_damped_modes_are_all_the_eigenvalues(linear: LinearModel) -> None:
    """Against the generalised problem [[0, 1], [-K, -C]] - lambda [[1, 0], [0, M]]."""
    n = len(linear.coordinates)
    zero, one = np.zeros((n, n)), np.eye(n)
    expected = eigvals(
        np.block([[zero, one], [-linear.stiffness, -linear.damping]]),
        np.block([[one, zero], [zero, linear.mass]]),
    )
    expected = expected[np.abs(expected) > 1e-3]
    expected = np.sort_complex(expected[expected.imag >= 0])
    modes = [mode for mode in damped_modes(linear) if mode.frequency_hz > 0]
    np.testing.assert_allclose(np.sort_complex([m.eigenvalue for m in modes]), expected, rtol=1e-8)
    frequencies = [mode.frequency_hz for mode in damped_modes(linear)]
    assert frequencies == sorted(frequencies)
    for mode in modes:
        assert mode.frequency_hz == pytest.approx(abs(mode.eigenvalue) / (2 * np.pi), rel=1e-14)
        assert mode.damping_ratio == pytest.approx(-mode.eigenvalue.real / abs(mode.eigenvalue), rel=1e-14)


def test_free_flight_is_one_mode_of_frequency_zero(
    quarter_linear: LinearModel, chain_linear: LinearModel
) -> None:
    for linear in (one_mass(quarter_linear, damping=0.0, stiffness=0.0), chain_linear):
        rigid, *others = damped_modes(linear)
        assert (rigid.frequency_hz, rigid.damping_ratio, rigid.eigenvalue) == (0.0, 0.0, 0j)
        assert all(mode.frequency_hz > 0.1 for mode in others)
        assert len(others) == len(linear.coordinates) - 1


def test_drag_without_a_spring_is_a_rest_and_a_decay(quarter_linear: LinearModel) -> None:
    rest, decay, oscillation = damped_modes(one_mass(quarter_linear, damping=0.5, stiffness=0.0))
    assert rest.eigenvalue == 0
    assert decay.eigenvalue == pytest.approx(-0.5) and decay.damping_ratio == pytest.approx(1.0)
    assert oscillation.damping_ratio == pytest.approx(0.1)


def test_an_unstable_position(quarter_linear: LinearModel) -> None:
    falling = one_mass(quarter_linear, damping=0.0, stiffness=-9.0)
    with pytest.raises(LinearisationError, match="falls over in 'bounce'") as error:
        undamped_modes(falling)
    assert "\n" not in str(error.value)
    growth = {round(mode.eigenvalue.real, 9): mode.damping_ratio for mode in damped_modes(falling)}
    assert growth[3.0] == pytest.approx(-1.0) and growth[-3.0] == pytest.approx(1.0)


@pytest.mark.parametrize("follower", [0.3, 0.49, 0.8])
def test_forces_without_a_potential(quarter_linear: LinearModel, follower: float) -> None:
    """K = [[1, p], [-p, 2]]: -l^2 = 1.5 -+ sqrt(0.25 - p^2); above p = 0.5 an oscillation grows."""
    stiffness = np.array([[1.0, follower], [-follower, 2.0]])
    skew = replace(one_mass(quarter_linear, 0.0, 1.0), stiffness=stiffness, damping=np.zeros((2, 2)))
    with pytest.raises(LinearisationError, match="not symmetric.*use damped_modes"):
        undamped_modes(skew)
    modes = damped_modes(skew)
    split = np.sqrt(0.25 - follower**2 + 0j)
    expected = [1j * np.sqrt(1.5 - split), 1j * np.sqrt(1.5 + split)]
    found = [mode.eigenvalue for mode in modes]
    for value in expected:
        upper = value if value.imag > 0 else -value
        assert min(abs(other - upper) for other in found) < 1e-9
    assert (ModeKind.GROWING_OSCILLATION in {mode.kind for mode in modes}) == (follower > 0.5)


def test_thrust_that_follows_a_free_body(quarter_linear: LinearModel) -> None:
    """y'' = f a, a'' = 0: the eigenvalue zero four times and one shape, to which the engine may be turned."""
    free = replace(
        one_mass(quarter_linear, 0.0, 0.0),
        stiffness=np.array([[0.0, -9.0], [0.0, 0.0]]),
        damping=np.zeros((2, 2)),
        coordinates=("shift", "angle"),
    )
    (rigid,) = damped_modes(free)
    assert rigid.kind == "rigid body"
    np.testing.assert_allclose(np.abs(rigid.shape), [1, 0], atol=1e-12)


def test_an_undamped_model_has_the_same_modes_either_way(sedan_linear: LinearModel) -> None:
    conservative = replace(sedan_linear, damping=np.zeros((12, 12)))
    modes, undamped = damped_modes(conservative), undamped_modes(sedan_linear)
    np.testing.assert_allclose([mode.frequency_hz for mode in modes], undamped.frequencies_hz, rtol=1e-9)
    np.testing.assert_allclose([mode.damping_ratio for mode in modes], 0, atol=1e-10)
    for mode, other in zip(modes, undamped.modes, strict=True):
        assert mode.kind == other.kind == "oscillation" and mode.name == other.name
        np.testing.assert_allclose(mode.shape, other.shape, atol=1e-6)


def test_what_a_mode_does(quarter_linear: LinearModel) -> None:
    """The signs of damping and stiffness tell."""
    cases = {
        (0.4, 4.0): {"oscillation"},
        (5.0, 4.0): {"decay"},
        (0.5, 0.0): {"rigid body", "decay"},
        (0.0, -9.0): {"divergence", "decay"},
        (-0.4, 9.0): {"growing oscillation"},
        (0.0, 0.0): {"rigid body"},
    }
    for (damping, stiffness), kinds in cases.items():
        linear = one_mass(quarter_linear, damping, stiffness)
        found = [mode for mode in damped_modes(linear) if abs(mode.shape[0]) > 0.5]
        assert {mode.kind for mode in found} == kinds


def test_time_constants(quarter_linear: LinearModel) -> None:
    """l^2 + 5 l + 4 = 0: the decays last 1 s and 1/4 s."""
    slow, oscillation, fast = damped_modes(one_mass(quarter_linear, damping=5.0, stiffness=4.0))
    assert (slow.time_constant, fast.time_constant) == pytest.approx((1.0, 0.25))
    assert slow.damped_frequency_hz == 0 and oscillation.time_constant == pytest.approx(5.0)
    assert oscillation.damped_frequency_hz == pytest.approx(np.sqrt(4 - 0.04) / (2 * np.pi))
    assert damped_modes(one_mass(quarter_linear, 0.0, 0.0))[0].time_constant == np.inf


def test_two_decays_of_an_overdamped_oscillation(quarter_linear: LinearModel) -> None:
    """zeta = 5 / (2 * 2), w = 2 rad/s."""
    slow, oscillation, fast = damped_modes(one_mass(quarter_linear, damping=5.0, stiffness=4.0))
    assert slow.is_overdamped and fast.is_overdamped and not oscillation.is_overdamped
    assert (slow.partner, fast.partner) == (fast.eigenvalue, slow.eigenvalue)
    for mode in (slow, fast):
        assert mode.pair_damping_ratio == pytest.approx(1.25)
        assert mode.pair_frequency_hz == pytest.approx(1 / np.pi)
    assert oscillation.pair_damping_ratio == pytest.approx(oscillation.damping_ratio)
    assert oscillation.pair_frequency_hz == pytest.approx(oscillation.frequency_hz)
    for damping, stiffness in ((0.5, 0.0), (0.0, -9.0), (0.0, 0.0)):
        modes = damped_modes(one_mass(quarter_linear, damping, stiffness))
        assert not any(mode.is_overdamped for mode in modes)


def test_decays_of_several_overdamped_oscillations_find_their_partners(chain_linear: LinearModel) -> None:
    """C = 0.1 s K on a free chain, w^2 = k / I and 3 k / I: zeta = 0.05 s w, both far above 1."""
    stiff = replace(chain_linear, damping=0.1 * chain_linear.stiffness)
    square = stiff.stiffness[1, 1] / 126
    ratios = sorted(mode.pair_damping_ratio for mode in damped_modes(stiff) if mode.is_overdamped)
    expected = 0.05 * np.sqrt([square, square, 3 * square, 3 * square])
    np.testing.assert_allclose(ratios, expected, rtol=1e-6)


def test_sedan_s_modes_are_called_by_what_moves(sedan_linear: LinearModel) -> None:
    assert set(undamped_modes(sedan_linear).names) == SEDAN_NAMES
    assert {mode.name for mode in damped_modes(sedan_linear)} == SEDAN_NAMES
    yaw = next(mode for mode in damped_modes(sedan_linear) if mode.name == "yaw")
    assert yaw.damping_ratio == pytest.approx(0.014, abs=5e-4)


@pytest.mark.parametrize("factor", [0.75, 1.25])
@pytest.mark.parametrize(
    "group", ["suspension.front.spring", "tyre.rear.stiffness", "body.front.mass", "body"]
)
def test_names_survive_another_car(sedan: Model, group: str, factor: float) -> None:
    if group == "body":
        names = [
            f"body.{s}.inertia.{axes}" for s in ("front", "middle", "rear") for axes in ("xx", "yy", "zz")
        ]
        variant = sedan.scaled(*names, factor=factor)
    else:
        variant = sedan.scaled(group, factor=factor)
    assert set(undamped_modes(linearise(variant)).names) == SEDAN_NAMES


def test_wheel_hop_in_phase_moves_both_wheels_up(sedan_linear: LinearModel) -> None:
    modes = undamped_modes(sedan_linear)
    for axle in ("front", "rear"):
        rows = [sedan_linear.outputs.index(f"{axle}_{side}_wheel_displacement") for side in ("left", "right")]
        for phase, sign in (("in phase", 1), ("opposite", -1)):
            shape = modes.shapes[:, modes.names.index(f"{axle} wheel hop, {phase}")]
            left, right = sedan_linear.output_by_coordinates[rows] @ shape
            assert left == pytest.approx(sign * right, rel=1e-6)


def test_roll_turns_about_a_low_axis_and_lateral_motion_does_not(sedan_linear: LinearModel) -> None:
    """Roll leaves the contact patches almost in place; the lateral mode carries them along."""
    modes = undamped_modes(sedan_linear)
    sideways = {}
    for name in ("roll", "lateral"):
        shape = dict(zip(sedan_linear.coordinates, modes.shapes[:, modes.names.index(name)], strict=True))
        sideways[name] = abs((shape["y"] + 0.599 * shape["roll"]) / shape["y"])
    assert sideways["roll"] < 0.2 and sideways["lateral"] > 1.5


def test_energy_shares_add_up(linear: LinearModel) -> None:
    for mode in damped_modes(linear):
        assert sum(mode.energy.values()) == pytest.approx(1.0, rel=1e-12)
        assert min(mode.energy.values()) > -0.1


def test_energy_does_not_depend_on_where_the_body_s_place_is_measured(sedan_linear: LinearModel) -> None:
    """The same car, with the displacement of another point of the body as coordinates."""
    lever = np.array([0.4, -0.3, 0.7])
    rotations = {"yaw": [0, 0, 1], "pitch": [0, 1, 0], "roll": [1, 0, 0]}
    back = np.eye(12)
    for name, axis in rotations.items():
        back[:3, sedan_linear.coordinates.index(name)] = -np.cross(axis, lever)
    moved = replace(
        sedan_linear,
        mass=back.T @ sedan_linear.mass @ back,
        stiffness=back.T @ sedan_linear.stiffness @ back,
    )
    for shape in np.random.default_rng(5).normal(size=(5, 12)):
        expected = energy_shares(sedan_linear, shape)
        assert energy_shares(moved, np.linalg.solve(back, shape)) == pytest.approx(expected, abs=1e-9)


def test_energy_of_a_wheel_that_stays_in_place_is_nothing(half_linear: LinearModel) -> None:
    """The body rises by 1 and the travels by -1: only the body moves."""
    energy = energy_shares(half_linear, np.array([1.0, 0.0, -1.0, -1.0]))
    assert energy["front wheel hop"] == pytest.approx(0, abs=1e-15) and energy["bounce"] > 0.9


def test_one_wheel_alone_is_named_by_its_corner(sedan_linear: LinearModel) -> None:
    stiffness = sedan_linear.stiffness.copy()
    arm = sedan_linear.coordinates.index("rear_right_arm_angle")
    stiffness[arm, arm] *= 3
    assert "rear right wheel hop" in undamped_modes(replace(sedan_linear, stiffness=stiffness)).names


def test_a_second_motion_names_a_mode_only_if_it_is_visible(half_linear: LinearModel) -> None:
    bounce = np.array([1.0, 0.0, -1.0, -1.0])
    for pitch, names in ((0.05, ("bounce 1", "bounce 2")), (0.7, ("bounce", "pitch"))):
        other = bounce + pitch * np.array([0.0, 1.0, -1.3167, 1.4493])
        assert mode_names(half_linear, [bounce, other], [True, True]) == names
    assert mode_names(half_linear, [bounce, other], [True, False]) == ("bounce 1", "bounce 2")


def test_coordinates_without_a_word_keep_their_names(quarter_linear: LinearModel) -> None:
    renamed = replace(quarter_linear, coordinates=("engine_block", "wheel_bounce"))
    assert undamped_modes(renamed).names == ("engine block", "wheel hop")


def test_equal_names_are_told_apart(quarter_linear: LinearModel) -> None:
    twins = replace(
        one_mass(quarter_linear, damping=0.0, stiffness=1.0), coordinates=("body_bounce", "bounce")
    )
    assert undamped_modes(twins).names == ("bounce 1", "bounce 2")


@pytest.mark.parametrize("shares", [potential_shares, dissipation_shares])
def test_shares_of_potential_energy_and_dissipation_add_up(linear: LinearModel, shares: Shares) -> None:
    for mode in damped_modes(linear):
        total = sum(shares(linear, mode.shape).values())
        assert total == pytest.approx(0.0 if mode.kind == "rigid body" else 1.0, abs=1e-12)


def test_energies_where_the_spring_and_the_dashpot_are(quarter_linear: LinearModel) -> None:
    """Two masses that nothing couples: each mode has all of its energies to itself."""
    apart = one_mass(quarter_linear, damping=0.0, stiffness=9.0)
    table = energy_table(damped_modes(apart))
    own = [["bounce", "wheel hop"].index(name) for name in table["motion"].values]
    assert own == [0, 1] and list(table["mode"].values) == ["wheel hop", "bounce"]
    np.testing.assert_allclose(table["kinetic"], [[0, 1], [1, 0]], atol=1e-12)
    np.testing.assert_allclose(table["potential"], [[0, 1], [1, 0]], atol=1e-12)
    np.testing.assert_allclose(table["dissipation"], [[0, 1], [0, 0]], atol=1e-12)
    assert list(table["kind"].values) == ["oscillation", "oscillation"]


def test_kinetic_and_potential_energy_are_equal_on_average(sedan_linear: LinearModel) -> None:
    """Over all coordinates, not share by share: w^2 q^T M q = q^T K q."""
    for mode in undamped_modes(sedan_linear).modes:
        stored = (mode.shape @ sedan_linear.stiffness @ mode.shape).real
        assert stored == pytest.approx((2 * np.pi * mode.frequency_hz) ** 2, rel=1e-9)


def test_table_of_energies(sedan_linear: LinearModel) -> None:
    modes = damped_modes(sedan_linear)
    table = energy_table(modes)
    assert table.sizes == {"mode": 12, "motion": 9}
    np.testing.assert_allclose(table["frequency_hz"], [mode.frequency_hz for mode in modes])
    assert table["kinetic"].sel(mode="yaw", motion="yaw") == modes[4].energy["yaw"]
    assert "yaw" in str(table["dissipation"].to_pandas())


def test_axes_have_words_in_vehicles_only(quarter_linear: LinearModel) -> None:
    plane = one_mass(quarter_linear, damping=0.0, stiffness=1.0)
    assert undamped_modes(replace(plane, coordinates=("x", "y"))).names == ("x", "y")
    assert undamped_modes(replace(plane, coordinates=("y", "yaw"))).names == ("lateral", "yaw")


@pytest.mark.slow
@pytest.mark.parametrize("sections", [4, 5, 12])
def test_body_torsion_of_many_sections_is_named_by_its_nodes(sedan: Model, sections: int) -> None:
    modes = undamped_modes(linearise(load_model("sedan", sections=sections)))
    torsion = [name for name in modes.names if name.startswith("body torsion")]
    assert torsion[0] == "body torsion, 1 node"
    assert torsion[1:] == [f"body torsion, {nodes} nodes" for nodes in range(2, sections)]


def test_nodes_of_a_uniform_free_chain(chain_linear: LinearModel) -> None:
    """Seven equal discs, shapes cos(k pi (i + 1/2) / 7) with k nodes, as twists against the fourth disc."""
    names = ("roll", "front_torsion", *(f"section_{i}_torsion" for i in (2, 3, 5, 6)), "rear_torsion")
    chain = replace(chain_linear, coordinates=names)
    shapes = []
    for k in range(1, 7):
        angles = np.cos(k * np.pi * (np.arange(7) + 0.5) / 7)
        shapes.append(np.insert(np.delete(angles - angles[3], 3), 0, angles[3]))
    full = replace(chain, mass=np.eye(7), stiffness=np.diag([0.0, 1, 1, 1, 1, 1, 1]))
    expected = tuple(f"body torsion, {k} node{'s' if k > 1 else ''}" for k in range(1, 7))
    assert mode_names(full, shapes, [True] * 6) == expected
    assert mode_names(full, [1j * shape for shape in shapes], [True] * 6) == expected
