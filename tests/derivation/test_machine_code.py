"""Machine code against sympy's own numpy printer, function by function and for whole vehicles."""

import ctypes
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from operator import attrgetter, methodcaller
from threading import Barrier

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    CompiledEquations,
    ForceLaw,
    JointPort,
    Mechanism,
    Model,
    Program,
    load_model,
    prismatic,
)
from chassym.derivation.compilation.assembly import assembly
from chassym.derivation.compilation.compiled_function import CompiledFunction
from chassym.derivation.compilation.expressions import UnsupportedExpressionError
from chassym.derivation.compilation.instructions import LANES
from chassym.derivation.compilation.machine_code import compile_assembly, link
from chassym.derivation.compilation.parts import Kernel, divide, in_order_of_need, scratch_places

X, Y, C, D = sympy.symbols("x y c d", real=True)
COUNTS = (1, 7, 8, 9, 100)
EXPRESSIONS = [
    sympy.sin(X),
    sympy.cos(X),
    sympy.exp(X),
    sympy.exp(-X / 2),
    sympy.log(X**2 + 1),
    sympy.Abs(X),
    sympy.sqrt(X**2 + C**2),
    1 / sympy.sqrt(X**2 + 1),
    sympy.Max(X, 0),
    sympy.Max(X, Y, sympy.Rational(1, 4)),
    sympy.Min(X, C),
    sympy.Min(X, Y, -X),
    sympy.Heaviside(X),
    sympy.Heaviside(X - Y),
    X**2,
    X**3,
    X**7,
    X**-1,
    X**-2,
    (X + Y) ** -3,
    X * Y / (C * D**2),
    C / (X * Y),
    -X,
    -X * Y,
    -3 * X,
    X - Y,
    -X - Y,
    2 * X - 3 * Y + 4 * C - 5,
    X * Y * C * D,
    sympy.pi * X + sympy.Rational(1, 3),
    sympy.sqrt(2) * X,
    sympy.exp(1) + X,
    -(X + Y) * (C - D),
    -2 * sympy.sin(X) * sympy.cos(Y),
    sympy.sin(sympy.Max(X, 0) * sympy.cos(Y)) ** 2,
    C,
    -C,
    X,
    sympy.Integer(0),
    sympy.Rational(-7, 3),
]


def run(
    results: list[sympy.Expr], arguments: np.ndarray, constants: list[float], definitions: dict | None = None
) -> np.ndarray:
    """Compile expressions of x, y, c, d and evaluate them for samples of x, y; shape (results, samples)."""
    kernel = Kernel("kernel", {X: 0, Y: 1}, {C: 0, D: 1}, definitions or {}, results)
    linked = link(compile_assembly(assembly([kernel])), ["kernel"], f"test_{id(kernel)}")
    function = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3, *[ctypes.c_int64] * 3)(
        linked.addresses["kernel"]
    )
    count = arguments.shape[1]
    filled = -(-count // LANES) * LANES
    padded, found = np.ones((2, filled)), np.full((len(results), filled), np.nan)
    padded[:, :count] = arguments
    given = np.repeat(constants, LANES)
    function(padded.ctypes.data, given.ctypes.data, found.ctypes.data, filled, filled, 0)
    return found[:, :count]


def samples(count: int) -> np.ndarray:
    """Draw x and y, with zeros of both signs, equal pairs and large values among them."""
    drawn = np.random.default_rng(count).uniform(-3, 3, (2, count))
    special = np.array([[0.5, -0.5, 1.5, 2.5, -400.0], [0.5, 0.5, -1.5, 1e-300, 1e3]])
    drawn[:, : min(count, 5)] = special[:, : min(count, 5)]
    return drawn


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_every_function_is_numpys(expression: sympy.Expr) -> None:
    arguments, constants = samples(24), [1.7, -0.6]
    with np.errstate(all="ignore"):
        expected = sympy.lambdify([X, Y, C, D], expression, modules="numpy")(*arguments, *constants)
    (found,) = run([expression], arguments, constants)
    assert found == pytest.approx(np.broadcast_to(expected, 24), rel=4e-15, abs=1e-300)


@pytest.mark.parametrize("count", COUNTS)
def test_any_number_of_samples(count: int) -> None:
    arguments, constants = samples(count), [1.7, -0.6]
    with np.errstate(all="ignore"):
        expected = sympy.lambdify([X, Y, C, D], EXPRESSIONS, modules="numpy")(*arguments, *constants)
    found = run(EXPRESSIONS, arguments, constants)
    for own, other in zip(found, expected, strict=True):
        assert own == pytest.approx(np.broadcast_to(other, count), rel=4e-15, abs=1e-300)


def test_a_step_is_one_half_at_its_corner() -> None:
    """The derivative of a table at a knot is the mean of both sides."""
    corner = np.array([[0.0, -0.0, 1e-300, -1e-300], [0.0, 0.0, 0.0, 0.0]])
    (found,) = run([sympy.Heaviside(X)], corner, [0.0, 0.0])
    assert list(found) == [0.5, 0.5, 1.0, 0.0]


def test_definitions_are_evaluated_in_order() -> None:
    a, b = sympy.symbols("a b", real=True)
    arguments = samples(9)
    (found,) = run([a + b], arguments, [2.0, 0.0], {a: X * Y + C, b: sympy.sin(a)})
    inner = arguments[0] * arguments[1] + 2
    assert found == pytest.approx(inner + np.sin(inner), rel=4e-15)


def test_constants_keep_every_digit() -> None:
    number = sympy.Float(0.1) + sympy.Float(2**-50)
    (found,) = run([X * number], np.ones((2, 1)), [0.0, 0.0])
    assert found[0] == float(number)


def test_undefined_values_are_not_hidden() -> None:
    found = run([sympy.log(X), sympy.sqrt(X), 1 / Y], np.array([[-1.0], [0.0]]), [0.0, 0.0])[:, 0]
    assert np.isnan(found[0])
    assert np.isnan(found[1])
    assert np.isinf(found[2])


@pytest.mark.parametrize(
    ("expression", "named"),
    [
        (sympy.gamma(X), "gamma"),
        (1 + X * sympy.besselj(0, Y), "besselj"),
        (sympy.Function("mystery")(X), "mystery"),
        (sympy.Mod(X, 3).diff(X), "Derivative"),
        (sympy.Piecewise((X, sympy.Xor(X > 0, Y > 0, evaluate=False)), (0, True)), "Xor"),
        (sympy.I * X, "the number I"),
        (sympy.zoo * X, "the number zoo"),
        (X ** (1 + sympy.I), r"1 \+ I"),
    ],
    ids=str,
)
def test_what_has_no_machine_code_is_refused_by_name(expression: sympy.Expr, named: str) -> None:
    with pytest.raises(UnsupportedExpressionError, match=named) as caught:
        assembly([Kernel("kernel", {X: 0, Y: 1}, {}, {}, [expression])])
    assert "\n" not in str(caught.value)


# Every function over a grid with special points


SPECIAL = [0.0, -0.0, 1.0, -1.0, 2.0, 1e-300, -1e-300, 1e300, -1e300, np.inf, -np.inf, np.nan]
LINE = np.concatenate([np.linspace(-5, 5, 91), [700.0, -700.0], SPECIAL])
GRID = np.array([each.ravel() for each in np.meshgrid(LINE, np.concatenate([LINE[::6], SPECIAL]))])
HALF = sympy.Rational(1, 2)
FUNCTIONS: dict[str, tuple[sympy.Expr, Callable[[np.ndarray, np.ndarray], np.ndarray]]] = {
    "sin": (sympy.sin(X), lambda x, y: np.sin(x)),
    "cos": (sympy.cos(X), lambda x, y: np.cos(x)),
    "tan": (sympy.tan(X), lambda x, y: np.tan(x)),
    "asin": (sympy.asin(X), lambda x, y: np.arcsin(x)),
    "acos": (sympy.acos(X), lambda x, y: np.arccos(x)),
    "atan": (sympy.atan(X), lambda x, y: np.arctan(x)),
    "atan2": (sympy.atan2(X, Y), np.arctan2),
    "sinh": (sympy.sinh(X), lambda x, y: np.sinh(x)),
    "cosh": (sympy.cosh(X), lambda x, y: np.cosh(x)),
    "tanh": (sympy.tanh(X), lambda x, y: np.tanh(x)),
    "exp": (sympy.exp(X), lambda x, y: np.exp(x)),
    "log": (sympy.log(X), lambda x, y: np.log(x)),
    "sqrt": (sympy.sqrt(X), lambda x, y: np.sqrt(x)),
    "square root as a decimal": (X**0.5, lambda x, y: np.sqrt(x)),
    "square as a decimal": (X**2.0, lambda x, y: x**2),
    "x^1.5": (X**1.5, lambda x, y: x**1.5),
    "x^-2.5": (X**-2.5, lambda x, y: 1 / x**2.5),
    "cube root": (X ** sympy.Rational(1, 3), lambda x, y: x ** (1 / 3)),
    "x^7": (X**7, lambda x, y: x**7.0),
    "x^100": (X**100, lambda x, y: x**100.0),
    "2^x": (sympy.Integer(2) ** X, lambda x, y: 2.0**x),
    "x^y": (X**Y, lambda x, y: x**y),
    "Abs": (sympy.Abs(X), lambda x, y: np.abs(x)),
    "sign": (sympy.sign(X), lambda x, y: np.sign(x)),
    "Heaviside": (sympy.Heaviside(X), lambda x, y: np.heaviside(x, 0.5)),
    "Heaviside, a quarter": (sympy.Heaviside(X, HALF / 2), lambda x, y: np.heaviside(x, 0.25)),
    "Heaviside, right": (sympy.Heaviside(X, 1), lambda x, y: np.heaviside(x, 1.0)),
    "Heaviside, varying": (sympy.Heaviside(X, Y), lambda x, y: np.heaviside(x, y)),
    "Max": (sympy.Max(X, Y), np.maximum),
    "Max, a number": (sympy.Max(X, 0), lambda x, y: np.maximum(x, 0)),
    "Max of three": (sympy.Max(X, Y, -1), lambda x, y: np.maximum(np.maximum(x, y), -1)),
    "Min": (sympy.Min(X, Y), np.minimum),
    "Min of three": (sympy.Min(X, Y, X * Y), lambda x, y: np.minimum(np.minimum(x, y), x * y)),
    "Mod": (sympy.Mod(X, Y), np.mod),
    "Mod, a number": (sympy.Mod(X, 3), lambda x, y: np.mod(x, 3)),
}


def assert_within_ulps(found: np.ndarray, expected: np.ndarray, count: int) -> None:
    """Compare float64 with float64; NaN where NaN, infinite where infinite."""
    equal = (found == expected) | (np.isnan(found) & np.isnan(expected))
    assert np.all(np.abs(found - expected)[~equal] <= count * np.spacing(np.abs(expected[~equal])))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_to_4_ulp(name: str) -> None:
    expression, truth = FUNCTIONS[name]
    with np.errstate(all="ignore"):
        (found,) = run([expression], GRID, [0.0, 0.0])
        assert_within_ulps(found, truth(*GRID), 4)


RELATIONS: dict[str, tuple[sympy.Basic, Callable[[np.ndarray, np.ndarray], np.ndarray]]] = {
    "<": (X < Y, np.less),
    "<=": (X <= Y, np.less_equal),
    ">": (X > Y, np.greater),
    ">=": (X >= Y, np.greater_equal),
    "Eq": (sympy.Eq(X, Y), np.equal),
    "Ne": (sympy.Ne(X, Y), np.not_equal),
    "And": ((X < Y) & (X > 0) & (Y < 3), lambda x, y: (x < y) & (x > 0) & (y < 3)),
    "Or": ((X < 0) | sympy.Eq(Y, 2) | (X > 4), lambda x, y: (x < 0) | (y == 2) | (x > 4)),
    "Not": (sympy.Not((X < Y) & (X > 0), evaluate=False), lambda x, y: ~((x < y) & (x > 0))),
}


@pytest.mark.parametrize("name", RELATIONS)
def test_conditions(name: str) -> None:
    condition, truth = RELATIONS[name]
    found = run([sympy.Piecewise((1, condition), (0, True))], GRID, [0.0, 0.0])[0]
    assert np.array_equal(found, truth(*GRID))


def test_a_piecewise_law_takes_the_first_branch_that_holds() -> None:
    law = sympy.Piecewise((sympy.log(X), X > 2), (X**2, X > 0), (1 / X, (X >= -1) & (X < 0)))
    points = np.array([[3.0, 2.0, 1e-300, 0.0, -0.5, -1.0, -1.5, np.nan], np.zeros(8)])
    (found,) = run([law], points, [0.0, 0.0])
    expected = np.array([np.log(3.0), 4.0, 0.0, np.nan, -2.0, -1.0, np.nan, np.nan])
    assert_within_ulps(found, expected, 1)


def test_piecewise_laws_may_be_nested() -> None:
    inner = sympy.Piecewise((Y, Y > 1), (C, True))
    law = sympy.Piecewise((inner + 1, inner < 3), (sympy.Piecewise((D, X > 0), (-D, True)), True))
    (found,) = run([law], np.array([[1.0, 1.0, -1.0], [2.0, 0.0, 4.0]]), [2.5, 7.0])
    assert list(found) == [3.0, 3.5, -7.0]


def test_a_library_function_in_two_functions_of_one_module() -> None:
    kernels = [Kernel(name, {X: 0}, {}, {}, [sympy.tan(X) + sympy.tan(2 * X)]) for name in ("one", "two")]
    linked = link(compile_assembly(assembly(kernels)), ["one", "two"], "twice")
    assert set(linked.addresses) == {"one", "two"}


# Derivatives


SMOOTH = [
    sympy.tan(X),
    sympy.asin(X / 4),
    sympy.acos(X / 4),
    sympy.atan(X * Y),
    sympy.sinh(X),
    sympy.cosh(X),
    sympy.tanh(X - Y),
    (X + 4) ** 1.5,
    (X + 4) ** (Y / 3),
    sympy.Integer(3) ** X,
    sympy.exp(-X) * sympy.log(X + 5) / sympy.sqrt(X**2 + 1),
]


@pytest.mark.parametrize("expression", SMOOTH, ids=str)
def test_smooth_derivatives_are_those_of_a_complex_step(expression: sympy.Expr) -> None:
    arguments = np.random.default_rng(5).uniform(-1.4, 1.4, (2, 40))
    x, y = arguments
    evaluate = sympy.lambdify([X, Y], expression, modules="numpy")
    (found,) = run([expression.diff(X)], arguments, [0.0, 0.0])
    assert found == pytest.approx(evaluate(x + 1e-30j, y).imag / 1e-30, rel=1e-13, abs=1e-15)


BENT = [
    sympy.atan2(X, Y),
    sympy.Abs(X) ** 1.5,
    X * sympy.Abs(X),
    sympy.sign(X) * X**2,
    sympy.Abs(sympy.sin(3 * X)),
    sympy.Heaviside(X - Y) * X,
    sympy.Max(X, Y, X * Y),
    sympy.Min(X**2, Y, HALF),
    sympy.Piecewise((X**3, X > Y), (sympy.sin(X), X > -1), (1 - X, True)),
    X * sympy.Piecewise((Y, Y > 0), (X, True)),
]


@pytest.mark.parametrize("expression", BENT, ids=str)
def test_derivatives_beside_corners_are_those_of_differences(expression: sympy.Expr) -> None:
    arguments = np.random.default_rng(6).uniform(-1.4, 1.4, (2, 40))
    step = np.array([[1e-5], [0.0]])
    below, above = (run([expression], arguments + side * step, [0.0, 0.0])[0] for side in (-1, 1))
    (found,) = run([expression.diff(X)], arguments, [0.0, 0.0])
    assert found == pytest.approx((above - below) / 2e-5, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize(
    ("law", "slope_at_zero"),
    [
        (sympy.sign(X), 0.0),  # Coulomb's friction: flat on both sides
        (sympy.Heaviside(X), 0.0),
        (sympy.sign(X) * X**2, 0.0),
        (sympy.Abs(X), 0.0),
        (sympy.Max(X, 0), 0.5),
        (sympy.Min(3 * X, X), 2.0),
    ],
    ids=str,
)
def test_slopes_at_a_corner_are_the_mean_of_both_sides(law: sympy.Expr, slope_at_zero: float) -> None:
    program = Program()
    ((slope,),) = program.differentiate([program.let(law)], [X])
    (found,) = run([slope], np.zeros((2, 1)), [0.0, 0.0], dict(program.required([slope])))
    assert found[0] == slope_at_zero


# Whole vehicles


def plain_results(model: Model, lambdified: Callable, function: str, arguments: np.ndarray) -> np.ndarray:
    """Evaluate a vehicle's function by numpy from the program's definitions; shape (results, samples)."""
    equations = model.equations
    results = {
        "residual": list(equations.residual),
        "accelerations": list(equations.accelerations),
        "outputs": list(equations.outputs.values()),
        "residual_jacobian": [e for row in equations.residual_jacobian for e in row if e != 0],
    }[function]
    constants = {sympy.Symbol(name, real=True): value for name, value in model.values.items()}
    evaluate = lambdified(equations.program, [*constants, *equations.arguments], results)
    rows = evaluate(*constants.values(), *arguments)
    return np.array([np.broadcast_to(row, arguments.shape[1]) for row in rows], dtype=float)


def random_arguments(model: Model, count: int) -> np.ndarray:
    return np.random.default_rng(count).uniform(-0.4, 0.4, (model.argument_count, count))


def assert_rows_agree(found: np.ndarray, expected: np.ndarray) -> None:
    scale = np.abs(expected).max(axis=1)
    assert np.all(np.abs(found - expected).max(axis=1) <= 1e-12 * scale)


@pytest.mark.parametrize("function", ["residual", "accelerations", "outputs", "residual_jacobian"])
@pytest.mark.parametrize("name", ["quarter_car", "half_car", "torsion_chain"])
def test_small_vehicles(
    name: str, function: str, lambdified: Callable, request: pytest.FixtureRequest
) -> None:
    model = request.getfixturevalue(name)
    arguments = random_arguments(model, 100)
    found = getattr(model, function)(arguments)
    assert_rows_agree(found, plain_results(model, lambdified, function, arguments))


@pytest.mark.parametrize("function", ["accelerations", "outputs"])
def test_the_reference_car(sedan: Model, function: str, lambdified: Callable) -> None:
    arguments = random_arguments(sedan, 100)
    found = getattr(sedan, function)(arguments)
    assert_rows_agree(found, plain_results(sedan, lambdified, function, arguments))


@pytest.mark.parametrize("count", COUNTS)
def test_a_sample_does_not_depend_on_its_neighbours(sedan: Model, count: int) -> None:
    """Alone, by the function of one sample, or anywhere in a batch: the same bits."""
    arguments = random_arguments(sedan, 100)[:, :count]
    batch = sedan.accelerations(arguments)
    one = sedan.accelerations.single()
    assert batch.shape == (sedan.size, count)
    for column, sample in zip(batch.T, arguments.T, strict=True):
        assert np.array_equal(one(sample), column)
        assert np.array_equal(sedan.accelerations(sample[:, None])[:, 0], column)


def test_any_memory_layout_is_accepted(half_car: Model) -> None:
    arguments = random_arguments(half_car, 9)
    expected = half_car.accelerations(arguments)
    assert np.array_equal(half_car.accelerations(np.asfortranarray(arguments)), expected)
    assert np.array_equal(half_car.accelerations(np.repeat(arguments, 2, axis=1)[:, ::2]), expected)


def test_results_of_one_call_outlive_the_next(half_car: Model) -> None:
    one = half_car.accelerations.single()
    first, second = random_arguments(half_car, 2).T
    kept, batch = one(first), half_car.accelerations(first[:, None])
    before = kept.copy(), batch.copy()
    one(second)
    half_car.accelerations(second[:, None])
    assert np.array_equal(kept, before[0])
    assert np.array_equal(batch, before[1])


def test_variants_do_not_disturb_each_other(half_car: Model) -> None:
    """Two parameter sets on the same machine code, evaluated in turn."""
    arguments = random_arguments(half_car, 3)
    heavier = half_car.scaled("body.mass", factor=2.0)
    before = half_car.accelerations(arguments)
    other = heavier.accelerations(arguments)
    assert not np.allclose(other, before)
    assert np.array_equal(half_car.accelerations(arguments), before)
    assert heavier.compiled is half_car.compiled


def test_a_missing_parameter_is_named(half_car: Model) -> None:
    values = {name: value for name, value in half_car.values.items() if name != "body.mass"}
    with pytest.raises(KeyError, match="body.mass"):
        half_car.compiled.accelerations.bind(values)


def test_a_matrix_stands_in_its_places(quarter_car: Model) -> None:
    """The quarter car by hand: M in the columns of the accelerations, K in those of the coordinates."""
    jacobian = quarter_car.residual_jacobian.matrix(np.zeros(quarter_car.argument_count), (2, 6))
    value = quarter_car.parameters.flat()
    k, kt = value["spring.rate"], value["tyre.stiffness"]
    assert jacobian[:, :2] == pytest.approx(np.array([[k, -k], [-k, k + kt]]))
    assert jacobian[:, 4:] == pytest.approx(np.diag([value["sprung.mass"], value["unsprung.mass"]]))


def test_distances_from_the_knots_of_a_table(quarter_car: Model) -> None:
    """Rate of the damper's travel less each inner velocity of its table."""
    arguments = random_arguments(quarter_car, 9)
    body, wheel = arguments[2:4]
    knots = np.array(quarter_car.parameters.value("damper.velocity"))[1:-1]
    assert quarter_car.knot_distances(arguments) == pytest.approx(wheel - body - knots[:, None])


def test_a_mechanism_with_a_law_of_many_functions() -> None:
    cart = Mechanism("cart", sympy.S.Zero)
    joint = prismatic("z", "z")
    cart.add_body("cart", cart.ground, joint, (0, 0, 0), mass=sympy.Integer(2))
    stiffness = sympy.Symbol("bushing.stiffness", real=True)
    free = sympy.Piecewise((0, sympy.Abs(X) < 0.1), (X - 0.1 * sympy.sign(X), True))
    rubbing = 3 * sympy.tanh(Y / 0.2) + sympy.sign(Y) * sympy.Abs(Y) ** 1.5
    stop = sympy.exp(5 * X) * sympy.Heaviside(X - 0.3, 0)
    law = ForceLaw(stiffness * free + rubbing + stop + sympy.tan(stiffness / 1000), X, Y)
    cart.add_force_element("bushing", JointPort(joint.steps[0].coordinate), law)
    compiled = CompiledEquations(cart)
    residual = compiled.residual.bind({"bushing.stiffness": 500.0})
    s, v = arguments = np.random.default_rng(7).uniform(-0.5, 0.5, (2, 60))
    force = 500 * np.where(np.abs(s) < 0.1, 0, s - 0.1 * np.sign(s))
    force += 3 * np.tanh(v / 0.2) + np.sign(v) * np.abs(v) ** 1.5 + np.exp(5 * s) * (s > 0.3) + np.tan(0.5)
    states = np.vstack([arguments, np.full(60, 0.7)])
    assert residual(states)[0] == pytest.approx(2 * 0.7 + force, rel=1e-12)
    slopes = compiled.residual_jacobian.bind({"bushing.stiffness": 500.0})(states)
    for row in range(2):
        step = 1e-6 * np.eye(3)[:, [row]]
        expected = (residual(states + step) - residual(states - step))[0] / 2e-6
        assert slopes[row] == pytest.approx(expected, rel=1e-6)
    assert np.all(slopes[2] == 2)


# Kernels in parts


@pytest.fixture(scope="module")
def large() -> Kernel:
    """Give a kernel of names made of their predecessor and of one long before, all within one or so.

    Results are early and late names, an argument, a constant, a number, and sums of names that are far apart.
    """
    t = sympy.symbols("t:3000", real=True)
    definitions = {t[0]: X * Y}
    for i in range(1, len(t)):
        near, far = t[i - 1], t[7919 % i]
        forms = [sympy.sin(near + 2 * far + X), near * far - Y / 3, sympy.cos(D * near) * far * C]
        definitions[t[i]] = forms[i % 3] if i % 50 else sympy.Piecewise((near, near > far), (far / 2, True))
    results = [t[2999], t[5], t[1500] - t[10] * t[2900], X, C, sympy.Integer(3), *t[100::50], t[5]]
    return Kernel("kernel", {X: 0, Y: 1}, {C: 0, D: 1}, definitions, results)


def test_a_kernel_in_parts_is_numpys(large: Kernel) -> None:
    assert len(divide(in_order_of_need(large))) > 20
    arguments, constants = np.random.default_rng(3).uniform(-1, 1, (2, 20)), [0.7, -0.6]
    pairs = list(large.definitions.items())
    plain = sympy.lambdify([X, Y, C, D], list(large.results), "numpy", cse=lambda given: (pairs, list(given)))
    expected = plain(*arguments, *constants)
    found = run(list(large.results), arguments, constants, dict(large.definitions))
    for own, other in zip(found, expected, strict=True):
        assert own == pytest.approx(np.broadcast_to(other, 20), rel=1e-11, abs=1e-13)


def test_parts_stay_small_and_a_small_kernel_whole(large: Kernel) -> None:
    statements = in_order_of_need(large)
    assert max(map(len, divide(statements))) < 300
    assert divide(statements[:800]) == [statements[:800]]


def test_scratch_memory_keeps_a_value_until_its_last_use(large: Kernel) -> None:
    parts = divide(in_order_of_need(large))
    places = scratch_places(parts)
    held: dict[int, sympy.Symbol] = {}
    assigned: set[sympy.Symbol | int] = set()
    for part in parts:
        own = {statement.target for statement in part}
        for statement in part:
            target = statement.target
            assert assigned.issuperset(statement.needs)
            assert all(held[places[symbol]] == symbol for symbol in statement.needs if symbol not in own)
            assigned.add(target)
            if not isinstance(target, int) and target in places:
                held[places[target]] = target
    assert assigned == {*large.definitions, *range(len(large.results))}
    assert len(held) < 0.7 * len(places)


def test_what_no_result_needs_is_left_out() -> None:
    a, b = sympy.symbols("a b", real=True)
    kernel = Kernel("kernel", {X: 0}, {}, {a: sympy.sin(X), b: sympy.cos(X)}, [b])
    assert [statement.target for statement in in_order_of_need(kernel)] == [b, 0]


# Derivatives by any name


def richardson(function: Callable[[float], np.ndarray], centre: float, step: float) -> np.ndarray:
    """Differentiate by central differences of four steps, extrapolated: an error of the eighth order."""
    table = []
    for level in range(4):
        h = step / 2**level
        table.append((function(centre + h) - function(centre - h)) / (2 * h))
    for order in range(1, 4):
        table = [b + (b - a) / (4**order - 1) for a, b in pairwise(table)]
    return table[0]


NAMES = {
    "quarter_car": [
        "body_bounce",
        "wheel_bounce_rate",
        "body_bounce_acceleration",
        "road",
        "road_rate",
        "sprung.mass",
        "spring.rate",
        "damper.force[3]",
        "damper.velocity[1]",
        "tyre.damping",
        "tyre.preload",
        "gravity",
    ],
    "half_car": ["pitch", "pitch_rate", "bounce_acceleration", "rear_road", "body.mass", "body.mass_centre.z"]
    + ["axle.front.x", "suspension.rear.spring.rate", "front_tyre.preload"],
    "sedan": ["roll", "yaw_rate", "front_left_pad_z", "body.front.mass", "body.middle.mass_centre.z"]
    + ["suspension.front.arm_pivot.z", "tyre.rear.stiffness.y", "front_left_spring.preload"],
}


@pytest.mark.parametrize("vehicle", NAMES)
def test_derivatives_by_any_name(vehicle: str, request: pytest.FixtureRequest) -> None:
    """Against differences; what cannot be told apart from zero is measured by value over argument."""
    model, names = request.getfixturevalue(vehicle), NAMES[vehicle]
    symbols = [symbol.name for symbol in model.equations.arguments]
    state = random_arguments(model, 3)[:, 0]
    compiled = model.compiled

    def results(name: str, number: float) -> np.ndarray:
        values, moved = dict(model.values), state.copy()
        if name in symbols:
            moved[symbols.index(name)] = number
        else:
            values[name] = number
        return np.concatenate(
            [f.bind(values)(moved[:, None])[:, 0] for f in (compiled.residual, compiled.outputs)]
        )

    shape = model.size + len(model.output_names), len(names)
    found = compiled.jacobian(names).bind(model.values).matrix(state, shape)
    for column, name in zip(found.T, names, strict=True):
        centre = state[symbols.index(name)] if name in symbols else model.values[name]
        expected = richardson(partial(results, name), centre, 0.02 * max(abs(centre), 1e-2))
        scale = np.maximum(np.abs(expected), np.abs(results(name, centre)) / max(abs(centre), 1e-2))
        assert np.all(np.abs(column - expected) <= 1e-8 * scale), name


def test_derivatives_by_all_arguments_are_the_linearisation(half_car: Model) -> None:
    """The half car has no tables, so that no slope has to be stated."""
    state = random_arguments(half_car, 2)[:, 0]
    names = [symbol.name for symbol in half_car.equations.arguments]
    shape = half_car.size + len(half_car.output_names), len(names)
    found = half_car.compiled.jacobian(names).bind(half_car.values).matrix(state, shape)
    expected = half_car.compiled.linearisation.bind(half_car.values).matrix(state, shape)
    assert found == pytest.approx(expected, rel=1e-13)


def test_derivatives_are_compiled_once(quarter_car: Model) -> None:
    compiled = quarter_car.compiled
    assert compiled.jacobian(["sprung.mass"]) is compiled.jacobian(("sprung.mass",))
    assert compiled.jacobian(["sprung.mass"]) is not compiled.jacobian(["unsprung.mass"])


@pytest.mark.parametrize(
    ("wrong", "near"),
    [("sprung.mas", "sprung.mass"), ("body_bounce_velocity", "body_bounce_rate"), ("", ""), ("_0", "")],
)
def test_an_unknown_name_is_refused_with_near_ones(quarter_car: Model, wrong: str, near: str) -> None:
    with pytest.raises(ValueError, match=f"'{wrong}' is no argument or parameter .*{near}") as caught:
        quarter_car.compiled.jacobian(["spring.rate", wrong])
    assert "\n" not in str(caught.value)


def test_a_string_is_no_sequence_of_names(quarter_car: Model) -> None:
    with pytest.raises(TypeError, match=r"^names: a sequence of names is needed; .*'sprung.mass' received$"):
        quarter_car.compiled.jacobian("sprung.mass")


def test_derivatives_by_nothing(quarter_car: Model) -> None:
    function = quarter_car.compiled.jacobian([]).bind(quarter_car.values)
    assert function(np.zeros((8, 3))).shape == (0, 3)


@pytest.mark.parametrize("function", ["residual", "accelerations", "outputs", "residual_jacobian"])
def test_no_samples_give_no_results(quarter_car: Model, function: str) -> None:
    bound = getattr(quarter_car, function)
    assert bound(np.empty((8, 0))).shape == (len(bound.rows), 0)


@pytest.mark.parametrize("shape", [(1, 3), (10, 0), (0, 3), (8,), (8, 1, 1)])
def test_arguments_of_another_shape_are_refused(quarter_car: Model, shape: tuple[int, ...]) -> None:
    assert quarter_car.argument_count == 8
    with pytest.raises(ValueError, match=r"arguments: shape .* received; \(8, samples\) is needed"):
        quarter_car.residual(np.zeros(shape))


def test_the_derivative_of_a_magnitude_has_machine_code() -> None:
    """A quadratic damper's force is v |v|; its slope 2 |v| needs the sign of v."""
    v = sympy.Symbol("v", real=True)
    program = Program()
    force = program.let(v * program.let(sympy.Abs(v)))
    ((slope,),) = program.differentiate([force], [v])
    names = ["quadratic"]
    kernel = Kernel("quadratic", {v: 0}, {}, program.required([slope]), [slope])
    code = compile_assembly(assembly([kernel]))
    linked = link(code, names, "quadratic damper")
    rates, slopes = np.array([-2.0, -0.5, 0.0, 0.25, 1.0, 3.0, 4.0, 5.0]), np.empty(8)
    signature = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3, *[ctypes.c_int64] * 3)
    signature(linked.addresses["quadratic"])(rates.ctypes.data, 0, slopes.ctypes.data, 8, 8, 0)
    assert slopes == pytest.approx(2 * np.abs(rates))


def test_a_force_law_typed_at_a_prompt_works_without_the_disk_cache(cache_directory: str) -> None:
    program = """
from dataclasses import dataclass
import numpy as np, sympy
from chassym.derivation import Characteristic, CompiledEquations, JointPort, Mechanism, prismatic

@dataclass(frozen=True)
class Cubic(Characteristic):
    def force(self, program, deflection, rate, preload):
        return program.let(deflection**3)

cart = Mechanism("cart", gravity=0)
joint = prismatic("z", "z")
cart.add_body("cart", cart.ground, joint, (0, 0, 0), mass=1)
cart.add_force_element("spring", JointPort(joint.steps[0].coordinate), Cubic())
print(CompiledEquations(cart).residual.bind({})(np.array([[2.0], [0.0], [0.0]]))[0, 0])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert float(done.stdout) == 8.0


# Threads


@pytest.mark.slow
def test_threads_that_fetch_different_functions_get_what_one_thread_gets(
    monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """All functions of one model grow on one program."""
    names = ["residual", "residual_jacobian", "accelerations", "outputs"]
    names += ["knot_distances", "singularities", "linearisation"]
    fetches = [attrgetter(name) for name in names]
    fetches.append(methodcaller("jacobian", ("body.mass", "tyre.front.stiffness.z")))
    fetched = []
    for threads in (1, 8):
        monkeypatch.setenv("CHASSYM_CACHE_DIR", str(tmp_path_factory.mktemp("empty")))
        model = load_model("rigid_sedan")
        started = Barrier(threads)

        def fetch(
            function: Callable, compiled: CompiledEquations = model.compiled, started: Barrier = started
        ) -> CompiledFunction:
            started.wait()
            return function(compiled)

        interval = sys.getswitchinterval()
        sys.setswitchinterval(1e-6)
        try:
            with ThreadPoolExecutor(threads) as pool:
                functions = list(pool.map(fetch, fetches))
        finally:
            sys.setswitchinterval(interval)
        arguments = random_arguments(model, 5)
        values = defaultdict(lambda: 0.5, model.values)  # stated slopes have no value of their own
        fetched.append([function.bind(values)(arguments) for function in functions])
    for alone, together in zip(*fetched, strict=True):
        assert together == pytest.approx(alone, rel=1e-10, abs=1e-8)
