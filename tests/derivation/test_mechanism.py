"""What a mechanism refuses: one line that names the part, before anything is derived."""

from collections.abc import Callable

import pytest
import sympy

from chassym.derivation import (
    AngularVelocity,
    Body,
    Coordinate,
    DamperTable,
    JointPort,
    Linear,
    Mechanism,
    MechanismError,
    PointAcceleration,
    PointDisplacement,
    TravelPort,
    derive,
    free,
    prismatic,
    revolute,
    weld,
)
from chassym.derivation.symbols import ParameterSymbols


@pytest.fixture
def cart() -> Mechanism:
    """Give a cart on a rail, ready for more parts."""
    mechanism = Mechanism("test bench", sympy.Float(9.81))
    mechanism.add_body("cart", mechanism.ground, prismatic("along", "x"), (0, 0, 0), mass=1)
    mechanism.add_input("shaker", "m")
    mechanism.add_force_element("rubber", travel(mechanism), Linear(sympy.S.One))
    mechanism.add_output(
        PointDisplacement("reading", mechanism.point("p", body(mechanism), (0, 0, 0)), "x", mechanism.ground)
    )
    return mechanism


def body(mechanism: Mechanism) -> Body:
    return mechanism.bodies[0]


def travel(mechanism: Mechanism) -> TravelPort:
    return TravelPort(mechanism.point("p", body(mechanism), (0, 0, 0)), mechanism.ground, "x")


def add_body(mechanism: Mechanism, name: str, coordinate: str) -> None:
    mechanism.add_body(name, mechanism.ground, prismatic(coordinate, "z"), (0, 0, 0), mass=1)


def add_output(mechanism: Mechanism, name: str) -> None:
    mechanism.add_output(AngularVelocity(name, body(mechanism), "x", mechanism.ground))


TAKEN = ["cart", "along", "shaker", "rubber", "reading", "ground"]
WAYS: dict[str, Callable[[Mechanism, str], object]] = {
    "body": lambda m, name: add_body(m, name, "other"),
    "coordinate": lambda m, name: add_body(m, "other", name),
    "input": lambda m, name: m.add_input(name, "m"),
    "force element": lambda m, name: m.add_force_element(name, travel(m), Linear(sympy.S.One)),
    "output": add_output,
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", TAKEN)
def test_a_name_is_given_once(cart: Mechanism, way: str, name: str) -> None:
    with pytest.raises(MechanismError, match=f"'test bench'.*'{name}'") as caught:
        WAYS[way](cart, name)
    assert "\n" not in str(caught.value)


def test_a_free_body_may_not_repeat_a_coordinate(cart: Mechanism) -> None:
    with pytest.raises(MechanismError, match="'x'"):
        cart.add_body("first", cart.ground, free().then(prismatic("x", "x")), (0, 0, 0), mass=1)


def test_a_parent_of_another_mechanism_is_refused(cart: Mechanism) -> None:
    other = Mechanism("elsewhere", sympy.S.Zero)
    with pytest.raises(MechanismError, match=r"'wheel'.*'cart'.*'elsewhere'"):
        other.add_body("wheel", body(cart), prismatic("z", "z"), (0, 0, 0), mass=1)
    with pytest.raises(MechanismError, match=r"'hub'.*'ground'.*'elsewhere'"):
        other.add_body("hub", cart.ground, prismatic("up", "z"), (0, 0, 0), mass=1)


def test_a_point_on_a_body_of_another_mechanism_is_refused(cart: Mechanism) -> None:
    other = Mechanism("elsewhere", sympy.S.Zero)
    with pytest.raises(MechanismError, match=r"'tip'.*'cart'.*'elsewhere'"):
        other.point("tip", body(cart), (0, 0, 0))


@pytest.mark.parametrize("make", [revolute, prismatic])
@pytest.mark.parametrize("axis", ["X", "w", "xy", ""])
def test_an_unknown_axis_is_refused(make: Callable, axis: str) -> None:
    with pytest.raises(MechanismError, match=f"'angle'.*'{axis}'.*'x', 'y', 'z'"):
        make("angle", axis)


@pytest.mark.parametrize(
    ("joint", "properties", "coordinate"),
    [
        (prismatic("slide", "y"), {}, "slide"),
        (revolute("turn", "z"), {}, "turn"),
        (revolute("turn", "z"), {"mass": 1}, "turn"),
        (revolute("turn", "z"), {"inertia": (1, 1, 0)}, "turn"),
        (prismatic("slide", "y"), {"inertia": (1, 1, 1)}, "slide"),
        (prismatic("slide", "y").then(revolute("turn", "x")), {"mass": 1}, "turn"),
    ],
)
def test_a_coordinate_that_moves_no_mass_is_refused(
    cart: Mechanism, joint: object, properties: dict, coordinate: str
) -> None:
    cart.add_body("feather", body(cart), joint, (1, 2, 3), **properties)
    with pytest.raises(MechanismError, match=f"'{coordinate}' moves no mass") as caught:
        derive(cart)
    assert "\n" not in str(caught.value)


def test_a_massless_body_may_carry_others(cart: Mechanism) -> None:
    hub = cart.add_body("hub", body(cart), revolute("steer", "z"), (0, 0, 0))
    cart.add_body("rim", hub, weld(), (0.1, 0, 0), mass=2)
    matrix = derive(cart).mass_matrix
    assert matrix[1][1] == pytest.approx(2 * 0.1**2)


@pytest.mark.parametrize("use", ["port", "acceleration", "displacement", "velocity"])
def test_a_frame_must_be_an_ancestor(cart: Mechanism, use: str) -> None:
    """What stands beside the cart is not jointed to it; its motion seen from the cart has no path."""
    beside = cart.add_body("beside", cart.ground, prismatic("up", "z"), (0, 0, 0), mass=1)
    point = cart.point("q", beside, (0, 0, 0))
    match use:
        case "port":
            cart.add_force_element("link", TravelPort(point, body(cart), "x"), Linear(sympy.S.One))
        case "acceleration":
            cart.add_output(PointAcceleration("out", point, "x", body(cart)))
        case "displacement":
            cart.add_output(PointDisplacement("out", point, "x", body(cart)))
        case "velocity":
            cart.add_output(AngularVelocity("out", beside, "x", body(cart)))
    with pytest.raises(MechanismError, match=r"'beside'.*'cart'") as caught:
        derive(cart)
    assert "\n" not in str(caught.value)


def test_a_child_is_no_frame_for_its_parent(cart: Mechanism) -> None:
    child = cart.add_body("child", body(cart), prismatic("up", "z"), (0, 0, 0), mass=1)
    cart.add_output(PointDisplacement("out", cart.point("q", body(cart), (0, 0, 0)), "x", child))
    with pytest.raises(MechanismError, match=r"'cart'.*'child'"):
        derive(cart)


def test_a_table_needs_as_many_forces_as_velocities(cart: Mechanism) -> None:
    table = DamperTable(sympy.symbols("v:3"), sympy.symbols("f:2"))
    cart.add_force_element("damper", travel(cart), table)
    with pytest.raises(ValueError, match="shorter"):
        derive(cart)


def test_an_unknown_parameter_symbol_is_refused_by_name(quarter_car: object) -> None:
    symbols = ParameterSymbols(quarter_car.parameters)  # type: ignore[attr-defined]
    with pytest.raises(KeyError, match="'sprung.weight'"):
        symbols("sprung.weight")
    with pytest.raises(KeyError, match="'damper.velocity'"):
        symbols("damper.velocity")
    with pytest.raises(KeyError, match="'sprung.mass'"):
        symbols.table("sprung.mass")


def test_a_vehicle_that_is_nowhere_is_refused_by_name() -> None:
    from chassym.derivation import ParameterError, load_model

    with pytest.raises(ParameterError, match=r"'lorry'.*quarter_car, sedan"):
        load_model("lorry")


def test_inertia_without_mass_keeps_its_gyroscopic_terms() -> None:
    """A free rotor's equations do not ask whether it has a mass at its centre."""
    a, b, c, m = sympy.symbols("a b c m", positive=True)
    biases = []
    for mass in (0, m):
        rotor = Mechanism("rotor", gravity=0)
        joint = revolute("yaw", "z").then(revolute("pitch", "y")).then(revolute("roll", "x"))
        rotor.add_body("rotor", rotor.ground, joint, (0, 0, 0), mass=mass, inertia=(a, b, c))
        equations = derive(rotor)
        biases.append(equations.program.expand(equations.bias))
    assert any(entry != 0 for entry in biases[0])
    assert [sympy.simplify(x - y) for x, y in zip(*biases, strict=True)] == [0, 0, 0]


@pytest.mark.parametrize("name", ["z_rate", "z_acceleration"])
def test_names_of_derivatives_are_taken_too(name: str) -> None:
    cart = Mechanism("cart", gravity=0)
    cart.add_body("cart", cart.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    with pytest.raises(MechanismError, match=f"'{name}' is taken"):
        cart.add_input(name, "m")


def test_names_of_intermediate_results_are_kept_apart() -> None:
    cart = Mechanism("cart", gravity=0)
    with pytest.raises(MechanismError, match="'_0' begins with an underscore"):
        cart.add_input("_0", "m")


def test_a_force_on_a_coordinate_that_no_joint_has_is_refused() -> None:
    cart = Mechanism("cart", gravity=0)
    cart.add_body("cart", cart.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    cart.add_force_element("spring", JointPort(Coordinate("typo", "m")), Linear(1))
    with pytest.raises(MechanismError, match="coordinate 'typo' in m, which no joint has; there are z"):
        derive(cart)


def test_a_frame_of_another_mechanism_is_refused() -> None:
    cart, other = Mechanism("cart", gravity=0), Mechanism("other", gravity=0)
    body = cart.add_body("cart", cart.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    stranger = other.add_body("stranger", other.ground, prismatic("x", "x"), (0, 0, 0), mass=1)
    travel = TravelPort(cart.point("hook", body, (0, 0, 0)), stranger, "z")
    cart.add_force_element("spring", travel, Linear(1))
    with pytest.raises(MechanismError, match="body 'stranger' is not in this mechanism"):
        derive(cart)
