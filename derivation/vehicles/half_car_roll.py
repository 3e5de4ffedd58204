"""Half car seen from behind: bounce and roll of the body on two wheels, 4 degrees of freedom.

With the forces F of the suspensions, see `sliding_wheels`, half the track b, roll lifting the right side, and
small angles,

    m z''      = F_l + F_r
    I roll''   = b (F_r - F_l)
    m_w z_l''  = - F_l - k_t (z_l - u_l) - c_t (z_l' - u_l'),      z_r alike.

Source: R. N. Jazar, Vehicle Dynamics: Theory and Application, chapter "Vehicle Vibrations", half car; there
the anti-roll bar is a torsion spring that the body's roll twists against the wheels', k_R = 4 b^2 k_bar.
"""

from __future__ import annotations

from chassym.derivation.joint import prismatic, revolute
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import AngularVelocity, PointAcceleration, PointDisplacement
from chassym.derivation.parameters import Parameters
from chassym.derivation.schema import POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.sliding_wheels import add_axle, axle_definitions

SCHEMA = Schema(
    "half_car_roll",
    (
        ParameterDefinition("gravity", "m/s^2", POSITIVE),
        ParameterDefinition("body.mass", "kg", POSITIVE),
        ParameterDefinition("body.inertia.xx", "kg*m^2", POSITIVE),
        *axle_definitions(),
    ),
)


def half_car_roll(parameters: Parameters) -> Mechanism:
    """The body rises and rolls about its mass centre; the wheels slide along the ground's vertical axis."""
    symbols = ParameterSymbols(parameters)
    car = Mechanism("half_car_roll", symbols("gravity"))
    joint = prismatic("bounce", "z").then(revolute("roll", "x"))
    inertia = (symbols("body.inertia.xx"), 0, 0)
    body = car.add_body("body", car.ground, joint, (0, 0, 0), mass=symbols("body.mass"), inertia=inertia)
    add_axle(car, symbols, body)
    sensor = car.point("sensor", body, body.mass_centre)
    car.add_output(PointAcceleration("vertical_acceleration", sensor, "z", car.ground))
    car.add_output(PointDisplacement("body_displacement", sensor, "z", car.ground))
    car.add_output(AngularVelocity("roll_rate", body, "x", car.ground))
    return car
