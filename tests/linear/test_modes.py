"""Modes: eigenvalue problems solved otherwise, normalisation, rigid bodies, decay and growth, and names."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, eigvals

from chassym.derivation import Model
from chassym.linear import (
    LinearisationError,
    LinearModel,
    damped_modes,
    energy_shares,
    linearise,
    undamped_modes,
)
from chassym.linear.motion import mode_names

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
    assert (modes.shapes[np.abs(modes.shapes).argmax(axis=0), range(len(squared))] > 0).all()


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


def test_forces_without_a_potential_are_refused(quarter_linear: LinearModel) -> None:
    skew = replace(quarter_linear, stiffness=np.array([[2.0, 1.0], [-1.0, 3.0]]))
    with pytest.raises(LinearisationError, match="not symmetric"):
        undamped_modes(skew)


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
