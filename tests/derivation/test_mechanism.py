"""What a mechanism refuses: one line that names the part, before anything is derived."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    Actuator,
    AngularVelocity,
    Body,
    CombinedPort,
    CompiledEquations,
    ContactForce,
    Coordinate,
    DamperTable,
    Deflection,
    ForceLaw,
    Input,
    JointPort,
    Linear,
    LineOfSightPort,
    Mechanism,
    MechanismError,
    PointDisplacement,
    SpringTable,
    TravelPort,
    Unilateral,
    UserOutput,
    build_model,
    derive,
    free,
    planar,
    prismatic,
    revolute,
    spherical,
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
    other.add_body("hub", cart.ground, prismatic("up", "z"), (0, 0, 0), mass=1)  # there is one ground


def test_a_point_on_a_body_of_another_mechanism_is_refused(cart: Mechanism) -> None:
    other = Mechanism("elsewhere", sympy.S.Zero)
    with pytest.raises(MechanismError, match=r"'tip'.*'cart'.*'elsewhere'"):
        other.point("tip", body(cart), (0, 0, 0))


@pytest.mark.parametrize("properties", [{"inertia": (1, 1, 1)}, {"mass": 1}], ids=["slide", "turn"])
def test_a_coordinate_that_moves_no_mass_is_refused(cart: Mechanism, properties: dict) -> None:
    """A slide moves no inertia without mass, and a turn no mass on its axis."""
    joint = prismatic("turn", "y") if "inertia" in properties else revolute("turn", "z")
    cart.add_body("feather", body(cart), joint, (1, 2, 3), **properties)
    with pytest.raises(MechanismError, match="'turn' moves no mass") as caught:
        derive(cart)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("make", [derive, lambda m: CompiledEquations(m).residual], ids=["derive", "compile"])
def test_a_massless_leaf_is_refused(cart: Mechanism, make: Callable) -> None:
    hub = cart.add_body("hub", body(cart), revolute("turn", "z"), (0, 0, 0))
    cart.add_body("label", hub, weld(), (0, 0, 1))
    with pytest.raises(MechanismError, match="body 'hub' moves and has no mass") as caught:
        make(cart)
    assert "\n" not in str(caught.value)


def test_a_massless_body_may_carry_others(cart: Mechanism) -> None:
    hub = cart.add_body("hub", body(cart), revolute("steer", "z"), (0, 0, 0))
    cart.add_body("rim", hub, weld(), (0.1, 0, 0), mass=2)
    matrix = derive(cart).mass_matrix
    assert matrix[1][1] == pytest.approx(2 * 0.1**2)


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

    with pytest.raises(ParameterError, match=r"'lorry'.*quarter_car, .*sedan"):
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


def test_a_name_that_is_taken_says_by_what() -> None:
    cart = Mechanism("cart", gravity=0)
    body = cart.add_body("cart", cart.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    output = PointDisplacement("cart", cart.point("centre", body, (0, 0, 0)), "z", cart.ground)
    with pytest.raises(MechanismError, match="'cart' is taken by a body; an output needs another one$"):
        cart.add_output(output)


def test_names_of_intermediate_results_are_kept_apart() -> None:
    cart = Mechanism("cart", gravity=0)
    with pytest.raises(MechanismError, match="'_0' begins with an underscore"):
        cart.add_input("_0", "m")


@pytest.fixture
def stranger() -> Mechanism:
    """Give another mechanism with the same names in it."""
    other = Mechanism("elsewhere", gravity=0)
    other.add_body("visitor", other.ground, prismatic("x", "x"), (0, 0, 0), mass=1)
    other.add_input("hand", "m")
    other.add_force_element("tie", JointPort(other.coordinate("x")), Linear(1))
    return other


PARTS: dict[str, Callable[[Mechanism, Mechanism], object]] = {
    "coordinate 'typo'": lambda m, o: m.add_force_element(
        "new", JointPort(Coordinate("typo", "m")), Linear(1)
    ),
    "coordinate 'x'": lambda m, o: m.add_force_element("new", JointPort(o.coordinates[0]), Linear(1)),
    "body 'visitor'": lambda m, o: m.add_force_element(
        "new", TravelPort(m.point("hook", body(m), (0, 0, 0)), body(o), "z"), Linear(1)
    ),
    "input 'hand'": lambda m, o: m.add_force_element("new", travel(m).less(o.inputs[0]), Linear(1)),
    "input 'hand' ": lambda m, o: m.add_force_element("new", travel(m), Actuator(Input("hand", "N"))),
    "force element 'tie'": lambda m, o: m.add_output(ContactForce("new", o.elements[0])),
    "body 'visitor' ": lambda m, o: m.add_output(AngularVelocity("new", body(o), "x", m.ground)),
    "body 'visitor'  ": lambda m, o: m.add_output(AngularVelocity("new", body(m), "x", m.ground, body(o))),
    "body 'visitor'   ": lambda m, o: m.add_applied_torque("new", body(o), "x", m.ground),
    "coordinate 'x' ": lambda m, o: m.add_output(
        UserOutput(
            "new", "m", sympy.S.One, {sympy.Symbol("s"): Deflection("inner", JointPort(o.coordinates[0]))}
        )
    ),
}


@pytest.mark.parametrize("part", PARTS)
def test_what_is_not_in_the_mechanism_is_refused(cart: Mechanism, stranger: Mechanism, part: str) -> None:
    with pytest.raises(MechanismError, match=f"{part.strip()} is not in mechanism 'test bench'") as caught:
        PARTS[part](cart, stranger)
    assert "\n" not in str(caught.value)
    cart.add_input("new", "m")  # the name is still free


def test_an_unknown_coordinate_is_refused(cart: Mechanism) -> None:
    with pytest.raises(MechanismError, match="'test bench': no coordinate 'up'; there are along"):
        cart.coordinate("up")


AXES: dict[str, Callable[[Mechanism, object], object]] = {
    "'angle'": lambda m, axis: revolute("angle", axis),
    "'slide'": lambda m, axis: prismatic("slide", axis),
    "'p'": lambda m, axis: TravelPort(m.point("p", body(m), (0, 0, 0)), m.ground, axis),
    "'new'": lambda m, axis: m.add_output(AngularVelocity("new", body(m), axis, m.ground)),
    "'thrust'": lambda m, axis: m.add_applied_torque("thrust", body(m), axis, m.ground),
}


@pytest.mark.parametrize("place", AXES)
@pytest.mark.parametrize(
    "axis", ["X", "w", "xy", "", (0, 0, 0), (0.0, 0, 0), (1, 2), (1, 2, float("nan")), True, None]
)
def test_a_direction_that_is_none_is_refused(cart: Mechanism, place: str, axis: object) -> None:
    with pytest.raises(MechanismError, match=f"{place}.*expected") as caught:
        AXES[place](cart, axis)
    assert "\n" not in str(caught.value)


def test_an_axis_of_any_length_and_sense_will_do() -> None:
    assert revolute("a", (0, 0, -3)).steps[0].axis == (0, 0, -1)
    assert revolute("a", (0.0, 2.5, 0.0)).steps[0].axis == (0, 1, 0)
    assert prismatic("a", (3, 0, 4)).steps[0].axis == (sympy.Rational(3, 5), 0, sympy.Rational(4, 5))


DEPENDENT: dict[str, Callable[[], object]] = {
    "'a', 'b'.*1 degrees": lambda: prismatic("a", "x").then(prismatic("b", "x")),
    "'a', 'b'.*1 deg": lambda: revolute("a", "z").then(revolute("b", (0, 0, -1))),
    "'a', 'b', 'c'.*2 degrees": lambda: (
        prismatic("a", "x").then(prismatic("b", "y")).then(prismatic("c", (1, 1, 0)))
    ),
    "'roll', 'again'.*3 degrees": lambda: spherical().then(revolute("again", "x")),
    "'roll', 'x', .*6 degrees": lambda: spherical().then(free(prefix="")),
}


@pytest.mark.parametrize("message", DEPENDENT)
def test_steps_that_repeat_each_other_are_refused(message: str) -> None:
    with pytest.raises(MechanismError, match=message):
        DEPENDENT[message]()


@pytest.mark.parametrize("sequence", ["xxy", "xyy", "xy", "xyzx", "abc", ""])
def test_a_rotation_sequence_that_is_none_is_refused(sequence: str) -> None:
    with pytest.raises(MechanismError, match=f"rotation sequence '{sequence}'"):
        spherical(sequence)


def test_a_planar_joint_needs_two_directions() -> None:
    with pytest.raises(MechanismError, match="x, y, yaw: its two axes are parallel"):
        planar(axes=("x", (-2, 0, 0)))


def test_a_second_joint_for_a_body_is_a_loop(cart: Mechanism) -> None:
    arm = cart.add_body("arm", body(cart), revolute("swing", "y"), (0, 0, 0), mass=1)
    cart.add_body("rod", arm, revolute("bend", "y"), (0, 0, -1), mass=1)
    with pytest.raises(MechanismError, match="'rod' hangs on 'arm' already; .* 'ground' would close a loop"):
        cart.add_body("rod", cart.ground, revolute("foot", "y"), (0, 0, -2), mass=1)


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({"mass": -1}, "mass -1"),
        ({"mass": float("nan")}, "mass: received nan"),
        ({"mass": 1, "inertia": (1, -1, 1)}, "-1, 1, 1 about the mass centre"),
        ({"mass": 1, "inertia": (1, 1)}, "three principal moments"),
        ({"mass": 1, "inertia": ((1, 0, 0), (0, 1, 0))}, "three rows of three"),
        ({"mass": 1, "inertia": ((1, 0.1, 0), (0.2, 1, 0), (0, 0, 1))}, "symmetric"),
        ({"mass": 2, "inertia": (1, 1, 1), "inertia_about": (1, 0, 0)}, "-1, -1, 1"),
    ],
)
def test_mass_and_inertia_that_no_body_has_are_refused(
    cart: Mechanism, properties: dict, message: str
) -> None:
    with pytest.raises(MechanismError, match=f"body 'block'.*{message}|{message}") as caught:
        cart.add_body("block", body(cart), revolute("turn", "x"), (0, 0, 0), **properties)
    assert "'block'" in str(caught.value)
    assert "\n" not in str(caught.value)
    cart.add_input("turn", "m")  # the name is still free


def test_a_tensor_turned_by_numbers_is_symmetric_enough(cart: Mechanism) -> None:
    """One rounding makes the elements that face each other differ in their last digit."""
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    tensor = turn @ np.diag([1, 2, 2.5]) @ turn.T
    assert not (tensor == tensor.T).all()
    block = cart.add_body("block", body(cart), revolute("turn", "x"), (0, 0, 0), mass=3, inertia=tensor)
    assert np.array(block.inertia.rows(), dtype=float) == pytest.approx(tensor)


def test_points_at_one_place_have_no_line_of_sight(cart: Mechanism) -> None:
    ends = [cart.point(name, part, (1, 0, 0)) for name, part in (("a", body(cart)), ("b", cart.ground))]
    with pytest.raises(MechanismError, match="points 'a' and 'b' coincide"):
        LineOfSightPort(*ends)


def test_a_combination_of_nothing_is_refused() -> None:
    with pytest.raises(MechanismError, match="no deflections"):
        CombinedPort(())


@pytest.mark.parametrize(
    ("places", "forces"),
    [((1,), (1,)), ((0, 1, 2), (0, 1)), ((0, 1, 1), (0, 1, 2)), ((0, 2, 1.5), (0, 1, 2))],
)
@pytest.mark.parametrize("table", [DamperTable, SpringTable])
def test_a_table_that_is_none_is_refused(table: Callable, places: tuple, forces: tuple) -> None:
    with pytest.raises(MechanismError, match="table"):
        table(places, forces)


def test_an_actuator_pulls_with_a_force() -> None:
    with pytest.raises(MechanismError, match="actuator: input 'road' is in m"):
        Actuator(Input("road", "m"))


def oscillator(law: object = None, mass: object = 1, **kwargs: object) -> Mechanism:
    """Make a mass on a slide, on one force element."""
    mechanism = Mechanism("oscillator", gravity=0)
    mechanism.add_body("block", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=mass, **kwargs)
    port = JointPort(mechanism.coordinate("z"))
    mechanism.add_force_element("spring", port, law or Linear(sympy.Symbol("k")))
    return mechanism


def named(name: str) -> sympy.Symbol:
    return sympy.Symbol(name, real=True)


AMBIGUOUS: dict[str, Callable[[], Mechanism]] = {
    "'block': the name of symbol 'z' is that of a coordinate": lambda: oscillator(
        mass_centre=(named("z"), 0, 0)
    ),
    "'spring': the name of symbol 'z' is that": lambda: oscillator(Linear(named("z"))),
    "'spring': the name of symbol 'z_rate' is that": lambda: oscillator(Linear(sympy.Symbol("z_rate"))),
    "'spring': the name of symbol 'spring.slope' is that": lambda: oscillator(
        DamperTable((-1, 0, named("spring.slope")), (0, 1, 2))
    ),
    "'block': the name of symbol '_0' begins with an underscore": lambda: oscillator(mass=named("_0")),
    "'spring': the name of symbol 'm' stands for two": lambda: oscillator(
        Linear(named("m")), mass=sympy.Symbol("m")
    ),
    "'spring': the name of symbol 'z' is a coordinate's": lambda: oscillator(
        ForceLaw(sympy.Symbol("z") * named("s"), named("s"))
    ),
}


@pytest.mark.parametrize("message", AMBIGUOUS)
def test_a_symbol_that_means_two_things_is_refused(message: str) -> None:
    with pytest.raises(MechanismError, match=message) as caught:
        derive(AMBIGUOUS[message]())
    assert "\n" not in str(caught.value)


def test_a_formula_may_mention_the_motion() -> None:
    """A force law that knows more than its own deflection, and an output of the coordinate."""
    s, z = named("s"), named("z")
    mechanism = oscillator(ForceLaw(s * (1 + z**2), s))
    mechanism.add_output(UserOutput("square", "m^2", z**2))
    equations = derive(mechanism)
    assert equations.program.expand(equations.generalized_forces) == [-z * (z**2 + 1)]
    assert equations.program.expand([equations.outputs["square"]]) == [z**2]


def test_what_is_added_later_does_not_count() -> None:
    """A model, and the equations, are those of the mechanism at the time."""
    mechanism = oscillator()
    model, equations = build_model(mechanism, {"k": 3}), derive(mechanism)
    mechanism.add_force_element("second", JointPort(mechanism.coordinate("z")), Linear(sympy.Symbol("k")))
    mechanism.add_input("late", "m")
    mechanism.add_output(UserOutput("twice", "m", 2 * named("z")))
    state = np.array([[1.0], [0.0], [0.0]])
    assert model.residual(state) == pytest.approx(3) and model.output_names == []
    assert build_model(equations, {"k": 3}).residual(state) == pytest.approx(3)
    longer = np.array([[1.0], [0.0], [0.0], [5.0], [7.0]])
    assert build_model(mechanism, {"k": 3}).residual(longer) == pytest.approx(6)


WRONG_KINDS: dict[str, Callable[[Mechanism], object]] = {
    "body 'new': parent: received 'cart', expected a Body": lambda m: m.add_body(
        "new", "cart", prismatic("n", "z"), (0, 0, 0), mass=1
    ),
    "parent: received .*list|parent: received \\[": lambda m: m.add_body(
        "new", [body(m)], prismatic("n", "z"), (0, 0, 0), mass=1
    ),
    "body 'new': joint: received 'x', expected a Joint": lambda m: m.add_body("new", body(m), "x", (0, 0, 0)),
    "body 'new': mass: received '3 kg'": lambda m: add_block(m, mass="3 kg"),
    "body 'new': mass: received None": lambda m: add_block(m, mass=None),
    "body 'new': mass: received True": lambda m: add_block(m, mass=True),
    "body 'new': mass: received I": lambda m: add_block(m, mass=sympy.I),
    "body 'new': origin: 2 components": lambda m: add_block(m, origin=(0, 0)),
    "body 'new': origin: received 0": lambda m: add_block(m, origin=0),
    "body 'new': origin: received '000'": lambda m: add_block(m, origin="000"),
    "body 'new': origin: received nan": lambda m: add_block(m, origin=(0, 0, float("nan"))),
    "body 'new': inertia": lambda m: add_block(m, inertia=1),
    "point 'new': body: received 'cart'": lambda m: m.point("new", "cart", (0, 0, 0)),
    "joint port: received 'along', expected a Coordinate; mechanism.coordinate": lambda m: JointPort("along"),
    "travel: point: received .*Body|travel: point: received Body": lambda m: TravelPort(
        body(m), m.ground, "z"
    ),
    "combination: expected pairs": lambda m: CombinedPort((travel(m), 1)),
    "combination: port: received 'z'": lambda m: CombinedPort((("z", 1),)),
    "prescribed motion: received .*Coordinate": lambda m: travel(m).less(m.coordinates[0]),
    "input 'pull' is in N; expected m": lambda m: travel(m).less(m.add_input("pull", "N")),
    "input 'new': unit 'mm' received": lambda m: m.add_input("new", "mm"),
    "force element 'new': port: received .*Linear": lambda m: m.add_force_element(
        "new", Linear(1), travel(m)
    ),
    "force element 'new': characteristic: received k": lambda m: m.add_force_element(
        "new", travel(m), sympy.Symbol("k")
    ),
    r"command is in N\*m, expected N": lambda m: m.add_force_element(
        "new", travel(m), Actuator(m.add_input("moment", "N*m"))
    ),
    "linear law: stiffness: received '20 N/mm'": lambda m: Linear("20 N/mm"),
    "linear law: damping: received nan": lambda m: Linear(1, float("nan")),
    "force law: received 'x'": lambda m: ForceLaw("x"),
    "force law: variable: received 's'": lambda m: ForceLaw(sympy.Symbol("s"), "s"),
    "unilateral law: received k": lambda m: Unilateral(sympy.Symbol("k")),
    "output 'new': port: received": lambda m: Deflection("new", m.elements[0]),
    "output 'new': element: received": lambda m: ContactForce("new", travel(m)),
    "output 'new': body: received": lambda m: AngularVelocity("new", "cart", "x", m.ground),
    "output: received 'z'": lambda m: m.add_output("z"),
    "gravity: received nan": lambda m: Mechanism("new", gravity=float("nan")),
    "bushing 'new': axis 'w'": lambda m: m.add_bushing(
        "new", m.point("p", body(m), (0, 0, 0)), m.ground, {"x": Linear(1), "w": Linear(1)}
    ),
}


def add_block(mechanism: Mechanism, **properties: object) -> None:
    origin = properties.pop("origin", (0, 0, 0))
    mechanism.add_body("new", body(mechanism), prismatic("n", "z"), origin, **({"mass": 1} | properties))


@pytest.mark.parametrize("message", WRONG_KINDS)
def test_what_is_of_the_wrong_kind_is_refused_where_it_is_given(cart: Mechanism, message: str) -> None:
    with pytest.raises(MechanismError, match=message) as caught:
        WRONG_KINDS[message](cart)
    assert "\n" not in str(caught.value)
    elements = [element.name for element in cart.elements]
    assert elements == ["rubber"] and [each.name for each in cart.bodies] == ["cart"]


def test_nothing_that_moves_is_no_mechanism() -> None:
    statue = Mechanism("statue", gravity=1)
    statue.add_body("block", statue.ground, weld(), (0, 0, 0), mass=1)
    with pytest.raises(MechanismError, match="'statue' has no coordinates"):
        derive(statue)


def test_a_table_inside_a_unilateral_law_takes_its_slope_from_the_rule() -> None:
    table = DamperTable((-1, 0, 1), (-40, 0, 10))
    mechanism = oscillator(Unilateral(table))
    mechanism.add_force_element("hold", JointPort(mechanism.coordinate("z")), Linear(1, 0))
    assert mechanism.knotted == {"spring": table}
    slope = mechanism.slopes["spring"]
    equations = derive(mechanism)
    (row,) = equations.linearisation
    rate = equations.program.expand([row[1]])[0]
    pushing = dict.fromkeys(equations.arguments, 0) | {mechanism.coordinate("z").rate: -1}
    assert rate.xreplace(pushing | {slope: sympy.Integer(77)}) == 77


def test_values_of_a_table_have_to_increase() -> None:
    places = sympy.symbols("v:3", real=True)
    mechanism = oscillator(DamperTable(places, (-1, 0, 1)))
    for values in ((1, 0.5, -1), (0, 0, 1)):
        with pytest.raises(MechanismError, match="'spring': a place of its table .* increasing places"):
            _ = build_model(mechanism, dict(zip(places, values, strict=True))).residual


def test_equations_refuse_derivatives_by_strangers() -> None:
    equations = derive(oscillator(mass=sympy.Symbol("m", positive=True)))
    with pytest.raises(ValueError, match="variables: m is no argument or parameter"):
        equations.jacobian([sympy.Symbol("m")])
