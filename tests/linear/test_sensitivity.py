"""Exact derivatives by parameters against closed forms and Richardson-extrapolated differences."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import sympy
from sympy.physics.mechanics import dynamicsymbols

from chassym.derivation import (
    Linear,
    LineOfSightPort,
    Mechanism,
    Model,
    ParameterError,
    Polynomial,
    TravelPort,
    build_model,
    from_lagrangian,
    load_model,
    prismatic,
    revolute,
)
from chassym.linear import LinearModel, OperatingPoint, damped_modes, frequency_response, linearise, position
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.linear_model import LinearisationError
from chassym.linear.road.road_contacts import Passage, road_contacts
from chassym.linear.road.road_surface import iso_8608
from chassym.linear.slope_rule import DescribingFunction, Secant, SlopeRule, mean_slope, right_slope
from chassym.linear.statics.equilibrium import find_equilibrium
from chassym.linear.variation.metrics import (
    DampingRatio,
    Metric,
    NaturalFrequency,
    ResponseAmplitude,
    RoadVibration,
)
from chassym.linear.variation.sensitivity import Sensitivity, sensitivity
from chassym.linear.variation.tornado import tornado

STEP = 0.02  # relative, of the differences

RULES = [right_slope, mean_slope, Secant(0.3), DescribingFunction(0.4)]


def changed(model: Model, name: str, factor: float) -> Model:
    """Multiply one number of a model."""
    base, _, index = name.partition("[")
    value = model.parameters[base].value
    if not index:
        return model.with_parameters({name: factor * value})
    entries = list(value)
    entries[int(index[:-1])] *= factor
    return model.with_parameters({base: entries})


def extrapolated(evaluate: Callable[[float], np.ndarray], step: float = STEP) -> np.ndarray:
    """Differentiate at factor one by three central differences, each half as wide: an error of order six."""
    table = [(evaluate(1 + h) - evaluate(1 - h)) / (2 * h) for h in (step, step / 2, step / 4)]
    table = [(4 * fine - coarse) / 3 for coarse, fine in zip(table, table[1:], strict=False)]
    return (16 * table[1] - table[0]) / 15


def matrices(linear: LinearModel, like: Sensitivity) -> np.ndarray:
    return np.concatenate([getattr(linear, name).ravel() for name in like.matrices])


def sensible(found: Sensitivity) -> list[int]:
    """Numbers that are not zero and whose change moves no knot to, or from, rest."""
    return [
        index
        for index, (name, value) in enumerate(zip(found.parameters, found.values, strict=True))
        if value != 0 and "velocity[2]" not in name
    ]


@pytest.mark.parametrize(
    ("vehicle", "rule"),
    [*(("quarter_car", rule) for rule in RULES), ("half_car", mean_slope), ("ride_model", mean_slope)],
    ids=str,
)
def test_matrices_of_small_vehicles(vehicle: str, rule: SlopeRule) -> None:
    """Of every number of the vehicle; ride_model shares its weight among more springs than it needs."""
    model = load_model(vehicle)
    found = sensitivity(model, None, rule)
    scale = np.abs(matrices(found.linear, found))
    for index in sensible(found):
        name = found.parameters[index]
        expected = extrapolated(lambda f, n=name: matrices(linearise(changed(model, n, f), rule), found))
        own = np.concatenate([each[index].ravel() for each in found.matrices.values()])
        assert np.abs(own * found.values[index] - expected).max() < 1e-9 * scale.max(), name


PICKED = [
    "body.front.mass",
    "body.middle.inertia.xx",
    "body.front.torsional_stiffness",
    "body.rear.stiffness_proportional_damping",
    "suspension.front.arm_pivot.y",
    "suspension.rear.spring.lever_ratio",
    "suspension.front.damper.force[1]",
    "suspension.rear.damper.velocity[3]",
    "suspension.front.anti_roll_bar.rate",
    "tyre.rear.stiffness.z",
    "tyre.front.damping.y",
    "axle.rear.x",
    "gravity",
]


@pytest.fixture(scope="module")
def car(sedan: Model) -> Sensitivity:
    return sensitivity(sedan, PICKED)


@pytest.mark.parametrize("name", PICKED)
def test_eigenvalues_of_the_reference_car(sedan: Model, car: Sensitivity, name: str) -> None:
    modes = damped_modes(car.linear)
    eigenvalues = np.array([mode.eigenvalue for mode in modes])

    def followed(factor: float) -> np.ndarray:
        own = np.linalg.eigvals(displacements_and_rates(linearise(changed(sedan, name, factor))).A)
        return own[np.abs(own - eigenvalues[:, None]).argmin(axis=1)]

    index = PICKED.index(name)
    expected = extrapolated(followed, 0.004)
    found = car.eigenvalues(eigenvalues)[:, index] * car.values[index]
    assert np.abs(found - expected).max() < 1e-8 * np.abs(eigenvalues).max()
    large = np.abs(expected) > 1e-3 * np.abs(eigenvalues)
    assert (np.abs(found - expected) < 1e-8 * np.abs(expected))[large].all()


@pytest.mark.parametrize("name", PICKED)
def test_frequency_response_of_the_reference_car(sedan: Model, car: Sensitivity, name: str) -> None:
    index, frequencies = PICKED.index(name), [0.3, 1.2, 3.0, 9.5, 31.0]
    inputs = ["front_left_pad_y", "rear_right_pad_z"]
    for output in ("roll_rate", "vertical_acceleration", "rear_right_patch_force_z"):

        def response(factor: float, output: str = output) -> np.ndarray:
            found = frequency_response(linearise(changed(sedan, name, factor)), frequencies)
            return np.array([found.select(output, each) for each in inputs])

        expected = extrapolated(response, 0.004)
        found = car.response(output, inputs, frequencies)[index] * car.values[index]
        scale = np.abs(response(1.0)).max(axis=1, keepdims=True)
        assert (np.abs(found - expected) < 1e-8 * np.maximum(scale, np.abs(expected))).all()


def test_quarter_car_in_closed_form(quarter_car: Model) -> None:
    """One mass on a fixed wheel (a very stiff tyre): w^2 = k / m, zeta = c / (2 sqrt(k m))."""
    stiff = quarter_car.scaled("tyre", factor=1e9)
    found = sensitivity(stiff, ["sprung.mass", "spring.rate"])
    k, m = (stiff.parameters[name].value for name in ("spring.rate", "sprung.mass"))
    (mode,) = [mode for mode in damped_modes(found.linear) if mode.name == "bounce"]
    by_mass, by_rate = found.frequencies_hz([mode.eigenvalue])[0]
    assert by_mass == pytest.approx(-np.sqrt(k / m) / (4 * np.pi * m), rel=1e-6)
    assert by_rate == pytest.approx(1 / (4 * np.pi * np.sqrt(k * m)), rel=1e-6)
    zeta_by_mass, zeta_by_rate = found.damping_ratios([mode.eigenvalue])[0]
    assert zeta_by_mass == pytest.approx(-mode.damping_ratio / (2 * m), rel=1e-6)
    assert zeta_by_rate == pytest.approx(-mode.damping_ratio / (2 * k), rel=1e-6)


def test_the_position_at_rest_follows_where_preloads_are_given(sedan: Model) -> None:
    """A car that was loaded: its parameters move it, and its geometry with it."""
    names = ["body.middle.mass", "suspension.front.spring.rate", "tyre.rear.stiffness.z"]
    point = find_equilibrium(sedan, changes={"body.middle.mass": 700.0})
    at_rest = dict(zip([c.name for c in sedan.system.coordinates], point.coordinates, strict=True))
    found = sensitivity(point, names)
    for index, name in enumerate(names):
        value = point.model.parameters[name].value

        def settled(factor: float, name: str = name, value: float = value) -> np.ndarray:
            there = find_equilibrium(point.model, changes={name: factor * value}, start=at_rest)
            return matrices(linearise(there), found)

        expected = extrapolated(settled)
        own = np.concatenate([each[index].ravel() for each in found.matrices.values()]) * found.values[index]
        assert np.abs(own - expected).max() < 1e-8 * np.abs(matrices(found.linear, found)).max()


def lever() -> Model:
    """Give a level lever on two stretched springs that end at one place above it: they share its weight."""
    mass, near, far, rate, g = sympy.symbols("mass near far rate g", positive=True)
    mechanism = Mechanism("lever", gravity=g)
    hinge = revolute("tilt", "y")
    arm = mechanism.add_body("arm", mechanism.ground, hinge, (0, 0, 0), mass=mass, mass_centre=(far, 0, 0))
    anchor = mechanism.point("anchor", mechanism.ground, (0, 0, 1))
    for name, place in (("inner", near), ("outer", far)):
        port = LineOfSightPort(mechanism.point(name, arm, (place, 0, 0)), anchor)
        mechanism.add_force_element(name, port, Linear(rate), preloaded=True)
    return build_model(mechanism, {mass: 20.0, near: 0.4, far: 1.1, rate: 3000.0, g: 9.81})


@pytest.mark.parametrize("name", ["near", "far", "mass", "g", "rate"])
def test_shared_loads_follow_the_parameters(name: str) -> None:
    """The preload that each spring takes, of smallest norm, makes part of the stiffness."""
    model = lever()
    found = sensitivity(model, [name])
    expected = extrapolated(lambda factor: matrices(linearise(changed(model, name, factor)), found))
    own = np.concatenate([each[0].ravel() for each in found.matrices.values()]) * found.values[0]
    assert np.abs(own - expected).max() < 1e-9 * np.abs(matrices(found.linear, found)).max()


def metrics(model: Model) -> list[Metric]:
    passage = Passage(iso_8608("C"), road_contacts(model), 20.0)
    return [
        NaturalFrequency("bounce"),
        DampingRatio("wheel hop"),
        ResponseAmplitude("vertical_acceleration", {"road": 0.01}, 8.0),
        RoadVibration("vertical_acceleration", passage),
    ]


@pytest.mark.parametrize("which", range(4))
def test_metrics(quarter_car: Model, which: int) -> None:
    metric = metrics(quarter_car)[which]
    found = sensitivity(quarter_car)
    derivatives = metric.derivative(found)
    for index in sensible(found)[:: 1 if which < 3 else 5]:
        name = found.parameters[index]
        expected = extrapolated(lambda f, n=name: metric.of(linearise(changed(quarter_car, n, f))))
        scale = abs(metric.of(found.linear))
        assert derivatives[index] * found.values[index] == pytest.approx(expected, rel=1e-6, abs=1e-7 * scale)


def test_tornado_touches_its_derivatives_at_small_changes(quarter_car: Model) -> None:
    small, large = (
        tornado(quarter_car, NaturalFrequency("bounce"), ["sprung", "spring", "tyre"], change)
        for change in (1e-5, 0.25)
    )
    assert [bar.label for bar in large.bars] == ["sprung", "spring", "tyre"]
    for bar in small.bars:
        assert bar.at_more == pytest.approx(bar.predicted_at_more, rel=1e-4)
        assert bar.at_less == pytest.approx(bar.predicted_at_less, rel=1e-4)
    nominal, sprung = large.nominal, large.bars[0]
    assert nominal + sprung.at_less == pytest.approx(
        NaturalFrequency("bounce").of(linearise(quarter_car.scaled("sprung", factor=0.75)))
    )
    groups = {"both": ["sprung", "tyre"], "springs": ["spring"]}
    both = tornado(quarter_car, NaturalFrequency("bounce"), groups, 1e-5).bars
    parts = {bar.label: bar.predicted_at_more for bar in small.bars}
    assert {bar.label for bar in both} == set(groups)
    assert {bar.label: bar.predicted_at_more for bar in both}["both"] == pytest.approx(
        parts["sprung"] + parts["tyre"]
    )


def test_a_mode_that_takes_another_name_is_followed(sedan: Model) -> None:
    """Bounce and pitch of the car share their energy almost evenly: names change places, modes do not."""
    found = tornado(sedan, NaturalFrequency("bounce"), ["body.rear.mass", "body.front.mass", "tyre.front"])
    bars = {bar.label: bar for bar in found.bars}
    for label in ("body.rear.mass", "body.front.mass"):
        assert bars[label].at_more == pytest.approx(bars[label].predicted_at_more, rel=0.3)
        assert bars[label].at_less == pytest.approx(bars[label].predicted_at_less, rel=0.3)
    stiff = linearise(sedan.scaled("tyre.front", factor=1.25))
    named = {mode.name: mode.frequency_hz for mode in damped_modes(stiff)}
    followed = found.nominal + bars["tyre.front"].at_more
    assert min(abs(frequency - followed) for frequency in named.values()) < 1e-9
    assert abs(named["bounce"] - followed) > 0.01


def slider(*, preloaded: bool) -> Model:
    """Give a mass on a spring that stiffens: k s + k3 s^3."""
    mass, k, k3, g = sympy.symbols("mass k k3 g", positive=True)
    mechanism = Mechanism("slider", gravity=g)
    body = mechanism.add_body("body", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=mass)
    foot = TravelPort(mechanism.point("foot", body, (0, 0, 0)), mechanism.ground, "z")
    mechanism.add_force_element("spring", foot, Polynomial((k, 0, k3)), preloaded=preloaded)
    return build_model(mechanism, {mass: 50.0, k: 2e4, k3: 5e7, g: 9.81})


@pytest.mark.parametrize(("preloaded", "load"), [(False, 0.0), (True, -200.0)])
def test_what_preloads_do_not_balance_moves_the_operating_point(preloaded: bool, load: float) -> None:
    """Without preloads a heavier mass sinks; with them the design position stays, and a loaded one moves."""
    model = slider(preloaded=preloaded)
    names = ["mass", "k", "k3", "g"]

    def settled(changed_model: Model) -> OperatingPoint:
        given = {} if not preloaded else changed_model.preloads
        found = find_equilibrium(replace(changed_model, given_preloads=given), loads={"z": load})
        return position(changed_model, {"z": float(found.coordinates[0])}, loads={"z": load})

    found = sensitivity(settled(model), names)
    assert abs(found.linear.operating_point.coordinates[0]) > 1e-3
    for index, name in enumerate(names):
        expected = extrapolated(lambda f, n=name: linearise(settled(changed(model, n, f))).stiffness, 0.004)
        own = found.matrices["stiffness"][index] * found.values[index]
        assert own == pytest.approx(expected, rel=1e-7, abs=1e-7 * found.linear.stiffness[0, 0])


def test_a_lagrangian_s_equilibrium_follows_its_parameters() -> None:
    """A soft spring that a weight holds at rest: w^2 = (k - 2 k2 z) / m where the weight moves z."""
    m, k, k2, g, held = sympy.symbols("m k k2 g held", positive=True)
    q = dynamicsymbols("q")
    lagrangian = m * q.diff() ** 2 / 2 - k * q**2 / 2 - k2 * q**3 / 3 - (m * g - held) * q
    values = {m: 10.0, k: 1e4, k2: 1e5, g: 9.81, held: 98.1}
    model = build_model(from_lagrangian(lagrangian, [q], name="soft spring"), values)
    found = sensitivity(model, ["m", "held"]).matrices["stiffness"]
    # K = k + 2 k2 q and k q + k2 q^2 + m g - held = 0, so that dK/dm = -2 k2 g / k at q = 0
    assert found[:, 0, 0] == pytest.approx([-2 * 1e5 * 9.81 / 1e4, 2 * 1e5 / 1e4], rel=1e-9)


def test_a_position_that_nothing_determines_cannot_follow() -> None:
    mass, g = sympy.symbols("mass g", positive=True)
    mechanism = Mechanism("lift", gravity=g)
    mechanism.add_body("cabin", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=mass)
    model = build_model(mechanism, {mass: 10.0, g: 9.81})
    with pytest.raises(LinearisationError, match="not determined by its forces"):
        sensitivity(position(model, loads={"z": 98.1}), ["mass"])


def test_refusals(quarter_car: Model) -> None:
    with pytest.raises(LinearisationError, match=r"eigenvalue 12345\+0j 1/s is none of 'quarter_car'"):
        sensitivity(quarter_car, ["sprung.mass"]).eigenvalues([12345.0])
    with pytest.raises(TypeError, match="the string 'sprung.mass' received"):
        sensitivity(quarter_car, "sprung.mass")
    with pytest.raises(TypeError, match="sequences of names are needed"):
        tornado(quarter_car, NaturalFrequency("bounce"), "sprung")
    with pytest.raises(LinearisationError, match="is zero: its amplitude has no derivative"):
        still = ResponseAmplitude("vertical_acceleration", {"road": 0.0}, 1.0)
        still.derivative(sensitivity(quarter_car, ["sprung.mass"]))
    with pytest.raises(ParameterError, match="sensitivity: sprung.mas: received an unknown name"):
        sensitivity(quarter_car, ["sprung.mas"])
    with pytest.raises(LinearisationError, match="mode 'bounces' is unknown; the nearest is 'bounce'"):
        NaturalFrequency("bounces").of(linearise(quarter_car))


def test_multiple_and_zero_eigenvalues_have_no_derivatives_of_their_own() -> None:
    found = sensitivity(load_model("torsion_chain"))
    modes = damped_modes(found.linear)
    derivatives = found.eigenvalues([mode.eigenvalue for mode in modes])
    rigid = [mode.eigenvalue == 0 for mode in modes]
    assert np.isnan(derivatives[rigid]).all() and np.isfinite(derivatives[np.invert(rigid)]).all()
