"""The car of the reference thesis: three body sections in torsion on four swing arms, 12 degrees of freedom.

X points to the rear, Y to the passenger side (right), Z up; the origin is the centre of the front axle at
wheel-centre height. Source: Y. Liu, Investigation of Vehicle Body Stiffness Modification on Vehicle Ride
Comfort and Handling Using a Low-Order Vehicle Model, honors thesis, The Ohio State University, 2016, section
2.2.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy

from chassym.derivation.body import Body
from chassym.derivation.characteristic import DamperTable, Linear
from chassym.derivation.joint import free, revolute, weld
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import (
    AngularVelocity,
    ContactForce,
    Deflection,
    PointAcceleration,
    PointDisplacement,
)
from chassym.derivation.parameters import Parameters
from chassym.derivation.port import CombinedPort, JointPort, TravelPort
from chassym.derivation.schema import INCREASING, NONNEGATIVE, POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols

AXLES = ("front", "rear")
SIDES = {"left": 1, "right": -1}


def _definitions() -> tuple[ParameterDefinition, ...]:
    define = ParameterDefinition
    found = [define("gravity", "m/s^2", POSITIVE)]
    for section in ("front", "middle", "rear"):
        found += [define(f"body.{section}.mass", "kg", POSITIVE)]
        found += [define(f"body.{section}.inertia.{axes}", "kg*m^2", POSITIVE) for axes in ("xx", "yy", "zz")]
        found += [define(f"body.{section}.mass_centre.{axis}", "m") for axis in "xz"]
    for axle in AXLES:
        suspension = f"suspension.{axle}"
        found += [
            define(f"body.{axle}.torsion_axis.z", "m"),
            define(f"body.{axle}.torsional_stiffness", "N*m/rad", NONNEGATIVE),
            define(f"body.{axle}.stiffness_proportional_damping", "s", NONNEGATIVE),
            define(f"axle.{axle}.x", "m"),
            *(
                define(f"{suspension}.{place}.{axis}", "m")
                for place in ("arm_pivot", "wheel_centre", "contact_patch")
                for axis in "yz"
            ),
            define(f"{suspension}.spring.rate", "N/m", POSITIVE),
            define(f"{suspension}.spring.lever_ratio", "1", POSITIVE),
            define(f"{suspension}.damper.velocity", "m/s", INCREASING),
            define(f"{suspension}.damper.force", "N", same_length_as=f"{suspension}.damper.velocity"),
            define(f"{suspension}.damper.lever_ratio", "1", POSITIVE),
            define(f"{suspension}.anti_roll_bar.rate", "N/m", NONNEGATIVE),
            define(f"{suspension}.unsprung.mass", "kg", POSITIVE),
            *(
                define(f"{suspension}.unsprung.inertia.{axes}", "kg*m^2", POSITIVE)
                for axes in ("xx", "yy", "zz")
            ),
            *(define(f"tyre.{axle}.stiffness.{axis}", "N/m", NONNEGATIVE) for axis in "xyz"),
            *(define(f"tyre.{axle}.damping.{axis}", "N*s/m", NONNEGATIVE) for axis in "xyz"),
        ]
    return tuple(found)


SCHEMA = Schema(
    "full_car",
    _definitions(),
    inertias=(
        *(f"body.{section}.inertia" for section in ("front", "middle", "rear")),
        *(f"suspension.{axle}.unsprung.inertia" for axle in AXLES),
    ),
)


def full_car(parameters: Parameters) -> Mechanism:
    """The car on its four actuator pads, free in space."""
    symbols = ParameterSymbols(parameters)
    car = Mechanism("full_car", symbols("gravity"))
    middle = car.add_body(
        "middle_section",
        car.ground,
        free(),
        symbols.vector("body.middle.mass_centre", "xz"),
        mass=symbols("body.middle.mass"),
        inertia=[symbols(f"body.middle.inertia.{axes}") for axes in ("xx", "yy", "zz")],
    )
    sections = {axle: _end_section(car, symbols, middle, axle) for axle in AXLES}
    add_corners(car, symbols, sections)
    _measure_body(car, middle)
    return car


def kinematics_and_compliance_rig(parameters: Parameters) -> Mechanism:
    """The same suspension with the body held to the ground: 4 degrees of freedom.

    Set the tyres' longitudinal and lateral rates to zero for pads that are free in the plane.
    """
    symbols = ParameterSymbols(parameters)
    rig = Mechanism("kinematics_and_compliance_rig", symbols("gravity"))
    held = rig.add_body("body", rig.ground, weld(), (0, 0, 0))
    add_corners(rig, symbols, dict.fromkeys(AXLES, held))
    return rig


def _end_section(car: Mechanism, symbols: ParameterSymbols, middle: Body, axle: str) -> Body:
    """The front or rear third of the body, on a torsion spring about the body's X axis."""
    place = f"body.{axle}"
    joint = revolute(f"{axle}_torsion", "x")
    centre = symbols.vector(f"{place}.mass_centre", "xz")
    section = car.add_body(
        f"{axle}_section",
        middle,
        joint,
        (centre[0], 0, symbols(f"{place}.torsion_axis.z")),
        mass=symbols(f"{place}.mass"),
        mass_centre=centre,
        inertia=[symbols(f"{place}.inertia.{axes}") for axes in ("xx", "yy", "zz")],
    )
    stiffness = symbols(f"{place}.torsional_stiffness")
    torsion = Linear(stiffness, stiffness * symbols(f"{place}.stiffness_proportional_damping"))
    car.add_force_element(f"{axle}_body_torsion", JointPort(joint.steps[0].coordinate), torsion)
    return section


def add_corners(car: Mechanism, symbols: ParameterSymbols, sections: Mapping[str, Body]) -> None:
    """Four swing arms with springs, dampers, anti-roll bars and tyres, on the sections that carry them."""
    for axle in AXLES:
        travels = [_corner(car, symbols, sections[axle], axle, side) for side in SIDES]
        bar = CombinedPort(tuple(zip(travels, (1, -1), strict=True)))
        rate = symbols(f"suspension.{axle}.anti_roll_bar.rate")
        car.add_force_element(f"{axle}_anti_roll_bar", bar, Linear(rate))


def _corner(car: Mechanism, symbols: ParameterSymbols, section: Body, axle: str, side: str) -> TravelPort:
    """One wheel on its swing arm; returns the travel of the wheel centre in its body section."""
    corner, place = f"{axle}_{side}", f"suspension.{axle}"

    def hard_point(name: str) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
        y, z = symbols(f"{place}.{name}.y"), symbols(f"{place}.{name}.z")
        return symbols(f"axle.{axle}.x"), SIDES[side] * y, z

    arm = car.add_body(
        f"{corner}_arm",
        section,
        revolute(f"{corner}_arm_angle", "x"),
        hard_point("arm_pivot"),
        mass=symbols(f"{place}.unsprung.mass"),
        mass_centre=hard_point("wheel_centre"),
        inertia=[symbols(f"{place}.unsprung.inertia.{axes}") for axes in ("xx", "yy", "zz")],
    )
    centre = car.point(f"{corner}_wheel_centre", arm, hard_point("wheel_centre"))
    travel = TravelPort(centre, section, "z")
    wheel_rate = symbols(f"{place}.spring.rate") / symbols(f"{place}.spring.lever_ratio") ** 2
    car.add_force_element(f"{corner}_spring", travel, Linear(wheel_rate), preloaded=True)
    velocities, forces = symbols.table(f"{place}.damper.velocity"), symbols.table(f"{place}.damper.force")
    damper = DamperTable(velocities, forces, symbols(f"{place}.damper.lever_ratio") ** -2)
    car.add_force_element(f"{corner}_damper", travel, damper)
    patch = car.point(f"{corner}_contact_patch", arm, hard_point("contact_patch"))
    for axis in "xyz":
        pad = car.add_input(f"{corner}_pad_{axis}", "m")
        tyre = Linear(symbols(f"tyre.{axle}.stiffness.{axis}"), symbols(f"tyre.{axle}.damping.{axis}"))
        name = f"{corner}_tyre_{axis}"
        car.add_force_element(name, TravelPort(patch, car.ground, axis, pad), tyre, preloaded=axis == "z")
        car.add_output(ContactForce(f"{corner}_patch_force_{axis}", name))
    car.add_output(Deflection(f"{corner}_wheel_travel", travel))
    car.add_output(PointDisplacement(f"{corner}_wheel_displacement", centre, "z", car.ground))
    return travel


def _measure_body(car: Mechanism, middle: Body) -> None:
    """The sensors at the middle section's mass centre, in ground axes and in the body's own."""
    sensor = car.point("sensor", middle, middle.mass_centre)
    for prefix, frame in (("", car.ground), ("body_axes_", middle)):
        for axis, direction in zip("xyz", ("longitudinal", "lateral", "vertical"), strict=True):
            car.add_output(PointAcceleration(f"{prefix}{direction}_acceleration", sensor, axis, frame))
        for axis, rotation in zip("xyz", ("roll", "pitch", "yaw"), strict=True):
            car.add_output(AngularVelocity(f"{prefix}{rotation}_rate", middle, axis, frame))
    car.add_output(PointDisplacement("body_displacement", sensor, "z", car.ground))
