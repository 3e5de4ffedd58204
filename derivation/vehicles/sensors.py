"""Sensors on a car's body: accelerations and angular velocities, in the ground's axes and its own."""

from __future__ import annotations

from chassym.derivation.body import Point
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import AngularVelocity, PointAcceleration, PointDisplacement


def add_body_sensors(car: Mechanism, sensor: Point) -> None:
    """Sensors at a point of the body."""
    for prefix, axes in (("", car.ground), ("body_axes_", sensor.body)):
        for axis, direction in zip("xyz", ("longitudinal", "lateral", "vertical"), strict=True):
            car.add_output(PointAcceleration(f"{prefix}{direction}_acceleration", sensor, axis, axes))
        for axis, rotation in zip("xyz", ("roll", "pitch", "yaw"), strict=True):
            car.add_output(AngularVelocity(f"{prefix}{rotation}_rate", sensor.body, axis, axes))
    car.add_output(PointDisplacement("body_displacement", sensor, "z", car.ground))
