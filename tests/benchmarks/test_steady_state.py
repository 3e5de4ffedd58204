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
from typing import TypeVar

import mujoco
import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, SteadyState, rig, simulate, steady_state
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.simulation.right_hand_side import RightHandSide
from chassym.nonlinear.steady.integrated_orbit import integrated_orbit

from ..consistency.test_mujoco import mjcf

Result = TypeVar("Result")

pytestmark = pytest.mark.benchmark

MOST_STEPS = 8192
"""Steps of a period beyond which the Runge-Kutta method is not tried."""

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


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize(("name", "excitation"), [("lateral", rig.lateral()), ("vertical", rig.vertical())])
def test_one_steady_state_beside_time_integration(
    sedan: Model, capsys: pytest.CaptureFixture[str], name: str, excitation: Harmonic, tolerance: float
) -> None:
    """Waiting from rest until the transients are as small as the tolerance: by `simulate`, and by MuJoCo's
    compiled Runge-Kutta steps of the same tree without most of the forces, which is less than the test takes.
    """
    solved, found = _best_s(lambda: steady_state(sedan, excitation, metrics=METRICS, tolerance=tolerance), 30)
    judged, _ = _best_s(
        lambda: steady_state(sedan, excitation, metrics=METRICS, tolerance=tolerance).is_stable, 15
    )
    exact = steady_state(sedan, excitation, metrics=METRICS, tolerance=1e-10)
    periods = _periods_until(sedan, exact.orbit, tolerance)
    until = np.array([0.0, periods * excitation.period_s])
    simulated, _ = _best_s(
        lambda: simulate(sedan, excitation, until, relative_tolerance=tolerance), 1 if tolerance < 1e-4 else 2
    )
    lines = [
        f"{name} at {tolerance:g}: steady state {solved * 1e3:.1f} ms ({found.statistics.unknowns} unknowns, "
        f"{found.statistics.iterations} steps), with stability {judged * 1e3:.1f} ms;",
        f"transients die out in {periods} periods: simulate {simulated:.2f} s "
        f"({simulated / solved:.0f} times)",
    ]
    for what, error in (("its states", _state_error), ("metrics read at its steps", _metric_error)):
        steps = _runge_kutta_steps(sedan, exact, error, tolerance)
        if steps is None:
            lines.append(f"MuJoCo, until {what} are as accurate: more than {MOST_STEPS} steps a period")
            continue
        stepped, _ = _best_s(_mujoco_steps(sedan, excitation.period_s / steps, steps * periods), 3)
        lines.append(
            f"MuJoCo, until {what} are as accurate: {steps} steps a period, {stepped:.2f} s "
            f"({stepped / solved:.0f} times)"
        )
        assert stepped > solved
    _say(capsys, *lines)
    assert simulated > 10 * solved


def _best_s(action: Callable[[], Result], repeats: int) -> tuple[float, Result]:
    """Shortest of several times, after one run to warm up if there are several, and a result."""
    taken = []
    for _ in range(repeats + (repeats > 1)):
        start = time.perf_counter()
        result = action()
        taken.append(time.perf_counter() - start)
    return min(taken[repeats > 1 :]), result


def _relative(model: Model, orbit: PeriodicOrbit, states: np.ndarray) -> np.ndarray:
    """Largest difference of a rate from the orbit's at phase zero, relative to the rates."""
    n = model.size
    rates = orbit.motion_at(np.linspace(0, 2 * np.pi, 200))[n:]
    return np.abs(states.T - orbit.state()).T[n:].max(axis=0) / np.abs(rates).max()


def _periods_until(model: Model, orbit: PeriodicOrbit, tolerance: float) -> int:
    """Periods after which motion from rest is on the orbit, as accurately as that."""
    times = orbit.period_s * np.arange(221)
    states = simulate(model, orbit.excitation, times, relative_tolerance=tolerance / 10).states
    away = np.flatnonzero(_relative(model, orbit, states) > tolerance)
    assert away[-1] < 220
    return int(away[-1]) + 1


def _runge_kutta_steps(
    model: Model,
    exact: SteadyState,
    error: Callable[[Model, SteadyState, np.ndarray], float],
    tolerance: float,
) -> int | None:
    """Steps of a period with which the classical Runge-Kutta method, that MuJoCo takes, has a steady state of
    its own as near as that: with all forces, knots within steps. None if none of those tried is enough.
    """
    start = exact.orbit.state()
    fed_back = np.eye(len(start)) - integrated_orbit(model, exact.orbit.excitation, start, 1e-9).monodromy
    for steps in 2 ** np.arange(5, int(np.log2(MOST_STEPS)) + 1):
        gap = _runge_kutta_period(model, exact.orbit, start, steps)[-1] - start
        off = start + np.linalg.solve(fed_back, np.nan_to_num(gap, nan=np.inf))
        if error(model, exact, _runge_kutta_period(model, exact.orbit, off, steps)) <= tolerance:
            return int(steps)
    return None


def _state_error(model: Model, exact: SteadyState, states: np.ndarray) -> float:
    return float(_relative(model, exact.orbit, states[:1].T)[0])


def _metric_error(model: Model, exact: SteadyState, states: np.ndarray) -> float:
    """Of peak-to-peak values over the steps, the worst relative one."""
    phases = 2 * np.pi / (len(states) - 1) * np.arange(len(states) - 1)
    arguments = exact.orbit.with_accelerations(states[:-1].T, exact.orbit.inputs_at(phases))
    peaks = dict(zip(model.output_names, np.ptp(model.outputs(arguments), axis=1), strict=True))
    return max(abs(peaks[name] / metric.value - 1) for name, metric in exact.peak_to_peak.items())


def _runge_kutta_period(model: Model, orbit: PeriodicOrbit, state: np.ndarray, steps: int) -> np.ndarray:
    """The states at all steps of a period, both ends included, shape (steps + 1, 2 n)."""
    rates, step = RightHandSide(model, orbit.excitation), orbit.period_s / steps
    found = [state]
    for time_s in step * np.arange(steps):
        first = rates(time_s, state)
        second = rates(time_s + step / 2, state + step / 2 * first)
        third = rates(time_s + step / 2, state + step / 2 * second)
        last = rates(time_s + step, state + step * third)
        state = state + step / 6 * (first + 2 * second + 2 * third + last)
        found.append(state)
    return np.array(found)


def _mujoco_steps(model: Model, step_s: float, steps: int) -> Callable[[], None]:
    """Compiled steps of the same tree with no more than a linear spring and damper at every joint: what
    tyres, tables, bars and moving pads would take is left out in favour of MuJoCo.
    """
    engine = mujoco.MjModel.from_xml_string(mjcf(model))
    n, function = model.size, model.residual_jacobian
    slopes = function.matrix(np.zeros(model.argument_count), (n, 3 * n))
    columns = [engine.joint(c.name).dofadr[0] for c in model.system.coordinates]
    engine.jnt_stiffness[columns] = np.diag(slopes[:, :n])
    engine.dof_damping[columns] = np.diag(slopes[:, n : 2 * n])
    engine.opt.gravity[:], engine.opt.timestep = 0.0, step_s
    engine.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(engine)
    data.qvel[:] = 0.01

    def run() -> None:
        mujoco.mj_step(engine, data, steps)
        assert np.isfinite(data.qpos).all()

    return run


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
