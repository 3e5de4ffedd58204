"""The K&C rig: small motions have the rates of springs in series, worked out by hand from the parameters."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest

from chassym.derivation import Model, ParameterError, load_model
from chassym.nonlinear.rig import RigTest, hold_body, load_rig_test, run
from chassym.nonlinear.rig.running import RigStep

BOUNCE, ROLL = "kinematics_and_compliance", "kinematics_and_compliance_roll"
AXLES = ("front", "rear")


def slow(name: str) -> RigTest:
    """A test with a small amplitude, whose regression lines are tangents."""
    return replace(load_rig_test(name).with_amplitude(1e-4), tolerance=1e-6)


@pytest.fixture(scope="module", params=["sedan", "rigid_sedan"])
def car(request: pytest.FixtureRequest) -> Model:
    """Give a car; its springs and bars differ from axle to axle and its patches from its wheel centres."""
    return load_model(
        request.param,
        {
            "suspension.front.contact_patch.y": "-800 mm",
            "suspension.rear.contact_patch.y": "-700 mm",
            "suspension.front.anti_roll_bar.rate": "9 N/mm",
        },
    )


@pytest.fixture(scope="module")
def bounce(car: Model) -> RigStep:
    return run(car, slow(BOUNCE)).steps[0]


@pytest.fixture(scope="module")
def roll(car: Model) -> RigStep:
    return run(car, slow(ROLL)).steps[0]


def tangents(car: Model, axle: str, bar_share: float) -> dict[str, float]:
    """Rates at the design position of the right wheel.

    The arm turns by phi about its pivot. The wheel centre, at (a, b) from there, rises by a phi and the
    patch, at (p, r), by p phi, while it moves outward by -r phi. Moments about the pivot, with the load F0 at
    the patch, the spring's k s at the wheel centre and the loads S of preload and weight there, whose arm
    shrinks by b phi:

        F (p - r phi) = (k a phi + S) (a - b phi),  S a = F0 p.
    """
    values = car.parameters.flat()
    place = f"suspension.{axle}"
    (a, b), (p, r) = (
        (
            -values[f"{place}.{point}.y"] + values[f"{place}.arm_pivot.y"],
            values[f"{place}.{point}.z"] - values[f"{place}.arm_pivot.z"],
        )
        for point in ("wheel_centre", "contact_patch")
    )
    spring = values[f"{place}.spring.rate"] / values[f"{place}.spring.lever_ratio"] ** 2
    spring += bar_share * values[f"{place}.anti_roll_bar.rate"]
    load = -car.preloads[f"{axle}_right_tyre_z.preload"]
    over_angle = (spring * a**2 - load * p / a * b + load * r) / p
    at_patch = over_angle / p
    tyre = values[f"tyre.{axle}.stiffness.z"]
    return {
        "wheel": over_angle / a,
        "ride": 1 / (1 / at_patch + 1 / tyre),
        "camber": -1 / a,
        "scrub": -r / a,
        "half track": -values[f"{place}.contact_patch.y"],
        "half wheel track": -values[f"{place}.wheel_centre.y"],
        "pad over patch": 1 + at_patch / tyre,
        "patch over wheel": p / a,
    }


@pytest.mark.parametrize("axle", AXLES)
def test_bounce_gives_wheel_rate_and_ride_rate_of_springs_in_series(
    car: Model, bounce: RigStep, axle: str
) -> None:
    expected = tangents(car, axle, bar_share=0)
    assert bounce.rates[f"{axle}_wheel_rate"].value == pytest.approx(expected["wheel"], rel=1e-4)
    assert bounce.rates[f"{axle}_ride_rate"].value == pytest.approx(expected["ride"], rel=1e-4)
    assert bounce.rates[f"{axle}_ride_rate"].unit == "N/m"


@pytest.mark.parametrize("axle", AXLES)
def test_bounce_gives_camber_and_scrub_of_the_arm(car: Model, bounce: RigStep, axle: str) -> None:
    expected = tangents(car, axle, bar_share=0)
    assert bounce.rates[f"{axle}_bump_camber"].value == pytest.approx(expected["camber"], rel=1e-4)
    assert bounce.rates[f"{axle}_bump_scrub"].value == pytest.approx(expected["scrub"], rel=1e-4)


@pytest.mark.parametrize("axle", AXLES)
def test_roll_stiffness_counts_the_anti_roll_bar_twice_at_each_wheel(
    car: Model, roll: RigStep, axle: str
) -> None:
    """The bar resists the difference of the travels, which is twice that of one wheel."""
    expected = tangents(car, axle, bar_share=2)
    stiffness = 2 * expected["half track"] ** 2 * expected["ride"]
    assert roll.rates[f"{axle}_roll_stiffness"].value == pytest.approx(stiffness, rel=1e-4)
    at_wheels = 2 * expected["half track"] * expected["half wheel track"] * expected["wheel"]
    assert roll.rates[f"{axle}_suspension_roll_stiffness"].value == pytest.approx(at_wheels, rel=1e-4)
    assert roll.rates[f"{axle}_roll_stiffness"].unit == "N*m/rad"


@pytest.mark.parametrize("axle", AXLES)
def test_roll_camber(car: Model, roll: RigStep, axle: str) -> None:
    """Over the roll angle, positive with the right side up, of the pads; its camber is that of the travel."""
    expected = tangents(car, axle, bar_share=2)
    travel_over_angle = expected["half track"] / (expected["pad over patch"] * expected["patch over wheel"])
    slope = expected["camber"] * travel_over_angle
    assert roll.rates[f"{axle}_roll_camber"].value == pytest.approx(slope, rel=1e-4)


def test_pads_are_free_in_the_plane(car: Model) -> None:
    held = hold_body(car)
    state = run(car, load_rig_test(BOUNCE)).steps[0].state
    outputs = dict(zip(held.output_names, state.orbit.outputs(64), strict=True))
    for name, values in outputs.items():
        if name.endswith(("patch_force_x", "patch_force_y")):
            assert not values.any()
        if name.endswith("patch_outward"):
            assert np.ptp(values) > 1e-3


def test_left_and_right_are_mirror_images(car: Model) -> None:
    test = replace(load_rig_test(BOUNCE), metrics=None, rates=())
    names = [
        n
        for n in hold_body(car).output_names
        if n.split("_", 2)[-1] in ("camber", "patch_outward", "patch_force_z")
    ]
    found = run(car, replace(test, metrics=tuple(names))).steps[0].state.orbit
    outputs = dict(zip(found.model.output_names, found.outputs(64), strict=True))
    for name in (each for each in names if "_left_" in each):
        assert outputs[name] == pytest.approx(outputs[name.replace("_left_", "_right_")], rel=1e-9, abs=1e-12)


def test_camber_is_the_lean_of_the_wheel_and_the_patch_moves_with_it(car: Model) -> None:
    """Exact at any travel: patch and wheel centre stay as far from the pivot as they are."""
    state = run(car, load_rig_test(BOUNCE)).steps[0].state
    outputs = dict(zip(state.orbit.model.output_names, state.orbit.outputs(64), strict=True))
    values = car.parameters.flat()
    pivot, centre, patch = (
        np.array([values[f"suspension.front.{point}.{axis}"] for axis in "yz"])
        for point in ("arm_pivot", "wheel_centre", "contact_patch")
    )
    angle = outputs["front_left_camber"]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = np.einsum("ijt,j->it", turn, patch - pivot) - (patch - pivot)[:, None]
    assert outputs["front_left_patch_outward"] == pytest.approx(-moved[0], abs=1e-12)
    rise = np.einsum("ijt,j->it", turn, centre - pivot)[1] - (centre - pivot)[1]
    assert outputs["front_left_wheel_travel"] == pytest.approx(rise, abs=1e-12)
    assert np.ptp(angle) > 0.05 / hypot(*(centre - pivot))


def test_the_error_of_a_rate_covers_a_finer_solution(car: Model) -> None:
    rough = run(car, replace(load_rig_test(BOUNCE), tolerance=1e-2)).steps[0].rates
    fine = run(car, replace(load_rig_test(BOUNCE), tolerance=1e-6)).steps[0].rates
    for name, rate in rough.items():
        assert abs(rate.value - fine[name].value) <= rate.error + fine[name].error


def test_a_held_vehicle_stays_as_it_is(car: Model) -> None:
    held = hold_body(car)
    assert hold_body(held) is held
    assert held.preloads == car.preloads


@pytest.mark.parametrize("vehicle", ["quarter_car", "half_car", "ride_model", "torsion_chain"])
def test_other_vehicles_are_refused(vehicle: str) -> None:
    with pytest.raises(
        ParameterError, match=f"{BOUNCE} test: vehicle: received a {vehicle}.*full_car or rigid_car"
    ):
        load_rig_test(BOUNCE).mounted(load_model(vehicle))
