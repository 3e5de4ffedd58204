"""An axle of the classical ride models: two wheels that slide along the ground's vertical axis.

Wheel heights z are measured from the ground, as are those Z of the body above them, and every force is
vertical. With travels s = z - Z, a suspension pulls its wheel down and the body up with

    F_l = k s_l + c s_l' + k_bar (s_l - s_r),

and a tyre pulls its wheel to the road u with k_t (z - u) + c_t (z' - u').

The suspensions act level with the body's mass centre, so that the loads they carry at rest have no lever when
the body turns. Heights of mass centres therefore play no part.
"""

from __future__ import annotations

import sympy

from chassym.derivation.body import Body
from chassym.derivation.characteristic import Linear
from chassym.derivation.joint import prismatic
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import ContactForce, Deflection, PointDisplacement
from chassym.derivation.port import CombinedPort, Port, TravelPort
from chassym.derivation.schema import NONNEGATIVE, POSITIVE, ParameterDefinition
from chassym.derivation.symbols import ParameterSymbols

SIDES = {"left": -1, "right": 1}


def axle_definitions(axle: str = "") -> tuple[ParameterDefinition, ...]:
    """Parameters of one axle; without a name if there is only one."""
    return (
        ParameterDefinition(_name("axle", axle, "track"), "m", POSITIVE),
        ParameterDefinition(_name("suspension", axle, "spring.rate"), "N/m", POSITIVE),
        ParameterDefinition(_name("suspension", axle, "damper.coefficient"), "N*s/m", NONNEGATIVE),
        ParameterDefinition(_name("suspension", axle, "anti_roll_bar.rate"), "N/m", NONNEGATIVE),
        ParameterDefinition(_name("suspension", axle, "unsprung.mass"), "kg", POSITIVE),
        ParameterDefinition(_name("tyre", axle, "stiffness"), "N/m", POSITIVE),
        ParameterDefinition(_name("tyre", axle, "damping"), "N*s/m", NONNEGATIVE),
    )


def add_axle(
    car: Mechanism, symbols: ParameterSymbols, body: Body, x: sympy.Expr | float = 0, axle: str = ""
) -> None:
    """Two wheels with springs, dampers, an anti-roll bar and tyres on the road, at a distance x (m)."""
    left, right = (_add_wheel(car, symbols, body, x, axle, side) for side in SIDES)
    bar = CombinedPort(((left, 1), (right, -1)))
    rate = symbols(_name("suspension", axle, "anti_roll_bar.rate"))
    car.add_force_element("_".join(filter(None, (axle, "anti_roll_bar"))), bar, Linear(rate))


def _add_wheel(
    car: Mechanism, symbols: ParameterSymbols, body: Body, x: sympy.Expr | float, axle: str, side: str
) -> Port:
    """One wheel; returns its travel."""
    corner = "_".join(filter(None, (axle, side)))

    def value(group: str, rest: str) -> sympy.Symbol:
        return symbols(_name(group, axle, rest))

    place = (x, SIDES[side] * value("axle", "track") / 2, 0)
    joint = prismatic(f"{corner}_wheel_bounce", "z")
    mass = value("suspension", "unsprung.mass")
    wheel = car.add_body(f"{corner}_wheel", car.ground, joint, place, mass=mass)
    centre = car.point(f"{corner}_wheel_centre", wheel, place)
    seat = car.point(f"{corner}_spring_seat", body, place)
    height, body_height = (TravelPort(point, car.ground, "z") for point in (centre, seat))
    travel = CombinedPort(((height, 1), (body_height, -1)))
    suspension = Linear(value("suspension", "spring.rate"), value("suspension", "damper.coefficient"))
    car.add_force_element(f"{corner}_suspension", travel, suspension, preloaded=True)
    road = car.add_input(f"{corner}_road", "m")
    law = Linear(value("tyre", "stiffness"), value("tyre", "damping"))
    tyre = car.add_force_element(f"{corner}_tyre", height.less(road), law, preloaded=True)
    car.add_output(Deflection(f"{corner}_wheel_travel", travel))
    car.add_output(PointDisplacement(f"{corner}_wheel_displacement", centre, "z", car.ground))
    car.add_output(ContactForce(f"{corner}_patch_force_z", tyre))
    return travel


def _name(group: str, axle: str, rest: str) -> str:
    """``suspension.front.spring.rate``, or ``suspension.spring.rate`` where there is one axle."""
    return ".".join(filter(None, (group, axle, rest)))
