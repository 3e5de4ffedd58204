"""Equations for reading: what is written says what is computed, and the LaTeX is whole."""

import random
import re
from functools import cache

import numpy as np
import pytest
import sympy
from matplotlib.mathtext import MathTextParser
from sympy.calculus.euler import euler_equations

from chassym.derivation import (
    HELD,
    Actuator,
    CombinedPort,
    DamperTable,
    ForceLaw,
    JointPort,
    Linear,
    LineOfSightPort,
    Mechanism,
    MechanismError,
    Polynomial,
    PrescribedPort,
    Program,
    SpringTable,
    TravelPort,
    Unilateral,
    derive,
    prismatic,
    revolute,
    spherical,
    vehicle_names,
)
from chassym.derivation.reading.element_symbols import element_symbols
from chassym.derivation.reading.lagrange_form import functions_of_time, is_short, written_size
from chassym.derivation.reading.latex import displayed, to_latex
from chassym.derivation.reading.tidy import tidied, without_rounding
from chassym.derivation.reading.typesetting import WIDEST, Typesetter, width
from chassym.derivation.reading.written_form import straight_line_form, written_form

from .latex_reader import equations_of, evaluate

PARSER = MathTextParser("path")
LINEAR_DAMPING = ("half_car", "half_car_roll", "ride_model", "torsion_chain")
SHORT = ("quarter_car", *LINEAR_DAMPING)
"""The built-in vehicles that are small enough to be written out."""


@pytest.fixture(scope="module", params=vehicle_names())
def vehicle(request):
    """Give the name of every built-in vehicle."""
    return request.param


@pytest.fixture(scope="module")
def model(vehicle, built_in):
    """Give every built-in vehicle."""
    return built_in(vehicle)


@pytest.fixture(scope="module", params=SHORT)
def short(request, built_in):
    """Give every built-in vehicle that is small enough to be written out."""
    return built_in(request.param)


def test_short_vehicles_are_those_that_can_be_written_out(built_in):
    assert {name for name in vehicle_names() if is_short(built_in(name).equations)} == set(SHORT)


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


@pytest.mark.parametrize("name", LINEAR_DAMPING)
@pytest.mark.parametrize("seed", [1, 2])
def test_energy_is_lost_at_twice_the_dissipation_function(name, seed, built_in):
    model = built_in(name)
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
    rates = arguments[n : 2 * n]
    assert found["T"] == pytest.approx(rates @ mass @ rates / 2, rel=1e-9)
    assert found.keys() >= {"V", "D"}


@pytest.fixture(scope="module")
def articles(built_in):
    """Give the article of a built-in vehicle by its name."""

    @cache
    def write(name):
        return to_latex(built_in(name).equations, built_in(name).glossary)

    return write


@pytest.fixture(scope="module")
def article(vehicle, articles):
    """Give every built-in vehicle's article."""
    return articles(vehicle)


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


@pytest.mark.parametrize("name", SHORT)
def test_articles_read_back_give_the_compiled_residual(name, built_in, articles):
    short, article = built_in(name), articles(name)
    arguments, numbers = state(short, seed=4)
    known = {entry.latex: float(numbers[s]) for s, entry in short.glossary.items() if s in numbers}
    blocks = re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", article, flags=re.S)
    energies, elements, motion = map(equations_of, blocks)
    for left, right in elements:
        known[left] = evaluate(right, known)
    for letter, right in energies:
        kinds = {"T": "kinetic_energy", "V": "potential_energy", "D": "dissipation"}
        expected = value(getattr(short.equations, kinds[letter]), numbers)
        assert evaluate(right, known) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    residual = [evaluate(left, known) - evaluate(right, known) for left, right in motion]
    assert residual == pytest.approx(short.residual(arguments[:, None])[:, 0], rel=1e-9, abs=1e-8)


def test_large_articles_read_back_give_the_compiled_residual(sedan, articles):
    arguments, numbers = state(sedan, seed=5)
    article = articles("sedan")
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


@cache
def parse(formula):
    """Typeset a formula once."""
    PARSER.parse(f"${formula}$")


def pieces(formula):
    """Give the terms of an equation and of the sums in it; all digits are one to the parser."""
    formula, found = re.sub(r"\d+", "1", formula), []
    while inner := re.search(r"\\left\(((?:(?!\\left|\\right).)+)\\right\)", formula):
        found += terms(inner[1])
        formula = formula.replace(inner[0], "(x)")
    return [*found, *terms(formula)]


def terms(formula):
    """Give the terms of the two sides of an equation."""
    level, found = 0, [""]
    for token in re.findall(r"\\[A-Za-z]+|\\?.", formula):
        level += (token in ("{", "(")) - (token in ("}", ")"))
        if level == 0 and token in "+-=":
            found.append("")
        else:
            found[-1] += token
    assert level == 0
    return [piece.strip() for piece in found if piece.strip()]


def test_formulas_of_articles_can_be_typeset(article):
    aligned = re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", article, flags=re.S)
    lines = [line for block in aligned for line in re.split(r"\\\\(?:\[1ex\])?\n", block)]
    inline = re.findall(r"\$([^$]*)\$", article)
    for line in [*lines, *inline[:: max(1, len(inline) // 60)]]:
        for piece in pieces(line.replace("&", "").replace(r"\qquad {}", "")):
            parse(piece)


def test_formulas_that_cannot_be_typeset_are_found():
    parse.cache_clear()
    found = pieces(r"\frac{a + b}{2}\,\left(c - d\right) = - x_{12} + y")
    assert found == ["c", "d", r"\frac{a + b}{1}\,(x)", "x_{1}", "y"]
    assert pieces(r"\max\left(0, v - 1\right)^{2}") == ["1, v", "1", r"\max(x)^{1}"]
    with pytest.raises(ValueError, match="Unknown symbol"):
        parse(r"\nonsense{x}")


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


def test_articles_hold_no_parameter_values(torsion_chain, quarter_car):
    for model, name in ((torsion_chain, "inertia.front"), (quarter_car, "damper.force")):
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


def test_deflections_that_are_known_are_printed_as_numbers():
    """A spring across the way of a slider has neither deflection nor rate, one on the ground neither."""
    m, k, c = sympy.symbols("m k c", positive=True)
    mechanism = Mechanism("slider", gravity=0)
    body = mechanism.add_body("body", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    for name, owner, axis in (("own", body, "z"), ("across", body, "x"), ("still", mechanism.ground, "x")):
        port = TravelPort(mechanism.point(name, owner, (0, 0, 0)), mechanism.ground, axis)
        mechanism.add_force_element(name, port, Linear(k, c))
    equations = derive(mechanism)
    shift, rate = (
        found["own"] for found in (element_symbols(equations).deflections, element_symbols(equations).rates)
    )
    _, potential, dissipation = (row.right for row in written_form(equations).energies)
    assert (potential, dissipation) == (k * shift**2 / 2, c * rate**2 / 2)
    for text in (displayed(equations), to_latex(equations)):
        assert "across" not in text and "still" not in text


def test_numbers_are_printed_with_six_digits_and_kept_in_full():
    x = sympy.Symbol("x")
    typesetter = Typesetter({x: "x"})
    assert typesetter.latex(x / 3.0) == r"0.333333\,x"
    assert typesetter.latex(sympy.Float(1234567.89)) == r"1.23457 \cdot 10^{6}"
    assert typesetter.terms(0.1 * x - 2.5) == [r"0.1\,x", "- 2.5"]
    assert tidied(x / 3.0) == x / 3.0


def test_rounding_errors_are_left_out_of_sums():
    x, y, z = sympy.symbols("x y z")
    rest = 0.1 + 0.2 - 0.3
    assert rest != 0
    assert tidied(2.5 * x + rest * y) == 2.5 * x
    assert tidied(z * (2.5 * x + rest * y * (x + 1)) ** 2) == z * (2.5 * x) ** 2
    assert tidied(2.5 * x + z * (rest * y + 2 * rest * x)) == 2.5 * x
    for kept in (rest * y, rest * y + rest * x, 2.5 * x + 1e-12 * y, x + y / 10**20):
        assert tidied(kept) == kept
    assert without_rounding(rest * y, beside=[x]) == 0
    assert without_rounding(rest * y, beside=[rest * x]) == rest * y


# Any mechanism

LAWS = (
    lambda push: Linear(K, C, 0.3),
    lambda push: Polynomial((K, 0.1 * K, K), (C, C)),
    lambda push: ForceLaw(C * V * abs(V) + K * sympy.tanh(S), S, V),
    lambda push: Unilateral(Linear(K, C)),
    lambda push: DamperTable((-1, 0, 1.5), (-C, 0, 0.3 * C), 0.7),
    lambda push: SpringTable((-1, 0, 1), (-K, 0, 2 * K), outer_slopes=HELD),
    lambda push: Actuator(push),
)
PORTS = (
    lambda m, first, second: TravelPort(first, second.body, (0.6, 0, 0.8)),
    lambda m, first, second: TravelPort(first, second.body, "z").less(m.add_input("road", "m")),
    lambda m, first, second: LineOfSightPort(first, second),
    lambda m, first, second: JointPort(m.coordinates[0]),
    lambda m, first, second: PrescribedPort(m.add_input("road", "m")),
    lambda m, first, second: CombinedPort(
        ((JointPort(m.coordinates[0]), 0.3), (TravelPort(first, second.body, "x"), K))
    ),
)
K, C, LENGTH, MASS = sympy.symbols("k c l m", positive=True)
S, V = sympy.symbols("s v", real=True)


def mechanism_at_random(seed):
    """Give a link on a slider with two force elements; seven seeds in a row have every law and port."""
    pick = random.Random(seed)

    def place(*ends):
        return tuple(pick.choice((0, 1, -1, 0.1, 0.3, LENGTH, *ends)) for _ in range(3))

    mechanism = Mechanism("random", gravity=pick.choice((0, 9.81, sympy.Symbol("g"))))
    joint = prismatic("s_a", pick.choice(("x", "z", (0.6, 0, 0.8)))).then(revolute("tilt", "y"))
    inertia = pick.choice(((1, 1, 1), (MASS, MASS, MASS)))
    mass = pick.choice((MASS, 1.5))
    body = mechanism.add_body(
        "link", mechanism.ground, joint, (0, 0, 0), mass=mass, mass_centre=place(), inertia=inertia
    )
    ports = (PORTS[seed % len(PORTS)], PORTS[3])
    laws = (LAWS[3 * seed % len(LAWS)], LAWS[(3 * seed + 1) % len(LAWS)])
    for name, port, law in zip(("a", "a_"), ports, laws, strict=True):
        first = mechanism.point(f"link {name}", body, place())
        second = mechanism.point(f"ground {name}", mechanism.ground, (0.7, 0.2, -3))
        push = mechanism.add_input(f"push_{name}", "N")
        mechanism.add_force_element(name, port(mechanism, first, second), law(push))
    return mechanism


@pytest.mark.parametrize("seed", range(7))
def test_any_mechanism_can_be_read(seed):
    equations = derive(mechanism_at_random(seed))
    written = [each.lhs - each.rhs for each in equations.lagrange_equations]
    derived = equations.program.expand(equations.residual)
    mentioned = set(equations.arguments).union(*(each.free_symbols for each in (*written, *derived)))
    generator = np.random.default_rng(seed)
    numbers = {s: sympy.Float(generator.uniform(0.2, 1)) for s in sorted(mentioned, key=str)}
    expected = [value(each, numbers) for each in derived]
    assert [value(each, numbers) for each in written] == pytest.approx(expected, rel=1e-9, abs=1e-9)
    form = written_form(equations)
    numbers = evaluated(form.elements, numbers)
    left = [value(sympy.Add(*row.left), numbers) - value(row.right, numbers) for row in form.motion]
    assert left == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert_whole(to_latex(equations))
    assert_whole(equations._repr_latex_().replace("aligned", "align*"))


def test_squares_below_a_root_stay_there():
    """Of sin^2 and cos^2 in a length none is a factor of the product that the length stands in."""
    length, k = sympy.symbols("l k", positive=True)
    mechanism = Mechanism("link", gravity=0)
    joint = prismatic("x", "x").then(revolute("th", "y"))
    body = mechanism.add_body("link", mechanism.ground, joint, (0, 0, 0), mass=1, inertia=(0, 1, 0))
    end, foot = (
        mechanism.point("end", body, (length, 0, 0)),
        mechanism.point("foot", mechanism.ground, (0, 0, -1)),
    )
    mechanism.add_force_element("spring", LineOfSightPort(end, foot), Polynomial((k, k)))
    equations = derive(mechanism)
    numbers = dict(zip(equations.arguments, map(sympy.Float, (0.2, 0.3, 0.5, -0.4, 0.7, 1.1)), strict=True))
    numbers |= {length: sympy.Float(0.8), k: sympy.Float(3.0)}
    written = [value(each.lhs - each.rhs, numbers) for each in equations.lagrange_equations]
    derived = [value(each, numbers) for each in equations.program.expand(equations.residual)]
    assert written == pytest.approx(derived, rel=1e-12)


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
