"""Ways to run the command line, and a small study of the reference car for its tests and its report's."""

import json

import pytest

from chassym.cli import main
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


@pytest.fixture(autouse=True)
def eighty_columns(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture
def run(capsys):
    """Give a way to run the command line: its status, and what it wrote on standard output and error."""

    def call(*words):
        status = main(list(words))
        return status, *capsys.readouterr()

    return call


@pytest.fixture
def refused(run, monkeypatch):
    """Give a way to run the command line with wrong input; nothing slow may start. Returns the message."""

    def slow(*_):
        raise AssertionError("slow work began before the input was found wrong")

    monkeypatch.setattr("chassym.derivation.compilation.numeric.derive", slow)
    monkeypatch.setattr("chassym.derivation.compilation.numeric.CompiledEquations._function", slow)

    def call(*words):
        status, out, err = run(*words)
        assert status == 2
        assert out == ""
        assert err.count("\n") == 1
        assert err.endswith("\n")
        assert err.startswith("chassym: ")
        return err

    return call


@pytest.fixture
def answer(run):
    """Give a way to run a command that answers in JSON, and with nothing else."""

    def call(*words):
        status, out, err = run(*words, "--json")
        assert (status, err) == (0, "")
        return json.loads(out)

    return call
