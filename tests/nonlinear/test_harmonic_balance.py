"""Harmonic balance: exact Jacobian, convergence rate at a kink, refusals, and problems with known answers."""

from dataclasses import replace

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    CompiledEquations,
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    PointDisplacement,
    TravelPort,
    build_model,
    prismatic,
    revolute,
)
from chassym.derivation.parameters import parse_parameters
from chassym.derivation.schema import POSITIVE, ParameterDefinition, Schema
from chassym.nonlinear import (
    Harmonic,
    NoPeriodicOrbitError,
    harmonic_steady_state,
    rig,
    simulate,
    steady_state,
)
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_balance import (
    Extension,
    at_rest,
    balance_residual,
    jacobian,
    newton,
)
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit


def _parameters(model: str, **values: float):
    schema = Schema(model, tuple(ParameterDefinition(name, "1", POSITIVE) for name in values))
    lines = [
        f'{n} = {{ value = {float(v)!r}, unit = "1", description = "d", source = "s" }}'
        for n, v in values.items()
    ]
    return parse_parameters("\n".join([f'model = "{model}"', 'description = "test"', *lines]), schema)


@pytest.fixture(scope="module")
def oscillator() -> Model:
    """A mass on a spring and damper whose foot moves, without gravity."""
    m, k, c = sympy.symbols("m k c", real=True)
    mechanism = Mechanism("oscillator", gravity=0)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    point = mechanism.point("foot", mass, (0, 0, 0))
    port = TravelPort(point, mechanism.ground, "z").less(mechanism.add_input("road", "m"))
    mechanism.add_force_element("spring", port, Linear(k, c))
    mechanism.add_output(PointDisplacement("displacement", point, "z", mechanism.ground))
    mechanism.add_output(PointAcceleration("acceleration", point, "z", mechanism.ground))
    return Model(_parameters("oscillator", m=2.0, k=800.0, c=6.0), CompiledEquations(mechanism))


def test_a_steady_state_of_nothing_is_refused() -> None:
    mechanism = Mechanism("mute", gravity=0)
    mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    mechanism.add_force_element("spring", JointPort(mechanism.coordinate("z")), Linear(100, 1))
    with pytest.raises(ValueError, match="metrics: none to measure; mute has no outputs"):
        steady_state(build_model(mechanism, {}), Harmonic(1.0, {}))


@pytest.fixture(scope="module")
def swing() -> Model:
    """A damped pendulum that a spring to a moving point drives to large angles: nonlinear by its geometry
    alone.
    """
    m, k, c, length, g = sympy.symbols("m k c length g", real=True)
    mechanism = Mechanism("swing", gravity=g)
    arm = mechanism.add_body(
        "arm", mechanism.ground, revolute("angle", "x"), (0, 0, 0), mass=m, mass_centre=(0, 0, -length)
    )
    bob = mechanism.point("bob", arm, (0, 0, -length))
    pull = TravelPort(bob, mechanism.ground, "y").less(mechanism.add_input("hand", "m"))
    mechanism.add_force_element("pull", pull, Linear(k, c))
    mechanism.add_output(PointDisplacement("sideways", bob, "y", mechanism.ground))
    mechanism.add_output(PointAcceleration("acceleration", bob, "z", mechanism.ground))
    values = _parameters("swing", m=1.0, k=3.0, c=0.8, length=1.0, g=9.81)
    return Model(values, CompiledEquations(mechanism))


def test_linear_oscillator_has_its_closed_form(oscillator: Model) -> None:
    frequency_hz = 2.5
    s = 2j * np.pi * frequency_hz
    transfer = (6.0 * s + 800.0) / (2.0 * s**2 + 6.0 * s + 800.0)
    found = steady_state(
        oscillator,
        Harmonic(frequency_hz, {"road": 0.03j}),
        metrics=["displacement", "acceleration"],
        tolerance=1e-9,
    )
    assert found.orbit.harmonic_content(1)[0, 1] == pytest.approx(0.03j * transfer, rel=1e-6)
    balanced = newton(at_rest(oscillator, Harmonic(frequency_hz, {"road": 0.03j}), 3), 1e-12).orbit
    assert balanced.coefficients[0, 1] == pytest.approx(0.03j * transfer, rel=1e-12)
    assert found.peak_to_peak["displacement"].value == pytest.approx(2 * abs(0.03 * transfer), rel=1e-9)
    assert found.peak_to_peak["acceleration"].value == pytest.approx(
        2 * abs(0.03 * transfer * s**2), rel=1e-9
    )


def test_floquet_multipliers_of_a_linear_system_are_exponentials(oscillator: Model) -> None:
    found = steady_state(oscillator, Harmonic(2.5, {"road": 0.01}), metrics=["displacement"])
    poles = np.roots([2.0, 6.0, 800.0])
    expected = np.exp(poles / 2.5)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(expected), rel=1e-3)
    assert found.is_stable


def test_large_pendulum_swings_agree_with_integration(swing: Model) -> None:
    excitation = Harmonic(0.42, {"hand": 0.9})
    found = steady_state(swing, excitation, tolerance=1e-8)
    times = np.concatenate([[0.0], np.linspace(60, 61, 4001) * excitation.period_s])
    moved = simulate(swing, excitation, times, relative_tolerance=1e-11)
    angle = moved.states[0, 1:]
    assert np.ptp(angle) > 1.0, "the swing must be large for the test to mean something"
    assert found.orbit.state() == pytest.approx(moved.states[:, 1], abs=1e-8)
    expected = np.ptp(moved.outputs()[1, 1:])
    assert found.peak_to_peak["acceleration"].value == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("tumbling", [0.0, 0.2])
def test_jacobian_is_the_derivative_of_the_residual(sedan: Model, tumbling: float) -> None:
    """Near the motion of a test, and where angles are so large that inertia changes on the way."""
    generator = np.random.default_rng(5)
    orbit = newton(at_rest(sedan, rig.lateral(), 4), 1e-6).orbit
    away = tumbling * generator.normal(size=orbit.coefficients.shape)
    orbit = replace(orbit, coefficients=orbit.coefficients + away)
    # A smooth orbit's samples may sit near a knot; a small step does not pass one.
    direction = 1e-3 * generator.normal(size=orbit.coefficients.shape) + 0j
    direction[:, 1:] += 1e-3j * generator.normal(size=direction[:, 1:].shape)

    def residual(step: float) -> np.ndarray:
        moved = replace(orbit, coefficients=orbit.coefficients + step * direction)
        return fourier.packed(balance_residual(moved))

    exact = jacobian(orbit) @ fourier.packed(direction)
    coarse, fine = ((residual(h) - residual(-h)) / (2 * h) for h in (2e-4, 1e-4))
    assert (4 * fine - coarse) / 3 == pytest.approx(exact, rel=1e-6, abs=1e-7 * np.abs(exact).max())


def test_error_falls_with_the_square_of_the_harmonics(sedan: Model) -> None:
    """A corner of the force leaves 1/H^2 in what the equations of motion make of the orbit."""
    low = newton(at_rest(sedan, rig.vertical(), 10), 1e-6)
    extension = Extension(low)
    phases = np.linspace(0, 2 * np.pi, 7, endpoint=False) + 0.1
    exact = extension.solve(low.orbit, 2560, 1e-11).orbit.arguments_at(phases)
    orders = np.array([20, 40, 80, 160, 320])
    errors = []
    for harmonics in orders:
        found = extension.solve(low.orbit, int(harmonics), 1e-11).orbit.arguments_at(phases)
        errors.append(np.abs(found - exact)[2 * sedan.size : 3 * sedan.size].max())
    slope = np.polyfit(np.log(orders), np.log(errors), 1)[0]
    assert -3.2 < slope < -1.7


def test_chord_extension_and_newton_find_the_same_orbit(sedan: Model) -> None:
    low = newton(at_rest(sedan, rig.lateral(), 8), 1e-5)
    extended = Extension(low).solve(low.orbit, 24, 1e-11).orbit
    solved = newton(at_rest(sedan, rig.lateral(), 24), 1e-11).orbit
    assert extended.coefficients == pytest.approx(solved.coefficients, abs=1e-11)


def test_an_orbit_satisfies_the_equations_of_motion(sedan: Model) -> None:
    low = newton(at_rest(sedan, rig.lateral(), 10), 1e-6)
    orbit = Extension(low).solve(low.orbit, 160, 1e-9).orbit
    residual = sedan.residual(orbit.sampled(64))
    assert np.abs(residual).max() < 1e-9 * 15000
    accelerations = slice(2 * sedan.size, 3 * sedan.size)
    series, equations = orbit.arguments(256)[accelerations], orbit.sampled(256)[accelerations]
    assert np.linalg.norm(series - equations) < 1e-3 * np.linalg.norm(equations)


def test_starting_from_a_neighbour_saves_iterations(sedan: Model) -> None:
    neighbour = newton(at_rest(sedan, rig.lateral(2.99), 8), 1e-8).orbit
    first = newton(at_rest(sedan, rig.lateral(), 8), 1e-8)
    again = newton(replace(neighbour, excitation=rig.lateral()), 1e-8)
    assert again.iterations < first.iterations
    assert again.orbit.coefficients == pytest.approx(first.orbit.coefficients, abs=1e-9)


def test_failure_names_cause_and_remedy(sedan: Model) -> None:
    with pytest.raises(NoPeriodicOrbitError, match="smaller amplitude"):
        newton(at_rest(sedan, rig.vertical(amplitude_m=50.0), 6), 1e-9)
    with pytest.raises(NoPeriodicOrbitError, match="less accuracy"):
        harmonic_steady_state(sedan, rig.vertical(), metrics=["pitch_rate"], tolerance=1e-12)
    with pytest.raises(ValueError, match="tolerance: 1e-13 received; .* not less than 1e-12"):
        steady_state(sedan, rig.vertical(), tolerance=1e-13)


def test_a_motion_that_nothing_holds_is_named(sedan: Model) -> None:
    loose = sedan.with_parameters({f"tyre.{axle}.stiffness.x": 0.0 for axle in ("front", "rear")})
    with pytest.raises(NoPeriodicOrbitError, match="coordinate 'x'; give it some stiffness"):
        steady_state(loose, rig.lateral())


def test_a_patch_force_may_be_a_metric_too(sedan: Model) -> None:
    name = "rear_left_patch_force_z"
    found = steady_state(sedan, rig.vertical(), metrics=[name])
    waves = found.orbit.outputs(4096)[sedan.output_names.index(name)]
    assert set(found.peak_to_peak) == {name}
    assert found.peak_to_peak[name].value == pytest.approx(np.ptp(waves), rel=1e-4)
    assert found.contact is not None and found.contact.value <= waves.min() + found.contact.error


def test_unknown_output_is_refused_by_name(sedan: Model) -> None:
    with pytest.raises(KeyError, match="'jaw_rate'"):
        steady_state(sedan, rig.vertical(), metrics=["jaw_rate"])


def test_orbit_of_rest_does_not_move(sedan: Model) -> None:
    found = steady_state(sedan, Harmonic(3.0, {}), metrics=["yaw_rate", "vertical_acceleration"])
    assert isinstance(found.orbit, PeriodicOrbit)
    assert all(abs(metric.value) < 1e-9 for metric in found.peak_to_peak.values())


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan])
def test_impossible_tolerance_is_refused(sedan: Model, tolerance: float) -> None:
    with pytest.raises(ValueError, match="tolerance: .* received; a number less than 1 is needed"):
        steady_state(sedan, rig.lateral(), tolerance=tolerance)


def test_slow_excitation_of_a_fast_system_has_its_multipliers(oscillator: Model) -> None:
    """Over a thousand seconds the transients are gone: every multiplier is zero to rounding."""
    found = steady_state(oscillator, Harmonic(0.001, {"road": 0.01}), metrics=["displacement"])
    assert np.abs(found.multipliers).max() < 1e-12
