"""Four wheels on virtual swing arms, each with spring, damper, anti-roll bar and tyre on an actuator pad.

Every arm turns about the X axis through its instant centre, on the far side of the car, in the body section
that carries it. Spring and damper act along that section's vertical axis at the wheel centre.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy

from chassym.derivation.body import Body
from chassym.derivation.characteristic import Linear
from chassym.derivation.joint import revolute
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import ContactForce, Deflection, PointDisplacement
from chassym.derivation.port import CombinedPort, TravelPort
from chassym.derivation.schema import INCREASING, NONNEGATIVE, POSITIVE, ParameterDefinition
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.table import DamperTable

AXLES = ("front", "rear")
SIDES = {"left": 1, "right": -1}
MOMENTS = ("xx", "yy", "zz")

UNSPRUNG_INERTIAS = tuple(f"suspension.{axle}.unsprung.inertia" for axle in AXLES)


def axle_definitions(axle: str) -> list[ParameterDefinition]:
    """Parameters of one axle; hard points are those of the left wheel."""
    define, place = ParameterDefinition, f"suspension.{axle}"
    hard_points = ("arm_pivot", "wheel_centre", "contact_patch")
    return [
        define(f"axle.{axle}.x", "m"),
        *(define(f"{place}.{point}.{axis}", "m") for point in hard_points for axis in "yz"),
        define(f"{place}.spring.rate", "N/m", POSITIVE),
        define(f"{place}.spring.lever_ratio", "1", POSITIVE),
        define(f"{place}.damper.velocity", "m/s", INCREASING),
        define(f"{place}.damper.force", "N", same_length_as=f"{place}.damper.velocity"),
        define(f"{place}.damper.lever_ratio", "1", POSITIVE),
        define(f"{place}.anti_roll_bar.rate", "N/m", NONNEGATIVE),
        define(f"{place}.unsprung.mass", "kg", POSITIVE),
        *(define(f"{place}.unsprung.inertia.{moment}", "kg*m^2", POSITIVE) for moment in MOMENTS),
        *(define(f"tyre.{axle}.stiffness.{axis}", "N/m", NONNEGATIVE) for axis in "xyz"),
        *(define(f"tyre.{axle}.damping.{axis}", "N*s/m", NONNEGATIVE) for axis in "xyz"),
    ]


def add_axles(car: Mechanism, symbols: ParameterSymbols, carriers: Mapping[str, Body]) -> None:
    """Both axles, each on the body that carries it."""
    for axle in AXLES:
        travels = [_add_corner(car, symbols, carriers[axle], axle, side) for side in SIDES]
        bar = CombinedPort(tuple(zip(travels, (1, -1), strict=True)))
        rate = symbols(f"suspension.{axle}.anti_roll_bar.rate")
        car.add_force_element(f"{axle}_anti_roll_bar", bar, Linear(rate))


def _add_corner(car: Mechanism, symbols: ParameterSymbols, section: Body, axle: str, side: str) -> TravelPort:
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
        inertia=[symbols(f"{place}.unsprung.inertia.{moment}") for moment in MOMENTS],
    )
    centre = car.point(f"{corner}_wheel_centre", arm, hard_point("wheel_centre"))
    patch = car.point(f"{corner}_contact_patch", arm, hard_point("contact_patch"))
    travel = TravelPort(centre, section, "z")
    _add_spring_and_damper(car, symbols, travel, axle, corner)
    for axis in "xyz":
        pad = car.add_input(f"{corner}_pad_{axis}", "m")
        tyre = Linear(symbols(f"tyre.{axle}.stiffness.{axis}"), symbols(f"tyre.{axle}.damping.{axis}"))
        slip = TravelPort(patch, car.ground, axis).less(pad)
        element = car.add_force_element(f"{corner}_tyre_{axis}", slip, tyre, preloaded=axis == "z")
        car.add_output(ContactForce(f"{corner}_patch_force_{axis}", element))
    car.add_output(Deflection(f"{corner}_wheel_travel", travel))
    car.add_output(PointDisplacement(f"{corner}_wheel_displacement", centre, "z", car.ground))
    return travel


def _add_spring_and_damper(
    car: Mechanism, symbols: ParameterSymbols, travel: TravelPort, axle: str, corner: str
) -> None:
    """Both at the wheel centre; the lever ratio counts twice, once for the force and once for the travel."""
    place = f"suspension.{axle}"
    wheel_rate = symbols(f"{place}.spring.rate") / symbols(f"{place}.spring.lever_ratio") ** 2
    car.add_force_element(f"{corner}_spring", travel, Linear(wheel_rate), preloaded=True)
    velocities, forces = symbols.table(f"{place}.damper.velocity"), symbols.table(f"{place}.damper.force")
    damper = DamperTable(velocities, forces, symbols(f"{place}.damper.lever_ratio") ** -2)
    car.add_force_element(f"{corner}_damper", travel, damper)
