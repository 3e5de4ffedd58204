"""The linear model's matrices, signs, names and refusals."""

from dataclasses import replace

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    Body,
    Characteristic,
    ForceLaw,
    JointPort,
    Linear,
    Mechanism,
    Model,
    Unilateral,
    build_model,
    prismatic,
)
from chassym.linear import (
    LinearisationError,
    LinearModel,
    OperatingPointError,
    linearise,
    to_control,
)
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.jump import find_jump
from chassym.linear.operating_point import design_position

S, V = sympy.symbols("s v", real=True)
FRICTION = sympy.Symbol("friction", real=True)

VEHICLES = ["sedan", "quarter_car", "half_car", "torsion_chain"]


@pytest.fixture(params=VEHICLES)
def linear(request: pytest.FixtureRequest) -> LinearModel:
    return linearise(request.getfixturevalue(request.param))


def numbers(model: Model, vector: object) -> np.ndarray:
    return np.array([float(e.subs({s: model.values[s.name] for s in e.free_symbols})) for e in vector])


def velocity(model: Model, body: Body, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocity of a place on a body and the body's angular velocity per unit rate, shape (3, n), at rest.

    At the design position all frames are parallel: a slider moves what it carries along its axis, a hinge
    turns it about its origin.
    """
    names = [c.name for c in model.system.coordinates]
    linear, angular = np.zeros((3, len(names))), np.zeros((3, len(names)))
    carrier: Body | None = body
    while carrier is not None:
        for step in carrier.joint.steps:
            column, axis = names.index(step.coordinate.name), numbers(model, step.axis)
            if step.is_rotation:
                angular[:, column] = axis
                linear[:, column] = np.cross(axis, place - numbers(model, carrier.origin))
            else:
                linear[:, column] = axis
        carrier = carrier.parent
    return linear, angular


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_mass_matrix_is_the_sum_over_the_bodies(vehicle: str, request: pytest.FixtureRequest) -> None:
    model = request.getfixturevalue(vehicle)
    expected = np.zeros((model.size, model.size))
    for body in model.system.bodies:
        linear, angular = velocity(model, body, numbers(model, body.mass_centre))
        moments = np.diag(numbers(model, (body.inertia.xx, body.inertia.yy, body.inertia.zz)))
        expected += numbers(model, [body.mass])[0] * linear.T @ linear + angular.T @ moments @ angular
    np.testing.assert_allclose(linearise(model).mass, expected, rtol=1e-12, atol=1e-12 * expected.max())


def test_mass_is_positive_definite_and_stiffness_symmetric(linear: LinearModel) -> None:
    np.testing.assert_allclose(linear.mass, linear.mass.T, rtol=1e-14)
    assert np.linalg.eigvalsh(linear.mass)[0] > 0
    for matrix in (linear.stiffness, linear.damping):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-13 * np.abs(matrix).max())
    assert np.linalg.eigvalsh(linear.damping)[0] > -1e-12 * np.abs(linear.damping).max()


def test_pads_push_through_the_tyres(sedan: Model, sedan_linear: LinearModel) -> None:
    """A pad acts on the patch that it carries: by its tyre's stiffness, and with its rate by the damping."""
    value = sedan.parameters.flat()
    for corner in ("front_left", "front_right", "rear_left", "rear_right"):
        axle, side = corner.split("_")
        place = f"suspension.{axle}.contact_patch"
        mirror = 1 if side == "left" else -1
        patch = np.array([value[f"axle.{axle}.x"], mirror * value[f"{place}.y"], value[f"{place}.z"]])
        arm = next(body for body in sedan.system.bodies if body.name == f"{corner}_arm")
        moved, _ = velocity(sedan, arm, patch)
        for row, axis in enumerate("xyz"):
            column = sedan_linear.inputs.index(f"{corner}_pad_{axis}")
            for matrix, rate in (
                (sedan_linear.input_stiffness, "stiffness"),
                (sedan_linear.input_damping, "damping"),
            ):
                expected = value[f"tyre.{axle}.{rate}.{axis}"] * moved[row]
                np.testing.assert_allclose(matrix[:, column], expected, rtol=1e-12, atol=1e-9)


def test_half_car_is_the_hand_built_one(half_car: Model, half_linear: LinearModel) -> None:
    """M, C, K from the energies written out for the plane; coordinates z, pitch and both travels.

    With a = x - xc, h = z - zc of a hub seen from the mass centre, the wheel's place is
    (h + s) sin(pitch) + a cos(pitch) along x and z - a sin(pitch) + (h + s) cos(pitch) along z. The wheels
    carry the body's weight, m g in all, at h: the second derivative of their height adds m g h to the pitch
    stiffness.
    """
    v = half_car.parameters.flat()
    mass = np.diag([v["body.mass"], v["body.inertia.yy"], 0.0, 0.0])
    stiffness, damping = np.zeros((4, 4)), np.zeros((4, 4))
    height = -v["body.mass_centre.z"]
    stiffness[1, 1] = v["body.mass"] * v["gravity"] * height
    for i, axle in enumerate(("front", "rear")):
        travel = np.eye(4)[2 + i]
        rise = travel + [1, v["body.mass_centre.x"] - v[f"axle.{axle}.x"], 0, 0]
        shift = np.array([0, height, 0, 0])
        mass += v[f"axle.{axle}.mass"] * (np.outer(rise, rise) + np.outer(shift, shift))
        spring, tyre = f"suspension.{axle}", f"tyre.{axle}"
        stiffness += v[f"{spring}.spring.rate"] * np.outer(travel, travel)
        stiffness += v[f"{tyre}.stiffness"] * np.outer(rise, rise)
        damping += v[f"{spring}.damper.coefficient"] * np.outer(travel, travel)
        damping += v[f"{tyre}.damping"] * np.outer(rise, rise)
        np.testing.assert_allclose(
            half_linear.input_stiffness[:, i], v[f"{tyre}.stiffness"] * rise, rtol=1e-12
        )
        np.testing.assert_allclose(half_linear.input_damping[:, i], v[f"{tyre}.damping"] * rise, rtol=1e-12)
    for found, expected in (
        (half_linear.mass, mass),
        (half_linear.damping, damping),
        (half_linear.stiffness, stiffness),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-13 * np.abs(expected).max())


def test_state_matrices_satisfy_the_second_order_equations(linear: LinearModel) -> None:
    """For random states and inputs, x' and y are put back into the equations they were made from."""
    n, p = len(linear.coordinates), len(linear.inputs)
    matrices = displacements_and_rates(linear)
    state, given = (np.random.default_rng(3).normal(size=(size, 20)) for size in (2 * n, 2 * p))
    change = matrices.A @ state + matrices.B @ given
    (q, rate), (u, u_rate) = np.split(state, [n]), np.split(given, [p])
    np.testing.assert_array_equal(change[:n], rate)
    forces = linear.mass @ change[n:] + linear.damping @ rate + linear.stiffness @ q
    pushed = linear.input_stiffness @ u + linear.input_damping @ u_rate
    np.testing.assert_allclose(forces, pushed, atol=1e-12 * np.abs(linear.stiffness).max())
    measured = linear.output_by_coordinates @ q + linear.output_by_rates @ rate
    measured += linear.output_by_accelerations @ change[n:]
    measured += linear.output_by_inputs @ u + linear.output_by_input_rates @ u_rate
    np.testing.assert_allclose(matrices.C @ state + matrices.D @ given, measured, rtol=1e-9, atol=1e-6)


def test_names_and_units_go_with_the_matrices(sedan_linear: LinearModel) -> None:
    matrices = displacements_and_rates(sedan_linear)
    assert matrices.state_names[:3] == ("x", "y", "z") and matrices.state_names[12:14] == ("x_rate", "y_rate")
    assert (
        matrices.input_names[2] == "front_left_pad_z" and matrices.input_names[14] == "front_left_pad_z_rate"
    )
    units = dict(zip(matrices.output_names, matrices.output_units, strict=True))
    assert units["yaw_rate"] == "rad/s" and units["rear_left_patch_force_z"] == "N"
    assert matrices.state_units[3] == "rad" and matrices.state_units[15] == "rad/s"
    assert matrices.input_units[0] == "m" and matrices.input_units[12] == "m/s"
    for matrix, rows, columns in (
        (matrices.A, matrices.state_names, matrices.state_names),
        (matrices.B, matrices.state_names, matrices.input_names),
        (matrices.C, matrices.output_names, matrices.state_names),
        (matrices.D, matrices.output_names, matrices.input_names),
    ):
        assert matrix.shape == (len(rows), len(columns))


def test_control_system_has_the_same_matrices_and_names(sedan_linear: LinearModel) -> None:
    system, matrices = to_control(sedan_linear), displacements_and_rates(sedan_linear)
    for name in "ABCD":
        np.testing.assert_array_equal(getattr(system, name), getattr(matrices, name))
    assert tuple(system.state_labels) == matrices.state_names
    assert tuple(system.input_labels) == matrices.input_names
    assert tuple(system.output_labels) == matrices.output_names
    assert system.name == "full_car_mean_slope"
    assert system.isctime(strict=True)


def test_a_system_without_inputs_becomes_a_control_system(chain_linear: LinearModel) -> None:
    assert to_control(chain_linear).nstates == 6


def test_matrices_cannot_be_changed(quarter_linear: LinearModel) -> None:
    with pytest.raises(ValueError, match="read-only"):
        quarter_linear.mass[0, 0] = 1.0


def test_a_convention_is_a_function(quarter_linear: LinearModel) -> None:
    with pytest.raises(
        LinearisationError, match="inputs: 'rates' received; expected displacements_and_rates"
    ):
        to_control(quarter_linear, "rates")  # type: ignore[arg-type]


def test_position_that_is_no_equilibrium_is_refused(quarter_car: Model) -> None:
    wrong = dict(quarter_car.preloads) | {"spring.preload": quarter_car.preloads["spring.preload"] + 12.0}
    with pytest.raises(
        OperatingPointError, match=r"12 N is left on coordinate '(body|wheel)_bounce'.*give no preloads"
    ) as error:
        linearise(replace(quarter_car, given_preloads=wrong))
    assert "\n" not in str(error.value)
    np.testing.assert_allclose(
        linearise(replace(quarter_car, given_preloads=quarter_car.preloads)).residual, 0, atol=1e-9
    )


def test_singular_mass_is_refused_by_the_coordinate_s_name(quarter_linear: LinearModel) -> None:
    massless = replace(quarter_linear, mass=np.diag([356.25, 0.0]))
    dependent = replace(quarter_linear, mass=np.array([[1.0, 2.0], [2.0, 4.0]]))
    for linear in (massless, dependent):
        with pytest.raises(
            LinearisationError, match="mass matrix of 'quarter_car' is singular: coordinate"
        ) as error:
            displacements_and_rates(linear)
        assert "\n" not in str(error.value)
    with pytest.raises(LinearisationError, match="'wheel_bounce'"):
        displacements_and_rates(massless)


def slider(law: Characteristic, friction: float = 6.0) -> Model:
    """Give 2 kg on a spring of 50 N/m and a force law, on a base that is moved along."""
    mechanism = Mechanism("slider", gravity=0)
    joint = prismatic("slide", "x")
    mechanism.add_body("block", mechanism.ground, joint, (0, 0, 0), mass=2)
    port = JointPort(joint.steps[0].coordinate)
    base = mechanism.add_input("base", "m")
    mechanism.add_force_element("spring", port, Linear(50))
    mechanism.add_force_element("contact", port.less(base), law)
    mentioned = FRICTION in getattr(law, "expression", sympy.S.Zero).free_symbols
    return build_model(mechanism, {FRICTION: friction} if mentioned else {})


def test_coulomb_friction_at_rest_is_refused() -> None:
    """The force passes from -mu to mu: its slope is no number, and by no means zero."""
    with pytest.raises(
        LinearisationError,
        match=r"'slider' .* coordinate 'slide' jumps by 12 N where 'slide_rate' passes zero",
    ) as error:
        linearise(slider(ForceLaw(FRICTION * sympy.sign(V), rate=V)))
    assert "\n" not in str(error.value)


def test_friction_without_a_jump_is_linearised() -> None:
    """Smoothed over v0 it is a damper of mu / v0; with mu = 0 there is none."""
    smooth = linearise(slider(ForceLaw(FRICTION * sympy.tanh(V / 0.1), rate=V)))
    np.testing.assert_allclose(smooth.damping, [[60.0]])
    np.testing.assert_allclose(smooth.input_damping, [[60.0]])
    none = linearise(slider(ForceLaw(FRICTION * sympy.sign(V), rate=V), friction=0.0))
    np.testing.assert_array_equal(none.damping, [[0.0]])


@pytest.mark.parametrize(
    ("law", "size"),
    [
        (ForceLaw(3 * sympy.Heaviside(S) - 1.5, S), 3),
        (ForceLaw(3 * sympy.Heaviside(S, 0) - 3 * sympy.Heaviside(-S, 0), S), 6),
        (ForceLaw(sympy.Piecewise((7 * S - 4, S < 0), (7 * S, True)), S), 4),
        (ForceLaw(5 * V - 1e-3 * sympy.sign(V - S), S, V), 2e-3),
        (ForceLaw(sympy.sign(V) ** 3, rate=V), 2),
        (Unilateral(ForceLaw(sympy.sign(V) + sympy.Rational(1, 2), rate=V)), 0.5),
    ],
)
def test_every_jump_at_the_design_position_is_refused(law: Characteristic, size: float) -> None:
    """A law's value below, at and above zero by hand; the unilateral one is -1/2 or 0."""
    with pytest.raises(LinearisationError, match=f"jumps by {size:.3g} N where 'slide"):
        linearise(slider(law))


@pytest.mark.parametrize(
    ("law", "damping", "stiffness"),
    [
        (ForceLaw(V * sympy.Abs(V), rate=V), 0, 50),
        (ForceLaw(V**2 * sympy.sign(V) + 3 * V, rate=V), 3, 50),
        (ForceLaw(S * (4 + sympy.sign(S)), S), 0, 54),
        (ForceLaw(sympy.sign(S) * sympy.Abs(S) ** sympy.Rational(3, 2), S), 0, 50),
        (ForceLaw(6 * sympy.sign(V - sympy.Rational(1, 10)) + 6, rate=V), 0, 50),
        (ForceLaw(sympy.Piecewise((0, sympy.Abs(S) < 0.1), (9 + S, True)), S), 0, 50),
        (Unilateral(Linear(8)), 0, 54),
    ],
)
def test_bends_and_distant_jumps_are_linearised(
    law: Characteristic, damping: float, stiffness: float
) -> None:
    """A bend has the mean of both sides' slopes, a jump elsewhere none."""
    linear = linearise(slider(law))
    np.testing.assert_allclose(linear.damping, [[damping]])
    np.testing.assert_allclose(linear.stiffness, [[stiffness]])


def test_a_jump_in_a_prescribed_motion_is_refused_by_its_name() -> None:
    mechanism = Mechanism("shaken", gravity=0)
    joint = prismatic("slide", "x")
    mechanism.add_body("block", mechanism.ground, joint, (0, 0, 0), mass=2)
    base = mechanism.add_input("base", "m")
    law = ForceLaw(sympy.sign(base.rate) + 50 * S, S)
    mechanism.add_force_element("spring", JointPort(joint.steps[0].coordinate), law)
    with pytest.raises(LinearisationError, match="jumps by 2 N where 'base_rate' passes zero"):
        linearise(build_model(mechanism, {}))


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_vehicles_have_no_jump(vehicle: str, request: pytest.FixtureRequest) -> None:
    assert find_jump(design_position(request.getfixturevalue(vehicle))) is None
