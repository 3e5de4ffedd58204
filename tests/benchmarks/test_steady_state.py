"""How fast, on the reference car: compilation, the command line, one steady state; each beside an
alternative, in one run.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, rig, simulate, steady_state

pytestmark = pytest.mark.benchmark

METRICS = [
    f"{name}{kind}"
    for kind, names in {
        "_acceleration": ("longitudinal", "lateral", "vertical"),
        "_rate": ("roll", "pitch", "yaw"),
    }.items()
    for name in names
]


def _median_s(action: Callable[[], object], repeats: int) -> float:
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken))


def _say(capsys: pytest.CaptureFixture[str], *lines: str) -> None:
    with capsys.disabled():
        print("", *lines, sep="\n  ")


@pytest.mark.parametrize(("name", "excitation"), [("lateral", rig.lateral()), ("vertical", rig.vertical())])
def test_one_steady_state_beside_time_integration(
    sedan: Model, capsys: pytest.CaptureFixture[str], name: str, excitation: Harmonic
) -> None:
    found = steady_state(sedan, excitation, metrics=METRICS)
    solved = _median_s(lambda: steady_state(sedan, excitation, metrics=METRICS), 15)
    judged = _median_s(lambda: steady_state(sedan, excitation, metrics=METRICS).is_stable, 15)
    start = time.perf_counter()
    simulate(sedan, excitation, np.linspace(0, 40, 400), relative_tolerance=1e-5)
    waited = time.perf_counter() - start
    _say(
        capsys,
        f"{name}: steady state {solved * 1e3:.0f} ms ({found.harmonics} harmonics), "
        f"with stability {judged * 1e3:.0f} ms; waiting 40 simulated seconds for the transients "
        f"(DOP853, rtol 1e-5) {waited:.1f} s: {waited / solved:.0f} times as long",
    )
    assert waited > 10 * solved


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


def test_right_hand_side_beside_mujoco(sedan: Model, capsys: pytest.CaptureFixture[str]) -> None:
    """Accelerations with every force, against MuJoCo's forward dynamics of a tree of as many hinges without
    any.
    """
    axes = ("1 0 0", "0 1 0", "0 0 1")
    sphere = '<geom type="sphere" size="0.1" contype="0" conaffinity="0"/>'
    bodies = "".join(f'<body pos="0 0 0.3"><joint axis="{axes[i % 3]}"/>{sphere}' for i in range(12))
    tree = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}{'</body>' * 12}</worldbody></mujoco>")
    data = mujoco.MjData(tree)
    count = 1024
    arguments = 0.01 * np.random.default_rng(0).normal(size=(sedan.argument_count, count))
    single, one = sedan.accelerations.single(), arguments[:, 0]
    theirs = _median_s(lambda: [mujoco.mj_forward(tree, data) for _ in range(count)], 15) / count
    ours = _median_s(lambda: [single(one) for _ in range(count)], 15) / count
    batch = _median_s(lambda: sedan.accelerations(arguments), 15) / count
    _say(
        capsys,
        f"accelerations of the car with all forces: {ours * 1e6:.1f} us a call, "
        f"{batch * 1e6:.2f} us a sample in a batch; MuJoCo's mj_forward of 12 hinges in a chain "
        f"{theirs * 1e6:.1f} us a call: {theirs / batch:.0f} times the batch's",
    )
    assert batch < theirs
