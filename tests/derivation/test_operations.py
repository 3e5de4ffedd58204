"""Gates on the size of the equations: a change that makes them longer fails here."""

import pytest

from chassym.derivation import Model

GATES = {
    "sedan": {"mass_matrix_and_bias": 1600, "right_hand_side": 3300},
    "half_car": {"mass_matrix_and_bias": 80, "right_hand_side": 210},
    "quarter_car": {"mass_matrix_and_bias": 4, "right_hand_side": 60},
    "torsion_chain": {"mass_matrix_and_bias": 4, "right_hand_side": 32},
}


@pytest.mark.parametrize("name", GATES)
def test_operations(name: str, request: pytest.FixtureRequest) -> None:
    model: Model = request.getfixturevalue(name)
    for quantity, gate in GATES[name].items():
        assert model.equations.operations[quantity] <= gate


def test_derivatives_cost_a_few_times_the_function(sedan: Model) -> None:
    """36 derivatives of the residual for less than seven times its price."""
    equations = sedan.equations
    derivatives = [entry for row in equations.residual_jacobian for entry in row]
    count = equations.program.operations
    assert count(derivatives) < 7 * count(equations.residual)
