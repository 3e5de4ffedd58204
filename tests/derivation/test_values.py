"""Models from mechanisms and equations of motion with values: units, what is missing, what is possible."""

import numpy as np
import pytest
import sympy
from sympy.physics.mechanics import dynamicsymbols

from chassym.derivation import (
    EquationsOfMotion,
    JointPort,
    Linear,
    Mechanism,
    Model,
    ParameterError,
    derive,
    prismatic,
)
from chassym.derivation.from_sympy import from_lagrangian
from chassym.derivation.values import build_model
from chassym.linear import linearise, undamped_modes

m, k, g = sympy.symbols("m k g", positive=True)
VALUES = {"m": 2.0, "k": "0.8 N/mm"}


@pytest.fixture(scope="module")
def oscillator() -> EquationsOfMotion:
    q = dynamicsymbols("q")
    return from_lagrangian(m * q.diff() ** 2 / 2 - k * q**2 / 2, [q], name="oscillator")


def hanging(*, preloaded: bool) -> Mechanism:
    """Hang a mass on a spring."""
    mechanism = Mechanism("hanging", gravity=g)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    assert mass in mechanism.bodies
    port = JointPort(mechanism.coordinate("z"))
    mechanism.add_force_element("spring", port, Linear(k), preloaded=preloaded)
    return mechanism


def with_unit(text: str) -> tuple[float, str]:
    """Value and unit that a text becomes, for a parameter without any assumption."""
    q, a = dynamicsymbols("q"), sympy.Symbol("a")
    parameter = build_model(
        from_lagrangian(q.diff() ** 2 / 2 - a * q, [q], name="one"), {a: text}
    ).parameters["a"]
    assert isinstance(parameter.value, float)
    return parameter.value, parameter.unit


def refused(source: Mechanism | EquationsOfMotion, values: dict, *words: str) -> None:
    with pytest.raises(ParameterError) as caught:
        build_model(source, values)
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


def test_preloads_are_found() -> None:
    """The weight m g hangs on the spring, whose resisting force at rest is -m g."""
    model = build_model(hanging(preloaded=True), {m: 3.0, k: 1e3, g: "9.81 m/s^2"})
    assert model.preloads == pytest.approx({"spring.preload": -3.0 * 9.81}, rel=1e-12)
    assert undamped_modes(linearise(model)).frequencies_hz == pytest.approx([np.sqrt(1e3 / 3) / (2 * np.pi)])


def test_a_mechanism_without_preloads() -> None:
    model = build_model(hanging(preloaded=False), {m: 3.0, k: 1e3, g: 9.81})
    assert model.preloads == {}
    assert model.accelerations(np.zeros((3, 1)))[0, 0] == pytest.approx(-9.81, rel=1e-14)


def test_mechanism_and_its_equations_make_the_same_model() -> None:
    mechanism, values = hanging(preloaded=True), {m: 3.0, k: 1e3, g: 9.81}
    models = [build_model(source, values) for source in (mechanism, derive(mechanism))]
    assert models[0].values == models[1].values
    assert models[0].system.bodies == models[1].system.bodies == mechanism.bodies


def test_values_of_a_vehicle_by_name(quarter_car: Model) -> None:
    """The quarter car, its tables' entries included, from its own numbers."""
    model = build_model(quarter_car.system, quarter_car.parameters.flat(), "the same")
    assert model.values == pytest.approx(quarter_car.values, rel=1e-12)
    assert linearise(model).slopes == pytest.approx(linearise(quarter_car).slopes, rel=1e-12)
    assert model.parameters.description == "the same"


def test_variants_by_numbers_and_text(oscillator: EquationsOfMotion) -> None:
    model = build_model(oscillator, {m: 2.0, k: ("0.8 N/mm", "rate of the spring")})
    assert model.values == {"m": 2.0, "k": 800.0}
    assert (model.parameters["k"].description, model.parameters["m"].description) == (
        "rate of the spring",
        "m",
    )
    assert model.with_parameters({"k": "20 N/cm"}).values["k"] == 2000.0
    assert model.with_parameters({"k": 5}).values["k"] == 5.0
    assert model.scaled("k", factor=2.0).values["k"] == 1600.0
    assert model.with_parameters({"k": 5}).compiled is model.compiled
    with pytest.raises(ParameterError, match="k: received .*dimension.*N/m"):
        model.with_parameters({"k": "20 kg"})


def test_a_bare_number_has_no_unit(oscillator: EquationsOfMotion) -> None:
    model = build_model(oscillator, VALUES)
    assert [(p.name, p.unit) for p in model.parameters.values()] == [("m", "1"), ("k", "N/m")]
    with pytest.raises(ParameterError, match="m: received the unit 'kg'"):
        model.with_parameters({"m": "3 kg"})


def test_numbers_of_any_kind(oscillator: EquationsOfMotion) -> None:
    model = build_model(oscillator, {m: np.float64(2.0), k: sympy.Rational(1, 4)})
    assert model.values == {"m": 2.0, "k": 0.25}


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("20 N/mm", 20e3, "N/m"),
        ("2 kN*m/deg", 2e3 * 180 / np.pi, "N*m/rad"),
        ("5 lbf*s/ft", 5 * 4.4482216152605 / 0.3048, "N*s/m"),
        ("72 km/h", 20.0, "m/s"),
        ("3 g*cm^2", 3e-7, "kg*m^2"),
        ("0.5 t", 500.0, "kg"),
        ("2 bar", 2e5, "Pa"),
        ("60 rpm", 2 * np.pi, "rad/s"),
        ("1 mm/rpm", 1e-3 * 60 / (2 * np.pi), "m/(rad/s)"),
        ("3 Hz", 3.0, "1/s"),
        ("10 %", 0.1, "1"),
        ("4 1/s", 4.0, "1/s"),
        ("7", 7.0, "1"),
    ],
)
def test_units_become_si(text: str, value: float, unit: str) -> None:
    found = with_unit(text)
    assert found[0] == pytest.approx(value, rel=1e-12)
    assert found[1] == unit


@pytest.mark.parametrize("text", ["3 foo", "3 N/", "3 m**9**9**9", "20 Nm", "20 kNm", "N", "3 ; import os"])
def test_units_that_are_none_are_refused(oscillator: EquationsOfMotion, text: str) -> None:
    refused(oscillator, {m: 1.0, k: text}, "values: k: received")


def test_missing_values_are_named(oscillator: EquationsOfMotion) -> None:
    refused(oscillator, {}, "values: k, m: received nothing")
    refused(oscillator, {"m": 1.0}, "values: k: received nothing")
    refused(hanging(preloaded=True), {m: 1.0, k: 1.0}, "values: g: received nothing")


def test_unknown_names_are_refused_with_near_ones(oscillator: EquationsOfMotion) -> None:
    refused(oscillator, VALUES | {"kk": 1.0}, "values: kk: received an unknown name", "such as k")
    refused(
        hanging(preloaded=True), {m: 1.0, k: 1.0, g: 1.0, "spring.preload": 1.0}, "spring.preload", "unknown"
    )
    q = dynamicsymbols("q")
    bare = from_lagrangian(q.diff() ** 2 / 2, [q], name="bare")
    refused(bare, {"a": 1.0}, "values: a: received an unknown name", "no parameters")
    assert build_model(bare, {}).values == {}


def test_a_symbol_of_the_energies_alone_may_have_a_value() -> None:
    """A constant in V moves nothing, but stands in the energy that a user wrote down."""
    q, level = dynamicsymbols("q"), sympy.Symbol("level")
    equations = from_lagrangian(m * q.diff() ** 2 / 2 - m * g * (q + level), [q], name="fall")
    values = {m: 1.0, g: 9.81}
    assert build_model(equations, values | {level: 3.0}).values == {"m": 1.0, "g": 9.81, "level": 3.0}
    assert build_model(equations, values).values == {"m": 1.0, "g": 9.81}


def test_values_outside_a_symbols_assumptions_are_refused(oscillator: EquationsOfMotion) -> None:
    refused(oscillator, {m: -1.0, k: 1.0}, "values: m", "greater than zero")
    refused(oscillator, {m: 1.0, k: "0 N/m"}, "values: k", "greater than zero", "N/m")
    q, c = dynamicsymbols("q"), sympy.Symbol("c", nonnegative=True)
    damped = from_lagrangian(q.diff() ** 2 / 2, [q], dissipation=c * q.diff() ** 2 / 2, name="damped")
    refused(damped, {c: -1.0}, "values: c", "zero or greater")
    model = build_model(damped, {c: 0.0})
    with pytest.raises(ParameterError, match="zero or greater"):
        model.with_parameters({"c": -2.0})


def test_what_is_no_value_is_refused(oscillator: EquationsOfMotion) -> None:
    refused(oscillator, {m: float("nan"), k: 1.0}, "values: m", "nan")
    refused(oscillator, {m: [1.0, 2.0], k: 1.0}, "values: m", "one finite number")
    refused(oscillator, {m: None, k: 1.0}, "values: m", "None")
    refused(oscillator, {m: (1.0, 2.0), k: 1.0}, "values: m", "description")
    refused(oscillator, {m: (1.0,), k: 1.0}, "values: m", "description")
    refused(oscillator, {m: 1.0, "m": 1.0, k: 1.0}, "values: m", "two values")
    refused(oscillator, {3: 1.0}, "values", "key 3", "symbol or a name")


def test_what_has_no_equations_is_refused() -> None:
    with pytest.raises(
        TypeError, match="str received; expected a mechanism, a Lagrangian or equations of motion"
    ):
        build_model("pendulum", {})  # type: ignore[arg-type]
