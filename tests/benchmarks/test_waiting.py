"""A steady state of the reference car beside waiting for it by time integration, in one run.

Who waits is given every advantage: the exact response tells beforehand how long to wait and how finely to
integrate, to read the last period costs nothing, and no error is estimated.
"""

import time
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeVar

import mujoco
import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, rig, simulate, steady_state
from chassym.nonlinear.simulation.right_hand_side import RightHandSide

from ..consistency.test_mujoco import mjcf

Array = np.ndarray
Result = TypeVar("Result")

pytestmark = pytest.mark.benchmark

METRICS = [
    f"{name}{kind}"
    for kind, names in {
        "_acceleration": ("longitudinal", "lateral", "vertical"),
        "_rate": ("roll", "pitch", "yaw"),
    }.items()
    for name in names
]

MOST_PERIODS = 256
STEPS = 2 ** np.arange(5, 14)
"""Steps of a period that are tried."""

TOLERANCES = 10.0 ** -np.arange(3.0, 9.0, 0.5)
"""Those of integrators that choose their steps."""

READ = 1024
"""Instants of the last period that integrators with steps of their own are read at."""

LOOKED = 2**12
"""Places where peaks are looked for, in a period and then beside the best of them."""


def best_s(action: Callable[[], Result], repeats: int) -> tuple[float, Result]:
    """Shortest of several times, after one run to warm up if there are several, and a result."""
    taken = []
    for _ in range(repeats + (repeats > 1)):
        start = time.perf_counter()
        result = action()
        taken.append(time.perf_counter() - start)
    return min(taken[repeats > 1 :]), result


@dataclass(frozen=True, eq=False)
class Wait:
    """The task of one who waits: to be as accurate as that after so many periods from rest."""

    model: Model
    excitation: Harmonic
    tolerance: float

    @cached_property
    def expected(self) -> dict[str, float]:
        found = steady_state(self.model, self.excitation, metrics=METRICS, tolerance=1e-10)
        return {name: metric.value for name, metric in found.peak_to_peak.items()}

    @cached_property
    def periods(self) -> int:
        """The fewest after which transients take no more than half the tolerance of any metric."""
        times = self.excitation.period_s * np.arange(MOST_PERIODS * READ + 1) / READ
        states = simulate(self.model, self.excitation, times, relative_tolerance=1e-2 * self.tolerance).states

        def is_settled(period: int) -> bool:
            return self.error(states[:, period * READ : (period + 1) * READ]) <= self.tolerance / 2

        return bisect_left(range(MOST_PERIODS), True, key=is_settled) + 1

    def error(self, states: Array) -> float:
        """Of peak-to-peak values, the worst, over a period given by its states at equal steps, (2 n, count).

        Between the steps the motion is what its rates and accelerations there make of it.
        """
        if not np.isfinite(states).all():
            return np.inf
        count = states.shape[1]
        place = np.arange(count + 1) / count
        rates = self._arguments(place[:-1], states)[self.model.size : 3 * self.model.size]
        closed, slopes = (np.concatenate([each, each[:, :1]], axis=1) for each in (states, rates))
        motion = CubicHermiteSpline(place, closed, self.excitation.period_s * slopes, axis=1)

        def outputs(places: Array) -> Array:
            return np.asarray(self.model.outputs(self._arguments(places, motion(np.mod(places, 1)))))

        width, extent = 1 / LOOKED, []
        everywhere, beside = np.arange(LOOKED) * width, np.linspace(-width, width, LOOKED)
        found = outputs(everywhere)
        for row in self._rows:
            highest, lowest = everywhere[found[row].argmax()], everywhere[found[row].argmin()]
            extent.append(outputs(highest + beside)[row].max() - outputs(lowest + beside)[row].min())
        return self.worst(np.array(extent))

    def error_at_steps(self, states: Array) -> float:
        """The same of values that are looked at in the steps alone."""
        places = np.arange(states.shape[1]) / states.shape[1]
        return self.worst(np.ptp(self.model.outputs(self._arguments(places, states))[self._rows], axis=1))

    def worst(self, peaks: Array) -> float:
        """Relative error of peak-to-peak values in the order of those expected."""
        return float(np.abs(peaks / list(self.expected.values()) - 1).max())

    @property
    def _rows(self) -> list[int]:
        return [self.model.output_names.index(name) for name in self.expected]

    def _arguments(self, places: Array, states: Array) -> Array:
        """The equations' arguments at places of the period, 0 to 1."""
        turning = self.excitation.vector(self.model)[:, None] * np.exp(2j * np.pi * places)
        inputs = [turning.real, -self.excitation.angular_frequency * turning.imag]
        n = self.model.size
        arguments = np.concatenate([states, np.zeros((n, len(places))), *inputs])
        arguments[2 * n : 3 * n] = self.model.accelerations(arguments)
        return arguments

    @cached_property
    def end_s(self) -> float:
        return self.periods * self.excitation.period_s

    @cached_property
    def read_at(self) -> Array:
        """Instants of the last period, after the first one."""
        last = self.end_s - self.excitation.period_s + self.excitation.period_s * np.arange(READ) / READ
        return np.concatenate([[0.0], last])

    @cached_property
    def runge_kutta(self) -> Callable[[int], Array]:
        """The classical method with so many steps a period in a loop in machine code, as who has the compiled
        right-hand side and numba would write it; the states of the last period.
        """
        numba = pytest.importorskip("numba")
        model, n, periods, period_s = self.model, self.model.size, self.periods, self.excitation.period_s
        evaluate, constants = model.right_hand_side.pointer, model.right_hand_side.constants

        @numba.njit
        def integrate(state: Array, inputs: Array, constants: Array, steps: int) -> Array:
            last, h = np.empty((steps, 2 * n)), period_s / steps
            arguments, rates, total = np.empty(2 * n + inputs.shape[1]), np.empty(2 * n), np.empty(2 * n)
            for step in range(periods * steps):
                place = step % steps
                last[place] = state
                for stage in range(4):
                    node = 0.0 if stage == 0 else h if stage == 3 else h / 2
                    weight = h / 6 if stage in (0, 3) else h / 3
                    half_step = 2 * place + (stage + 1) // 2
                    for i in range(2 * n):
                        arguments[i] = state[i] + node * rates[i] if stage else state[i]
                    for i in range(inputs.shape[1]):
                        arguments[2 * n + i] = inputs[half_step, i]
                    evaluate(arguments.ctypes, constants.ctypes, rates.ctypes)
                    for i in range(2 * n):
                        total[i] = (total[i] if stage else state[i]) + weight * rates[i]
                for i in range(2 * n):
                    state[i] = total[i]
            return last

        def run(steps: int) -> Array:
            turning = np.exp(1j * np.pi / steps * np.arange(2 * steps + 1))[:, None]
            moved = self.excitation.vector(model) * turning
            inputs = np.concatenate([moved.real, -self.excitation.angular_frequency * moved.imag], axis=1)
            return np.asarray(integrate(np.zeros(2 * n), inputs, constants, steps)).T

        run(1)
        return run

    def cvode(self, method: str, tolerance: float) -> Array:
        """SUNDIALS' integrator on the compiled right-hand side, called from Python."""
        module, rates = pytest.importorskip("sksundae.cvode"), RightHandSide(self.model, self.excitation)

        def derivatives(time_s: float, state: Array, found: Array) -> None:
            found[:] = rates(time_s, state)

        def jacobian(time_s: float, state: Array, _: Array, found: Array) -> None:
            found[:] = rates.jacobian(time_s, state)

        accuracy = {"rtol": tolerance, "atol": 1e-3 * tolerance, "max_num_steps": 10**6}
        solver = module.CVODE(derivatives, method=method, jacfn=jacobian, **accuracy)
        return np.asarray(solver.solve(self.read_at, np.zeros(2 * self.model.size)).y[1:].T)

    def simulated(self, tolerance: float) -> Array:
        found = simulate(self.model, self.excitation, self.read_at, relative_tolerance=tolerance)
        return found.states[:, 1:]

    def fewest_steps(self, error: Callable[[Array], float]) -> int | None:
        """Of a period, by the classical Runge-Kutta method; None if none of those tried is enough."""
        enough = (int(steps) for steps in STEPS if error(self.runge_kutta(steps)) <= self.tolerance)
        return next(enough, None)

    def loosest(self, run: Callable[[float], Array]) -> float | None:
        """The largest tolerance that is tried with which an integrator is as accurate."""
        enough = (each for each in TOLERANCES if self.error(run(each)) <= self.tolerance)
        return next(enough, None)

    def mujoco(self, steps: int) -> Callable[[], None]:
        """As many compiled Runge-Kutta steps of the same tree with no more than a linear spring and damper at
        every joint: what tyres, tables, bars and moving pads would take is left out in favour of MuJoCo.
        """
        model = self.model
        engine = mujoco.MjModel.from_xml_string(mjcf(model))
        n, function = model.size, model.residual_jacobian
        slopes = function.matrix(np.zeros(model.argument_count), (n, 3 * n))
        columns = [engine.joint(c.name).dofadr[0] for c in model.system.coordinates]
        engine.jnt_stiffness[columns] = np.diag(slopes[:, :n])
        engine.dof_damping[columns] = np.diag(slopes[:, n : 2 * n])
        engine.opt.gravity[:], engine.opt.timestep = 0.0, self.excitation.period_s / steps
        engine.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        data = mujoco.MjData(engine)
        data.qvel[:] = 0.01

        def run() -> None:
            mujoco.mj_step(engine, data, steps * self.periods)
            assert np.isfinite(data.qpos).all()

        return run


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize(("name", "excitation"), [("lateral", rig.lateral()), ("vertical", rig.vertical())])
def test_one_steady_state_beside_waiting_for_it(
    sedan: Model, capsys: pytest.CaptureFixture[str], name: str, excitation: Harmonic, tolerance: float
) -> None:
    wait = Wait(sedan, excitation, tolerance)

    solved, found = best_s(lambda: steady_state(sedan, excitation, metrics=METRICS, tolerance=tolerance), 30)
    reached = wait.worst(np.array([found.peak_to_peak[name].value for name in wait.expected]))
    judged, _ = best_s(
        lambda: steady_state(sedan, excitation, metrics=METRICS, tolerance=tolerance).is_stable, 15
    )
    lines = [
        f"{name} at {tolerance:g}: steady state {solved * 1e3:.1f} ms ({found.statistics.unknowns} unknowns, "
        f"{found.statistics.iterations} steps, worst error {reached:.0e}), with stability "
        f"{judged * 1e3:.1f} ms; waiting for {wait.periods} periods:",
    ]

    def add(who: str, how: str, action: Callable[[], object], repeats: int) -> float:
        taken, _ = best_s(action, repeats)
        lines.append(f"{who:30} {how:15} {taken * 1e3:7.1f} ms, {taken / solved:5.1f} times")
        return taken

    integrators: dict[str, Callable[[float], Array]] = {
        "simulate": wait.simulated,
        "CVODE Adams": lambda tolerance: wait.cvode("Adams", tolerance),
        "CVODE BDF": lambda tolerance: wait.cvode("BDF", tolerance),
    }
    for who, run in integrators.items():
        loose = wait.loosest(run)
        assert loose is not None
        assert add(who, f"tolerance {loose:.0e}", partial(run, loose), 2) > solved
    for who, error in {"at its steps": wait.error_at_steps, "between its steps": wait.error}.items():
        steps = wait.fewest_steps(error)
        if steps is None:
            lines.append(f"MuJoCo, read {who}: more than {STEPS[-1]} steps a period")
        else:
            assert add(f"MuJoCo, read {who}", f"{steps} steps", wait.mujoco(steps), 3) > solved
    steps = wait.fewest_steps(wait.error)
    assert steps is not None
    add("Runge-Kutta in machine code", f"{steps} steps", lambda: wait.runge_kutta(steps), 5)
    with capsys.disabled():
        print("", *lines, sep="\n  ")
