"""The built-in vehicles, linearised."""

import pytest

from chassym.derivation import Model
from chassym.linear import LinearModel, linearise


@pytest.fixture(scope="session")
def sedan_linear(sedan: Model) -> LinearModel:
    return linearise(sedan)


@pytest.fixture(scope="session")
def quarter_linear(quarter_car: Model) -> LinearModel:
    return linearise(quarter_car)


@pytest.fixture(scope="session")
def half_linear(half_car: Model) -> LinearModel:
    return linearise(half_car)


@pytest.fixture(scope="session")
def chain_linear(torsion_chain: Model) -> LinearModel:
    return linearise(torsion_chain)
