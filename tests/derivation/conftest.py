"""The built-in vehicles by name, each loaded once for all tests of the derivation."""

from collections.abc import Callable
from functools import cache

import pytest

from chassym.derivation import Model, load_model

SHARED = ("sedan", "quarter_car", "half_car", "torsion_chain")
"""Vehicles that are fixtures for all tests."""


@pytest.fixture(scope="session")
def built_in(request: pytest.FixtureRequest, cache_directory: str) -> Callable[[str], Model]:
    """Give a built-in vehicle by its name."""

    @cache
    def load(name: str) -> Model:
        return request.getfixturevalue(name) if name in SHARED else load_model(name)

    return load
