"""Ports and outputs by their definitions: rates are time derivatives, and forces do the work they should.

Everything is differentiated on the program itself, in a tree whose branches turn about oblique axes, so that
points and frames on different branches are seen from each other.
"""

from collections.abc import Callable, Sequence
from itertools import permutations

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    Actuator,
    AngularAcceleration,
    AngularVelocity,
    Body,
    CombinedPort,
    ContactForce,
    Deflection,
    DeflectionRate,
    ElementForce,
    EquationsOfMotion,
    ForceLaw,
    JointPort,
    Linear,
    LineOfSightPort,
    Mechanism,
    Output,
    PointAcceleration,
    PointDisplacement,
    PointPosition,
    PointVelocity,
    Port,
    TravelPort,
    UserOutput,
    cylindrical,
    derive,
    free,
    planar,
    revolute,
    spherical,
)

TOLERANCE = 1e-12
AXIS = (0.3, -0.5, 0.8)


@pytest.fixture
def tree() -> Mechanism:
    """Give a free base with two branches of two bodies each."""
    mechanism = Mechanism("tree", gravity=9.81)
    common = {"mass": 2, "inertia": (2, 3, 4)}
    base = mechanism.add_body("base", mechanism.ground, free("yxz"), (0.1, 0, 0.2), **common)
    left = mechanism.add_body("left", base, cylindrical("left_slide", "left_turn", AXIS), (1, 0, 0), **common)
    mechanism.add_body("left_tip", left, spherical("zxz", prefix="tip_"), (2, 0.3, 0), **common)
    right = mechanism.add_body("right", base, planar(("p", "q", "r"), ("y", (1, 0, 1))), (0, -1, 0), **common)
    mechanism.add_body("right_tip", right, revolute("bend", (1, 1, 0)), (0, -2, 0.3), **common)
    mechanism.add_input("shaker", "m")
    return mechanism


def bodies(mechanism: Mechanism) -> list[Body]:
    return [mechanism.ground, *mechanism.bodies]


class Evaluated:
    """The equations' expressions as numbers at one random state."""

    def __init__(self, equations: EquationsOfMotion, lambdified: Callable, seed: int = 0) -> None:
        self.equations, self.program, self._lambdified = equations, equations.program, lambdified
        self.arguments = np.random.default_rng(seed).uniform(-0.7, 0.7, len(equations.arguments))

    def numbers(self, expressions: Sequence[sympy.Expr]) -> np.ndarray:
        function = self._lambdified(self.program, list(self.equations.arguments), list(expressions))
        return np.array([float(value) for value in function(*self.arguments)])

    def time_derivative(self, expressions: Sequence[sympy.Expr]) -> np.ndarray:
        """Derivatives by coordinates, rates and inputs, times their own time derivatives."""
        equations = self.equations
        n = len(equations.coordinates)
        inputs = [u.position for u in equations.system.inputs]
        before = [*equations.arguments[: 2 * n], *inputs]
        after = [*equations.arguments[n : 3 * n], *(u.rate for u in equations.system.inputs)]
        rows = self.program.differentiate(list(expressions), before)
        return self.numbers([sympy.Add(*(a * b for a, b in zip(row, after, strict=True))) for row in rows])


def close(found: np.ndarray, expected: np.ndarray) -> bool:
    return bool(np.abs(found - expected).max() <= TOLERANCE * max(1.0, np.abs(expected).max()))


def outputs_of(mechanism: Mechanism, outputs: Sequence[Output], lambdified: Callable) -> tuple:
    for output in outputs:
        mechanism.add_output(output)
    equations = derive(mechanism)
    evaluated = Evaluated(equations, lambdified)
    return evaluated, [equations.outputs[output.name] for output in outputs]


PAIRS = [(2, 5), (5, 3), (0, 3), (3, 0), (1, 4)]
"""Body of the point, and frame, by their numbers in the tree: ancestors, descendants and other branches."""


@pytest.mark.parametrize(("on", "seen_from"), PAIRS)
def test_velocity_and_acceleration_are_time_derivatives(
    tree: Mechanism, lambdified: Callable, on: int, seen_from: int
) -> None:
    """In the observer's own axes components are differentiated as they are."""
    point = tree.point("sensor", bodies(tree)[on], (0.4, -0.2, 1.1))
    frame = bodies(tree)[seen_from]
    outputs = [
        make
        for axis in ("x", "y", "z", AXIS)
        for make in (
            PointPosition(f"r {axis}", point, axis, frame),
            PointVelocity(f"v {axis}", point, axis, frame, frame),
            PointAcceleration(f"a {axis}", point, axis, frame, frame),
            PointDisplacement(f"d {axis}", point, axis, frame),
        )
    ]
    evaluated, found = outputs_of(tree, outputs, lambdified)
    position, velocity, acceleration, displacement = (found[i::4] for i in range(4))
    assert close(evaluated.numbers(velocity), evaluated.time_derivative(position))
    assert close(evaluated.numbers(acceleration), evaluated.time_derivative(velocity))
    assert close(evaluated.time_derivative(displacement), evaluated.time_derivative(position))
    at_rest = Evaluated(evaluated.equations, lambdified)
    at_rest.arguments[:] = 0
    assert close(at_rest.numbers(displacement), np.zeros(4))


@pytest.mark.parametrize(("on", "axes"), PAIRS)
def test_axes_only_turn_a_vector(tree: Mechanism, lambdified: Callable, on: int, axes: int) -> None:
    """Lengths and angles do not depend on whose axes they are read in."""
    point = tree.point("sensor", bodies(tree)[on], (0.4, -0.2, 1.1))
    body, frame, observer = tree.bodies[1], bodies(tree)[axes], tree.bodies[3]
    makers = {
        "v": lambda name, axis, frame: PointVelocity(name, point, axis, frame, observer),
        "a": lambda name, axis, frame: PointAcceleration(name, point, axis, frame, observer),
        "w": lambda name, axis, frame: AngularVelocity(name, body, axis, frame, observer),
        "e": lambda name, axis, frame: AngularAcceleration(name, body, axis, frame, observer),
    }
    outputs = [
        make(f"{kind}{axis}{i}", axis, each)
        for i, each in enumerate((frame, tree.ground))
        for kind, make in makers.items()
        for axis in "xyz"
    ]
    evaluated, found = outputs_of(tree, outputs, lambdified)
    turned, straight = evaluated.numbers(found).reshape(2, 4, 3)
    assert close(turned @ turned.T, straight @ straight.T)
    assert np.linalg.det(turned[:3]) == pytest.approx(np.linalg.det(straight[:3]))


@pytest.mark.parametrize(("on", "seen_from"), [(a, b) for a, b in PAIRS if a])
def test_angular_acceleration_is_the_time_derivative(
    tree: Mechanism, lambdified: Callable, on: int, seen_from: int
) -> None:
    body, frame = bodies(tree)[on], bodies(tree)[seen_from]
    outputs = [
        make(f"{make.__name__} {axis}", body, axis, frame, frame)
        for make in (AngularVelocity, AngularAcceleration)
        for axis in "xyz"
    ]
    evaluated, found = outputs_of(tree, outputs, lambdified)
    assert close(evaluated.numbers(found[3:]), evaluated.time_derivative(found[:3]))


def test_angular_velocity_moves_what_is_fixed_to_a_body(tree: Mechanism, lambdified: Callable) -> None:
    """Two points of one body: the difference of their velocities is w x r, seen from another branch."""
    body, frame = tree.bodies[2], tree.bodies[4]
    points = [tree.point(name, body, place) for name, place in (("p", (1, 2, 3)), ("q", (2, -1, 4)))]
    outputs = [AngularVelocity(f"w{axis}", body, axis, frame, frame) for axis in "xyz"]
    outputs += [PointPosition(f"r{p.name}{axis}", p, axis, frame) for p in points for axis in "xyz"]
    outputs += [PointVelocity(f"v{p.name}{axis}", p, axis, frame, frame) for p in points for axis in "xyz"]
    evaluated, found = outputs_of(tree, outputs, lambdified)
    w, r1, r2, v1, v2 = evaluated.numbers(found).reshape(5, 3)
    assert close(v2 - v1, np.cross(w, r2 - r1))


PORTS = (
    "travel in another branch",
    "travel of an ancestor",
    "travel over the ground",
    "line of sight",
    "line of sight to the ground",
    "joint",
    "less a motion",
    "combination",
)


def ports(tree: Mechanism) -> dict[str, Port]:
    """Every kind of port, between bodies of different branches."""
    left, right = (tree.point(name, tree.bodies[i], (1.5, 0.5, 0.1 * i)) for name, i in (("l", 2), ("r", 4)))
    anchor = tree.point("anchor", tree.ground, (0, 0, 5))
    travel = TravelPort(left, tree.bodies[4], AXIS)
    return {
        "travel in another branch": travel,
        "travel of an ancestor": TravelPort(tree.point("b", tree.bodies[0], (1, 1, 1)), tree.bodies[2], "y"),
        "travel over the ground": TravelPort(right, tree.ground, "z"),
        "line of sight": LineOfSightPort(left, right),
        "line of sight to the ground": LineOfSightPort(anchor, right),
        "joint": JointPort(tree.coordinate("tip_nutation")),
        "less a motion": LineOfSightPort(left, anchor).less(tree.inputs[0]),
        "combination": CombinedPort(
            ((travel, 2), (TravelPort(right, tree.ground, "x"), sympy.Rational(-1, 3)))
        ),
    }


@pytest.mark.parametrize("name", PORTS)
def test_a_port_does_the_work_it_says(tree: Mechanism, lambdified: Callable, name: str) -> None:
    """Rate = ds/dt, Q = -F ds/dq, s = 0 at the design position."""
    port = ports(tree)[name]
    s, v = sympy.symbols("s v", real=True)
    element = tree.add_force_element("rubber", port, ForceLaw(700 * sympy.sin(s) + 3 * v**3 + 11, s, v))
    readings = [Deflection("s", port), DeflectionRate("v", port), ElementForce("f", element)]
    readings += [ContactForce("contact", element), UserOutput("twice", "N", 2 * s, {s: readings[2]})]
    evaluated, (deflection, rate, force, contact, twice) = outputs_of(tree, readings, lambdified)
    s_now, v_now, f_now, contact_now, twice_now = evaluated.numbers([deflection, rate, force, contact, twice])
    assert v_now == pytest.approx(evaluated.time_derivative([deflection])[0], abs=TOLERANCE)
    assert f_now == pytest.approx(700 * np.sin(s_now) + 3 * v_now**3 + 11)
    assert (contact_now, twice_now) == (pytest.approx(-f_now), pytest.approx(2 * f_now))
    equations = evaluated.equations
    n = len(equations.coordinates)
    (slopes,) = equations.program.differentiate([deflection], equations.arguments[:n])
    assert close(evaluated.numbers(equations.generalized_forces), -f_now * evaluated.numbers(slopes))
    evaluated.arguments[:] = 0
    assert evaluated.numbers([deflection])[0] == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize(("on", "axes"), [(5, 0), (3, 5), (1, 1), (4, 2)])
def test_applied_loads_do_the_work_of_their_motion(
    tree: Mechanism, lambdified: Callable, on: int, axes: int
) -> None:
    """Q = F dv/dq' + T dw/dq', of the velocities along the axes they act in."""
    body, frame = bodies(tree)[on], bodies(tree)[axes]
    point = tree.point("nozzle", body, (0.4, -0.2, 1.1))
    thrust = tree.add_applied_force("thrust", point, AXIS, frame)
    torque = tree.add_applied_torque("torque", body, (0, 1, 2), frame)
    assert (thrust.unit, torque.unit) == ("N", "N*m")
    outputs = [PointVelocity("v", point, AXIS, frame), AngularVelocity("w", body, (0, 1, 2), frame)]
    evaluated, found = outputs_of(tree, outputs, lambdified)
    equations = evaluated.equations
    n = len(equations.coordinates)
    rows = equations.program.differentiate(found, equations.arguments[n : 2 * n])
    force, moment = evaluated.numbers([thrust.position, torque.position])
    expected = [force * a + moment * b for a, b in zip(*rows, strict=True)]
    assert close(evaluated.numbers(equations.generalized_forces), evaluated.numbers(expected))


def test_an_actuator_drives_its_port_up(tree: Mechanism, lambdified: Callable) -> None:
    """A positive command works on a positive rate."""
    command = tree.add_input("command", "N")
    port = ports(tree)["line of sight"]
    tree.add_force_element("strut", port, Actuator(command))
    evaluated, (rate,) = outputs_of(tree, [DeflectionRate("v", port)], lambdified)
    equations = evaluated.equations
    n = len(equations.coordinates)
    power = evaluated.numbers(equations.generalized_forces) @ evaluated.arguments[n : 2 * n]
    pull, speed = evaluated.numbers([command.position, rate])
    assert power == pytest.approx(pull * speed)


def test_a_bushing_is_three_elements(tree: Mechanism) -> None:
    point = tree.point("eye", tree.bodies[2], (1, 1, 1))
    laws = {axis: Linear(100 * (i + 1)) for i, axis in enumerate("xyz")}
    elements = tree.add_bushing("bushing", point, tree.bodies[1], laws)
    assert [elements[axis].name for axis in "xyz"] == ["bushing_x", "bushing_y", "bushing_z"]
    assert [elements[axis].port.axis for axis in "xyz"] == list("xyz")
    assert [elements[axis].characteristic.stiffness for axis in "xyz"] == [100, 200, 300]


@pytest.mark.parametrize("axes", list(permutations("xyz")))
def test_every_sequence_of_different_axes_is_regular_at_rest(axes: tuple[str, ...]) -> None:
    top = Mechanism("top", gravity=0)
    top.add_body("top", top.ground, spherical("".join(axes)), (0, 0, 0), mass=1, inertia=(1, 2, 2))
    distance = derive(top).program.expand([derive(top).singularities["top"]])[0]
    second = top.coordinates[1].position
    assert sympy.simplify(distance**2 - sympy.cos(second) ** 2) == 0
