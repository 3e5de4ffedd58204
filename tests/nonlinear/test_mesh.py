"""Meshes of an orbit: knots found where a known motion passes them, pieces no longer than wanted."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chassym.derivation import Model, load_model
from chassym.nonlinear import ExcitationError, FourierOrbit, Harmonic, rig, steady_state
from chassym.nonlinear.collocation.collocation import Linearisation, in_pieces
from chassym.nonlinear.collocation.mesh import FULL_TURN, MOST_PIECES, cut, fastest_rate, first_boundaries
from chassym.nonlinear.harmonics.fourier import coefficients
from chassym.nonlinear.orbits.gauss_points import gauss_points
from chassym.nonlinear.orbits.knots import knot_phases
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit


def waving(car: Model, pieces: int, points: int, start: float = 0.3) -> PiecewiseOrbit:
    """The wheel alone moves as a cosine, its velocity -0.4 m/s sin(phase); the damper's knots are at 0, -0.15
    and 0.1 m/s.
    """
    excitation = Harmonic(2.0, {})
    boundaries = np.linspace(start, start + FULL_TURN, pieces + 1)
    phases = boundaries[:-1, None] + FULL_TURN / pieces * gauss_points(points).places.values
    starts, accelerations = np.zeros((pieces, 4)), np.zeros((pieces, points, 2))
    starts[:, 1] = 0.4 / excitation.angular_frequency * np.cos(boundaries[:-1])
    starts[:, 3] = -0.4 * np.sin(boundaries[:-1])
    accelerations[:, :, 1] = -0.4 * excitation.angular_frequency * np.cos(phases)
    return PiecewiseOrbit(car, excitation, boundaries, starts, accelerations)


def test_knots_are_found_where_the_motion_passes_them(quarter_car: Model) -> None:
    first = np.arcsin([-0.1 / 0.4, 0.0, 0.15 / 0.4])
    expected = np.sort(np.mod(np.concatenate([first, np.pi - first]), FULL_TURN))
    found = knot_phases(waving(quarter_car, 12, 8))
    beside = np.abs(np.exp(1j * found) - np.exp(1j * expected[:, None])).min(axis=1)
    assert len(found) == 6
    assert beside.max() < 1e-6


def test_passings_are_found_to_a_high_order(quarter_car: Model) -> None:
    """Inverse interpolation leaves the square of the spacing, a secant step more than its third power."""
    expected = np.arcsin(0.15 / 0.4)
    errors = []
    for pieces in (3, 6, 12):
        found = knot_phases(waving(quarter_car, pieces, 16))
        errors.append(np.abs(found - expected).min())
    assert errors[-1] < 1e-8 + errors[0] / 30


@pytest.fixture(scope="module")
def orbit(quarter_car: Model) -> PiecewiseOrbit:
    found = steady_state(quarter_car, Harmonic(2.0, {"road": 0.03}), tolerance=1e-10).orbit
    assert isinstance(found, PiecewiseOrbit)
    return found


def test_an_error_of_a_knot_moves_the_orbit_by_its_square(orbit: PiecewiseOrbit) -> None:
    knots = knot_phases(orbit)
    is_knot = np.abs(np.mod(orbit.boundaries[:-1], FULL_TURN)[:, None] - knots).min(axis=1) < 1e-6
    assert is_knot.sum() == len(knots) > 2
    phases = np.linspace(0, FULL_TURN, 7)
    motions, moves = [], np.array([0.0, 2e-3, 1e-3, 5e-4])
    for move in moves:
        found = in_pieces(orbit, orbit.boundaries + move * np.append(is_knot, is_knot[0]), 8)
        for _ in range(5):
            found = Linearisation(found).corrected()
        motions.append(found.motion_at(phases))
    exact, moves = motions[0], moves[1:]
    errors = [np.abs(motion - exact).max() for motion in motions[1:]]
    slope = np.polyfit(np.log(moves), np.log(errors), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.25)
    assert errors[0] < 0.1 * moves[0] * np.abs(exact).max()


def test_a_settled_mesh_has_its_boundaries_on_the_knots(orbit: PiecewiseOrbit) -> None:
    distances = orbit.model.knot_distances(orbit.arguments_at(orbit.boundaries[:-1]))
    knots = knot_phases(orbit)
    assert len(knots) > 2
    for knot in knots:
        assert np.abs(np.mod(orbit.boundaries, FULL_TURN) - knot).min() < 1e-7
    assert np.sort(np.abs(distances).min(axis=0))[len(knots) - 1] < 1e-6


def test_a_series_passes_knots_where_its_pieces_do(sedan: Model) -> None:
    """Between samples they are interpolated: an error of the square of the spacing."""
    exact = steady_state(sedan, rig.vertical(), tolerance=1e-7).orbit
    motion = exact.motion_at(FULL_TURN / 4096 * np.arange(4096))[: sedan.size]
    series = FourierOrbit(sedan, exact.excitation, coefficients(motion, 512))
    passed = knot_phases(series)
    assert len(passed) > 20
    distance = np.abs(np.exp(1j * passed)[:, None] - np.exp(1j * exact.boundaries)).min(axis=1)
    assert distance.max() < (FULL_TURN / 512) ** 2


def test_a_knot_that_is_passed_where_two_pieces_meet_is_found(quarter_car: Model) -> None:
    """The damper's knot at rest lies between the rates with which one piece ends and the next begins."""
    orbit = waving(quarter_car, 12, 8, start=0.0)
    away = 1e-9 * np.where(np.arange(12) < 6, -1.0, 1.0)
    found = knot_phases(replace(orbit, starts=orbit.starts + np.outer(away, [0, 0, 0, 1])))
    assert len(found) == 6
    for meeting in (0.0, np.pi):
        assert np.abs(np.exp(1j * found) - np.exp(1j * meeting)).min() < 1e-12


def test_passings_at_the_same_instant_are_one(quarter_car: Model) -> None:
    twin = quarter_car.with_parameters({"damper.velocity": [-1.0, -0.15, 0.0, 1e-9, 1.0]})
    assert len(knot_phases(waving(twin, 12, 8))) == 4


@settings(max_examples=200, deadline=None)
@given(
    knots=st.lists(st.floats(0, 6.28), max_size=8, unique=True),
    lengths=st.lists(st.floats(0.05, 1.0), min_size=1, max_size=12),
    start=st.floats(-3, 9),
    data=st.data(),
)
def test_a_cut_keeps_knots_and_grows_no_piece_much(
    knots: list[float], lengths: list[float], start: float, data: st.DataObject
) -> None:
    boundaries = start + FULL_TURN * np.concatenate([[0.0], np.cumsum(lengths)]) / np.sum(lengths)
    wanted = np.array(
        data.draw(st.lists(st.sampled_from([1.0, 2.0]), min_size=len(lengths), max_size=len(lengths)))
    )
    fixed = np.sort(np.array(knots))
    fixed = fixed[np.diff(fixed, prepend=-1.0) > 1e-6]
    found = cut(fixed, boundaries, wanted)
    assert np.all(np.diff(found) > 0)
    assert found[-1] - found[0] == pytest.approx(FULL_TURN)
    for knot in fixed:
        assert np.abs(found - knot).min() == 0.0
    grown = np.concatenate([[0.0], np.cumsum(wanted)])

    def pieces_until(phases: np.ndarray) -> np.ndarray:
        turns = np.floor((phases - start) / FULL_TURN)
        return turns * grown[-1] + np.interp(phases - turns * FULL_TURN, boundaries, grown)

    assert np.diff(pieces_until(found)).max() < 1.31
    assert len(found) - 1 <= wanted.sum() + len(fixed) + 1


def test_first_pieces_are_short_enough_for_the_fastest_motion(sedan: Model) -> None:
    """The reference car's wheels and torsions are the fastest; its whole orbit of a slow test needs more."""
    still = FourierOrbit(sedan, Harmonic(0.5, {}), np.zeros((sedan.size, 2), dtype=complex))
    count = len(first_boundaries(still)) - 1
    assert fastest_rate(sedan) * 2.0 / count < 2 * np.pi
    fast = replace(still, excitation=Harmonic(50.0, {}))
    assert 6 < len(first_boundaries(fast)) - 1 < count


def test_a_test_that_is_too_slow_for_the_fastest_motion_is_refused_at_once(sedan: Model) -> None:
    for frequency_hz in (1e-3, 1e-9, 1e-300):
        still = FourierOrbit(sedan, Harmonic(frequency_hz, {}), np.zeros((sedan.size, 2), dtype=complex))
        with pytest.raises(ExcitationError, match=r"frequency: \S+ Hz received; 0.01\d* Hz or more"):
            first_boundaries(still)
    slowest = FourierOrbit(sedan, Harmonic(0.02, {}), np.zeros((sedan.size, 2), dtype=complex))
    assert len(first_boundaries(slowest)) - 1 <= MOST_PIECES


def test_fastest_rate_of_the_quarter_car() -> None:
    car = load_model("quarter_car")
    p = {name: car.parameters.value(name) for name in ("spring.rate", "tyre.stiffness", "unsprung.mass")}
    hop = np.sqrt((p["spring.rate"] + p["tyre.stiffness"]) / p["unsprung.mass"])
    assert fastest_rate(car) >= hop
