"""The straight-line program: sharing, expansion, derivatives against sympy's own and against differences."""

from collections.abc import Callable, Iterator

import mpmath
import numpy as np
import pytest
import sympy

from chassym.derivation import DamperTable, Model, Program

X, Y, Z = VARIABLES = sympy.symbols("x y z", real=True)

UNARY = (
    sympy.sin,
    sympy.cos,
    lambda e: sympy.exp(sympy.sin(e)),
    lambda e: sympy.log(2 + sympy.cos(e)),
    lambda e: sympy.sqrt(1 + e**2),
    lambda e: 1 / (2 + sympy.sin(e)),
    lambda e: sympy.Max(e, 0),
    lambda e: sympy.Min(e, sympy.Rational(1, 3)),
    lambda e: e**3,
)


def random_program(seed: int) -> tuple[Program, list[sympy.Expr], list[sympy.Expr]]:
    """Build the same random expressions twice: on a program, and written out."""
    generator = np.random.default_rng(seed)
    program = Program()
    named, plain = list(VARIABLES), list(VARIABLES)
    for _ in range(10):
        i, j = generator.integers(len(named), size=2)
        factor, function = int(generator.integers(-3, 4)), UNARY[generator.integers(len(UNARY))]
        build = (
            lambda a, b, f=factor: f * a + b,
            lambda a, b: a * b,
            lambda a, b, f=function: f(a) - b,
            lambda a, b, f=function: f(a),
        )[generator.integers(4)]
        named.append(program.let(build(named[i], named[j])))
        plain.append(sympy.sympify(build(plain[i], plain[j])))
    return program, named[-4:], plain[-4:]


def precise(expressions: list[sympy.Expr], point: dict[sympy.Symbol, mpmath.mpf]) -> list[mpmath.mpf]:
    return [mpmath.mpf(sympy.sympify(e).subs(point).evalf(30)) for e in expressions]


@pytest.fixture(autouse=True)
def thirty_digits() -> Iterator[None]:
    with mpmath.workdps(30):
        yield


def test_equal_expressions_are_stated_once() -> None:
    program = Program()
    first = program.let(X * Y)
    assert program.let(Y * X) == first
    assert program.let(-3 * X * Y) == -3 * first
    assert program.let(Y - X) == -program.let(X - Y)
    assert len(program.definitions) == 2


@pytest.mark.parametrize("atom", [X, -X, 3 * X, sympy.Integer(7), sympy.S.Zero, sympy.pi])
def test_atoms_and_their_multiples_need_no_name(atom: sympy.Expr) -> None:
    program = Program()
    assert program.let(atom) == atom
    assert not program.definitions


def test_an_assigned_atom_has_a_name_of_its_own() -> None:
    program = Program()
    name = program.assign(X)
    assert name != X
    assert program.expand([name]) == [X]


@pytest.mark.parametrize("seed", range(10))
def test_written_out_it_is_the_same_expression(seed: int) -> None:
    program, named, plain = random_program(seed)
    point = dict(zip(VARIABLES, map(mpmath.mpf, ("0.3", "-1.1", "0.7")), strict=True))
    for found, expected in zip(precise(program.expand(named), point), precise(plain, point), strict=True):
        assert mpmath.almosteq(found, expected, rel_eps=1e-25, abs_eps=1e-25)


def test_required_is_the_shortest_sufficient_part() -> None:
    program = Program()
    a = program.let(X * Y)
    b = program.let(sympy.sin(a) + 1)
    program.let(sympy.cos(X))
    assert list(program.required([b])) == [a, b]
    assert list(program.required([a + Z])) == [a]
    assert program.required([X]) == {}


def test_operations_count_every_assignment_once() -> None:
    program = Program()
    a = program.let(X * Y)  # 1
    b = program.let(a + Z)  # 1
    assert program.operations([b * a, b * b]) == 1 + 1 + 1 + 1


# Derivatives


@pytest.mark.parametrize("seed", range(20))
def test_derivatives_are_those_of_the_written_out_expressions(seed: int) -> None:
    """To 25 digits at a point where no Max or Min has its corner."""
    program, named, plain = random_program(seed)
    point = dict(zip(VARIABLES, map(mpmath.mpf, ("0.37", "-1.13", "0.71")), strict=True))
    for row, expression in zip(program.differentiate(named, VARIABLES), plain, strict=True):
        expected = precise([expression.diff(v) for v in VARIABLES], point)
        for found, truth in zip(precise(program.expand(row), point), expected, strict=True):
            assert mpmath.almosteq(found, truth, rel_eps=1e-25, abs_eps=1e-25)


def test_a_polynomial_by_hand() -> None:
    program = Program()
    product = program.let(X * Y)
    result = program.let(product**2 + Z)
    rows = program.differentiate([result, X, sympy.Integer(3)], VARIABLES)
    assert program.expand(rows[0]) == [2 * X * Y**2, 2 * X**2 * Y, 1]
    assert rows[1:] == [[1, 0, 0], [0, 0, 0]]


def test_structural_zeros_stay_zero() -> None:
    program = Program()
    depends = program.let(sympy.sin(X) * Z)
    (row,) = program.differentiate([depends], VARIABLES)
    assert row[1] == 0
    assert all(entry != 0 for entry in (row[0], row[2]))


def test_parameters_are_not_differentiated() -> None:
    program = Program()
    stiffness = program.let(Y**2)
    assert program.expand(program.differentiate([stiffness * X], [X])[0]) == [Y**2]


def test_a_stated_slope_stands_for_the_derivative() -> None:
    program = Program()
    rate = program.assign(2 * X - Y)
    force = program.assign(sympy.Max(rate, 0))
    result = program.let(force * Z)
    slope = sympy.Symbol("slope", real=True)
    (row,) = program.differentiate([result], VARIABLES, {force: {rate: slope}})
    written = program.expand(row)
    assert written[:2] == [2 * slope * Z, -slope * Z]
    assert program.expand([force])[0] == written[2]


def test_a_table_states_its_knots_and_slopes() -> None:
    """The ends of the table are no knots."""
    velocities, forces = sympy.symbols("v:4", real=True), sympy.symbols("f:4", real=True)
    numbers = dict(zip((*velocities, *forces, X), (-1, -0.5, 0.25, 1, -3, 0, 3, 15, 1), strict=True))
    program = Program()
    stated = DamperTable(velocities, forces, sympy.Rational(1, 2) * X).table.numbers(program)
    found = [float(each.xreplace(numbers)) for each in program.expand(stated)]
    knots, slopes, spacings = found[:2], found[2:5], found[5:]
    assert knots == [-0.5, 0.25] and slopes == [3, 2, 8] and spacings == [0.5, 0.75, 0.75]


# The reference car, with 30 digits


class Reference:
    """Residual and outputs of the car as a function of all arguments, in mpmath's numbers."""

    def __init__(self, model: Model, lambdified: Callable[..., Callable[..., list]]) -> None:
        equations = model.equations
        constants = {sympy.Symbol(name, real=True): value for name, value in model.values.items()}
        results = [*equations.residual, *equations.outputs.values()]
        symbols = [*constants, *equations.arguments]
        self._function = lambdified(equations.program, symbols, results, "mpmath")
        self._constants = [mpmath.mpf(value) for value in constants.values()]

    def __call__(self, arguments: list[mpmath.mpf]) -> np.ndarray:
        return np.array(self._function(*self._constants, *arguments), dtype=object)

    def jacobian(self, arguments: np.ndarray) -> np.ndarray:
        """Central differences with a step so small, and so many digits, that 18 digits are exact."""
        centre, step = [mpmath.mpf(float(a)) for a in arguments], mpmath.mpf("1e-10")
        columns = []
        for i in range(len(centre)):
            ends = [[*centre[:i], centre[i] + side * step, *centre[i + 1 :]] for side in (-1, 1)]
            below, above = map(self, ends)
            columns.append((above - below) / (2 * step))
        return np.array(columns).T.astype(float)


@pytest.fixture(scope="module")
def reference(sedan: Model, lambdified: Callable[..., Callable[..., list]]) -> Reference:
    return Reference(sedan, lambdified)


def random_arguments(model: Model, seed: int) -> np.ndarray:
    """Draw angles to 0.3 rad, rates to 2, accelerations to 10, pads to 5 cm and 0.5 m/s."""
    n, m = model.size, len(model.system.inputs)
    scale = np.concatenate(
        [np.full(n, 0.3), np.full(n, 2.0), np.full(n, 10.0), np.full(m, 0.05), np.full(m, 0.5)]
    )
    return scale * np.random.default_rng(seed).uniform(-1, 1, len(scale))


def damper_slopes(model: Model, arguments: np.ndarray) -> dict[str, float]:
    """Give the slope symbols their values at a state, from the dampers' own rates."""
    equations, mechanism = model.equations, model.system
    values = dict(zip(equations.arguments, arguments, strict=True))
    values |= {sympy.Symbol(name, real=True): value for name, value in model.values.items()}
    rates = equations.program.expand([equations.elements[name].rate for name in mechanism.slopes])
    slopes = {}
    for (name, slope), rate in zip(mechanism.slopes.items(), rates, strict=True):
        table = model.tables[name]
        piece = np.searchsorted(table.knots[:, 0], float(rate.xreplace(values)))
        slopes[slope.name] = float(table.slopes[piece, 0])
    return slopes


def row_scaled_difference(found: np.ndarray, expected: np.ndarray) -> float:
    return float((np.abs(found - expected).max(axis=1) / np.abs(expected).max(axis=1)).max())


@pytest.mark.parametrize("seed", [11, 12])
def test_derivatives_of_the_reference_car(sedan: Model, reference: Reference, seed: int) -> None:
    """Compiled Jacobian and linearisation against differences of 30 digits, row by row."""
    arguments = random_arguments(sedan, seed)
    expected = reference.jacobian(arguments)
    n, size = sedan.size, 3 * sedan.size
    jacobian = sedan.residual_jacobian.matrix(arguments, (n, size))
    assert row_scaled_difference(jacobian, expected[:n, :size]) < 1e-12
    bound = sedan.compiled.linearisation.bind(sedan.values | damper_slopes(sedan, arguments))
    assert row_scaled_difference(bound.matrix(arguments, expected.shape), expected) < 1e-12


def test_the_linearisation_takes_the_slope_it_is_given(sedan: Model) -> None:
    """At rest a damper of slope c adds c (ds/dq)^2 to one derivative by a rate, and nothing else."""
    rest = np.zeros(sedan.argument_count)
    shape = (sedan.size + len(sedan.output_names), sedan.argument_count)
    names = [symbol.name for symbol in sedan.system.slopes.values()]
    assert names == [
        f"{axle}_{side}_damper.slope" for axle in ("front", "rear") for side in ("left", "right")
    ]

    def linear(slope: float) -> np.ndarray:
        changes = dict.fromkeys(names, 0.0) | {names[0]: slope}
        return sedan.compiled.linearisation.bind(sedan.values | changes).matrix(rest, shape)

    change = linear(1000.0) - linear(0.0)
    arm = [c.name for c in sedan.system.coordinates].index("front_left_arm_angle")
    value = sedan.parameters.flat()
    lever = value["suspension.front.wheel_centre.y"] - value["suspension.front.arm_pivot.y"]
    expected = np.zeros(shape)
    expected[arm, sedan.size + arm] = 1000.0 * lever**2
    assert change == pytest.approx(expected, abs=1e-9)


def test_the_mass_matrix_is_in_the_jacobian(sedan: Model) -> None:
    """The columns of the accelerations are the mass matrix: symmetric, positive, the same at any rate."""
    still = random_arguments(sedan, 3)
    moving = still.copy()
    moving[sedan.size :] = random_arguments(sedan, 4)[sedan.size :]
    n = sedan.size
    masses = [sedan.residual_jacobian.matrix(a, (n, 3 * n))[:, 2 * n :] for a in (still, moving)]
    assert masses[0] == pytest.approx(masses[1], abs=1e-10)
    assert masses[0] == pytest.approx(masses[0].T, abs=1e-10)
    assert np.linalg.eigvalsh(masses[0]).min() > 0
