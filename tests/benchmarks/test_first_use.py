"""How long a first call of the command line takes on the reference car, with compilation, and a later one."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import pytest

pytestmark = pytest.mark.benchmark


def _median_s(action: Callable[[], object], repeats: int) -> float:
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        taken.append(time.perf_counter() - start)
    return median(taken)


def _say(capsys: pytest.CaptureFixture[str], *lines: str) -> None:
    with capsys.disabled():
        print("", *lines, sep="\n  ")


def test_first_compilation_and_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    environment = os.environ | {"CHASSYM_CACHE_DIR": str(tmp_path)}
    program = "import sys; from chassym.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", program, "test", "lateral", "--json"]

    def run() -> None:
        done = subprocess.run(command, env=environment, check=True, capture_output=True)
        assert json.loads(done.stdout)["converged"]

    cold = _median_s(run, 1)
    warm = _median_s(run, 3)
    bare = _median_s(
        lambda: subprocess.run([sys.executable, "-c", "import sympy, scipy.linalg"], check=True), 3
    )
    _say(
        capsys,
        f"chassym test lateral: {cold:.1f} s with derivation and compilation, {warm:.1f} s from the cache;",
        f"importing sympy and scipy.linalg alone takes {bare:.1f} s",
    )
    assert warm < cold
