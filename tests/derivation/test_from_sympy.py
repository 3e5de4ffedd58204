"""Bodies of sympy.physics.mechanics: against Kane's and Lagrange's method, and what is refused."""

from collections.abc import Sequence

import numpy as np
import pytest
import sympy
from sympy.physics.mechanics import (
    Force,
    KanesMethod,
    LinearDamper,
    LinearPathway,
    LinearSpring,
    Particle,
    PinJoint,
    Point,
    PrismaticJoint,
    ReferenceFrame,
    RigidBody,
    Torque,
    dynamicsymbols,
    inertia,
)

from chassym.derivation import EquationsOfMotion, Input, MechanismError
from chassym.derivation.from_sympy import from_bodies
from chassym.derivation.values import build_model
from chassym.linear import damped_modes, linearise

m, g, length, k, c = sympy.symbols("m g l k c", positive=True)
STATES = 20


def plain(name: str) -> sympy.Symbol:
    return sympy.Symbol(name, real=True)


def by_kane(
    frame: ReferenceFrame,
    bodies: Sequence[RigidBody | Particle],
    coordinates: Sequence[sympy.Expr],
    loads: Sequence,
) -> tuple[sympy.Matrix, sympy.Matrix]:
    """Form M and Q - h by Kane's method with u = q', in plain symbols; potential energies give no forces."""
    speeds = [dynamicsymbols(f"{q.func.__name__}_rate") for q in coordinates]
    kinematic = [speed - q.diff() for speed, q in zip(speeds, coordinates, strict=True)]
    method = KanesMethod(frame, coordinates, speeds, kd_eqs=kinematic)
    method.kanes_equations(bodies, loads)
    symbols = {f: plain(f.func.__name__) for f in (*coordinates, *speeds)}
    symbols |= {q.diff(): plain(f"{q.func.__name__}_rate") for q in coordinates}
    return method.mass_matrix.xreplace(symbols), method.forcing.xreplace(symbols)


def assert_same(equations: EquationsOfMotion, expected: tuple[sympy.Matrix, sympy.Matrix]) -> None:
    """Compare M and Q - h at random states and random positive parameters."""
    net = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    matrix = [entry for row in equations.mass_matrix for entry in row]
    found = equations.program.expand([*matrix, *net])
    wanted = [*expected[0], *expected[1]]
    symbols = sorted(set().union(*(e.free_symbols for e in (*found, *wanted))), key=str)
    drawn = np.random.default_rng(7).uniform(0.2, 1.2, (len(symbols), STATES))
    values = []
    for results in (found, wanted):
        rows = sympy.lambdify(symbols, results, cse=True)(*drawn)
        values.append(np.array([np.broadcast_to(row, STATES) for row in rows]))
    assert values[0] == pytest.approx(values[1], rel=1e-11, abs=1e-11)


@pytest.fixture
def ground() -> ReferenceFrame:
    return ReferenceFrame("N")


@pytest.fixture
def origin(ground: ReferenceFrame) -> Point:
    point = Point("O")
    point.set_vel(ground, 0)
    return point


def spherical_pendulum(ground: ReferenceFrame, origin: Point) -> tuple[RigidBody, list[sympy.Expr]]:
    """Hang a rigid body on three rotations, its mass centre off all their axes."""
    precession, nutation, spin = angles = dynamicsymbols("precession nutation spin")
    frame = ReferenceFrame("B")
    frame.orient_body_fixed(ground, angles, "ZXZ")
    rates = [precession.diff(), nutation.diff(), spin.diff()]
    axes = frame.ang_vel_in(ground).express(frame)
    frame.set_ang_vel(ground, axes)
    assert all(axes.to_matrix(frame).has(rate) for rate in rates)
    centre = origin.locatenew("centre", -length * frame.z + length / 3 * frame.x)
    centre.v2pt_theory(origin, ground, frame)
    A, B, C = sympy.symbols("A B C", positive=True)
    return RigidBody("top", centre, frame, m, (inertia(frame, A, B, C), centre)), list(angles)


def test_spherical_pendulum_is_that_of_kane(ground: ReferenceFrame, origin: Point) -> None:
    body, angles = spherical_pendulum(ground, origin)
    weight = (body.masscenter, -m * g * ground.z)
    brake = (body.frame, -c * body.frame.ang_vel_in(ground))
    equations = from_bodies(ground, [body], angles, loads=[weight, brake], name="top")
    assert_same(equations, by_kane(ground, [body], angles, [weight, brake]))


def test_weight_as_potential_energy_is_weight_as_load(ground: ReferenceFrame, origin: Point) -> None:
    body, angles = spherical_pendulum(ground, origin)
    expected = by_kane(ground, [body], angles, [(body.masscenter, -m * g * ground.z)])
    body.potential_energy = m * g * body.masscenter.pos_from(origin).dot(ground.z)
    equations = from_bodies(ground, [body], angles, name="top")
    assert_same(equations, expected)
    assert equations.energies.potential != 0


def test_double_pendulum_with_torques_is_that_of_kane(ground: ReferenceFrame, origin: Point) -> None:
    """Particles on rods, a motor at each joint; forces and torques as objects and as pairs."""
    first, second, upper, lower = dynamicsymbols("first second upper lower")
    rods = [
        ground.orientnew(name, "Axis", (angle, ground.z)) for name, angle in (("A", first), ("B", second))
    ]
    knee = origin.locatenew("knee", length * rods[0].x)
    knee.v2pt_theory(origin, ground, rods[0])
    foot = knee.locatenew("foot", 2 * length * rods[1].x)
    foot.v2pt_theory(knee, ground, rods[1])
    bodies = [Particle("thigh", knee, m), Particle("shank", foot, 3 * m)]
    loads = [
        Force(knee, m * g * ground.x),
        (foot, 3 * m * g * ground.x),
        Torque(rods[0], (upper - lower) * ground.z),
        (rods[1], lower * ground.z),
    ]
    equations = from_bodies(ground, bodies, [first, second], loads=loads, inputs=[upper, lower], name="leg")
    matrix, forcing = by_kane(ground, bodies, [first, second], loads)
    commands = {upper: plain("upper"), lower: plain("lower")}
    assert_same(equations, (matrix, forcing.xreplace(commands)))


def test_loads_of_actuators(ground: ReferenceFrame, origin: Point) -> None:
    """A spring and a damper between two points: closed form k (s - s0) + c s' along the slide."""
    s, rest = dynamicsymbols("s"), sympy.Symbol("rest", positive=True)
    end = origin.locatenew("end", s * ground.x)
    end.set_vel(ground, s.diff() * ground.x)
    pathway = LinearPathway(origin, end)
    loads = [*LinearSpring(k, pathway, rest).to_loads(), *LinearDamper(c, pathway).to_loads()]
    equations = from_bodies(ground, [Particle("mass", end, m)], [s], loads=loads, name="slide")
    x, v, a = map(plain, ("s", "s_rate", "s_acceleration"))
    (found,) = equations.program.expand(equations.residual)
    expected = m * a + k * (sympy.sqrt(x**2) - rest) * x / sympy.sqrt(x**2) + c * v
    assert sympy.simplify(found - expected) == 0


def test_bodies_of_joints_whose_speeds_are_rates(ground: ReferenceFrame) -> None:
    """A pendulum on a cart, laid out by sympy's joints: x'' and theta'' in closed form."""
    x, theta = dynamicsymbols("x theta")
    frames, moment = [ReferenceFrame(name) for name in "CB"], sympy.Symbol("I", positive=True)
    wall, cart, bob = (RigidBody(name, frame=f) for name, f in zip("ACB", (ground, *frames), strict=True))
    cart.mass, bob.mass, bob.central_inertia = 2 * m, m, inertia(frames[1], 0, 0, moment)
    axes = {"joint_axis": ground.x, "coordinates": x, "speeds": x.diff()}
    PrismaticJoint("slide", wall, cart, **axes)
    top = length * frames[1].y
    PinJoint(
        "pin", cart, bob, coordinates=theta, speeds=theta.diff(), child_point=top, joint_axis=frames[0].z
    )
    wall.masscenter.set_vel(ground, 0)
    weight = (bob.masscenter, -m * g * ground.y)
    equations = from_bodies(ground, [cart, bob], [x, theta], loads=[weight], name="crane")
    angle, turning, a, alpha = map(plain, ("theta", "theta_rate", "x_acceleration", "theta_acceleration"))
    expected = [
        3 * m * a + m * length * (alpha * sympy.cos(angle) - turning**2 * sympy.sin(angle)),
        moment * alpha + m * length * (length * alpha + a * sympy.cos(angle) + g * sympy.sin(angle)),
    ]
    found = equations.program.expand(equations.residual)
    assert [sympy.simplify(p - q) for p, q in zip(found, expected, strict=True)] == [0, 0]


def test_prescribed_motion_with_dissipation_and_outputs(ground: ReferenceFrame, origin: Point) -> None:
    """A mass over a moving road, its frequency and damping ratio in closed form."""
    z = dynamicsymbols("z")
    road = Input("road", "m")
    place = origin.locatenew("place", z * ground.z)
    mass = Particle("mass", place, m)
    mass.potential_energy = k * (z - road.position) ** 2 / 2
    equations = from_bodies(
        ground,
        [mass],
        [z],
        units={z: "m"},
        dissipation=c * (z.diff() - road.rate) ** 2 / 2,
        inputs=[road],
        outputs={"stretch": (z - road.position, "m")},
        name="mass",
    )
    model = build_model(equations, {m: 300.0, k: "20 N/mm", c: 1500.0})
    (mode,) = damped_modes(linearise(model))
    assert mode.frequency_hz == pytest.approx(np.sqrt(20e3 / 300.0) / (2 * np.pi), rel=1e-12)
    assert mode.damping_ratio == pytest.approx(1500.0 / (2 * np.sqrt(300.0 * 20e3)), rel=1e-12)
    assert [(u.name, u.unit) for u in model.system.inputs] == [("road", "m")]
    assert model.output_names == ["stretch"]


# Refusals


def assert_refused(caught: pytest.ExceptionInfo[MechanismError], *words: str) -> None:
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


def test_generalised_speeds_are_refused(ground: ReferenceFrame, origin: Point) -> None:
    x, speed = dynamicsymbols("x speed")
    place = origin.locatenew("place", x * ground.x)
    place.set_vel(ground, speed * ground.x)
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [Particle("cart", place, m)], [x], name="cart")
    assert_refused(caught, "body 'cart'", "speed(t)", "generalised speeds", "q.diff()")
    frame = ground.orientnew("A", "Axis", (x, ground.z))
    frame.set_ang_vel(ground, speed * ground.z)
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [RigidBody("wheel", origin, frame, m)], [x], name="wheel")
    assert_refused(caught, "body 'wheel'", "speed(t)")
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [], [x], loads=[(frame, ground.z)], name="cart")
    assert_refused(caught, "load on A", "speed(t)")


def test_unknown_motion_is_refused(ground: ReferenceFrame) -> None:
    x = dynamicsymbols("x")
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [Particle("cart", Point("adrift"), m)], [x], name="cart")
    assert_refused(caught, "body 'cart'", "adrift", "no velocity in frame N")
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [], [x], loads=[(ReferenceFrame("loose"), ground.z)], name="cart")
    assert_refused(caught, "load on loose", "frame N")


def test_other_kinds_of_bodies_and_loads_are_refused(ground: ReferenceFrame, origin: Point) -> None:
    x = dynamicsymbols("x")
    place = origin.locatenew("place", x * ground.x)
    body = Particle("cart", place, m)
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [place], [x], name="cart")
    assert_refused(caught, "bodies", "place", "RigidBody and Particle")
    for load in ((place, 3), (place,), 5):
        with pytest.raises(MechanismError) as caught:
            from_bodies(ground, [body], [x], loads=[load], name="cart")
        assert_refused(caught, "loads", "(point, force)")
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [body], [x], loads=[(body, ground.x)], name="cart")
    assert_refused(caught, "Point or a ReferenceFrame")


def test_force_of_an_unknown_function_is_refused(ground: ReferenceFrame, origin: Point) -> None:
    x, push = dynamicsymbols("x push")
    place = origin.locatenew("place", x * ground.x)
    with pytest.raises(MechanismError) as caught:
        from_bodies(ground, [Particle("cart", place, m)], [x], loads=[(place, push * ground.x)], name="cart")
    assert_refused(caught, "force on 'x'", "push(t)")
