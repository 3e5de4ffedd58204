"""Machine code against sympy's own numpy printer, function by function and for whole vehicles."""

import ctypes
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest
import sympy

from chassym.derivation import Model, Program, machine_code
from chassym.derivation.machine_code import (
    LANES,
    Kernel,
    UnsupportedExpressionError,
    assembly,
    compile_assembly,
    link,
)

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
    function = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3, *[ctypes.c_int64] * 2)(
        linked.addresses["kernel"]
    )
    count = arguments.shape[1]
    filled = -(-count // LANES) * LANES
    padded, found = np.ones((2, filled)), np.full((len(results), filled), np.nan)
    padded[:, :count] = arguments
    given = np.array(constants)
    function(padded.ctypes.data, given.ctypes.data, found.ctypes.data, filled, filled)
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
        (sympy.tan(X), "tan"),
        (sympy.atan2(X, Y), "atan2"),
        (1 + X * sympy.sinh(Y), "sinh"),
        (sympy.Piecewise((X, X > 0), (0, True)), "Piecewise"),
        (X ** sympy.Rational(1, 3), r"x\*\*\(1/3\)"),
        (sympy.Integer(2) ** X, r"2\*\*x"),
        (X**Y, r"x\*\*y"),
        (sympy.Function("mystery")(X), "mystery"),
    ],
    ids=str,
)
def test_a_function_without_machine_code_is_refused_by_name(expression: sympy.Expr, named: str) -> None:
    with pytest.raises(UnsupportedExpressionError, match=named) as caught:
        assembly([Kernel("kernel", {X: 0, Y: 1}, {}, {}, [expression])])
    assert "\n" not in str(caught.value)


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


@pytest.mark.parametrize("shape", [(1, 3), (10, 0), (10,)])
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
    kernel = machine_code.Kernel("quadratic", {v: 0}, {}, program.required([slope]), [slope])
    code = machine_code.compile_assembly(machine_code.assembly([kernel]))
    linked = machine_code.link(code, names, "quadratic damper")
    rates, slopes = np.array([-2.0, -0.5, 0.0, 0.25, 1.0, 3.0, 4.0, 5.0]), np.empty(8)
    signature = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3, ctypes.c_int64, ctypes.c_int64)
    signature(linked.addresses["quadratic"])(rates.ctypes.data, 0, slopes.ctypes.data, 8, 8)
    assert slopes == pytest.approx(2 * np.abs(rates))


def test_a_force_law_typed_at_a_prompt_works_without_the_disk_cache(cache_directory: str) -> None:
    program = """
from dataclasses import dataclass
import numpy as np, sympy
from chassym.derivation import Characteristic, CompiledEquations, JointPort, Mechanism, prismatic

@dataclass(frozen=True)
class Cubic(Characteristic):
    def force(self, program, deflection, rate):
        return program.let(deflection**3)

cart = Mechanism("cart", gravity=0)
joint = prismatic("z", "z")
cart.add_body("cart", cart.ground, joint, (0, 0, 0), mass=1)
cart.add_force_element("spring", JointPort(joint.steps[0].coordinate), Cubic())
print(CompiledEquations(cart).residual.bind({})(np.array([[2.0], [0.0], [0.0]]))[0, 0])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert float(done.stdout) == 8.0
