"""The kinematics and compliance rig: a car's suspension with the body held and the pads free in the plane.

The arms turn about the car's X axis, so the wheels do not steer: toe is zero whatever the travel, and camber
is the arm's angle. The pads' freedom is that of tyres without longitudinal and lateral stiffness.
"""

from __future__ import annotations

from dataclasses import replace

import sympy

from chassym.derivation import CompiledEquations, Mechanism, Model, PointDisplacement, UserOutput
from chassym.derivation.parameters import Parameters
from chassym.derivation.schema import refusal
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.full_car import kinematics_and_compliance_rig
from chassym.derivation.vehicles.swing_arms import AXLES, SIDES

KINDS = ("full_car", "rigid_car")
"""Models on the suspension that the rig holds."""


HELD = "kinematics_and_compliance_rig"
"""Name of the mechanism on the rig."""


def hold_body(model: Model, test: str = "kinematics and compliance") -> Model:
    """The suspension of a car on the K&C rig, with the preloads that hold the car's design position.

    A vehicle on that rig already is left there.

    Raises
    ------
    ParameterError
        If the vehicle is none of `KINDS`; the message begins with the name of the test.
    """
    if model.system.name == HELD:
        return model
    kind = model.parameters.schema.model
    if kind not in KINDS:
        received = f"a {kind}, whose body cannot be held"
        raise refusal(f"{test} test", "vehicle", received, f"one of model {' or '.join(KINDS)}")
    preloads, parameters = model.preloads, _free_in_the_plane(model.parameters)
    return replace(
        model, parameters=parameters, compiled=CompiledEquations(_rig(parameters)), given_preloads=preloads
    )


def _free_in_the_plane(parameters: Parameters) -> Parameters:
    planar = [name for name in parameters if name.startswith("tyre.") and name.endswith((".x", ".y"))]
    return parameters.replace(dict.fromkeys(planar, 0.0), origin="pads free in the plane")


def _rig(parameters: Parameters) -> Mechanism:
    rig, symbols = kinematics_and_compliance_rig(parameters), ParameterSymbols(parameters)
    for axle in AXLES:
        for side in SIDES:
            _add_wheel_outputs(rig, symbols, axle, side)
        _add_axle_outputs(rig, symbols, axle)
    return rig


def _add_wheel_outputs(rig: Mechanism, symbols: ParameterSymbols, axle: str, side: str) -> None:
    """Pad displacement, camber (its top leaning outward is positive) and way of the patch outward."""
    corner, left = f"{axle}_{side}", SIDES[side]
    pad = next(each for each in rig.inputs if each.name == f"{corner}_pad_z")
    angle = rig.coordinate(f"{corner}_arm_angle").position
    rig.add_output(UserOutput(f"{corner}_pad_displacement", "m", pad.position))
    rig.add_output(UserOutput(f"{corner}_camber", "rad", left * angle))
    arm = next(body for body in rig.bodies if body.name == f"{corner}_arm")
    y, z = (symbols(f"suspension.{axle}.contact_patch.{axis}") for axis in "yz")
    patch = rig.point(f"{corner}_patch", arm, (symbols(f"axle.{axle}.x"), left * y, z))
    rig.add_output(PointDisplacement(f"{corner}_patch_outward", patch, (0, -left, 0), rig.ground))


def _add_axle_outputs(rig: Mechanism, symbols: ParameterSymbols, axle: str) -> None:
    """Moment of the patch forces about the car's X axis, roll angles of the pads and of the wheels.

    Lever arms are those of the design position: half the track, to the left in the left wheel's y.
    """
    patch, wheel = (symbols(f"suspension.{axle}.{point}.y") for point in ("contact_patch", "wheel_centre"))
    wholes = {
        "roll_moment": ("N*m", "patch_force_z", patch),
        "roll_angle": ("rad", "pad_displacement", 1 / (2 * patch)),
        "suspension_roll_angle": ("rad", "wheel_travel", 1 / (2 * wheel)),
    }
    outputs = {output.name: output for output in rig.outputs}
    for name, (unit, signal, factor) in wholes.items():
        sides = {sympy.Symbol(side, real=True): outputs[f"{axle}_{side}_{signal}"] for side in SIDES}
        left, right = sides
        rig.add_output(UserOutput(f"{axle}_{name}", unit, factor * (left - right), sides))
