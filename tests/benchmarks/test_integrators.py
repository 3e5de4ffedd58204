"""Integrators on the two tests of the reference car: error, evaluations and time, all in one run."""

import time
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chassym.derivation import Model
from chassym.nonlinear import Harmonic, rig, simulate
from chassym.nonlinear.simulation.held_motion import HeldMotion
from chassym.nonlinear.simulation.right_hand_side import RightHandSide

pytestmark = pytest.mark.benchmark

END_S = 5.0
WANTED = 1e-9
"""Error of the last state (SI units) that every integrator is brought below."""

TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)

Candidate = Callable[[RightHandSide, float], np.ndarray]


def of_scipy(method: str) -> Candidate:
    def integrate(rates: RightHandSide, tolerance: float) -> np.ndarray:
        jacobian = {"jac": rates.jacobian} if method == "LSODA" else {}
        options = {"rtol": tolerance, "atol": 1e-3 * tolerance} | jacobian
        return solve_ivp(rates, (0.0, END_S), np.zeros(24), method, t_eval=[END_S], **options).y[:, -1]

    return integrate


def of_sundials(method: str) -> Candidate:
    cvode = pytest.importorskip("sksundae.cvode")

    def integrate(rates: RightHandSide, tolerance: float) -> np.ndarray:
        def derivatives(time_s: float, state: np.ndarray, found: np.ndarray) -> None:
            found[:] = rates(time_s, state)

        def jacobian(time_s: float, state: np.ndarray, _: np.ndarray, found: np.ndarray) -> None:
            found[:] = rates.jacobian(time_s, state)

        accuracy = {"rtol": tolerance, "atol": 1e-3 * tolerance, "max_num_steps": 10**6}
        solver = cvode.CVODE(derivatives, method=method, jacfn=jacobian, **accuracy)
        return solver.solve(np.array([0.0, END_S]), np.zeros(24)).y[-1]

    return integrate


@pytest.mark.parametrize("name", ["lateral", "vertical"])
def test_events_at_full_order_beside_steps_across_the_knots(
    sedan: Model, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    excitation, times = getattr(rig, name)(), np.array([0.0, END_S])
    exact = simulate(sedan, excitation, times, relative_tolerance=1e-13).states[:, -1]

    def ours(tolerance: float) -> tuple[np.ndarray, int]:
        found = simulate(sedan, excitation, times, relative_tolerance=tolerance)
        return found.states[:, -1], found.evaluations

    runs = {"simulate": ours}
    for method in ("RK45", "DOP853", "LSODA"):
        runs[method] = counted(sedan, excitation, of_scipy(method))
    for method in ("Adams", "BDF"):
        runs[f"CVODE {method}"] = counted(sedan, excitation, of_sundials(method))
    runs["CVODE Adams, events"] = lambda tolerance: with_events(sedan, excitation, tolerance)
    lines, cheapest = [], {}
    for method, run in runs.items():
        for tolerance in TOLERANCES:
            begun = time.process_time()
            state, evaluations = run(tolerance)
            taken, error = time.process_time() - begun, np.abs(state - exact).max()
            figures = f"error {error:.1e}, {evaluations:6d} evaluations, {taken:.2f} s"
            lines.append(f"{method:19} {tolerance:.0e}: {figures}")
            if error < WANTED:
                cheapest[method] = evaluations, taken
                break
        else:
            lines.append(f"{method:19} never below {WANTED:.0e}")
    never = runs.keys() - cheapest.keys()
    own = cheapest.get("simulate", (np.nan, np.nan))
    ratios = [f"{m} {e / own[0]:.1f}, {t / own[1]:.1f}" for m, (e, t) in cheapest.items() if m != "simulate"]
    with capsys.disabled():
        print("", name, *lines, f"evaluations and time over simulate's: {'; '.join(ratios)}", sep="\n  ")
    assert not never
    assert min(cheapest, key=lambda method: cheapest[method][0]) == "simulate"


def with_events(model: Model, excitation: Harmonic, tolerance: float) -> tuple[np.ndarray, int]:
    """Adams' methods with SUNDIALS' own search for roots, on equations held on one side of every knot."""
    cvode, motion = pytest.importorskip("sksundae.cvode"), HeldMotion(model, excitation)

    def derivatives(time_s: float, state: np.ndarray, found: np.ndarray) -> None:
        found[:] = motion(time_s, state)

    def distances(time_s: float, state: np.ndarray, found: np.ndarray) -> None:
        found[:] = motion.distances(time_s, state)

    now = 0.05  # at rest all dampers stand on a knot
    state = simulate(model, excitation, np.array([0.0, now]), relative_tolerance=1e-13).states[:, -1]
    motion.sides[:] = motion.distances(now, state) > 0
    accuracy = {"rtol": tolerance, "atol": 1e-3 * tolerance, "max_num_steps": 10**6}
    events = {"eventsfn": distances, "num_events": len(motion.sides)}
    while now < END_S:
        solver = cvode.CVODE(derivatives, method="Adams", **accuracy, **events)
        found = solver.solve(np.array([now, END_S]), state)
        now, state = found.t[-1], found.y[-1]
        if found.i_events is not None:
            passed = np.flatnonzero(found.i_events[-1])
            motion.sides[passed] = 1 - motion.sides[passed]
    return state, motion.evaluations


def counted(
    model: Model, excitation: Harmonic, integrate: Candidate
) -> Callable[[float], tuple[np.ndarray, int]]:
    def run(tolerance: float) -> tuple[np.ndarray, int]:
        rates = RightHandSide(model, excitation)
        return integrate(rates, tolerance), rates.evaluations

    return run
