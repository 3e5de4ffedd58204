"""A small study of the reference car, shared by the tests of the study and of its report."""

import pytest

from chassym.derivation import Model
from chassym.study import StudyPlan, StudyResults, run_study

SMALL = StudyPlan(stiffnesses=(1e4, 1e6, 1e8), heave_frequencies_hz=(1.0, 9.0, 9.5))


@pytest.fixture(scope="session")
def announced() -> list[tuple[str, float]]:
    """Give what the small study announced."""
    return []


@pytest.fixture(scope="session")
def small_study(sedan: Model, announced: list[tuple[str, float]]) -> StudyResults:
    """Give a study of the sedan with three stiffnesses and three frequencies."""
    return run_study(sedan, lambda what, fraction: announced.append((what, fraction)), plan=SMALL)
