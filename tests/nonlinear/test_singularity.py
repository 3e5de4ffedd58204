"""Rotation sequences near their singularity: measured, reported, and refused before they spoil a result."""

import numpy as np
import pytest

from chassym.derivation import (
    AngularVelocity,
    JointPort,
    Linear,
    Mechanism,
    Model,
    build_model,
    cylindrical,
    prismatic,
    revolute,
    spherical,
)
from chassym.linear import OperatingPointError, linearise
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, SimulationError, simulate, steady_state


def gimbal(sequence: str) -> Model:
    """Give a body on three rotations, each on a spring; the second one is driven."""
    mechanism = Mechanism("gimbal", gravity=0)
    body = mechanism.add_body(
        "rotor", mechanism.ground, spherical(sequence), (0, 0, 0), mass=1, inertia=(2, 3, 4)
    )
    drive = mechanism.add_input("drive", "rad")
    for i, coordinate in enumerate(mechanism.coordinates):
        port = JointPort(coordinate)
        mechanism.add_force_element(f"spring_{i}", port.less(drive) if i == 1 else port, Linear(50, 8))
    mechanism.add_output(AngularVelocity("rate", body, "z", mechanism.ground))
    return build_model(mechanism, {})


@pytest.fixture(scope="module")
def tait_bryan() -> Model:
    return gimbal("zyx")


def test_distance_is_the_cosine_or_the_sine_of_the_second_angle(tait_bryan: Model) -> None:
    angles = np.linspace(0.2, 1.2, 9)
    for model, expected in ((tait_bryan, np.cos), (gimbal("zxz"), np.sin)):
        arguments = np.full((model.argument_count, len(angles)), 0.3)
        arguments[1] = angles
        found = np.abs(model.singularities(arguments)[0])
        np.testing.assert_allclose(found, expected(angles), atol=1e-15)
        near = model.nearest_singularity(arguments)
        assert near.body == "rotor" and near.distance == pytest.approx(expected(angles).min())
        assert near.sample == expected(angles).argmin()


def test_a_mechanism_without_three_rotations_has_none(quarter_car: Model) -> None:
    assert quarter_car.nearest_singularity(np.zeros((quarter_car.argument_count, 1))) is None
    moved = simulate(quarter_car, Harmonic(1.0, {}), np.array([0.0, 0.1]))
    assert moved.nearest_singularity is None


def test_a_simulation_stops_before_gimbal_lock(tait_bryan: Model) -> None:
    swing = np.array([0.0, 1.5, 0.0, 0.0, 3.0, 0.0])
    with pytest.raises(SimulationError, match=r"body 'rotor' comes to .* another sequence"):
        simulate(tait_bryan, Harmonic(0.05, {"drive": 1.571}), np.linspace(0, 10, 11), start=swing)


def test_a_simulation_says_how_near_it_came(tait_bryan: Model) -> None:
    moved = simulate(tait_bryan, Harmonic(0.05, {"drive": 1.0}), np.linspace(0, 40, 401))
    assert moved.nearest_singularity.distance == pytest.approx(np.cos(np.abs(moved.states[1]).max()))
    assert 0.1 < moved.nearest_singularity.distance < 0.6


def test_a_passage_between_two_instants_is_seen(tait_bryan: Model) -> None:
    arguments = np.zeros((tait_bryan.argument_count, 2))
    arguments[1] = 1.2, 1.9
    near = tait_bryan.nearest_singularity(arguments)
    assert near.distance == 0 and near.is_harmful


def test_a_steady_state_at_gimbal_lock_is_refused(tait_bryan: Model) -> None:
    """The drive turns slowly to 90 degrees and back."""
    assert steady_state(tait_bryan, Harmonic(0.01, {"drive": 1.2})).orbit.nearest_singularity.distance > 0.3
    with pytest.raises(NoPeriodicOrbitError, match=r"body 'rotor' comes to .* from its singularity"):
        steady_state(tait_bryan, Harmonic(0.01, {"drive": 1.7}))


def test_an_operating_point_at_gimbal_lock_is_refused() -> None:
    with pytest.raises(OperatingPointError, match=r"'gimbal' at the design .*body 'rotor' comes to 0 from"):
        linearise(gimbal("zxz"))


def test_slides_before_the_rotations_do_not_matter() -> None:
    mechanism = Mechanism("sled", gravity=0)
    joint = prismatic("x", "x").then(spherical("xyz"))
    mechanism.add_body("sled", mechanism.ground, joint, (0, 0, 0), mass=1, inertia=(1, 1, 1))
    assert mechanism.rotation_sequences == ("sled",)


def test_a_simulation_from_gimbal_lock_is_refused_at_once() -> None:
    with pytest.raises(SimulationError, match="stopped at 0 s: .*body 'rotor' comes to 0 from"):
        simulate(
            gimbal("zxz"), Harmonic(1.0, {}), np.array([0.0, 1.0]), start=np.array([0, 0, 0, 0, 0, 20.0])
        )


def test_slides_and_gimbals_without_mass_between_the_rotations_count() -> None:
    """A universal joint with a slip joint, and three rings that weigh nothing."""
    shaft = Mechanism("cardan", gravity=0)
    steps = revolute("a", "z").then(revolute("b", "y")).then(cylindrical("s", "spin", "x"))
    shaft.add_body("shaft", shaft.ground, steps, (0, 0, 0), mass=1, inertia=(1, 2, 3))
    rings = Mechanism("gimbals", gravity=0)
    outer = rings.add_body("outer", rings.ground, revolute("a", "z"), (0, 0, 0))
    inner = rings.add_body("inner", outer, revolute("b", "y"), (0, 0, 0))
    rings.add_body("rotor", inner, revolute("spin", "x"), (0, 0, 0), mass=1, inertia=(1, 2, 3))
    for mechanism in (shaft, rings):
        model = build_model(mechanism, {})
        arguments = np.zeros((model.argument_count, 1))
        arguments[1] = 1.2
        assert model.nearest_singularity(arguments).distance == pytest.approx(np.cos(1.2))
