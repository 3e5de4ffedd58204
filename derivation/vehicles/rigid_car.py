"""The reference car with a rigid body: six degrees of freedom of the body, four of its swing arms.

The limit of the `full_car` as its torsion springs become stiff. Axes and suspension are those of that car.
"""

from __future__ import annotations

from chassym.derivation.joint import free
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.parameters import Parameters
from chassym.derivation.schema import POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.sensors import add_body_sensors
from chassym.derivation.vehicles.swing_arms import (
    AXLES,
    MOMENTS,
    UNSPRUNG_INERTIAS,
    add_axles,
    axle_definitions,
)

SCHEMA = Schema(
    "rigid_car",
    (
        ParameterDefinition("gravity", "m/s^2", POSITIVE),
        ParameterDefinition("body.mass", "kg", POSITIVE),
        *(ParameterDefinition(f"body.mass_centre.{axis}", "m") for axis in "xz"),
        *(ParameterDefinition(f"body.inertia.{moment}", "kg*m^2", POSITIVE) for moment in MOMENTS),
        ParameterDefinition("body.inertia.xz", "kg*m^2"),
        *(ParameterDefinition(f"sensor.{axis}", "m") for axis in "xz"),
        *(definition for axle in AXLES for definition in axle_definitions(axle)),
    ),
    inertias=("body.inertia", *UNSPRUNG_INERTIAS),
)


def rigid_car(parameters: Parameters) -> Mechanism:
    """The car on its four actuator pads, free in space; the sensor is the origin of the body's frame."""
    symbols = ParameterSymbols(parameters)
    car = Mechanism("rigid_car", symbols("gravity"))
    xx, yy, zz, xz = (symbols(f"body.inertia.{element}") for element in (*MOMENTS, "xz"))
    body = car.add_body(
        "body",
        car.ground,
        free(),
        symbols.vector("sensor", "xz"),
        mass=symbols("body.mass"),
        mass_centre=symbols.vector("body.mass_centre", "xz"),
        inertia=((xx, 0, xz), (0, yy, 0), (xz, 0, zz)),
    )
    add_axles(car, symbols, dict.fromkeys(AXLES, body))
    add_body_sensors(car, car.point("sensor", body, body.origin))
    return car
