"""The symbolic state space against textbook matrices, and against the numerical one."""

from collections.abc import Mapping

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    ForceLaw,
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    SpringTable,
    build_model,
    derive,
    load_model,
    prismatic,
    revolute,
)
from chassym.linear import LinearisationError, linearise
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.symbolic import SymbolicStateSpace, symbolic_state_space

SECOND_ORDER = (
    "mass",
    "damping",
    "stiffness",
    "input_stiffness",
    "input_damping",
    "output_by_coordinates",
    "output_by_rates",
    "output_by_accelerations",
    "output_by_inputs",
    "output_by_input_rates",
)


def symbol(name: str) -> sympy.Symbol:
    return sympy.Symbol(name, real=True)


def same(found: sympy.Matrix, expected: sympy.Matrix) -> bool:
    return found.shape == expected.shape and (found - expected).applyfunc(sympy.simplify).is_zero_matrix


def numbers(matrix: sympy.Matrix, values: Mapping[str, float]) -> np.ndarray:
    known = {each: sympy.Float(values[each.name], 30) for each in matrix.free_symbols}
    return np.array(matrix.xreplace(known).tolist(), dtype=float).reshape(matrix.shape)


def test_quarter_car_is_that_of_the_textbook(quarter_car: Model) -> None:
    """Rajamani, Vehicle Dynamics and Control, 2nd ed., section 10.2, with tyre damping."""
    ms, mu, k, c = map(symbol, ("sprung.mass", "unsprung.mass", "spring.rate", "damper.slope"))
    kt, ct = map(symbol, ("tyre.stiffness", "tyre.damping"))
    found = symbolic_state_space(quarter_car)
    assert found.mass == sympy.diag(ms, mu)
    assert same(found.damping, sympy.Matrix([[c, -c], [-c, c + ct]]))
    assert same(found.stiffness, sympy.Matrix([[k, -k], [-k, k + kt]]))
    assert same(found.input_stiffness, sympy.Matrix([0, kt]))
    assert same(found.input_damping, sympy.Matrix([0, ct]))
    by_state = [[-k / ms, k / ms, -c / ms, c / ms], [k / mu, -(k + kt) / mu, c / mu, -(c + ct) / mu]]
    assert same(found.A, sympy.Matrix([[0, 0, 1, 0], [0, 0, 0, 1], *by_state]))
    assert same(found.B, sympy.Matrix([[0, 0], [0, 0], [0, 0], [kt / mu, ct / mu]]))
    rows = {
        "body_displacement": [1, 0, 0, 0, 0, 0],
        "wheel_displacement": [0, 1, 0, 0, 0, 0],
        "wheel_travel": [-1, 1, 0, 0, 0, 0],
        "vertical_acceleration": [*by_state[0], 0, 0],
        "patch_force_z": [0, -kt, 0, -ct, kt, ct],
    }
    assert set(rows) == set(found.output_names)
    assert same(found.C.row_join(found.D), sympy.Matrix([rows[name] for name in found.output_names]))
    assert found.state_names == displacements_and_rates(linearise(quarter_car)).state_names
    assert found.input_names == ("road", "road_rate")


def test_half_car_is_that_of_the_energies(half_car: Model) -> None:
    """M, C, K from the energies written out for the plane, coordinates z, pitch and both travels.

    With a the distance of a wheel behind the mass centre and h its height over it, the wheel is at
    (h + s) sin(pitch) + a cos(pitch) along x and z - a sin(pitch) + (h + s) cos(pitch) along z.
    """
    z, pitch, *travels = q = sympy.symbols("z pitch front rear")
    dz, dpitch, *rates = dq = sympy.symbols("dz dpitch dfront drear")
    kinetic = symbol("body.mass") * dz**2 / 2 + symbol("body.inertia.yy") * dpitch**2 / 2
    potential = symbol("body.mass") * symbol("gravity") * z
    dissipation = sympy.S.Zero
    rises = []
    for axle, travel, rate in zip(("front", "rear"), travels, rates, strict=True):
        a = symbol(f"axle.{axle}.x") - symbol("body.mass_centre.x")
        height = -symbol("body.mass_centre.z") + travel
        x = height * sympy.sin(pitch) + a * sympy.cos(pitch)
        rise = z - a * sympy.sin(pitch) + height * sympy.cos(pitch)
        vx, vz = (sum(place.diff(s) * v for s, v in zip(q, dq, strict=True)) for place in (x, rise))
        mass, spring = symbol(f"axle.{axle}.mass"), f"suspension.{axle}"
        kinetic += mass * (vx**2 + vz**2) / 2
        deflection = rise + symbol("body.mass_centre.z")
        potential += mass * symbol("gravity") * rise + symbol(f"{axle}_tyre.preload") * deflection
        potential += symbol(f"tyre.{axle}.stiffness") * deflection**2 / 2
        potential += symbol(f"{spring}.spring.rate") * travel**2 / 2
        dissipation += symbol(f"{spring}.damper.coefficient") * rate**2 / 2
        dissipation += symbol(f"tyre.{axle}.damping") * vz**2 / 2
        rises.append(sympy.Matrix([rise]).jacobian(q))
    rest = dict.fromkeys((*q, *dq), 0)
    found = symbolic_state_space(half_car)
    assert same(found.mass, sympy.hessian(kinetic, dq).subs(rest))
    assert same(found.damping, sympy.hessian(dissipation, dq).subs(rest))
    assert same(found.stiffness, sympy.hessian(potential, q).subs(rest))
    for column, (axle, rise) in enumerate(zip(("front", "rear"), rises, strict=True)):
        assert same(found.input_stiffness[:, column], symbol(f"tyre.{axle}.stiffness") * rise.T.subs(rest))
        assert same(found.input_damping[:, column], symbol(f"tyre.{axle}.damping") * rise.T.subs(rest))


@pytest.mark.parametrize(
    "vehicle", ["quarter_car", "half_car", "half_car_roll", "ride_model", "torsion_chain"]
)
def test_numbers_are_those_of_the_linear_model(vehicle: str) -> None:
    """For random parameters, to rounding."""
    model = load_model(vehicle)
    found = symbolic_state_space(model)
    random = np.random.default_rng(7)
    names = [each.name for each in found.symbols if each.name in model.parameters]
    for _ in range(3):
        changed = model.with_parameters(
            {name: model.parameters[name].value * random.uniform(0.7, 1.4) for name in names}
        )
        linear = linearise(changed)
        slopes = {f"{element}.slope": slope for element, slope in linear.slopes.items()}
        values = changed.values | slopes
        for name in SECOND_ORDER:
            expected = getattr(linear, name)
            close(numbers(getattr(found, name), values), expected)
        matrices = displacements_and_rates(linear)
        for name in "ABCD":
            close(numbers(getattr(found, name), values), getattr(matrices, name))
    assert found.state_names == matrices.state_names and found.output_names == matrices.output_names
    assert found.input_names == matrices.input_names


def close(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max(initial=1.0))


def pendulum(law: object = None) -> Mechanism:
    mechanism = Mechanism("pendulum", gravity=symbol("g"))
    joint = revolute("swing", "y")
    centre = (0, 0, -symbol("l"))
    mechanism.add_body("bob", mechanism.ground, joint, (0, 0, 0), mass=symbol("m"), mass_centre=centre)
    if law is not None:
        mechanism.add_force_element("law", JointPort(joint.steps[0].coordinate), law)
    return mechanism


def test_equations_without_numbers_are_linearised() -> None:
    """A pendulum: m l^2 q'' + m g l q = 0."""
    found = symbolic_state_space(derive(pendulum()))
    m, g, length = map(symbol, ("m", "g", "l"))
    assert same(found.mass, sympy.Matrix([[m * length**2]]))
    assert same(found.stiffness, sympy.Matrix([[m * g * length]]))
    assert same(found.A, sympy.Matrix([[0, 1], [-g / length, 0]]))
    assert found.B.shape == (2, 0) and found.C.shape == (0, 2)


def test_an_acceleration_answers_inputs_directly() -> None:
    """A block on spring and damper between it and a moved base: q'' = (k (u - q) + c (u' - q')) / m."""
    mechanism = Mechanism("shaken", gravity=0)
    joint = prismatic("slide", "x")
    block = mechanism.add_body("block", mechanism.ground, joint, (0, 0, 0), mass=symbol("m"))
    m, k, c = map(symbol, ("m", "k", "c"))
    port = JointPort(joint.steps[0].coordinate).less(mechanism.add_input("base", "m"))
    mechanism.add_force_element("mount", port, Linear(k, c))
    point = mechanism.point("centre", block, (0, 0, 0))
    mechanism.add_output(PointAcceleration("acceleration", point, "x", mechanism.ground))
    found = symbolic_state_space(derive(mechanism))
    assert same(found.C, sympy.Matrix([[-k / m, -c / m]]))
    assert same(found.D, sympy.Matrix([[k / m, c / m]]))


def test_the_slope_of_a_table_stays_a_symbol() -> None:
    table = SpringTable((-1.0, 0.0, 1.0), (-3.0, 0.0, 1.0))
    found = symbolic_state_space(derive(pendulum(table)))
    m, g, length, slope = map(symbol, ("m", "g", "l", "law.slope"))
    assert same(found.stiffness, sympy.Matrix([[m * g * length + slope]]))
    assert slope in found.symbols


def test_it_is_typeset(quarter_car: Model) -> None:
    found: SymbolicStateSpace = symbolic_state_space(quarter_car)
    text = found._repr_latex_()
    assert r"M &= \begin{bmatrix} m_{\text{sprung}} & 0 \\ 0 & m_{\text{unsprung}} \end{bmatrix}" in text
    assert text.count(r"\begin{bmatrix}") == text.count(r"\end{bmatrix}") == 5
    assert "damper.slope" in repr(found) and "quarter_car" in repr(found)


def chain(size: int, coupled: bool) -> Mechanism:
    """Masses on springs, each carried by the one before or all by the ground."""
    mechanism = Mechanism("chain", gravity=0)
    parent = mechanism.ground
    for i in range(size):
        joint = prismatic(f"q{i}", "x")
        body = mechanism.add_body(f"b{i}", parent, joint, (0, 0, 0), mass=symbol(f"m{i}"))
        mechanism.add_force_element(f"k{i}", JointPort(joint.steps[0].coordinate), Linear(symbol(f"c{i}")))
        parent = body if coupled else mechanism.ground
    return mechanism


def test_large_models_are_refused(rigid: Model) -> None:
    with pytest.raises(
        LinearisationError, match="'rigid_car' linearised in symbols has 4163 op.* at most 3000"
    ):
        symbolic_state_space(rigid)
    many = symbolic_state_space(derive(chain(8, coupled=False)))
    assert many.A[15, 7] == -symbol("c7") / symbol("m7")
    coupled = symbolic_state_space(derive(chain(8, coupled=True)))
    with pytest.raises(LinearisationError, match="couples 8 coordinates; at most 5") as error:
        _ = coupled.A
    assert "\n" not in str(error.value)
    assert coupled.mass[0, 0] == sympy.Add(*(symbol(f"m{i}") for i in range(8)))


@pytest.fixture
def rigid(cache_directory: str) -> Model:
    """Give the sedan with a rigid body, 10 degrees of freedom."""
    return load_model("rigid_sedan")


def test_a_mass_matrix_that_is_always_singular_is_refused() -> None:
    mechanism = Mechanism("massless", gravity=0)
    inner, outer = prismatic("inner", "x"), prismatic("outer", "x")
    carrier = mechanism.add_body("carrier", mechanism.ground, inner, (0, 0, 0))
    mechanism.add_body("block", carrier, outer, (0, 0, 0), mass=symbol("m"))
    mechanism.add_force_element("spring", JointPort(inner.steps[0].coordinate), Linear(symbol("k")))
    found = symbolic_state_space(derive(mechanism))
    with pytest.raises(LinearisationError, match="mass matrix of 'massless' is singular for all parameters"):
        _ = found.A


def test_an_infinite_derivative_is_refused() -> None:
    s = sympy.Symbol("s", real=True)
    mechanism = Mechanism("root", gravity=0)
    joint = prismatic("slide", "x")
    mechanism.add_body("block", mechanism.ground, joint, (0, 0, 0), mass=1)
    law = ForceLaw(sympy.sqrt(sympy.Abs(s)) * sympy.sign(s), s)
    mechanism.add_force_element("spring", JointPort(joint.steps[0].coordinate), law)
    model = build_model(mechanism, {})
    with pytest.raises(LinearisationError, match="'root' at the design position is not finite"):
        symbolic_state_space(model)
