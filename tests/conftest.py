"""Fixtures for all tests: the built-in vehicles, their own cache of compiled functions, plain evaluation."""

import os
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pytest
import sympy
from threadpoolctl import threadpool_limits

from chassym.derivation import Model, Program, load_model

Lambdified = Callable[..., Callable[..., list]]


@pytest.fixture(scope="session", autouse=True)
def cache_directory(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Keep the tests out of the user's cache of compiled functions; CHASSYM_CACHE_DIR is used if set.

    Workers side by side share one; each keeps linear algebra to one thread.
    """
    own, is_worker = tmp_path_factory.getbasetemp(), "PYTEST_XDIST_WORKER" in os.environ
    with pytest.MonkeyPatch.context() as patch, threadpool_limits(1 if is_worker else None):
        if not os.environ.get("CHASSYM_CACHE_DIR"):
            patch.setenv("CHASSYM_CACHE_DIR", str((own.parent if is_worker else own) / "compiled"))
        yield os.environ["CHASSYM_CACHE_DIR"]


@pytest.fixture(scope="session")
def sedan(cache_directory: str) -> Model:
    """Give the reference sedan, 12 degrees of freedom."""
    return load_model("sedan")


@pytest.fixture(scope="session")
def quarter_car(cache_directory: str) -> Model:
    """Give the quarter car, 2 degrees of freedom, with a damper table."""
    return load_model("quarter_car")


@pytest.fixture(scope="session")
def half_car(cache_directory: str) -> Model:
    """Give the half car in its plane, 4 degrees of freedom."""
    return load_model("half_car")


@pytest.fixture(scope="session")
def torsion_chain(cache_directory: str) -> Model:
    """Give the three body sections on torsion springs, 3 degrees of freedom."""
    return load_model("torsion_chain")


@pytest.fixture(scope="session")
def lambdified() -> Lambdified:
    """Give a way to evaluate expressions of a program without the package's own machine code."""

    def prepare(
        program: Program,
        symbols: Sequence[sympy.Symbol],
        results: Sequence[sympy.Expr],
        modules: str = "numpy",
    ) -> Callable[..., list]:
        """Print the program's assignments, in order, as the source of a Python function of the symbols."""
        assignments = list(program.required(results).items())
        return sympy.lambdify(
            symbols, list(results), modules=modules, cse=lambda given: (assignments, list(given))
        )

    return prepare


@pytest.fixture(scope="session")
def table_force() -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
    """Give a damper table's force: linear between its points and beyond its ends."""

    def force(rate: np.ndarray, velocities: np.ndarray, forces: np.ndarray) -> np.ndarray:
        first = (forces[1] - forces[0]) / (velocities[1] - velocities[0])
        last = (forces[-1] - forces[-2]) / (velocities[-1] - velocities[-2])
        inside = np.interp(rate, velocities, forces)
        return (
            inside + first * np.minimum(rate - velocities[0], 0) + last * np.maximum(rate - velocities[-1], 0)
        )

    return force
