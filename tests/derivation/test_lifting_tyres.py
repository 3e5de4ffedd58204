"""Tyres that push but do not pull: the same car as long as they push, no force beyond."""

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    ContactForce,
    Linear,
    Mechanism,
    MechanismError,
    TravelPort,
    Unilateral,
    UserOutput,
    build_model,
    load_model,
    prismatic,
    with_lifting_tyres,
)


@pytest.mark.parametrize("vehicle", ["sedan", "half_car", "quarter_car", "ride_model"])
def test_while_all_tyres_push_nothing_differs(vehicle: str) -> None:
    bonded = load_model(vehicle)
    lifting = with_lifting_tyres(bonded)
    assert lifting.preloads == pytest.approx(bonded.preloads)
    arguments = 1e-4 * np.random.default_rng(0).normal(size=(bonded.argument_count, 8))
    np.testing.assert_allclose(lifting.residual(arguments), bonded.residual(arguments), rtol=0, atol=1e-8)
    np.testing.assert_allclose(lifting.outputs(arguments), bonded.outputs(arguments), rtol=0, atol=1e-8)


def test_a_tyre_in_the_air_carries_nothing() -> None:
    car = with_lifting_tyres(load_model("quarter_car"))
    raised = np.zeros((car.argument_count, 1))
    raised[:2] = 0.5
    assert car.outputs(raised)[car.output_names.index("patch_force_z"), 0] == 0.0


def mass_on_a_foot() -> Mechanism:
    """A mass on a spring, with the foot's force among its outputs by itself and doubled."""
    mechanism = Mechanism("hopper", gravity=9.81)
    body = mechanism.add_body("body", mechanism.ground, prismatic("height", "z"), (0, 0, 0), mass=2.0)
    foot = TravelPort(mechanism.point("foot", body, (0, 0, 0)), mechanism.ground, "z")
    element = mechanism.add_force_element("leg", foot, Linear(sympy.Integer(500)), preloaded=True)
    force, symbol = ContactForce("patch_force_z", element), sympy.Symbol("force", real=True)
    mechanism.add_output(force)
    mechanism.add_output(UserOutput("double", "N", 2 * symbol, {symbol: force}))
    return mechanism


def test_outputs_speak_of_the_new_elements() -> None:
    model = with_lifting_tyres(build_model(mass_on_a_foot(), {}))
    (element,) = model.system.elements
    assert isinstance(element.characteristic, Unilateral)
    force, double = model.system.outputs
    assert force.element is element
    assert next(iter(double.quantities.values())).element is element
    raised = np.zeros((model.argument_count, 2))
    raised[0] = [-0.01, 0.5]
    np.testing.assert_allclose(model.outputs(raised)[1], [2 * (2.0 * 9.81 + 5.0), 0.0])


def test_a_mechanism_without_tyres_is_refused() -> None:
    with pytest.raises(MechanismError, match="'torsion_chain' has no tyre to lift"):
        with_lifting_tyres(load_model("torsion_chain"))


def test_an_unknown_element_is_refused_by_name() -> None:
    with pytest.raises(MechanismError, match="element 'tail': hopper has leg"):
        mass_on_a_foot().with_characteristics({"tail": Linear(1.0)})
