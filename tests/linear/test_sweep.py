"""Thousands of variants in one call against one model at a time."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import sympy
import xarray

from chassym.derivation import (
    Characteristic,
    EquilibriumError,
    ForceLaw,
    JointPort,
    Mechanism,
    Model,
    ParameterError,
    PointAcceleration,
    SpringTable,
    build_model,
    load_model,
    prismatic,
    variants,
)
from chassym.linear import (
    LinearModel,
    NaturalFrequency,
    damped_modes,
    frequency_response,
    linearise,
    track_modes,
)
from chassym.linear.linear_model import LinearisationError
from chassym.linear.operating_point import OperatingPointError
from chassym.linear.slope_rule import DescribingFunction, left_slope
from chassym.linear.variation.sweep import DampedModes, Matrices, ModesLike, Response, sweep
from chassym.linear.variation.variants import linearise_variants

FREQUENCIES_HZ = np.geomspace(0.02, 200, 40)
PADS = {"front_left_pad_z": 1.0, "front_right_pad_z": 1.0, "rear_left_pad_z": -1j, "rear_right_pad_z": -1j}


def at_random(model: Model, count: int, spread: float = 0.25) -> dict[str, np.ndarray]:
    """Give every number but moments of inertia and knots a factor of its own."""
    generator = np.random.default_rng(count)
    changes = {}
    for name, parameter in model.parameters.items():
        if ".inertia." not in name and not name.endswith(("velocity", "force")):
            factors = generator.uniform(1 - spread, 1 + spread, count)
            changes[name] = np.multiply(parameter.value, factors)
    return changes


@pytest.fixture(scope="module")
def changes(sedan: Model) -> dict[str, np.ndarray]:
    return at_random(sedan, 9)


@pytest.fixture(scope="module")
def swept(sedan: Model, changes: dict[str, np.ndarray]) -> xarray.Dataset:
    response = Response("vertical_acceleration", PADS, FREQUENCIES_HZ)
    return sweep(sedan, changes, [Matrices(), DampedModes(), response])


@pytest.mark.parametrize("index", [0, 4, 8])
def test_every_variant_is_what_it_is_alone(
    sedan: Model, changes: dict[str, np.ndarray], swept: xarray.Dataset, index: int
) -> None:
    alone = linearise(sedan.with_parameters({name: each[index] for name, each in changes.items()}))
    one = swept.sel(variant=index)
    for name in ("mass", "damping", "stiffness", "input_damping", "output_by_accelerations"):
        expected = getattr(alone, name)
        np.testing.assert_allclose(one[name], expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    expected = np.array([mode.eigenvalue for mode in damped_modes(alone)])
    assert (np.diff(one.natural_frequency_hz) > -1e-9).all()
    oscillations = one.eigenvalue.values[one.eigenvalue.values.imag >= 0]
    np.testing.assert_allclose(np.sort_complex(oscillations), np.sort_complex(expected), rtol=1e-9)
    direct = frequency_response(alone, FREQUENCIES_HZ).combined("vertical_acceleration", PADS)
    np.testing.assert_allclose(one.response, direct, rtol=1e-10)


def test_shapes_solve_the_equations_of_motion(swept: xarray.Dataset) -> None:
    one = swept.sel(variant=3)
    for root in range(24):
        s, shape = one.eigenvalue.values[root], one["shape"].values[:, root]
        dynamic = s**2 * one.mass.values + s * one.damping.values + one.stiffness.values
        assert np.abs(dynamic @ shape).max() < 1e-9 * np.abs(one.stiffness.values @ shape).max()
        assert (shape.conj() @ one.mass.values @ shape).real == pytest.approx(1.0)


def test_modes_are_found_again_by_their_shapes(sedan: Model) -> None:
    """Along a stiffness: the same branches as those that are followed step by step."""
    factors = np.linspace(0.8, 1.25, 10)
    names = ["tyre.front.stiffness.z", "suspension.rear.spring.rate"]
    changes = {name: factors * sedan.parameters[name].value for name in names}
    nominal = linearise(sedan)
    found = sweep(sedan, changes, [ModesLike(nominal)])
    assert list(found.mode.values) == [mode.name for mode in damped_modes(nominal)]

    def linear_at(factor: float) -> LinearModel:
        return linearise(sedan.scaled(*names, factor=factor))

    for factors_away in (factors[factors <= 1], factors[factors >= 1]):
        tracked = track_modes(linear_at, [1.0, *factors_away])
        eigenvalues = tracked.eigenvalue.values[0]
        for mode in damped_modes(nominal):
            branch = np.abs(eigenvalues - mode.eigenvalue).min(axis=1).argmin()
            index = np.isin(factors, factors_away)
            own = found.mode_frequency_hz.sel(mode=mode.name).values[index]
            np.testing.assert_allclose(own, tracked.frequency_hz.values[1:, branch], rtol=1e-7)
    assert (found.mode_assurance > 0.5).all()


def test_quantities_that_are_none_are_refused(quarter_car: Model) -> None:
    for quantity in (DampedModes, NaturalFrequency("bounce"), "modes"):
        with pytest.raises(LinearisationError, match="quantities: .* received; expected Matrices"):
            sweep(quarter_car, {"sprung.mass": [300.0]}, [quantity])


def test_labels_units_and_parameters_are_there(sedan: Model, swept: xarray.Dataset) -> None:
    assert swept.mass.dims == ("variant", "coordinate", "column")
    assert list(swept.coordinate.values) == [c.name for c in sedan.system.coordinates]
    assert swept.natural_frequency_hz.attrs["units"] == "Hz" and swept.response.attrs["units"] == "m/s^2"
    assert swept["body.front.mass"].attrs["units"] == "kg" and swept.attrs["slope_rule"] == "mean_slope"
    assert swept.natural_frequency_hz.values.shape == (9, 24)
    assert (swept.response_error < 1e-10).all()


def test_slope_rules_and_tables_of_variants() -> None:
    car = load_model("quarter_car")
    force = np.array([[-1200.0, -300.0, 0.0, 200.0, 900.0], [-2000.0, -700.0, 10.0, 300.0, 800.0]])
    for rule in (left_slope, DescribingFunction(0.3)):
        found = sweep(car, {"damper.force": force}, [Matrices()], rule)
        for index in range(2):
            alone = linearise(car.with_parameters({"damper.force": force[index].tolist()}), rule)
            np.testing.assert_allclose(found.damping[index], alone.damping, rtol=1e-12)
    entry = sweep(car, {"damper.force[3]": force[:, 3]}, [Matrices()])
    whole = [*car.parameters["damper.force"].value]
    for index in range(2):
        whole[3] = force[index, 3]
        alone = linearise(car.with_parameters({"damper.force": list(whole)}))
        np.testing.assert_allclose(entry.damping[index], alone.damping, rtol=1e-12)


def test_loads_that_several_springs_share_are_shared_as_in_a_single_model() -> None:
    """More preloads than equations: the solution of smallest norm, for every variant its own."""
    car = load_model("ride_model")
    found = variants(car, at_random(car, 5))
    for index in (0, 4):
        for name, expected in found.one(index).preloads.items():
            assert found.preloads[name][index] == pytest.approx(expected, rel=1e-10)


def test_a_far_variant_is_balanced_too(sedan: Model) -> None:
    """Preloads of variants that do not resemble the first one are found another way."""
    factors = np.array([1.0, 0.05, 30.0])
    pivots = {
        name: factors * sedan.parameters[name].value
        for name in ("suspension.front.arm_pivot.y", "suspension.rear.arm_pivot.y")
    }
    found = variants(sedan, pivots)
    for index in range(3):
        for name, expected in found.one(index).preloads.items():
            assert found.preloads[name][index] == pytest.approx(expected, rel=1e-9)


def test_variants_whose_modes_are_inexact_are_solved_directly(quarter_car: Model) -> None:
    """As those of nearly multiple eigenvalues are: here the shapes of one variant are made wrong by 1e-6."""
    found = variants(quarter_car, {"sprung.mass": [300.0, 350.0, 400.0]})
    linear = linearise_variants(found)
    values, vectors = linear.eigensystem
    vectors[1, 0] *= 1 + 1e-6
    response = Response("vertical_acceleration", {"road": 1.0}, FREQUENCIES_HZ).of(linear)
    for index in range(3):
        alone = frequency_response(linearise(found.one(index)), FREQUENCIES_HZ)
        expected = alone.select("vertical_acceleration", "road")
        np.testing.assert_allclose(response["response"][1][index], expected, rtol=1e-11)
    assert (response["response_error"][1] < 1e-11).all()


def test_a_critically_damped_car() -> None:
    """Its double eigenvalue makes shapes nearly parallel; on a stiff tyre it is one mass."""
    car = load_model("quarter_car").scaled("tyre.stiffness", factor=1e6)
    k, m = car.parameters["spring.rate"].value, car.parameters["sprung.mass"].value
    c = 2 * np.sqrt(k * m) * np.array([0.9, 1.0, 1 + 1e-13, 1.2])
    force = np.outer(c, car.parameters["damper.velocity"].value)
    low = FREQUENCIES_HZ[FREQUENCIES_HZ < 5]
    found = sweep(car, {"damper.force": force}, [Response("vertical_acceleration", {"road": 1.0}, low)])
    s = 2j * np.pi * low
    for index in range(4):
        expected = s**2 * (k + c[index] * s) / (m * s**2 + c[index] * s + k)
        np.testing.assert_allclose(found.response[index], expected, rtol=1e-4)


def test_memory_grows_with_the_result_only(quarter_car: Model) -> None:
    def peak(count: int) -> tuple[int, int]:
        tracemalloc.start()
        masses = np.linspace(300, 400, count)
        found = sweep(quarter_car, {"sprung.mass": masses}, [DampedModes()])
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most, found.nbytes

    peak(1000)
    (few, few_bytes), (many, many_bytes) = peak(1000), peak(20_000)
    assert many - few < 1.2 * (many_bytes - few_bytes) + 500_000


def test_refusals_name_the_variant_or_the_parameter(quarter_car: Model, sedan: Model) -> None:
    quantities = [Matrices()]
    for changes, words in (
        ({"sprung.mass": [300.0, -1.0]}, "variant 1: override: sprung.mass: received -1.0"),
        ({"sprung.mass": [300.0, np.nan]}, "variant 1: .*sprung.mass: received nan"),
        ({"sprung.mas": [300.0]}, "variants: sprung.mas: received an unknown name"),
        ({"sprung.mass": [300.0], "tyre.stiffness": [1e5, 2e5]}, "received numbers of variants"),
        ({"damper.force": [1.0, 2.0]}, r"an array of shape \(2,\), expected one of shape \(count, 5\)"),
        ({"damper.velocity": [[-1.0, 0.0, -0.1, 0.1, 1.0]]}, "variant 0: .*strictly increasing"),
        ({"sprung.mass": []}, "expected one and the same, not zero"),
        ({"sprung.mass": ["1 kg"]}, "expected an array of numbers in SI"),
        ({"damper.force": [[-1.0, 0, 0, 0, 1]], "damper.force[0]": [-2.0]}, "numbers twice"),
        ({}, "expected the numbers of at least one parameter"),
    ):
        with pytest.raises(ParameterError, match=words):
            sweep(quarter_car, changes, quantities)
    with pytest.raises(ParameterError, match="variant 1: .*each at most the sum of the other two"):
        sweep(sedan, {"body.front.inertia.xx": [126.0, 500.0]}, quantities)
    for response in (
        Response("bounce", {"road": 1.0}, [1.0]),
        Response("vertical_acceleration", {"pad": 1.0}, [1.0]),
        Response("vertical_acceleration", {"road": 1.0}, [-1.0]),
    ):
        with pytest.raises(LinearisationError):
            sweep(quarter_car, {"sprung.mass": [300.0]}, [response])


def test_variants_that_nothing_holds_are_refused(quarter_car: Model) -> None:
    given = Model(quarter_car.parameters, quarter_car.compiled, quarter_car.preloads)
    with pytest.raises(OperatingPointError, match="variant 1 of 'quarter_car' is not an equilibrium"):
        linearise_variants(variants(given, {"sprung.mass": [given.values["sprung.mass"], 400.0]}))
    with pytest.raises(EquilibriumError, match="not finite"):
        linearise_variants(variants(quarter_car, {"sprung.mass": [300.0, 1.7e308]}))


def test_a_massless_variant_is_named(quarter_car: Model) -> None:
    linear = linearise_variants(variants(quarter_car, {"sprung.mass": [300.0, 350.0]}))
    massless = linear.jacobian.copy()
    massless[1, 0, 4] = 0.0
    linear = replace(linear, jacobian=massless)
    with pytest.raises(LinearisationError, match="mass matrix of variant 1 of 'quarter_car' is singular"):
        _ = linear.state_matrix


def block(law: Characteristic, values: dict, *, gravity: float = 0) -> Model:
    mechanism = Mechanism("block", gravity=gravity)
    joint = prismatic("slide", "x")
    body = mechanism.add_body("mass", mechanism.ground, joint, (0, 0, 0), mass=2)
    place = mechanism.point("place", body, (0, 0, 0))
    mechanism.add_output(PointAcceleration("acceleration", place, "x", mechanism.ground))
    port = JointPort(joint.steps[0].coordinate).less(mechanism.add_input("base", "m"))
    mechanism.add_force_element("contact", port, law)
    return build_model(mechanism, values)


def test_a_jump_in_any_variant_is_refused() -> None:
    """Coulomb's friction that the first variant does not have."""
    s, v = sympy.symbols("s v", real=True)
    k, mu = sympy.symbols("k mu", nonnegative=True)
    model = block(ForceLaw(k * s + mu * sympy.sign(v), s, v), {k: 50.0, mu: 0.0})
    sweep(model, {"mu": [0.0, 0.0]}, [Matrices()])
    with pytest.raises(LinearisationError, match="variant 1: .*jumps by 12 N"):
        sweep(model, {"mu": [0.0, 6.0]}, [Matrices()])


def test_rounding_is_no_unbalance() -> None:
    """A table without a point at rest sums to zero up to rounding, alone and among variants."""
    k = sympy.Symbol("k", positive=True)
    places = (-0.1, -0.03, 0.02, 0.07)
    model = block(SpringTable(places, [place * k for place in places]), {k: 1e3})
    assert linearise(model).stiffness[0, 0] == pytest.approx(1e3)
    found = sweep(model, {"k": [1e3, 1.1e3]}, [Matrices()])
    assert found.stiffness.values.ravel() == pytest.approx([1e3, 1.1e3])


def test_several_responses_have_names_of_their_own(quarter_car: Model) -> None:
    masses = {"sprung.mass": [300.0, 400.0]}
    first = Response("body_displacement", {"road": 1.0}, [1.0, 2.0], name="body")
    second = Response("wheel_travel", {"road": 1.0}, [1.0, 2.0], name="travel")
    both = sweep(quarter_car, masses, [first, second])
    for quantity, name in ((first, "body"), (second, "travel")):
        np.testing.assert_array_equal(both[name], sweep(quarter_car, masses, [quantity])[name])
    with pytest.raises(LinearisationError, match="two of them give a different 'response'"):
        sweep(quarter_car, masses, [replace(first, name="response"), replace(second, name="response")])


def test_an_infinite_response_is_refused() -> None:
    s, v = sympy.symbols("s v", real=True)
    k = sympy.Symbol("k", nonnegative=True)
    model = block(ForceLaw(k * s, s, v), {k: 0.0})
    with pytest.raises(LinearisationError, match="holds 0, where the response .* is infinite"):
        sweep(model, {"k": [0.0]}, [Response("acceleration", {"base": 1.0}, [0.0])])


def test_a_variant_of_many_is_named_by_its_own_number(quarter_car: Model) -> None:
    given = Model(quarter_car.parameters, quarter_car.compiled, quarter_car.preloads)
    masses = np.full(1500, given.values["sprung.mass"])
    masses[1200] += 5.0
    with pytest.raises(OperatingPointError, match="variant 1200 of 'quarter_car'"):
        sweep(given, {"sprung.mass": masses}, [Matrices()])


def test_what_is_returned_cannot_corrupt_a_model(quarter_car: Model) -> None:
    table = quarter_car.tables["damper"]
    for array in (table.knots, table.slopes, linearise(quarter_car).operating_point.coordinates):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    linear = linearise_variants(variants(quarter_car, {"sprung.mass": [300.0]}))
    with pytest.raises(ValueError, match="read-only"):
        linear[0].mass[0, 0] = 1.0


def test_progress_reaches_the_end(quarter_car: Model) -> None:
    told: list[float] = []
    sweep(quarter_car, {"sprung.mass": np.linspace(300, 400, 2500)}, [Matrices()], progress=told.append)
    assert told == sorted(told) and told[-1] == 1.0 and len(told) == 3
