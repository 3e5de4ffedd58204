"""The glossary: complete for every built-in vehicle, unambiguous, and valid LaTeX for any name."""

import re
from functools import cache

import pytest
import sympy
from matplotlib.mathtext import MathTextParser

from chassym.derivation import (
    JointPort,
    Linear,
    Mechanism,
    SpringTable,
    derive,
    prismatic,
    revolute,
    spherical,
    vehicle_names,
)
from chassym.derivation.reading.element_symbols import element_symbols
from chassym.derivation.reading.glossary import glossary
from chassym.derivation.reading.lagrange_form import is_short
from chassym.derivation.reading.written_form import straight_line_form, written_form

PARSER = MathTextParser("path")


@cache
def parse(formula):
    """Typeset a formula once."""
    PARSER.parse(f"${formula}$")


@pytest.fixture(scope="module", params=vehicle_names())
def model(request, built_in):
    """Give every built-in vehicle; the smaller ones with all derived quantities on the program."""
    found = built_in(request.param)
    assert not is_short(found.equations) or found.equations.linearisation
    return found


def printed(equations):
    """Give the symbols of everything that is printed."""
    if not is_short(equations):
        form = straight_line_form(equations)
        return set().union(*(row.symbols for row in (*form.steps, *form.results))) - set(form.names)
    form = written_form(equations)
    energies = (equations.kinetic_energy, equations.potential_energy, equations.dissipation)
    expressions = (*energies, equations.lagrangian, *equations.lagrange_equations)
    rows = (*form.energies, *form.elements, *form.motion)
    return set().union(*(e.free_symbols for e in expressions), *(row.symbols for row in rows))


def test_every_symbol_has_a_description_and_a_unit(model):
    equations, entries = model.equations, model.glossary
    # Directions and sides are on the program, and no part of the equations.
    _ = equations.linearisation_change, equations.held_right_hand_side
    program = equations.program.definitions
    mentioned = printed(equations) | set(equations.arguments) | set(equations.parameters)
    directions = {*equations.motion.values(), *equations.change.values(), *equations.sides}
    for expression in program.values():
        mentioned |= expression.free_symbols - set(program) - directions
    missing = [symbol for symbol in mentioned if symbol not in entries]
    assert missing == []
    for symbol, entry in entries.items():
        assert entry.symbol == symbol
        assert entry.description.strip() and entry.unit.strip() and entry.latex.strip()


def test_parameters_are_described_as_in_the_vehicle_file(model):
    for symbol, entry in model.glossary.items():
        name = symbol.name.partition("[")[0]
        if name in model.parameters:
            assert entry.unit == model.parameters[name].unit
            assert entry.description.startswith(model.parameters[name].description)


def test_no_two_symbols_look_alike(model):
    for entries in (model.glossary, glossary(model.equations)):
        looks = [entry.latex for entry in entries.values()]
        assert len(set(looks)) == len(looks)
        assert not {"T", "V", "D", "M", "h", "Q"} & set(looks)


def test_every_symbol_can_be_typeset(model):
    for entry in model.glossary.values():
        parse(re.sub(r"\d+", "1", entry.latex))  # all digits are one to the parser


def test_without_a_parameter_set_units_of_parameters_are_unknown(model):
    entries = glossary(model.equations)
    assert entries.keys() == model.glossary.keys()
    for symbol, entry in entries.items():
        if symbol.name.partition("[")[0] in model.parameters:
            assert (entry.unit, entry.description) == ("", "parameter")
        else:
            assert entry == model.glossary[symbol] or entry.unit == model.glossary[symbol].unit


@pytest.mark.parametrize(
    ("vehicle", "name", "latex"),
    [
        ("quarter_car", "sprung.mass", r"m_{\text{sprung}}"),
        ("quarter_car", "spring.rate", r"k_{\text{spring}}"),
        ("quarter_car", "damper.force[3]", r"F_{\text{damper},3}"),
        ("half_car", "gravity", "g"),
        ("half_car", "body.inertia.yy", r"I_{\text{body},yy}"),
        ("half_car", "body.mass_centre.x", r"x_{\text{body mass centre}}"),
        ("half_car", "tyre.rear.damping", r"c_{\text{tyre rear}}"),
        ("half_car", "pitch_acceleration", r"\ddot{\theta}"),
        ("half_car", "front_travel_rate", r"\dot{z}_{\text{front travel}}"),
        ("half_car", "front_road_rate", r"\dot{u}_{\text{front road}}"),
        ("sedan", "yaw", r"\psi"),
        ("sedan", "roll", r"\varphi"),
        ("sedan", "tyre.front.stiffness.y", r"k_{\text{tyre front},y}"),
        ("sedan", "suspension.rear.spring.lever_ratio", r"i_{\text{suspension rear spring}}"),
        ("torsion_chain", "stiffness.front", r"k_{\text{front}}"),
    ],
)
def test_letters_are_those_of_the_field(vehicle, name, latex, built_in):
    model = built_in(vehicle)
    assert model.glossary[sympy.Symbol(name, real=True)].latex == latex


def test_coordinates_are_described_by_their_joints(sedan):
    entries = {symbol.name: entry for symbol, entry in sedan.glossary.items()}
    assert (
        entries["front_torsion"].description == "rotation of front_section relative to middle_section about x"
    )
    assert entries["pitch"].description == "rotation of middle_section relative to ground about y, after yaw"
    assert entries["front_left_pad_z"].description == "prescribed displacement of front left pad z"
    assert (entries["pitch_acceleration"].unit, entries["z_rate"].unit) == ("rad/s^2", "m/s")


def awkward():
    """Give a mechanism whose parts have names that LaTeX has to be protected from."""
    mass, stiff, energy = (
        sympy.Symbol("a_b", positive=True),
        sympy.Symbol("50 %&#{", real=True),
        sympy.Symbol("T"),
    )
    mechanism = Mechanism("100 % {awkward}_\\", gravity=sympy.Symbol("g"))
    joint = prismatic("s_left", "z").then(revolute("été φ", (1, 1, 0)))
    body = mechanism.add_body("~body^", mechanism.ground, joint, (0, 0, 0), mass=mass, inertia=(energy,) * 3)
    mechanism.add_body("top", body, spherical("zxz", prefix="top_"), (0, 0, 0), inertia=(energy,) * 3)
    coordinate = mechanism.coordinate("s_left")
    law = Linear(stiff, sympy.Symbol("50 %&#{.b", real=True), sympy.Symbol("F_left", real=True))
    mechanism.add_force_element("left", JointPort(coordinate), law, preloaded=True)
    mechanism.add_force_element(
        "right", JointPort(coordinate), Linear(sympy.Symbol("a b"), sympy.Symbol("a.b"))
    )
    return derive(mechanism)


def test_awkward_names_are_escaped_and_kept_apart():
    entries = glossary(awkward())
    looks = [entry.latex for entry in entries.values()]
    assert len(set(looks)) == len(looks)
    assert "T" not in looks
    for look in looks:
        unescaped = look.replace(r"\{", "").replace(r"\}", "")
        assert unescaped.count("{") == unescaped.count("}")
        inside = "".join(part.partition("}")[0] for part in unescaped.split(r"\text{")[1:])
        assert not set("%&#~^") & set(inside.replace(r"\%", "").replace(r"\&", "").replace(r"\#", ""))


def test_element_symbols_are_unlike_those_of_the_equations():
    equations = awkward()
    symbols = element_symbols(equations)
    assert symbols.forces["left"].name != "F_left"
    assert symbols.deflections["left"].name != "s_left"


def test_elements_have_symbols_of_their_own():
    """The symbol F_a is a parameter, so that the force of a is called as that of a_ would be."""
    preload, k, c = sympy.symbols("F_a k c", real=True)
    mechanism = Mechanism("oscillator", gravity=0)
    mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=sympy.Symbol("m"))
    port = JointPort(mechanism.coordinate("z"))
    for name, law in (("a", Linear(k, 0, preload)), ("a_", Linear(c)), ("a__", Linear(k * c))):
        mechanism.add_force_element(name, port, law)
    equations = derive(mechanism)
    symbols = element_symbols(equations)
    found = [*symbols.deflections.values(), *symbols.rates.values(), *symbols.forces.values(), preload]
    assert len({symbol.name for symbol in found}) == len(found)
    rows = {row.left[0]: row.right for row in written_form(equations).elements}
    shift = symbols.deflections["a"]
    assert rows == {
        shift: mechanism.coordinate("z").position,
        symbols.forces["a"]: preload + k * shift,
        symbols.forces["a_"]: c * shift,
        symbols.forces["a__"]: k * c * shift,
    }


def test_names_that_differ_by_spaces_look_different():
    mechanism = Mechanism("oscillator", gravity=0)
    mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    for name in ("left spring", "left_spring", "left__spring", "left_spring_"):
        mechanism.add_force_element(name, JointPort(mechanism.coordinate("z")), Linear(1))
    looks = [re.sub(r"\s+(?=\})", "", entry.latex) for entry in glossary(derive(mechanism)).values()]
    assert len({re.sub(r"\s+", " ", look) for look in looks}) == len(looks)


def test_a_table_slope_keeps_its_name_from_elements():
    mechanism = Mechanism("oscillator", gravity=0)
    mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    port = JointPort(mechanism.coordinate("z"))
    mechanism.add_force_element("F_a", port, SpringTable((-1, 0, 1), (-1, 0, 2)))
    mechanism.add_force_element("a.slope", port, Linear(1))
    equations = derive(mechanism)
    before = element_symbols(equations).forces
    assert equations.linearisation
    assert element_symbols(equations).forces == before
    assert equations.system.slopes["F_a"].name not in {symbol.name for symbol in before.values()}


def test_mathematical_names_stay_as_they_are():
    k, theta = sympy.Symbol("k_s", real=True), sympy.Symbol("theta0", real=True)
    mechanism = Mechanism("oscillator", gravity=0)
    mechanism.add_body("mass", mechanism.ground, prismatic("q1", "x"), (0, 0, 0), mass=sympy.Symbol("m"))
    mechanism.add_force_element("spring", JointPort(mechanism.coordinate("q1")), Linear(k, preload=theta))
    looks = {symbol.name: entry.latex for symbol, entry in glossary(derive(mechanism)).items()}
    assert (looks["m"], looks["k_s"], looks["theta0"]) == ("m", r"k_{\text{s}}", r"\theta_{0}")
    assert looks["q1_acceleration"] == r"\ddot{q}_{1}"
