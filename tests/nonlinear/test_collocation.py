"""Collocation in pieces: orders of convergence, Newton's method, and deviations against closed forms."""

import numpy as np
import pytest

from chassym.derivation import (
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    build_model,
    prismatic,
)
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, simulate, steady_state
from chassym.nonlinear.collocation.collocation import Linearisation, in_pieces
from chassym.nonlinear.collocation.floquet import monodromy, multipliers
from chassym.nonlinear.collocation.mesh import FULL_TURN
from chassym.nonlinear.harmonics.harmonic_balance import at_rest, newton
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

from .duffing import Duffing
from .oscillator import oscillator

SMOOTH = Duffing(damping=0.3, stiffness=1.0, cubic=0.5, force=0.6)
FREQUENCY = 0.8


def solved(points: int, pieces: int) -> PiecewiseOrbit:
    """The smooth oscillator's orbit on a fixed mesh."""
    guess = newton(at_rest(SMOOTH.model(), SMOOTH.excitation(FREQUENCY), 5), 1e-3).orbit
    found = in_pieces(guess, np.linspace(0, FULL_TURN, pieces + 1), points)
    for _ in range(6):
        found = Linearisation(found).corrected()
    return found


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    """The orbit's state at time zero, by shooting."""
    return SMOOTH.shot(solved(8, 12).state(), FREQUENCY)[0]


@pytest.mark.parametrize(("points", "counts"), [(1, (32, 64, 128)), (2, (16, 32, 64)), (3, (8, 16, 32))])
def test_boundaries_are_superconvergent(exact: np.ndarray, points: int, counts: tuple[int, ...]) -> None:
    """Gauss collocation with p points has order 2 p at the boundaries, if all is smooth."""
    errors = [np.abs(solved(points, count).starts[0] - exact).max() for count in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-2 * points, abs=0.3)


def test_more_points_converge_faster_than_any_power(exact: np.ndarray) -> None:
    errors = [np.abs(solved(points, 6).starts[0] - exact).max() for points in (2, 3, 4, 5, 6, 7)]
    ratios = np.array(errors[1:5]) / errors[:4]
    assert ratios.max() < 0.2
    assert errors[-1] < 1e-9


def test_newton_converges_quadratically() -> None:
    guess = newton(at_rest(SMOOTH.model(), SMOOTH.excitation(FREQUENCY), 1), 1e-3).orbit
    found, moves = in_pieces(guess, np.linspace(0, FULL_TURN, 13), 5), []
    for _ in range(4):
        better = Linearisation(found).corrected()
        moves.append(np.abs(better.starts - found.starts).max())
        found = better
    assert moves[1] < 5 * moves[0] ** 2 and moves[2] < 5 * moves[1] ** 2


def test_a_corrected_orbit_is_continuous_and_moves_as_the_equations_ask() -> None:
    found = solved(5, 9)
    residual = found.model.residual(found.arguments_at(found.boundaries[:-1] + 0.1))
    assert np.abs(residual).max() < 1e-9
    before, after = found.motion_at(found.boundaries[1:-1] - 1e-12), found.motion_at(found.boundaries[1:-1])
    assert before == pytest.approx(after, abs=1e-10)
    assert found.motion_at(np.array([FULL_TURN - 1e-12])) == pytest.approx(
        found.motion_at(np.zeros(1)), abs=1e-10
    )


@pytest.mark.parametrize("together", [1, 10, 80_000])
def test_pieces_solved_apart_or_together_are_the_same(together: int, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = Linearisation(solved(4, 7))
    monkeypatch.setattr("chassym.nonlinear.collocation.collocation._TOGETHER", together)
    found = Linearisation(solved(4, 7))
    assert found.monodromy == pytest.approx(expected.monodromy, abs=1e-14)


@pytest.mark.parametrize("frequency_hz", [0.4, 2.5, 11.0])
def test_multipliers_of_a_linear_system_are_exponentials(frequency_hz: float) -> None:
    found = steady_state(
        oscillator(), Harmonic(frequency_hz, {"road": 0.01}), metrics=["displacement"], tolerance=1e-9
    )
    expected = np.exp(np.roots([2.0, 6.0, 800.0]) / frequency_hz)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(expected), abs=1e-10)
    assert found.is_stable


def test_multipliers_of_a_smooth_nonlinear_system_are_those_of_shooting(exact: np.ndarray) -> None:
    """The variational equation is one of Hill's."""
    _, expected = SMOOTH.shot(exact, FREQUENCY)
    found = steady_state(
        SMOOTH.model(), SMOOTH.excitation(FREQUENCY), metrics=["displacement"], tolerance=1e-9
    )
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(expected), abs=1e-9)


def test_multipliers_obey_liouvilles_formula() -> None:
    """Their product is the exponential of the mean trace: exp(-c T)."""
    found = steady_state(
        SMOOTH.model(), SMOOTH.excitation(FREQUENCY), metrics=["displacement"], tolerance=1e-9
    )
    expected = np.exp(-SMOOTH.damping * 2 * np.pi / FREQUENCY)
    assert np.prod(found.multipliers) == pytest.approx(expected, rel=1e-10)


def test_deviations_across_knots_move_as_the_monodromy_matrix_says(quarter_car: Model) -> None:
    """Central differences of integrated motions beside an orbit that passes knots of the damper's table."""
    excitation = Harmonic(2.0, {"road": 0.02})
    orbit = steady_state(quarter_car, excitation, tolerance=1e-10).orbit
    assert isinstance(orbit, PiecewiseOrbit)
    start_s = orbit.boundaries[0] / excitation.angular_frequency
    times, columns = start_s + np.array([0.0, excitation.period_s]), []
    for direction in 1e-6 * np.eye(4):
        ends = [
            simulate(
                quarter_car,
                excitation,
                times,
                start=orbit.starts[0] + sign * direction,
                relative_tolerance=1e-12,
            ).states[:, -1]
            for sign in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / 2e-6)
    assert monodromy(orbit) == pytest.approx(np.stack(columns, axis=1), abs=1e-5)


def test_long_undamped_tests_are_stable_numerically() -> None:
    """Hundreds of turns of an undamped motion: its multipliers stay on the unit circle."""
    found = steady_state(
        oscillator(damping=0.0), Harmonic(0.0131, {"road": 0.01}), metrics=["displacement"], tolerance=1e-4
    )
    assert np.abs(found.multipliers) == pytest.approx(1.0, abs=1e-6)


def test_a_body_that_nothing_holds_is_named() -> None:
    mechanism = Mechanism("drifting", gravity=0)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1.0)
    port = JointPort(mechanism.coordinate("z")).less(mechanism.add_input("road", "m"))
    mechanism.add_force_element("damper", port, Linear(0, 2.0))
    mechanism.add_output(
        PointAcceleration("acceleration", mechanism.point("p", mass, (0, 0, 0)), "z", mechanism.ground)
    )
    with pytest.raises(NoPeriodicOrbitError, match="give it some stiffness"):
        steady_state(build_model(mechanism, {}), Harmonic(1.0, {"road": 0.1}))


def test_a_start_may_be_cut_anywhere(exact: np.ndarray) -> None:
    """Multipliers and states do not depend on where the first boundary is."""
    first = solved(8, 12)
    moved = in_pieces(first, first.boundaries + 0.2, 8)
    for _ in range(3):
        moved = Linearisation(moved).corrected()
    assert moved.state() == pytest.approx(exact, abs=1e-9)
    assert np.sort_complex(multipliers(moved)) == pytest.approx(np.sort_complex(multipliers(first)), abs=1e-9)
