"""Half car in the vertical plane: bounce and pitch of the body on two wheels, 4 degrees of freedom.

The wheels slide along the body's vertical axis, by their travels s. With z_w = z - x pitch + s the height of
a wheel at x behind the mass centre and h below it, and small angles,

    m z''                        = sum F
    (I + sum m_w h^2) pitch''    = - sum x F + m g h pitch
    m_w z_w''                    = - F - k_t (z_w - u) - c_t (z_w' - u')      of each wheel,

with F = k s + c s'. In `ride_model` the wheels slide along the ground's vertical axis and h plays no part.
"""

from __future__ import annotations

from chassym.derivation.characteristic import Linear
from chassym.derivation.joint import prismatic, revolute
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import (
    AngularVelocity,
    ContactForce,
    Deflection,
    PointAcceleration,
    PointDisplacement,
)
from chassym.derivation.parameters import Parameters
from chassym.derivation.port import TravelPort
from chassym.derivation.schema import NONNEGATIVE, POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols

AXLES = ("front", "rear")

SCHEMA = Schema(
    "half_car",
    (
        ParameterDefinition("gravity", "m/s^2", POSITIVE),
        ParameterDefinition("body.mass", "kg", POSITIVE),
        ParameterDefinition("body.inertia.yy", "kg*m^2", POSITIVE),
        ParameterDefinition("body.mass_centre.x", "m"),
        ParameterDefinition("body.mass_centre.z", "m"),
        *(
            definition
            for axle in AXLES
            for definition in (
                ParameterDefinition(f"axle.{axle}.x", "m"),
                ParameterDefinition(f"axle.{axle}.mass", "kg", POSITIVE),
                ParameterDefinition(f"suspension.{axle}.spring.rate", "N/m", POSITIVE),
                ParameterDefinition(f"suspension.{axle}.damper.coefficient", "N*s/m", NONNEGATIVE),
                ParameterDefinition(f"tyre.{axle}.stiffness", "N/m", POSITIVE),
                ParameterDefinition(f"tyre.{axle}.damping", "N*s/m", NONNEGATIVE),
            )
        ),
    ),
)


def half_car(parameters: Parameters) -> Mechanism:
    """The body rises and pitches about its mass centre; each wheel slides along the body's vertical axis."""
    symbols = ParameterSymbols(parameters)
    car = Mechanism("half_car", symbols("gravity"))
    centre = symbols.vector("body.mass_centre", "xz")
    joint = prismatic("bounce", "z").then(revolute("pitch", "y"))
    inertia = (0, symbols("body.inertia.yy"), 0)
    body = car.add_body("body", car.ground, joint, centre, mass=symbols("body.mass"), inertia=inertia)
    for axle in AXLES:
        hub = (symbols(f"axle.{axle}.x"), 0, 0)
        mass = symbols(f"axle.{axle}.mass")
        wheel = car.add_body(f"{axle}_wheel", body, prismatic(f"{axle}_travel", "z"), hub, mass=mass)
        point = car.point(f"{axle}_wheel_centre", wheel, hub)
        travel = TravelPort(point, body, "z")
        place = f"suspension.{axle}"
        law = Linear(symbols(f"{place}.spring.rate"), symbols(f"{place}.damper.coefficient"))
        car.add_force_element(f"{axle}_suspension", travel, law, preloaded=True)
        road = car.add_input(f"{axle}_road", "m")
        tyre = Linear(symbols(f"tyre.{axle}.stiffness"), symbols(f"tyre.{axle}.damping"))
        height = TravelPort(point, car.ground, "z").less(road)
        element = car.add_force_element(f"{axle}_tyre", height, tyre, preloaded=True)
        car.add_output(Deflection(f"{axle}_wheel_travel", travel))
        car.add_output(ContactForce(f"{axle}_patch_force_z", element))
    sensor = car.point("sensor", body, centre)
    car.add_output(PointAcceleration("vertical_acceleration", sensor, "z", car.ground))
    car.add_output(PointDisplacement("body_displacement", sensor, "z", car.ground))
    car.add_output(AngularVelocity("pitch_rate", body, "y", car.ground))
    return car
