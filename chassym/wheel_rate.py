"""The kinematics and compliance test: vertical patch force against wheel travel with the body held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chassym.derivation import Model, Parameters
from chassym.derivation.vehicles.full_car import AXLES
from chassym.nonlinear import SteadyState, rig, steady_state

FREQUENCY_HZ = 0.1 / (2 * np.pi)
"""0.1 rad/s, slow enough for a static curve. Source: Liu 2016, section 2.3."""

AMPLITUDE_M = 0.05
SAMPLES = 512

WEIGHTLESS = 1e-9
"""Gravity (m/s^2) of the test without static loads: parameters demand a positive one."""


class WheelRateError(ValueError):
    """A suspension on which a wheel rate cannot be measured."""


@dataclass(frozen=True, eq=False)
class WheelRate:
    """Force against travel of one right wheel over one slow cycle.

    Attributes
    ----------
    wheel
        Its corner.
    travel
        Jounce (m), shape (samples,).
    force
        Vertical patch force (N), shape (samples,).
    slope
        Of the regression line (N/m).
    offset
        Force of the regression line at no travel (N).
    error
        Of the slope, from that of the force (N/m).
    closed_form
        Tangent at the design position, see `closed_form` (N/m).
    spring_rate
        Rate of the spring at the wheel centre (N/m).
    """

    wheel: str
    travel: np.ndarray
    force: np.ndarray
    slope: float
    offset: float
    error: float
    closed_form: float
    spring_rate: float

    @property
    def load_stiffness(self) -> float:
        """The part of the closed form that the static load makes on the inclined arm (N/m)."""
        return self.closed_form - self.spring_rate


def measure_wheel_rates(
    model: Model, *, static_load: bool = True, amplitude_m: float = AMPLITUDE_M
) -> dict[str, WheelRate]:
    """Move all pads up and down in phase, free in the plane; a result for the right wheel of each axle.

    Parameters
    ----------
    model
        A full car. Its preloads hold the design position.
    static_load
        Whether the wheels carry the car's weight. Without it, what is left is the rate of the springs.
    amplitude_m
        Of the pads (m).
    """
    held = rig.hold_body(model if static_load else _weightless(model))
    travels = [f"{axle}_right_wheel_travel" for axle in AXLES]
    state = steady_state(held, rig.heave(FREQUENCY_HZ, amplitude_m), metrics=travels)
    return {axle: _read(held, state, axle) for axle in AXLES}


def _read(held: Model, state: SteadyState, axle: str) -> WheelRate:
    """The curve of one axle's right wheel and its regression line."""
    outputs = dict(zip(held.output_names, state.orbit.outputs(SAMPLES), strict=True))
    travel, force = outputs[f"{axle}_right_wheel_travel"], outputs[f"{axle}_right_patch_force_z"]
    swing = state.peak_to_peak[f"{axle}_right_wheel_travel"]
    if not swing.value > swing.error:
        raise WheelRateError(
            f"wheel rate: the {axle} wheels do not travel when their pads move; "
            f"suspension.{axle}.arm_pivot must lie beside suspension.{axle}.wheel_centre"
        )
    slope, offset = (float(number) for number in np.polyfit(travel, force, 1))
    force_error = state.contact.error if state.contact is not None else 0.0
    return WheelRate(
        wheel=f"{axle}_right",
        travel=travel,
        force=force,
        slope=slope,
        offset=offset,
        error=slope * (swing.error / swing.value + force_error / float(np.ptp(force))),
        closed_form=closed_form(held.parameters, axle, static_patch_force(held.preloads, axle)),
        spring_rate=spring_rate(held.parameters, axle),
    )


def spring_rate(parameters: Parameters, axle: str) -> float:
    """Rate of the spring at the wheel centre: its own over the lever ratio squared (N/m)."""
    values = parameters.flat()
    return values[f"suspension.{axle}.spring.rate"] / values[f"suspension.{axle}.spring.lever_ratio"] ** 2


def static_patch_force(preloads: Mapping[str, float], axle: str) -> float:
    """Vertical force under a wheel in the design position (N): the reaction to the tyre's preload."""
    return -preloads[f"{axle}_right_tyre_z.preload"]


def closed_form(parameters: Parameters, axle: str, static_force: float) -> float:
    """Slope of the vertical patch force over wheel travel at the design position, body held (N/m).

    With the wheel centre C at (a, b) and the patch P at (p, r) from the arm's pivot, in the plane across the
    car, moments about the pivot at arm angle phi give F = (k s + S) c / d: travel
    s = a sin phi + b cos phi - b, spring rate k, load S of preload and wheel weight at C, levers
    c = a cos phi - b sin phi and d = p cos phi - r sin phi. As F = F0 without travel, S = F0 p / a, and

        dF/ds = k a / p + F0 (a r - b p) / (p a^2).

    The second term is made by the static load: the patch lies below the wheel centre, and as the wheel rises
    the patch moves outwards by more, where a smaller force balances the same load.
    """
    values = parameters.flat()
    pivot, centre, patch = (
        np.array([values[f"suspension.{axle}.{point}.{axis}"] for axis in "yz"])
        for point in ("arm_pivot", "wheel_centre", "contact_patch")
    )
    (a, b), (p, r) = centre - pivot, patch - pivot
    return float(spring_rate(parameters, axle) * a / p + static_force * (a * r - b * p) / (p * a**2))


def _weightless(model: Model) -> Model:
    """The same vehicle without loads in its design position."""
    unloaded = dict.fromkeys(model.preloads, 0.0)
    return replace(model.with_parameters({"gravity": WEIGHTLESS}), given_preloads=unloaded)
