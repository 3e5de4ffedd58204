"""Stepped sine: jumps at folds and where stability is lost, coexisting orbits, backbone and distortion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy
from scipy.optimize import brentq

from chassym.derivation import (
    ForceLaw,
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointDisplacement,
    build_model,
    prismatic,
)
from chassym.nonlinear import Harmonic, NoPeriodicOrbitError, rig, simulate, steady_state
from chassym.nonlinear.continuation import stepping
from chassym.nonlinear.continuation.backbone import backbone
from chassym.nonlinear.continuation.branch import Branch
from chassym.nonlinear.continuation.continuation import follow
from chassym.nonlinear.continuation.paths import ACCELERATION, VELOCITY, AmplitudePath, FrequencyPath
from chassym.nonlinear.continuation.settling import settle
from chassym.nonlinear.continuation.stepped_sine import SteppedResponse, stepped_sine
from chassym.nonlinear.orbits.distortion import distortion
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit

from .duffing import Duffing

TURN = 2 * np.pi
DUFFING = Duffing()
FREQUENCIES = np.arange(0.8, 2.45, 0.1)


@pytest.fixture(scope="module")
def path() -> FrequencyPath:
    return FrequencyPath(DUFFING.model(), DUFFING.excitation())


@pytest.fixture(scope="module")
def resonance(path: FrequencyPath) -> Branch:
    return follow(path, 0.7 / TURN, 2.6 / TURN, harmonics=9)


@pytest.fixture(scope="module")
def swept(path: FrequencyPath) -> SteppedResponse:
    return stepped_sine(path, FREQUENCIES / TURN, metrics=["displacement"], tolerance=1e-4, harmonics=9)


def test_jumps_are_where_the_branch_folds(swept: SteppedResponse, resonance: Branch) -> None:
    high, low = (fold.value for fold in resonance.folds)
    up, down = swept.jumps
    assert (up.direction, down.direction) == ("upward", "downward")
    assert (up.cause, down.cause) == ("fold", "fold")
    assert (up.value, down.value) == pytest.approx((high, low), rel=1e-8)
    assert TURN * up.to_value == pytest.approx(2.1) and TURN * down.to_value == pytest.approx(1.2)
    assert (up.output, up.unit) == ("displacement", "m")
    assert up.from_amplitude > 10 * up.to_amplitude and down.from_amplitude < down.to_amplitude


def test_each_way_finds_its_stable_orbits(swept: SteppedResponse, resonance: Branch) -> None:
    """Between the folds upper orbits upward and lower ones downward; elsewhere the only one."""
    high, low = (fold.value for fold in resonance.folds)
    for index, value in enumerate(swept.values):
        heights = sorted(0.5 * np.ptp(orbit.outputs(4096)[0]) for orbit in resonance.at(value))
        assert len(heights) == (3 if low < value < high else 1)
        for run, expected in ((swept.upward, heights[-1]), (swept.downward, heights[0])):
            state = run.states[index]
            assert state is not None and state.is_stable
            assert 0.5 * state.peak_to_peak["displacement"].value == pytest.approx(expected, rel=2e-4)
    between = (swept.values > low) & (swept.values < high)
    assert np.array_equal(swept.coexisting, swept.values[between])


def test_integration_in_time_jumps_to_the_same_orbit(path: FrequencyPath, swept: SteppedResponse) -> None:
    """From the last orbit of the upper branch at the first frequency beyond the fold."""
    last, beyond = (int(np.argmin(np.abs(TURN * swept.values - w))) for w in (2.0, 2.1))
    start, end = swept.upward.states[last], swept.upward.states[beyond]
    assert start is not None and end is not None
    model, excitation = path.at(float(swept.values[beyond]))
    times = excitation.period_s * np.array([0.0, 150.0])
    moved = simulate(model, excitation, times, start=start.orbit.state(), relative_tolerance=1e-9).states[
        :, -1
    ]
    assert end.orbit.state() == pytest.approx(moved, abs=1e-3 * np.abs(moved).max())


def test_what_a_sweep_found_is_labelled(swept: SteppedResponse) -> None:
    labelled = swept.to_xarray()
    assert labelled.displacement.dims == ("direction", "frequency")
    assert labelled.frequency.attrs["units"] == "Hz" and labelled.displacement.attrs["units"] == "m"
    for direction, run in (("upward", swept.upward), ("downward", swept.downward)):
        assert labelled.displacement.sel(direction=direction).values == pytest.approx(
            run.peak_to_peak("displacement")
        )
    assert labelled.frequency[labelled.coexisting.values].values == pytest.approx(swept.coexisting)
    assert labelled.jump_value.values.tolist() == [jump.value for jump in swept.jumps]
    assert labelled.jump_direction.values.tolist() == ["upward", "downward"]
    assert not any(labelled.reason.values.ravel())


def test_amplitudes_are_swept_too(path: FrequencyPath) -> None:
    """At 1.6 rad/s the response jumps up as the force grows and down as it falls."""
    forces = AmplitudePath(path.model, DUFFING.excitation(1.6))
    found = stepped_sine(forces, np.linspace(0.2, 5.0, 13), metrics=["displacement"], harmonics=9)
    branch = follow(forces, 0.2, 5.0, harmonics=9)
    up, down = found.jumps
    assert (up.value, down.value) == pytest.approx([fold.value for fold in branch.folds], rel=1e-8)
    assert up.from_amplitude < up.to_amplitude and down.from_amplitude > down.to_amplitude
    inside = (found.values > down.value) & (found.values < up.value)
    assert np.array_equal(found.coexisting, found.values[inside]) and len(found.coexisting) > 3


def test_progress_comes_to_one(path: FrequencyPath) -> None:
    told: list[float] = []
    stepped_sine(path, [0.1, 0.12], metrics=["displacement"], progress=told.append)
    assert told == pytest.approx([0.25, 0.5, 0.75, 1.0])


@pytest.mark.parametrize(("held", "order"), [(VELOCITY, 1), (ACCELERATION, 2)])
def test_the_quarter_car_has_no_jumps(quarter_car: Model, held, order: int) -> None:
    """A table's damper bends the response, but does not fold it. Every step is the steady state there."""
    path = FrequencyPath(quarter_car, Harmonic(2.0, {"road": 0.01}), held)
    values = np.array([1.0, 2.0, 4.0, 8.0])
    found = stepped_sine(path, values, tolerance=1e-3)
    assert not found.jumps and not len(found.coexisting)
    for value, up, down in zip(values, found.upward.states, found.downward.states, strict=True):
        excitation = Harmonic(float(value), {"road": 0.01 * (2.0 / value) ** order})
        direct = steady_state(quarter_car, excitation).peak_to_peak["vertical_acceleration"]
        assert up is not None and up is down
        assert up.peak_to_peak["vertical_acceleration"].value == pytest.approx(direct.value, rel=3e-3)


def test_the_sedan_steps_through_its_resonances(sedan: Model) -> None:
    path = FrequencyPath(sedan, rig.vertical(amplitude_m=0.01))
    found = stepped_sine(path, [2.0, 3.0, 4.0], metrics=["roll_rate"])
    assert not found.jumps and not any(found.upward.reasons)
    direct = steady_state(sedan, rig.vertical(amplitude_m=0.01), metrics=["roll_rate"]).peak_to_peak[
        "roll_rate"
    ]
    assert found.upward.peak_to_peak("roll_rate")[1] == pytest.approx(direct.value, rel=3e-3)


def test_stability_lost_without_a_fold(path: FrequencyPath) -> None:
    """A strongly pushed Duffing oscillator gives up its symmetry: one multiplier passes one, no branch folds.

    The orbits beyond lean to one side; shooting finds them, too.
    """
    soft = Duffing(damping=0.1, force=1.0)
    forces = AmplitudePath(soft.model(), soft.excitation(0.6))
    found = stepped_sine(forces, [4.5, 5.0, 5.5, 6.0], metrics=["displacement"], tolerance=1e-6, harmonics=15)
    (jump,) = found.upward.jumps
    assert (jump.cause, jump.to_value) == ("stability lost", 5.5)
    means = [s.orbit.motion_at(TURN / 64 * np.arange(64))[0].mean() for s in found.upward.states if s]
    assert len(means) == 4 and np.abs(means[:2]).max() < 1e-6 and np.abs(means[2:]).min() > 1e-2
    lean = found.upward.states[2]
    state, multipliers = replace(soft, force=5.5).shot(lean.orbit.state(), 0.6)
    assert lean.orbit.state() == pytest.approx(state, abs=1e-3) and np.abs(multipliers).max() < 1

    (symmetric,) = follow(forces, 4.5, 5.5, harmonics=15).at(5.5)
    left = settle(symmetric.model, symmetric.excitation, symmetric.state(), 15)
    assert abs(left.coefficients[0, 0]) > 1e-2, (
        "an orbit that is only slowly left is not the one to settle to"
    )

    def excess(force: float) -> float:
        (symmetric,) = follow(forces, 4.5, force, harmonics=15).at(force)
        return abs(replace(soft, force=force).shot(symmetric.state(), 0.6)[1]).max() - 1

    assert jump.value == pytest.approx(brentq(excess, 5.0, 5.5, xtol=1e-4), abs=2e-3)


def _pumped(weight: sympy.Expr) -> Model:
    """A mass whose stiffness is pumped: at twice its frequency rest becomes unstable at 2 c w (Mathieu)."""
    mechanism = Mechanism("pumped", gravity=0)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    port = JointPort(mechanism.coordinate("z"))
    mechanism.add_force_element("spring", port, Linear(1.0, 0.1))
    s = sympy.Symbol("s", real=True)
    stiffness = mechanism.add_input("pump", "N").position
    mechanism.add_force_element("pumped", port, ForceLaw(s * stiffness + s**3, deflection=s))
    mechanism.add_force_element("weight", port, ForceLaw(weight, deflection=s))
    mechanism.add_output(
        PointDisplacement("displacement", mechanism.point("p", mass, (0, 0, 0)), "z", mechanism.ground)
    )
    return build_model(mechanism, {})


def test_motion_that_does_not_repeat_leaves_a_reason() -> None:
    """The pumped mass comes to move at half the frequency; steps before that are kept."""
    path = AmplitudePath(_pumped(sympy.Rational(-1, 10)), Harmonic(2.05 / TURN, {"pump": 1.0}))
    found = stepped_sine(path, [0.1, 0.5], metrics=["displacement"])
    first, second = found.upward.states
    assert first is not None and second is None
    assert "stability lost at amplitude_factor 0.2" in found.upward.reasons[1]
    assert "it may be sub-harmonic" in found.upward.reasons[1]
    assert np.isnan(found.upward.peak_to_peak("displacement")).tolist() == [False, True]
    assert found.to_xarray().reason.values[0].tolist() == list(found.upward.reasons)


def test_unstable_rest_is_left() -> None:
    """Pumped strongly once in each period of its own: nothing but a disturbance starts the motion."""
    model = _pumped(sympy.Integer(0))
    found = settle(model, Harmonic(1.0 / TURN, {"pump": 0.9}), np.zeros(2), 9)
    assert np.abs(found.coefficients).max() > 0.1


@pytest.mark.parametrize("iterations", [4, 100])
def test_however_patient_newton_is_a_jump_is_seen(
    path: FrequencyPath, resonance: Branch, monkeypatch: pytest.MonkeyPatch, iterations: int
) -> None:
    """Given time, Newton's method finds the other branch beyond a fold: an orbit, but not the next one."""
    monkeypatch.setattr(stepping, "_HASTE", iterations)
    found = stepped_sine(path, np.array([1.0, 1.5, 2.4]) / TURN, metrics=["displacement"], harmonics=9)
    assert [jump.value for jump in found.jumps] == pytest.approx([f.value for f in resonance.folds], rel=1e-8)


def test_settling_finds_the_orbit_nearby(path: FrequencyPath, resonance: Branch) -> None:
    upper, unstable, lower = resonance.at(1.6 / TURN)
    for near, expected in ((upper, upper), (lower, lower)):
        found = settle(near.model, near.excitation, 1.01 * near.state(), 9)
        assert found.coefficients == pytest.approx(expected.coefficients, abs=1e-7)
    left = settle(unstable.model, unstable.excitation, unstable.state(), 9)
    assert np.abs(left.coefficients - unstable.coefficients).max() > 0.1


def test_backbone_of_one_harmonic_has_its_closed_form(path: FrequencyPath) -> None:
    """The largest A: w^2 = k + 3/4 k3 A^2 - c^2 / 2 and F^2 = A^2 c^2 (w^2 + c^2 / 4)."""
    found = backbone(path, [0.05, 0.2, 1.0], 0.5 / TURN, 3.0 / TURN, output="displacement", harmonics=1)
    for factor, frequency_hz, amplitude in zip(
        found.factors, found.frequencies_hz, found.amplitudes, strict=True
    ):
        square, c = (TURN * frequency_hz) ** 2, DUFFING.damping
        assert square == pytest.approx(1 + 0.75 * amplitude**2 - c**2 / 2, rel=1e-5)
        assert amplitude**2 * c**2 * (square + c**2 / 4) == pytest.approx((factor * 0.2) ** 2, rel=2e-5)
    assert np.all(np.diff(found.frequencies_hz) > 0)
    labelled = found.to_xarray()
    assert labelled.displacement.attrs["units"] == "m" and labelled.frequency.attrs["units"] == "Hz"


def test_backbone_refuses_what_has_no_peak(path: FrequencyPath) -> None:
    with pytest.raises(NoPeriodicOrbitError, match="largest where the range from .* Hz ends; widen it"):
        backbone(path, [1.0], 0.8 / TURN, 1.2 / TURN, output="displacement")
    with pytest.raises(NoPeriodicOrbitError, match="largest where the range from .* Hz begins"):
        backbone(path, [1.0], 2.4 / TURN, 2.8 / TURN, output="displacement")
    with pytest.raises(KeyError, match="output 'speed'"):
        backbone(path, [1.0], 0.1, 0.2, output="speed")
    with pytest.raises(ValueError, match="factors: .* positive numbers are needed"):
        backbone(path, [1.0, -1.0], 0.1, 0.2, output="displacement")
    with pytest.raises(ValueError, match=r"frequencies: 0.2 to 0.1 Hz received"):
        backbone(path, [1.0], 0.2, 0.1, output="displacement")


@pytest.mark.parametrize("subharmonic", [1, 2])
def test_distortion_is_the_share_of_the_other_harmonics(path: FrequencyPath, subharmonic: int) -> None:
    coefficients = np.zeros((1, 8), dtype=complex)
    coefficients[0, subharmonic] = 0.2j
    others = [k for k in range(1, 8) if k != subharmonic][:2]
    coefficients[0, others] = 0.03, 0.04j
    coefficients[0, 0] = 5.0
    orbit = FourierOrbit(path.model, path.excitation, coefficients, subharmonic)
    assert distortion(orbit)["displacement"] == pytest.approx(0.05 / 0.2, rel=1e-9)
    still = replace(orbit, coefficients=0 * coefficients)
    assert np.isnan(distortion(still)["displacement"])


def test_values_have_to_ascend(path: FrequencyPath) -> None:
    for values in ([0.2], [0.2, 0.2], [0.3, 0.2], [[0.1, 0.2]]):
        with pytest.raises(ValueError, match="values: .* at least two ascending numbers are needed"):
            stepped_sine(path, values)
