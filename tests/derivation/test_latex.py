"""Equations for reading: what is written says what is computed, and the LaTeX is whole."""

import re

import numpy as np
import pytest
import sympy
from matplotlib.mathtext import MathTextParser
from sympy.calculus.euler import euler_equations

from chassym.derivation import (
    JointPort,
    Linear,
    Mechanism,
    MechanismError,
    Program,
    derive,
    load_model,
    prismatic,
    revolute,
    spherical,
    vehicle_names,
)
from chassym.derivation.reading.element_symbols import element_symbols
from chassym.derivation.reading.lagrange_form import functions_of_time, is_short, written_size
from chassym.derivation.reading.latex import displayed, to_latex
from chassym.derivation.reading.tidy import tidied
from chassym.derivation.reading.typesetting import WIDEST, width
from chassym.derivation.reading.written_form import straight_line_form, written_form

from .latex_reader import equations_of, evaluate

PARSER = MathTextParser("path")
LINEAR_DAMPING = ("half_car", "half_car_roll", "ride_model", "torsion_chain")


@pytest.fixture(scope="module", params=vehicle_names())
def model(request):
    """Give every built-in vehicle."""
    return load_model(request.param)


@pytest.fixture(scope="module")
def short(model):
    """Give every built-in vehicle that is small enough to be written out."""
    if not is_short(model.equations):
        pytest.skip("too large to be written out")
    return model


def state(model, seed=1):
    """Give arguments at random, and the numbers of all symbols that equations may mention."""
    arguments = np.random.default_rng(seed).uniform(-0.3, 0.3, model.argument_count)
    symbols = model.equations.arguments
    numbers = {symbol: sympy.Float(x) for symbol, x in zip(symbols, arguments, strict=True)}
    known = {symbol.name: symbol for symbol in model.glossary}
    numbers |= {known[name]: sympy.Float(x) for name, x in model.values.items() if name in known}
    return arguments, numbers


def value(expression, numbers):
    """Give the number of an expression."""
    return float(sympy.sympify(expression).xreplace(numbers))


def evaluated(rows, numbers):
    """Give the numbers of symbols with those that rows define, in order."""
    found = dict(numbers)
    for row in rows:
        (left,) = row.left
        found[left] = sympy.Float(value(row.right, found))
    return found


# Energies and Lagrange's equations


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_lagrange_equations_are_the_compiled_residual(short, seed):
    arguments, numbers = state(short, seed)
    written = [value(each.lhs - each.rhs, numbers) for each in short.equations.lagrange_equations]
    assert written == pytest.approx(short.residual(arguments[:, None])[:, 0], rel=1e-9, abs=1e-8)


def test_kinetic_energy_is_half_the_rates_with_the_mass_matrix(short):
    _, numbers = state(short)
    equations = short.equations
    matrix = sympy.Matrix(equations.program.expand([e for row in equations.mass_matrix for e in row]))
    rates = np.array([value(c.rate, numbers) for c in equations.coordinates])
    mass = np.array([value(e, numbers) for e in matrix]).reshape(len(rates), len(rates))
    assert value(equations.kinetic_energy, numbers) == pytest.approx(rates @ mass @ rates / 2, rel=1e-12)
    assert equations.lagrangian == equations.kinetic_energy - equations.potential_energy


@pytest.mark.parametrize("vehicle", LINEAR_DAMPING)
@pytest.mark.parametrize("seed", [1, 2])
def test_energy_is_lost_at_twice_the_dissipation_function(vehicle, seed):
    model = load_model(vehicle)
    equations, n = model.equations, model.size
    arguments, _ = state(model, seed)
    arguments[3 * n + len(equations.system.inputs) :] = 0  # what holds still does no work
    arguments[2 * n : 3 * n] = model.accelerations(arguments[:, None])[:, 0]
    numbers = state(model, seed)[1]
    numbers |= {s: sympy.Float(x) for s, x in zip(equations.arguments, arguments, strict=True)}
    energy = equations.kinetic_energy + equations.potential_energy
    changes = [(c.position, c.rate) for c in equations.coordinates]
    changes += [(c.rate, c.acceleration) for c in equations.coordinates]
    power = sum(value(energy.diff(symbol), numbers) * value(rate, numbers) for symbol, rate in changes)
    assert power == pytest.approx(-2 * value(equations.dissipation, numbers), rel=1e-9)


def test_power_of_a_damper_table_is_the_slope_of_its_dissipation_function(quarter_car):
    _, numbers = state(quarter_car)
    equations = quarter_car.equations
    form = written_form(equations)
    forces = evaluated(form.elements, numbers)
    (damper,) = (e for name, e in forces.items() if name.name == "F_damper")
    (tyre,) = (e for name, e in forces.items() if name.name == "v_tyre")
    body, wheel = equations.coordinates
    travel = value(wheel.rate - body.rate, numbers)
    slopes = [value(equations.dissipation.diff(c.rate), numbers) for c in (body, wheel)]
    damping = quarter_car.parameters.value("tyre.damping")
    assert slopes == pytest.approx([-damper, damper + damping * tyre], rel=1e-9)
    assert travel != 0


def test_lagrange_equations_of_a_driven_pendulum_are_eulers():
    m, length, g = sympy.symbols("m length g", positive=True)
    mechanism = Mechanism("pendulum", gravity=g)
    cart = mechanism.add_body("cart", mechanism.ground, prismatic("s", "x"), (0, 0, 0), mass=3 * m)
    mechanism.add_body("bob", cart, revolute("theta", "y"), (0, 0, 0), mass=m, mass_centre=(0, 0, -length))
    mechanism.add_force_element("spring", JointPort(mechanism.coordinate("s")), Linear(sympy.Symbol("k")))
    equations = derive(mechanism)
    time = sympy.Symbol("t")
    moving = functions_of_time(equations, time)
    motions = [moving[c.position] for c in equations.coordinates]
    expected = euler_equations(equations.lagrangian.xreplace(moving), motions, time)
    for ours, eulers in zip(equations.lagrange_equations, expected, strict=True):
        assert sympy.simplify((ours.lhs - ours.rhs).xreplace(moving) + eulers.lhs) == 0


def test_kinetic_energy_reads_like_a_textbook(half_car):
    equations = half_car.equations
    mass, rise = sympy.Symbol("body.mass", real=True), equations.coordinates[0].rate
    assert mass * rise**2 / 2 in sympy.Add.make_args(equations.kinetic_energy)


@pytest.mark.parametrize("name", ["kinetic_energy", "dissipation", "lagrangian", "lagrange_equations"])
def test_what_is_too_long_to_read_is_refused(sedan, name):
    with pytest.raises(MechanismError, match=r"'full_car'.*3000.*`program\.definitions`.*`to_latex`"):
        getattr(sedan.equations, name)


def test_the_written_size_is_that_of_the_expanded_expression():
    x, y = sympy.symbols("x y")
    program = Program()
    first = program.let(x + y)
    second = program.let(first * program.let(sympy.sin(first)))
    (expanded,) = program.expand([second])
    assert written_size(program, [second]) == sympy.count_ops(expanded) == 4
    assert written_size(program, [x, sympy.Integer(3)]) == 0


def test_tidying_changes_no_value():
    a, b, c, d = symbols = sympy.symbols("a b c d", real=True)
    sine, cosine = sympy.sin(a), sympy.cos(a)
    expression = (
        b * ((c * sine + d) ** 2 + (c * cosine) ** 2) + (2 * b - 2 * d) * c / 2 + sine**2 * (b + cosine**2)
    )
    numbers = dict(zip(symbols, map(sympy.Float, (0.3, -1.2, 0.7, 2.1)), strict=True))
    short = tidied(expression)
    assert value(short, numbers) == pytest.approx(value(expression, numbers), rel=1e-14)
    assert sympy.count_ops(short) < sympy.count_ops(expression)


def test_squares_with_different_factors_are_kept_apart():
    x, y = sympy.symbols("x y", real=True)
    expression = (
        3 * sympy.sin(x) ** 2 * y + 5 * sympy.cos(x) ** 2 * y + 2 * sympy.sin(x) ** 2 + 2 * sympy.cos(x) ** 2
    )
    numbers = {x: sympy.Float(0.4), y: sympy.Float(1.7)}
    assert value(tidied(expression), numbers) == pytest.approx(value(expression, numbers), rel=1e-14)
    assert tidied(2 * sympy.sin(x) ** 2 + 2 * sympy.cos(x) ** 2 + y) == y + 2


def test_kinetic_energy_of_a_top_is_goldsteins():
    mass, height, gravity, across, along = sympy.symbols("m l g A C", positive=True)
    mechanism = Mechanism("top", gravity)
    inertia = (across, across, along)
    origin, centre = (0, 0, 0), (0, 0, height)
    mechanism.add_body(
        *("top", mechanism.ground, spherical("zxz"), origin),
        **{"mass": mass, "mass_centre": centre, "inertia": inertia, "inertia_about": origin},
    )
    equations = derive(mechanism)
    precession, nutation, spin = equations.coordinates
    sine, cosine = sympy.sin(nutation.position), sympy.cos(nutation.position)
    expected = across * (nutation.rate**2 + precession.rate**2 * sine**2)
    expected = sympy.expand((expected + along * (spin.rate + precession.rate * cosine) ** 2) / 2)
    assert equations.kinetic_energy == expected  # Goldstein, Classical Mechanics, section 5.7
    assert equations.potential_energy == mass * gravity * height * cosine


# What is printed


def test_the_written_form_is_the_compiled_residual(short):
    arguments, numbers = state(short)
    form = written_form(short.equations)
    numbers = evaluated(form.elements, numbers)
    left = [value(sympy.Add(*row.left), numbers) - value(row.right, numbers) for row in form.motion]
    assert left == pytest.approx(short.residual(arguments[:, None])[:, 0], rel=1e-9, abs=1e-8)
    energies = (short.equations.kinetic_energy, short.equations.potential_energy, short.equations.dissipation)
    for row, energy in zip(form.energies, energies, strict=True):
        assert value(row.right, numbers) == pytest.approx(value(energy, numbers), rel=1e-9, abs=1e-9)


def test_forces_are_written_in_deflections_and_rates(short):
    symbols = element_symbols(short.equations)
    travels = {*symbols.deflections.values(), *symbols.rates.values()}
    rows = {row.left[0]: row for row in written_form(short.equations).elements}
    moving = set(short.equations.arguments)
    for force in set(symbols.forces.values()) & set(rows):
        assert rows[force].symbols & travels
        assert not rows[force].symbols & moving
    assert set(symbols.forces.values()) <= set(rows)


def test_the_straight_line_form_is_the_compiled_residual(model):
    arguments, numbers = state(model)
    form = straight_line_form(model.equations)
    found = evaluated([*form.steps, *form.results], numbers)
    n, accelerations = model.size, arguments[2 * model.size : 3 * model.size]
    mass = np.array(
        [[found.get(f"M_{{{i},{j}}}", 0) for j in range(1, n + 1)] for i in range(1, n + 1)], float
    )
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias, applied = (np.array([found[f"{x}_{{{i}}}"] for i in range(1, n + 1)], float) for x in "hQ")
    residual = model.residual(arguments[:, None])[:, 0]
    assert mass @ accelerations + bias - applied == pytest.approx(residual, rel=1e-9, abs=1e-8)


@pytest.fixture(scope="module")
def article(model):
    """Give every built-in vehicle's article."""
    return to_latex(model.equations, model.glossary)


def environments(text):
    """Give what is open when the text ends, and refuse what is closed in another order."""
    still_open = []
    for kind, name in re.findall(r"\\(begin|end)\{([^}]*)\}", text):
        if kind == "begin":
            still_open.append(name)
        else:
            assert still_open.pop() == name
    return still_open


def assert_whole(text):
    """Check braces, dollars and environments, and that text has no characters that it must not have."""
    unescaped = re.sub(r"\\[\\{}$%&#_]", "", text)
    assert environments(text) == []
    assert unescaped.count("{") == unescaped.count("}")
    assert unescaped.count("$") % 2 == 0
    assert not re.search(r"[%#]|[^\x00-\u017f]", unescaped)
    outside = re.sub(
        r"\$[^$]*\$|\\\[.*?\\\]|\\begin\{align\*\}.*?\\end\{align\*\}", "", unescaped, flags=re.S
    )
    assert not set("_^") & set(outside)


def test_articles_read_back_give_the_compiled_residual(short, article):
    arguments, numbers = state(short, seed=4)
    known = {entry.latex: float(numbers[s]) for s, entry in short.glossary.items() if s in numbers}
    blocks = re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", article, flags=re.S)
    energies, elements, motion = map(equations_of, blocks)
    for left, right in elements:
        known[left] = evaluate(right, known)
    for name, right in energies:
        kinds = {"T": "kinetic_energy", "V": "potential_energy", "D": "dissipation"}
        expected = value(getattr(short.equations, kinds[name]), numbers)
        assert evaluate(right, known) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    residual = [evaluate(left, known) - evaluate(right, known) for left, right in motion]
    assert residual == pytest.approx(short.residual(arguments[:, None])[:, 0], rel=1e-9, abs=1e-8)


def test_large_articles_read_back_give_the_compiled_residual(sedan):
    arguments, numbers = state(sedan, seed=5)
    article = to_latex(sedan.equations, sedan.glossary)
    known = {entry.latex: float(numbers[s]) for s, entry in sedan.glossary.items() if s in numbers}
    for left, right in re.findall(r"^\$([^$]*?) = ([^$]*)\$\\par$", article, flags=re.M):
        known[left] = evaluate(right, known)
    n = sedan.size
    mass = np.array([[known.get(f"M_{{{i},{j}}}", 0.0) for j in range(1, n + 1)] for i in range(1, n + 1)])
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias, applied = (np.array([known[f"{letter}_{{{i}}}"] for i in range(1, n + 1)]) for letter in "hQ")
    residual = sedan.residual(arguments[:, None])[:, 0]
    assert mass @ arguments[2 * n : 3 * n] + bias - applied == pytest.approx(residual, rel=1e-9, abs=1e-8)


def test_articles_are_whole(article):
    assert article.startswith(r"\documentclass{article}")
    assert article.endswith("\\end{document}\n")
    assert_whole(article)


def test_formulas_of_articles_can_be_typeset(article):
    aligned = re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", article, flags=re.S)
    lines = [line for block in aligned for line in re.split(r"\\\\(?:\[1ex\])?\n", block)]
    inline = re.findall(r"\$([^$]*)\$", article)
    for line in [*lines, *inline[:: max(1, len(inline) // 60)]]:
        formula = line.replace("&", "").replace(r"\qquad {}", "").replace(r"\displaystyle", "")
        PARSER.parse(f"${formula.strip()}$")


def test_lines_of_articles_fit_the_page(article):
    for block in re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", article, flags=re.S):
        for line in re.split(r"\\\\(?:\[1ex\])?\n", block):
            assert width(line) < 1.1 * WIDEST


def test_articles_explain_every_symbol_that_they_print(model, article):
    table, _, rest = article.partition(r"\end{longtable}")
    explained = set(re.findall(r"^\$(.*?)\$ & ", table, flags=re.M))
    names = sorted((entry.latex for entry in model.glossary.values()), key=len, reverse=True)
    for name in (name for name in names if r"\text" in name and name in rest):
        assert name in explained
    assert len(explained) > 3 * model.size


def test_articles_hold_no_parameter_values(half_car, quarter_car):
    for model, name in ((half_car, "body.mass"), (quarter_car, "damper.force")):
        other = model.scaled(name, factor=1.375)
        assert to_latex(other.equations, other.glossary) == to_latex(model.equations, model.glossary)


def test_notebooks_show_small_models_and_a_line_about_large_ones(model):
    shown = model.equations._repr_latex_()
    assert shown == displayed(model.equations)
    assert shown.startswith("$") and shown.endswith("$")
    assert_whole(shown.replace("aligned", "align*"))
    if is_short(model.equations):
        assert all(f"& {name} = " in shown for name in "TVD")
    else:
        assert len(shown) < 200 and "\n" not in shown
        assert f"{model.size} coordinates" in shown and r"to\_latex" in shown


def test_names_that_latex_would_stumble_over():
    mechanism = Mechanism("50 % of_{this} & that #1", gravity=sympy.Symbol("g^2"))
    joint = prismatic("x^2_&", "x").then(revolute("φ ~\\", "z"))
    mechanism.add_body(
        "$body$", mechanism.ground, joint, (0, 0, 0), mass=sympy.Symbol("m%"), inertia=(1, 1, 1)
    )
    force = mechanism.add_input("日本 {", "N", "a force in % of 1 N_2")
    assert force.name == "日本 {"
    equations = derive(mechanism)
    assert_whole(to_latex(equations))
    assert_whole(displayed(equations).replace("aligned", "align*"))
