"""The classical ride model: bounce, pitch and roll of a rigid body on four wheels, 7 degrees of freedom.

Wheels slide along the ground's vertical axis, see `sliding_wheels` for the force F of a suspension. With x a
wheel's distance behind the mass centre, y to its right, and small angles,

    m z''          = sum F
    I_yy pitch''   = - sum x F
    I_xx roll''    = sum y F
    m_w z_w''      = - F - k_t (z_w - u) - c_t (z_w' - u')      of each wheel.

Source: R. N. Jazar, Vehicle Dynamics: Theory and Application, chapter "Vehicle Vibrations", full car.
"""

from __future__ import annotations

from chassym.derivation.joint import prismatic, revolute
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import AngularVelocity, PointAcceleration, PointDisplacement
from chassym.derivation.parameters import Parameters
from chassym.derivation.schema import POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.sliding_wheels import add_axle, axle_definitions

AXLES = ("front", "rear")

SCHEMA = Schema(
    "ride_model",
    (
        ParameterDefinition("gravity", "m/s^2", POSITIVE),
        ParameterDefinition("body.mass", "kg", POSITIVE),
        ParameterDefinition("body.mass_centre.x", "m"),
        ParameterDefinition("body.inertia.xx", "kg*m^2", POSITIVE),
        ParameterDefinition("body.inertia.yy", "kg*m^2", POSITIVE),
        *(
            definition
            for axle in AXLES
            for definition in (ParameterDefinition(f"axle.{axle}.x", "m"), *axle_definitions(axle))
        ),
    ),
)


def ride_model(parameters: Parameters) -> Mechanism:
    """The body rises, pitches and rolls about its mass centre.

    There is no yaw: the yaw inertia, which the axis of pitch would see as the body rolls, is taken equal to
    the pitch inertia. The mass matrix is then diagonal and constant at any angle.
    """
    symbols = ParameterSymbols(parameters)
    car = Mechanism("ride_model", symbols("gravity"))
    joint = prismatic("bounce", "z").then(revolute("pitch", "y")).then(revolute("roll", "x"))
    centre = symbols.vector("body.mass_centre", "x")
    roll, pitch = symbols("body.inertia.xx"), symbols("body.inertia.yy")
    mass, inertia = symbols("body.mass"), (roll, pitch, pitch)
    body = car.add_body("body", car.ground, joint, centre, mass=mass, inertia=inertia)
    for axle in AXLES:
        add_axle(car, symbols, body, symbols(f"axle.{axle}.x"), axle)
    sensor = car.point("sensor", body, centre)
    car.add_output(PointAcceleration("vertical_acceleration", sensor, "z", car.ground))
    car.add_output(PointDisplacement("body_displacement", sensor, "z", car.ground))
    for axis, rotation in zip("xy", ("roll", "pitch"), strict=True):
        car.add_output(AngularVelocity(f"{rotation}_rate", body, axis, car.ground))
    return car
