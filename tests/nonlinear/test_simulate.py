"""Time simulation: closed forms, conserved energy, events, refusals, labelled results."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy
from scipy.integrate import quad_vec, solve_ivp

from chassym.derivation import (
    Characteristic,
    CombinedPort,
    ContactForce,
    ForceLaw,
    JointPort,
    Linear,
    Mechanism,
    Model,
    SpringTable,
    TravelPort,
    Unilateral,
    build_model,
    prismatic,
    revolute,
    with_lifting_tyres,
)
from chassym.nonlinear import (
    Excitation,
    Harmonic,
    LinearChirp,
    Simulation,
    SimulationError,
    Step,
    SteppedSine,
    TimeSeries,
    rig,
    simulate,
)
from chassym.nonlinear.simulation.right_hand_side import RightHandSide

STILL = Harmonic(1.0, {})
NOT_INCREASING = [[1.0, 0.5, 0.0], [0.0, 0.5, 0.2], [0.0, np.nan], [0.0, np.inf], [0.0], 5.0]
V = sympy.Symbol("v", real=True)


def block(law: Characteristic, gravity: float = 0.0, mass: float = 1.0) -> Model:
    """Give a mass on a slide, with a law between it and the road."""
    mechanism = Mechanism("block", gravity)
    body = mechanism.add_body("block", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=mass)
    port = TravelPort(mechanism.point("foot", body, (0, 0, 0)), mechanism.ground, "z")
    element = mechanism.add_force_element("foot", port.less(mechanism.add_input("road", "m")), law)
    mechanism.add_output(ContactForce("patch_force_z", element))
    return build_model(mechanism, {})


def run(model: Model, times: np.ndarray, start: list[float], **given: float) -> Simulation:
    return simulate(model, STILL, times, start=np.array(start), **given)


# What is asked


@pytest.mark.parametrize("times", NOT_INCREASING)
def test_instants_must_increase(quarter_car: Model, times: object) -> None:
    with pytest.raises(ValueError, match="time_s: .* increasing instants are needed"):
        simulate(quarter_car, STILL, np.array(times))


def test_start_must_have_the_state_s_shape(quarter_car: Model) -> None:
    with pytest.raises(ValueError, match=r"start: shape \(3,\) received; \(4,\) is needed"):
        simulate(quarter_car, STILL, np.array([0.0, 1.0]), start=np.zeros(3))


def test_start_must_be_finite(quarter_car: Model) -> None:
    with pytest.raises(ValueError, match="start: .*nan.* received; finite numbers are needed"):
        simulate(quarter_car, STILL, np.array([0.0, 1.0]), start=np.array([0, 0, np.nan, 0]))


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, 0.2, 1e-15])
def test_impossible_tolerance_is_refused(quarter_car: Model, tolerance: float) -> None:
    with pytest.raises(ValueError, match="relative_tolerance: .* from 1e-13 to 0.1 is needed"):
        simulate(quarter_car, STILL, np.array([0.0, 1.0]), relative_tolerance=tolerance)


def test_an_excitation_that_ends_early_is_refused_before_anything_moves(quarter_car: Model) -> None:
    series, told = TimeSeries(np.arange(5.0), {"road": np.zeros(5)}), list[float]()
    with pytest.raises(ValueError, match="20 s asked for; it is known from 0 to 4 s"):
        simulate(quarter_car, series, np.array([0.0, 20.0]), progress=told.append)
    assert not told


def test_rest_stays_rest(sedan: Model) -> None:
    moved = simulate(sedan, STILL, np.linspace(0, 1, 11))
    assert np.abs(moved.states).max() < 1e-9
    assert moved.steps < 500


def test_results_are_labelled_with_names_and_units(quarter_car: Model) -> None:
    told: list[float] = []
    excitation = Harmonic(2.0, {"road": 0.01})
    times = np.linspace(0, 1, 51)
    moved = simulate(quarter_car, excitation, times, progress=told.append)
    data = moved.to_xarray()
    units = {name: data[name].attrs["units"] for name in data.variables}
    assert units["wheel_travel"] == "m" and units["time"] == "s" and units["rate_of_road"] == "m/s"
    assert data["wheel_travel"].values == pytest.approx(moved.states[1] - moved.states[0])
    assert data["rate_of_body_bounce"].values == pytest.approx(moved.states[2])
    assert data["road"].values == pytest.approx(0.01 * np.cos(4 * np.pi * times))
    assert set(quarter_car.output_names) <= set(data.variables)
    assert told == sorted(told) and told[-1] == pytest.approx(1.0)
    assert data.attrs["knot_events"] == moved.events["knot"] > 0


def test_every_signal_of_the_sedan_has_a_name_of_its_own(sedan: Model) -> None:
    data = simulate(sedan, rig.vertical(), np.linspace(0, 0.1, 5)).to_xarray()
    assert len(data) == len(sedan.output_names) + 2 * sedan.size + 2 * len(sedan.system.inputs)
    assert data["pitch_rate"].attrs == {"units": "rad/s"}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_motion_without_end_is_an_error(sedan: Model) -> None:
    with pytest.raises(SimulationError, match="check the excitation's amplitude"):
        simulate(sedan, rig.vertical(amplitude_m=1e200), np.array([0.0, 1.0]))


# Smooth motions


@pytest.mark.parametrize(
    "excitation",
    [
        LinearChirp(0.5, 8.0, 3.0, {"road": -0.02j}),
        SteppedSine((1.0, 3.0, 6.0), (1.0, 2.0, 3.5), {"road": (0.02, 0.01j, 0.005)}),
        Step({"road": 0.05}, ramp_s=0.15, start_s=0.4),
    ],
)
def test_a_linear_oscillator_moves_as_duhamel_s_integral_says(excitation: Excitation) -> None:
    """The response is the integral of impulse response times k u + c u'."""
    k, c = 400.0, 3.0
    model, times = block(Linear(k, c)), np.linspace(0, 4, 9)
    decay, turn = c / 2, np.sqrt(k - c**2 / 4)
    found = simulate(model, excitation, times, relative_tolerance=1e-11)

    def integrand(past: float, now: float) -> float:
        value, rate = (each[0, 0] for each in excitation.signals(model, np.array([past])))
        lag = now - past
        return float(np.exp(-decay * lag) * np.sin(turn * lag) / turn * (k * value + c * rate))

    breaks = excitation.breaks(0.0, 4.0)
    for now, position in zip(times[1:], found.states[0, 1:], strict=True):
        points = breaks[breaks < now]
        expected = quad_vec(lambda t, now=now: integrand(t, now), 0.0, now, points=points, epsabs=1e-13)[0]
        assert position == pytest.approx(expected, abs=1e-10)
    assert found.events["excitation break"] == len(breaks)


def test_breaks_of_the_excitation_cost_next_to_nothing() -> None:
    """No step feels the rate behind a break: where one does, the integrator creeps up to it."""
    sine = SteppedSine((1.0, 6.0) * 10, 1.0, {"road": 0.02j})
    found = simulate(block(Linear(400, 3)), sine, np.array([0.0, sine.end_s]), relative_tolerance=1e-11)
    assert found.events["excitation break"] == 19 and found.steps < 1500


def double_pendulum() -> Model:
    mechanism = Mechanism("double pendulum", 9.81)
    upper = mechanism.add_body("upper", mechanism.ground, revolute("a", "y"), (0, 0, 0), **rod(0.0))
    mechanism.add_body("lower", upper, revolute("b", "y"), (0, 0, -1), **rod(-1.0))
    spring = ForceLaw(20 * V + 50 * V**3, deflection=V)
    mechanism.add_force_element("spring", JointPort(mechanism.coordinate("b")), spring)
    return build_model(mechanism, {})


def rod(top: float) -> dict:
    return {"mass": 2.0, "mass_centre": (0, 0, top - 0.5), "inertia": (0.17, 0.17, 0.01)}


def test_energy_is_conserved() -> None:
    """A double pendulum that turns over, with a hardening spring, written down by hand."""
    model = double_pendulum()
    found = run(model, np.linspace(0, 10, 201), [2.5, 0.5, 5.0, 3.0], relative_tolerance=1e-12)
    a, b, va, vb = found.states
    m, half, inertia, g = 2.0, 0.5, 0.17, 9.81
    both, rate = a + b, va + vb
    kinetic = 0.5 * (inertia + m * half**2) * va**2 + 0.5 * inertia * rate**2
    kinetic += 0.5 * m * (va**2 + half**2 * rate**2 + 2 * half * va * rate * np.cos(b))
    potential = -m * g * (half * np.cos(a) + np.cos(a) + half * np.cos(both)) + 10 * b**2 + 12.5 * b**4
    energy = kinetic + potential
    assert np.ptp(a) > 2 * np.pi
    assert np.ptp(energy) < 1e-9 * np.ptp(kinetic)


# Knots


STIFF, SOFT, BEND = 900.0, 100.0, 0.02


def two_springs() -> Model:
    """Give a mass between springs: soft up to a place, stiff beyond."""
    table = SpringTable([-1.0, BEND, 1.0], [-SOFT * (1 + BEND), 0.0, STIFF * (1 - BEND)])
    return block(table)


def exact_two_springs(time_s: float, position: float) -> tuple[float, int]:
    """Where the mass is that was let go at a position below the bend, and how often it has passed it.

    The springs are slack at the bend, so it passes there with its greatest speed: half periods in turn.
    """
    amplitude, knots = BEND - position, 0
    slow, fast = np.sqrt(SOFT), np.sqrt(STIFF)
    left = time_s - 0.5 * np.pi / slow
    if left < 0:
        return BEND - amplitude * np.cos(slow * time_s), 0
    while True:
        for turn, sign in ((fast, 1.0), (slow, -1.0)):
            knots += 1
            if left < np.pi / turn:
                return BEND + sign * amplitude * slow / turn * np.sin(turn * left), knots
            left -= np.pi / turn


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_an_oscillator_of_two_springs_moves_by_half_periods(tolerance: float) -> None:
    times = np.linspace(0, 20, 101)
    found = run(two_springs(), times, [-0.1, 0.0], relative_tolerance=tolerance)
    exact = [exact_two_springs(t, -0.1) for t in times]
    assert found.states[0] == pytest.approx([x for x, _ in exact], abs=30 * tolerance)
    assert found.events["knot"] == exact[-1][1] > 80


def test_knots_do_not_destroy_the_order() -> None:
    """A method of order 8 needs 10^(6/8) = 5.6 times the steps for six more digits; order 3, 100 times."""
    coarse, fine = (
        run(two_springs(), np.array([0.0, 20.0]), [-0.1, 0.0], relative_tolerance=t) for t in (1e-6, 1e-12)
    )
    assert fine.evaluations < 6 * coarse.evaluations


def test_a_knot_that_is_passed_twice_within_a_step_is_seen() -> None:
    """Thrown up it rises a millimetre above a knot, within steps of half a second."""
    g, speed = 9.81, 10.0
    top = speed**2 / (2 * g)
    bend, stiffness = top - 1e-3, 5e4
    model = block(SpringTable([0.0, bend, 2 * top], [0.0, 0.0, stiffness * (2 * top - bend)]), g)
    found = run(model, np.linspace(0, 1.5, 4), [0.0, speed], relative_tolerance=1e-6)
    assert found.events["knot"] == 2
    rise = (speed - np.sqrt(2e-3 * g)) / g
    turn, slow = np.sqrt(stiffness), np.sqrt(2e-3 * g)
    still = g / turn**2  # the spring's equilibrium above the knot
    amplitude = np.hypot(still, slow / turn)
    above = 2 * (np.pi / 2 - np.arcsin(still / amplitude)) / turn
    late = 1.5 - rise - above
    assert found.states[0, -1] == pytest.approx(bend - slow * late - 0.5 * g * late**2, abs=1e-6)


def test_alike_corners_pass_their_knots_together(sedan: Model) -> None:
    """In heave the left and the right wheels move alike: when one passes a knot, so does the other."""
    found = simulate(sedan, rig.heave(2.0, 0.02), np.linspace(0, 1, 21), relative_tolerance=1e-9)
    assert found.events["knot"] > 20 and found.events["knot"] % 2 == 0
    names = [c.name for c in sedan.system.coordinates]
    for axle in ("front", "rear"):
        left, right = (found.states[names.index(f"{axle}_{side}_arm_angle")] for side in ("left", "right"))
        np.testing.assert_allclose(left, -right, atol=1e-11)
    plain = solve_ivp(
        RightHandSide(sedan, rig.heave(2.0, 0.02)), (0, 1), np.zeros(24), "DOP853", rtol=1e-12, atol=1e-15
    )
    assert found.states[:, -1] == pytest.approx(plain.y[:, -1], abs=1e-8)


@pytest.mark.parametrize("name", ["lateral", "vertical"])
def test_the_tests_of_the_rig_are_integrated_to_rounding(sedan: Model, name: str) -> None:
    """Against small steps across the knots; one more digit asked for is one more digit got."""
    excitation, times = getattr(rig, name)(), np.array([0.0, 0.5])
    plain = solve_ivp(RightHandSide(sedan, excitation), times, np.zeros(24), "DOP853", rtol=1e-13, atol=1e-16)
    for tolerance in (1e-6, 1e-11):
        found = simulate(sedan, excitation, times, relative_tolerance=tolerance)
        assert np.abs(found.states[:, -1] - plain.y[:, -1]).max() < 10 * tolerance


def test_sliding_along_a_jump_is_refused() -> None:
    """Dry friction stops a block on a slope of less than its angle: it would stick for ever."""
    model = block(ForceLaw(8 * sympy.sign(V), rate=V), gravity=5.0)
    with pytest.raises(SimulationError, match=r"stopped at 0.333.* slides along a knot.* steep slope"):
        run(model, np.array([0.0, 2.0]), [0.0, 13 / 3])


def test_friction_reverses_a_motion_that_does_not_stick() -> None:
    """Upwards g and friction add, downwards they subtract."""
    model = block(ForceLaw(2 * sympy.sign(V), rate=V), gravity=5.0)
    found = run(model, np.array([0.0, 1.0, 2.0]), [0.0, 7.0])
    assert found.states[:, 2] == pytest.approx([3.5 - 1.5, -3.0], abs=1e-9)
    assert found.events["knot"] == 1


# Contact


G, FOOT = 9.81, 2e4


def drop_times(height: float) -> tuple[float, float]:
    """Time of the fall to the foot's spring, and of the stay on it, of 1 kg."""
    turn, speed = np.sqrt(FOOT), np.sqrt(2 * G * height)
    return float(np.sqrt(2 * height / G)), float(2 * (np.pi - np.arctan(speed * turn / G)) / turn)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_a_mass_bounces_for_ever(tolerance: float) -> None:
    """Flight and half a swing on the spring in turn; both ends of every flight are found."""
    height = 0.3
    fall, stay = drop_times(height)
    period, flights = 2 * fall + stay, 5
    times = np.linspace(0, (flights + 0.5) * period - 1e-3, 57)
    found = run(block(Unilateral(Linear(FOOT)), G), times, [height, 0.0], relative_tolerance=tolerance)
    into = np.mod(times, period)
    after = into - fall - stay
    flying = np.where(
        into < fall, height - G * into**2 / 2, np.sqrt(2 * G * height) * after - G * after**2 / 2
    )
    in_flight = (into < fall) | (after > 0)
    assert found.states[0][in_flight] == pytest.approx(flying[in_flight], abs=1e3 * tolerance)
    assert found.events["contact made"] == 6 and found.events["contact lost"] == 5
    assert [loss.start_s for loss in found.contact_losses] == pytest.approx(
        [0.0, *(fall + stay + i * period for i in range(5))], abs=1e4 * tolerance
    )
    assert [loss.end_s for loss in found.contact_losses] == pytest.approx(
        [fall + i * period for i in range(6)], abs=1e4 * tolerance
    )
    assert all(abs(loss.smallest_force) < 1e-3 and loss.patch == "" for loss in found.contact_losses)
    energy = found.states[1] ** 2 / 2 + G * found.states[0] + FOOT / 2 * np.minimum(found.states[0], 0) ** 2
    assert energy == pytest.approx(G * height, rel=1e3 * tolerance)


def test_a_bonded_patch_tells_where_it_was_pulled() -> None:
    """Swinging by a on its spring, preloaded by m g, the foot pulls where k x > m g."""
    amplitude, k = 0.02, 1000.0
    model = block(Linear(k, 0, -G), G)
    turn, edge = np.sqrt(k), G / k
    found = run(model, np.array([0.0, 2 * np.pi / turn]), [0.0, amplitude * turn])
    (loss,) = found.contact_losses
    assert loss.start_s * turn == pytest.approx(np.arcsin(edge / amplitude), abs=1e-7)
    assert loss.end_s * turn == pytest.approx(np.pi - np.arcsin(edge / amplitude), abs=1e-7)
    assert loss.smallest_force == pytest.approx(G - k * amplitude, rel=1e-3)
    assert "smallest force -10.19 N" in str(loss) and str(loss) in found.to_xarray().attrs["contact_losses"]
    assert found.events == {"knot": 0, "contact lost": 0, "contact made": 0, "excitation break": 0}


def test_losses_that_last_are_cut_at_both_ends() -> None:
    found = run(block(Linear(0, 0, 1.0), -1.0), np.array([0.0, 3.0]), [0.0, 0.0])
    (loss,) = found.contact_losses
    assert (loss.start_s, loss.end_s, loss.smallest_force) == (0.0, 3.0, -1.0)


def test_pulled_patches_of_the_sedan_are_those_of_its_outputs(sedan: Model) -> None:
    times = np.linspace(0, 0.5, 5001)
    found = simulate(sedan, rig.vertical(amplitude_m=0.1), times)
    outputs = dict(zip(sedan.output_names, found.outputs(), strict=True))
    assert len(found.contact_losses) > 3
    for corner in rig.CORNERS:
        force = outputs[f"{corner}_patch_force_z"]
        lost = [loss for loss in found.contact_losses if loss.patch == corner]
        told = np.any([(times >= loss.start_s) & (times <= loss.end_s) for loss in lost], axis=0)
        assert np.mean(told != (force <= 0)) < 1e-3
        assert min(loss.smallest_force for loss in lost) == pytest.approx(force.min(), rel=1e-2)


def test_a_sedan_whose_tyres_lift_is_integrated_as_accurately(sedan: Model) -> None:
    """Against small steps across knots and lift-offs; the patches in the air are told."""
    model, rough = with_lifting_tyres(sedan), rig.vertical(amplitude_m=0.1)
    found = simulate(model, rough, np.array([0.0, 0.5]), relative_tolerance=1e-9)
    plain = solve_ivp(RightHandSide(model, rough), (0, 0.5), np.zeros(24), "DOP853", rtol=1e-12, atol=1e-15)
    assert found.states[:, -1] == pytest.approx(plain.y[:, -1], abs=1e-7)
    assert found.events["contact lost"] >= 4 and found.events["knot"] > 20
    assert all(abs(loss.smallest_force) < 1e-6 for loss in found.contact_losses)


def lifting_quarter_car(law: Callable[[float, float], Characteristic]) -> Model:
    """Give a quarter car whose tyre obeys a law of stiffness and damping."""
    mechanism = Mechanism("lifting quarter car", G)
    joints = prismatic("body_z", "z"), prismatic("wheel_z", "z")
    body = mechanism.add_body("body", mechanism.ground, joints[0], (0, 0, 0), mass=400)
    wheel = mechanism.add_body("wheel", mechanism.ground, joints[1], (0, 0, 0), mass=40)
    points = [mechanism.point(b.name + "_centre", b, (0, 0, 0)) for b in (body, wheel)]
    up, low = (TravelPort(point, mechanism.ground, "z") for point in points)
    travel = CombinedPort(((up, 1), (low, -1)))
    mechanism.add_force_element("strut", travel, Linear(2e4, 1500), preloaded=True)
    road = mechanism.add_input("road", "m")
    tyre = mechanism.add_force_element("tyre", low.less(road), law(2e5, 100), preloaded=True)
    mechanism.add_output(ContactForce("patch_force_z", tyre))
    return build_model(mechanism, {})


def test_a_lifting_tyre_is_integrated_as_accurately_as_any() -> None:
    """Its damper makes the force jump in slope and rate at touch-down; against small steps across them."""
    model = lifting_quarter_car(lambda k, c: Unilateral(Linear(k, c)))
    rough, times = Harmonic(9.0, {"road": -0.03j}), np.linspace(0, 1.0, 11)
    found = simulate(model, rough, times, relative_tolerance=1e-10)
    plain = solve_ivp(
        RightHandSide(model, rough), (0, 1), np.zeros(4), "DOP853", times, rtol=1e-12, atol=1e-14
    )
    assert found.states == pytest.approx(plain.y, abs=1e-7)
    assert found.events["contact lost"] >= 8 <= found.events["contact made"]
    flights = [loss.end_s - loss.start_s for loss in found.contact_losses]
    assert len(flights) == found.events["contact lost"] and max(flights) > 0.03
    bonded = lifting_quarter_car(Linear)
    assert simulate(bonded, rough, times).contact_losses[0].smallest_force < -1000


def test_an_excitation_that_breaks_may_throw_a_tyre_off() -> None:
    """A pad that falls away faster at once: the damper's force jumps below zero at the break."""
    model = lifting_quarter_car(lambda k, c: Unilateral(Linear(k, 60 * c)))
    sine = SteppedSine((1.0, 12.0), (1.25, 3.0), {"road": 0.04})
    found = simulate(model, sine, np.linspace(0, 1.5, 16), relative_tolerance=1e-9)
    start = found.contact_losses[0].start_s
    assert start == pytest.approx(1.25, abs=1e-9)
    plain = [
        solve_ivp(RightHandSide(model, sine), (0, 1.25 - 1e-15), np.zeros(4), rtol=1e-9, atol=1e-12).y[:, -1]
    ]
    plain += [solve_ivp(RightHandSide(model, sine), (1.25, 1.5), plain[0], rtol=1e-9, atol=1e-12).y[:, -1]]
    assert found.states[:, -1] == pytest.approx(plain[1], abs=1e-5)
