"""Gates on the size of the equations: a change that makes them longer fails here."""

import numpy as np
import pytest

from chassym.derivation import Model, derive, load_model, vehicle_names
from chassym.derivation.vehicles.full_car import full_car

GATES = {
    "sedan": {"mass_matrix_and_bias": 1600, "right_hand_side": 3300},
    "rigid_sedan": {"mass_matrix_and_bias": 1150, "right_hand_side": 2500},
    "ride_model": {"mass_matrix_and_bias": 36, "right_hand_side": 280},
    "half_car": {"mass_matrix_and_bias": 80, "right_hand_side": 210},
    "half_car_roll": {"mass_matrix_and_bias": 12, "right_hand_side": 90},
    "quarter_car": {"mass_matrix_and_bias": 4, "right_hand_side": 60},
    "torsion_chain": {"mass_matrix_and_bias": 4, "right_hand_side": 32},
}

SECTION_GATES = {"mass_matrix_and_bias": 280, "right_hand_side": 380}
"""Operations that one more body section adds."""


def test_every_vehicle_has_a_gate() -> None:
    assert set(GATES) == set(vehicle_names())


@pytest.mark.parametrize("name", GATES)
def test_operations(name: str) -> None:
    operations = load_model(name).equations.operations
    for quantity, gate in GATES[name].items():
        assert operations[quantity] <= gate


def test_operations_grow_in_proportion_to_the_body_sections(sedan: Model) -> None:
    """The mass matrix is an arrow, so that every section costs the same, in the factorisation too."""
    numbers = (6, 10, 14)
    found = [derive(full_car(sedan.parameters, n)).operations for n in numbers]
    for quantity, gate in SECTION_GATES.items():
        added = np.diff([operations[quantity] for operations in found]) / np.diff(numbers)
        assert added.max() <= gate
        assert added[1] <= 1.1 * added[0]


def test_derivatives_cost_a_few_times_the_function(sedan: Model) -> None:
    """36 derivatives of the residual for less than seven times its price."""
    equations = sedan.equations
    derivatives = [entry for row in equations.residual_jacobian for entry in row]
    count = equations.program.operations
    assert count(derivatives) < 7 * count(equations.residual)
