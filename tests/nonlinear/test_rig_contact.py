"""Loss of contact: when a bonded patch is pulled, by closed form, and when a unilateral tyre flies."""

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    ContactForce,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    PointDisplacement,
    TravelPort,
    Unilateral,
    build_model,
    prismatic,
)
from chassym.nonlinear import Harmonic, steady_state
from chassym.nonlinear.rig import contact_losses

M, K, C, G = sympy.symbols("m k c g", positive=True)
MASS, RATE, DAMPING, GRAVITY = 100.0, 1e5, 3000.0, 9.81


def mass_on_a_tyre(*, unilateral: bool) -> Model:
    """A mass on a tyre that is bonded to its road, or is not."""
    mechanism = Mechanism("mass_on_a_tyre", G)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=M)
    centre = mechanism.point("centre", mass, (0, 0, 0))
    height = TravelPort(centre, mechanism.ground, "z").less(mechanism.add_input("road", "m"))
    law = Unilateral(Linear(K, C)) if unilateral else Linear(K, C)
    tyre = mechanism.add_force_element("tyre", height, law, preloaded=True)
    mechanism.add_output(PointAcceleration("acceleration", centre, "z", mechanism.ground))
    mechanism.add_output(PointDisplacement("displacement", centre, "z", mechanism.ground))
    mechanism.add_output(ContactForce("patch_force_z", tyre))
    return build_model(mechanism, {M: MASS, K: RATE, C: DAMPING, G: GRAVITY})


def force_amplitude(frequency_hz: float, amplitude_m: float) -> complex:
    """Of the bonded tyre: the mass times its acceleration under base excitation."""
    omega = 2 * np.pi * frequency_hz
    tyre = RATE + 1j * omega * DAMPING
    return -MASS * omega**2 * amplitude_m * tyre / (tyre - MASS * omega**2)


@pytest.mark.parametrize(("frequency", "amplitude"), [(4.0, 0.012), (4.0, 0.05), (9.0, 0.02)])
def test_a_bonded_patch_is_pulled_while_the_sine_is_beyond_the_load(
    frequency: float, amplitude: float
) -> None:
    """F = m g + Re(A exp(i w t)) is negative around the phase of -A for 2 arccos(m g / |A|)."""
    model, force = mass_on_a_tyre(unilateral=False), force_amplitude(frequency, amplitude)
    state = steady_state(model, Harmonic(frequency, {"road": amplitude}), metrics=["acceleration"])
    (loss,) = contact_losses(state.orbit)
    half = np.arccos(MASS * GRAVITY / abs(force))
    assert not loss.is_in_the_air
    assert loss.share == pytest.approx(half / np.pi, abs=1e-6)
    assert loss.smallest_force == pytest.approx(MASS * GRAVITY - abs(force), rel=1e-5)
    ((begin, end),) = (np.array(each) * 2 * np.pi / loss.period_s for each in loss.intervals_s)
    middle = np.angle(np.exp(1j * (np.pi - np.angle(force))))
    assert np.exp(0.5j * (begin + end)) == pytest.approx(np.exp(1j * middle), abs=1e-5)


def test_contact_that_is_kept_is_no_loss(quarter_car: Model) -> None:
    assert contact_losses(steady_state(quarter_car, Harmonic(1.0, {"road": 0.01})).orbit) == ()
    assert (
        contact_losses(steady_state(mass_on_a_tyre(unilateral=True), Harmonic(1.0, {"road": 1e-3})).orbit)
        == ()
    )


def test_a_loss_may_pass_the_end_of_the_period() -> None:
    """Turned to the start of the period, the same loss has the same length."""
    model, frequency, amplitude = mass_on_a_tyre(unilateral=False), 4.0, 0.02
    turn = np.exp(1j * (np.pi - np.angle(force_amplitude(frequency, amplitude))))
    losses = [
        contact_losses(steady_state(model, Harmonic(frequency, {"road": a})).orbit)[0]
        for a in (amplitude, amplitude * turn)
    ]
    (begin, end) = losses[1].intervals_s[0]
    assert begin < losses[1].period_s < end
    assert losses[1].share == pytest.approx(losses[0].share, abs=1e-6)


def test_a_patch_that_always_pulls_is_without_contact_all_the_time() -> None:
    """Of two tyres side by side one carries more than the weight, and pulls the other one up."""
    mechanism = Mechanism("two_tyres", G)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=M)
    port = TravelPort(mechanism.point("centre", mass, (0, 0, 0)), mechanism.ground, "z")
    port = port.less(mechanism.add_input("road", "m"))
    for name in ("left", "right"):
        tyre = mechanism.add_force_element(f"{name}_tyre", port, Linear(K, C), preloaded=True)
        mechanism.add_output(ContactForce(f"{name}_patch_force_z", tyre))
    model = build_model(mechanism, {M: MASS, K: RATE, C: DAMPING, G: GRAVITY})
    preloads = {"left_tyre.preload": 500.0, "right_tyre.preload": -500.0 - MASS * GRAVITY}
    pulled = Model(model.parameters, model.compiled, preloads)
    state = steady_state(pulled, Harmonic(1.0, {"road": 1e-4}), metrics=["left_patch_force_z"])
    (loss,) = contact_losses(state.orbit)
    assert (loss.patch, loss.share) == ("left", 1)


@pytest.mark.parametrize(("frequency", "amplitude"), [(4.0, 0.012), (6.0, 0.012)])
def test_a_tyre_in_the_air_carries_nothing_and_its_mass_falls_freely(
    frequency: float, amplitude: float
) -> None:
    model = mass_on_a_tyre(unilateral=True)
    state = steady_state(model, Harmonic(frequency, {"road": amplitude}), tolerance=1e-4)
    (loss,) = contact_losses(state.orbit)
    assert loss.is_in_the_air
    assert loss.smallest_force == 0
    assert 0 < loss.share < 0.6
    for begin, end in loss.intervals_s:
        width = end - begin
        inside, outside = (
            state.orbit.outputs_at(2 * np.pi / loss.period_s * times)
            for times in (np.linspace(begin, end, 9)[1:-1], end + width * np.linspace(0.05, 0.2, 4))
        )
        assert inside[0] == pytest.approx(-GRAVITY, rel=1e-9)
        assert np.all(outside[2] > 0)
    carried = state.orbit.outputs(4096)[2].mean()
    assert carried == pytest.approx(MASS * GRAVITY, rel=1e-3)


def test_patches_are_told_worst_first(half_car: Model) -> None:
    state = steady_state(half_car, Harmonic(6.0, {"front_road": 0.05, "rear_road": 0.05}))
    losses = contact_losses(state.orbit)
    assert [loss.patch for loss in losses] == ["front", "rear"]
    assert losses[0].smallest_force == pytest.approx(state.contact.value, rel=1e-4)
    assert losses[0].smallest_force < losses[1].smallest_force < 0
