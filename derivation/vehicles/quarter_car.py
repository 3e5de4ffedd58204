"""Quarter car: a sprung and an unsprung mass above a moving road, 2 degrees of freedom.

With heights z of body and wheel above the static equilibrium, travel s = z_w - z, a damper's table f and the
road u,

    m z''     = F
    m_w z_w'' = - F - k_t (z_w - u) - c_t (z_w' - u'),      F = k s + f(s').
"""

from __future__ import annotations

from chassym.derivation.characteristic import Linear
from chassym.derivation.joint import prismatic
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import ContactForce, Deflection, PointAcceleration, PointDisplacement
from chassym.derivation.parameters import Parameters
from chassym.derivation.port import CombinedPort, TravelPort
from chassym.derivation.schema import INCREASING, NONNEGATIVE, POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.table import DamperTable

SCHEMA = Schema(
    "quarter_car",
    (
        ParameterDefinition("gravity", "m/s^2", POSITIVE),
        ParameterDefinition("sprung.mass", "kg", POSITIVE),
        ParameterDefinition("unsprung.mass", "kg", POSITIVE),
        ParameterDefinition("spring.rate", "N/m", POSITIVE),
        ParameterDefinition("damper.velocity", "m/s", INCREASING),
        ParameterDefinition("damper.force", "N", same_length_as="damper.velocity"),
        ParameterDefinition("tyre.stiffness", "N/m", POSITIVE),
        ParameterDefinition("tyre.damping", "N*s/m", NONNEGATIVE),
    ),
)


def quarter_car(parameters: Parameters) -> Mechanism:
    """Both masses slide vertically; their displacements are measured from the ground."""
    symbols = ParameterSymbols(parameters)
    car = Mechanism("quarter_car", symbols("gravity"))
    origin = (0, 0, 0)
    sprung = car.add_body(
        "sprung", car.ground, prismatic("body_bounce", "z"), origin, mass=symbols("sprung.mass")
    )
    unsprung = car.add_body(
        "unsprung", car.ground, prismatic("wheel_bounce", "z"), origin, mass=symbols("unsprung.mass")
    )
    body = car.point("body_point", sprung, origin)
    wheel = car.point("wheel_centre", unsprung, origin)
    heights = [TravelPort(point, car.ground, "z") for point in (wheel, body)]
    travel = CombinedPort(tuple(zip(heights, (1, -1), strict=True)))
    road = car.add_input("road", "m")
    car.add_force_element("spring", travel, Linear(symbols("spring.rate")), preloaded=True)
    table = DamperTable(symbols.table("damper.velocity"), symbols.table("damper.force"))
    car.add_force_element("damper", travel, table)
    law = Linear(symbols("tyre.stiffness"), symbols("tyre.damping"))
    tyre = car.add_force_element("tyre", heights[0].less(road), law, preloaded=True)
    car.add_output(PointAcceleration("vertical_acceleration", body, "z", car.ground))
    car.add_output(PointDisplacement("body_displacement", body, "z", car.ground))
    car.add_output(PointDisplacement("wheel_displacement", wheel, "z", car.ground))
    car.add_output(Deflection("wheel_travel", travel))
    car.add_output(ContactForce("patch_force_z", tyre))
    return car
