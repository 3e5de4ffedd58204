"""Static equilibrium at the design position: preloads against statics by hand, for any parameters."""

from collections.abc import Mapping

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    CompiledEquations,
    EquilibriumError,
    Linear,
    Mechanism,
    Model,
    TravelPort,
    load_model,
    prismatic,
    revolute,
    vehicle_names,
)
from chassym.derivation.equilibrium import _least_squares, design_residual, solve_preloads
from chassym.derivation.vehicles.full_car import kinematics_and_compliance_rig

from .variants import scaled_at_random

TOLERANCE = 1e-9  # of the weight


def weight(model: Model) -> float:
    """Sum of all masses times gravity (N); the torsion chain has neither."""
    values = model.values
    flat = {sympy.Symbol(name, real=True): value for name, value in values.items()}
    total = sum(body.mass for body in model.system.bodies) * model.system.gravity
    return float(sympy.sympify(total).subs(flat))


@pytest.mark.parametrize("name", vehicle_names())
def test_built_in_vehicles_rest_at_the_design_position(name: str) -> None:
    model = load_model(name)
    assert np.abs(model.design_residual).max() <= TOLERANCE * weight(model)


@pytest.mark.parametrize("name", vehicle_names())
def test_any_parameters_rest_at_the_design_position(name: str) -> None:
    model = load_model(name)
    for seed in range(10):
        variant = scaled_at_random(model, seed)
        assert np.abs(variant.design_residual).max() <= TOLERANCE * weight(variant)


def test_body_and_wheels_stay_where_they_rest(sedan: Model) -> None:
    """The accelerations at the design position vanish too, up to the rounding of the preloads."""
    accelerations = sedan.accelerations(np.zeros((sedan.argument_count, 1)))
    assert np.abs(accelerations).max() < 1e-9


def patch_forces(model: Model) -> dict[str, float]:
    outputs = dict(
        zip(model.output_names, model.outputs(np.zeros((model.argument_count, 1)))[:, 0], strict=True)
    )
    return {name: value for name, value in outputs.items() if "patch_force" in name}


def statics_by_hand(values: Mapping[str, float]) -> dict[str, float]:
    """Patch forces and spring preloads of the car from moments about the axles and about the arms' pivots."""
    g = values["gravity"]
    parts = [
        (values[f"body.{s}.mass"], values[f"body.{s}.mass_centre.x"]) for s in ("front", "middle", "rear")
    ]
    axles = {axle: values[f"axle.{axle}.x"] for axle in ("front", "rear")}
    parts += [(2 * values[f"suspension.{axle}.unsprung.mass"], x) for axle, x in axles.items()]
    wheelbase = axles["rear"] - axles["front"]
    rear = sum(m * g * (x - axles["front"]) for m, x in parts) / wheelbase
    on_axle = {"front": sum(m * g for m, _ in parts) - rear, "rear": rear}
    found = {}
    for axle, load in on_axle.items():
        place = f"suspension.{axle}"
        y = {p: values[f"{place}.{p}.y"] for p in ("arm_pivot", "wheel_centre", "contact_patch")}
        lever = (y["contact_patch"] - y["arm_pivot"]) / (y["wheel_centre"] - y["arm_pivot"])
        found[f"{axle} patch"] = load / 2
        found[f"{axle} spring"] = load / 2 * lever - values[f"{place}.unsprung.mass"] * g
    return found


@pytest.mark.parametrize("seed", [None, 0, 1])
def test_preloads_of_the_car_by_hand(sedan: Model, seed: int | None) -> None:
    model = sedan if seed is None else scaled_at_random(sedan, seed)
    expected = statics_by_hand(model.values)
    for axle in ("front", "rear"):
        for side in ("left", "right"):
            corner = f"{axle}_{side}"
            assert model.preloads[f"{corner}_spring.preload"] == pytest.approx(
                expected[f"{axle} spring"], rel=1e-10
            )
            assert patch_forces(model)[f"{corner}_patch_force_z"] == pytest.approx(
                expected[f"{axle} patch"], rel=1e-10
            )


@pytest.mark.parametrize("name", ["sedan", "half_car", "quarter_car"])
def test_patches_carry_the_weight(name: str) -> None:
    model = load_model(name)
    vertical = [force for output, force in patch_forces(model).items() if output.endswith("_z")]
    assert sum(vertical) == pytest.approx(weight(model), rel=1e-12)


def test_given_preloads_are_used(quarter_car: Model) -> None:
    """Without preloads nothing carries the weights: the residual is the weights themselves."""
    loose = Model(quarter_car.parameters, quarter_car.compiled, dict.fromkeys(quarter_car.preloads, 0.0))
    value = loose.parameters.flat()
    expected = [value["gravity"] * value[f"{part}.mass"] for part in ("sprung", "unsprung")]
    assert loose.design_residual == pytest.approx(expected)


def test_suspension_on_a_body_held_to_the_ground(sedan: Model) -> None:
    """The ground carries the body: every wheel's weight is balanced at its own spring and patch."""
    compiled = CompiledEquations(kinematics_and_compliance_rig(sedan.parameters))
    values = sedan.parameters.flat()
    preloads = solve_preloads(compiled, values, 1)
    left = design_residual(compiled, values | preloads, 1)
    assert np.abs(left).max() <= TOLERANCE * values["gravity"] * values["suspension.front.unsprung.mass"]
    for corner in ("front_left", "rear_right"):
        own_weight = values["gravity"] * values[f"suspension.{corner.split('_')[0]}.unsprung.mass"]
        held = preloads[f"{corner}_spring.preload"] + preloads[f"{corner}_tyre_z.preload"]
        assert held == pytest.approx(-own_weight, rel=1e-9)


def oscillator(*, preloaded: bool, sideways: bool = False) -> Mechanism:
    """Make a mass on a vertical slider with a spring, and if asked for a pendulum held out sideways."""
    mechanism = Mechanism("oscillator", sympy.Symbol("g", real=True))
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("height", "z"), (0, 0, 0), mass=2.0)
    if sideways:
        out = revolute("swing", "y")
        mechanism.add_body("pendulum", mechanism.ground, out, (0, 0, 0), mass=1.0, mass_centre=(0.5, 0, 0))
    foot = TravelPort(mechanism.point("foot", mass, (0, 0, 0)), mechanism.ground, "z")
    mechanism.add_force_element("spring", foot, Linear(sympy.Integer(100)), preloaded=preloaded)
    return mechanism


def test_a_preload_is_the_force_at_zero_deflection() -> None:
    assert solve_preloads(CompiledEquations(oscillator(preloaded=True)), {"g": 9.81}, 1) == {
        "spring.preload": pytest.approx(-2.0 * 9.81)
    }


def test_a_load_that_no_preload_carries_is_refused_by_its_coordinate() -> None:
    compiled = CompiledEquations(oscillator(preloaded=True, sideways=True))
    with pytest.raises(EquilibriumError, match="'oscillator'.*'swing'") as caught:
        solve_preloads(compiled, {"g": 9.81}, 1)
    assert "\n" not in str(caught.value)


def test_without_gravity_there_is_nothing_to_carry() -> None:
    compiled = CompiledEquations(oscillator(preloaded=True, sideways=True))
    assert solve_preloads(compiled, {"g": 0.0}, 1) == {"spring.preload": 0.0}


def test_loads_are_shared_evenly() -> None:
    """Of two springs under one mass each carries half."""
    mechanism = oscillator(preloaded=True)
    foot = TravelPort(mechanism.point("second", mechanism.bodies[0], (0, 0, 0)), mechanism.ground, "z")
    mechanism.add_force_element("second_spring", foot, Linear(sympy.Integer(900)), preloaded=True)
    preloads = solve_preloads(CompiledEquations(mechanism), {"g": 9.81}, 1)
    assert list(preloads.values()) == pytest.approx([-9.81, -9.81])


def test_least_squares_of_many_sets() -> None:
    """Whether they resemble the first one or not, have full rank or not."""
    generator = np.random.default_rng(0)
    matrices = generator.normal(size=(1, 6, 4)) + 0.1 * generator.normal(size=(8, 6, 4))
    matrices[3] = generator.normal(size=(6, 4))
    matrices[4, :, 1] = 2 * matrices[4, :, 0]
    matrices[5, :, 1] = (1 + 1e-7) * matrices[5, :, 0]
    right = (matrices @ generator.normal(size=(8, 4, 1)))[:, :, 0]
    for order in (np.arange(8), np.arange(8)[::-1], np.roll(np.arange(8), 4)):
        found = _least_squares(matrices[order], right[order])
        for row, index in zip(found, order, strict=True):
            expected = np.linalg.lstsq(matrices[index], right[index], rcond=1e-12)[0]
            assert row == pytest.approx(expected, rel=1e-6 if index == 5 else 1e-11)
    wide = generator.normal(size=(3, 2, 4))
    found = _least_squares(wide, right[:3, :2])
    for row, matrix, load in zip(found, wide, right[:3, :2], strict=True):
        assert row == pytest.approx(np.linalg.lstsq(matrix, load)[0], rel=1e-11)


def test_forces_beyond_all_numbers_are_refused(sedan: Model) -> None:
    heavy = sedan.with_parameters({"body.front.mass": 1e308})
    with pytest.raises(EquilibriumError, match="not finite; a parameter is too large"):
        _ = heavy.preloads
