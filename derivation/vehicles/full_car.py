"""The car of the reference thesis: body sections in torsion on four swing arms, 12 degrees of freedom.

X points to the rear, Y to the passenger side (right), Z up; the origin is the centre of the front axle at
wheel-centre height. Source: Y. Liu, Investigation of Vehicle Body Stiffness Modification on Vehicle Ride
Comfort and Handling Using a Low-Order Vehicle Model, honors thesis, The Ohio State University, 2016, section
2.2. More than three body sections are an extension, see `body_sections`.
"""

from __future__ import annotations

from chassym.derivation.body import Body
from chassym.derivation.characteristic import Linear
from chassym.derivation.joint import Joint, free, revolute, weld
from chassym.derivation.mechanism import Mechanism, Place
from chassym.derivation.parameters import Parameters
from chassym.derivation.port import CombinedPort, JointPort, Port
from chassym.derivation.quantity import shown
from chassym.derivation.schema import NONNEGATIVE, POSITIVE, ParameterDefinition, ParameterError, Schema
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.body_sections import PLACES, Section, SectionedBody
from chassym.derivation.vehicles.sensors import add_body_sensors
from chassym.derivation.vehicles.swing_arms import AXLES as AXLES
from chassym.derivation.vehicles.swing_arms import (
    MOMENTS,
    UNSPRUNG_INERTIAS,
    add_axles,
    axle_definitions,
)


def _definitions() -> tuple[ParameterDefinition, ...]:
    define = ParameterDefinition
    found = [define("gravity", "m/s^2", POSITIVE)]
    for place in PLACES:
        found += [define(f"body.{place}.mass", "kg", POSITIVE)]
        found += [define(f"body.{place}.inertia.{moment}", "kg*m^2", POSITIVE) for moment in MOMENTS]
        found += [define(f"body.{place}.mass_centre.{axis}", "m") for axis in "xz"]
    for axle in AXLES:
        found += [
            define(f"body.{axle}.torsion_axis.z", "m"),
            define(f"body.{axle}.torsional_stiffness", "N*m/rad", NONNEGATIVE),
            define(f"body.{axle}.stiffness_proportional_damping", "s", NONNEGATIVE),
            *axle_definitions(axle),
        ]
    return tuple(found)


SCHEMA = Schema(
    "full_car",
    _definitions(),
    inertias=(*(f"body.{place}.inertia" for place in PLACES), *UNSPRUNG_INERTIAS),
)

MOST_SECTIONS = 1000
"""Sections beyond which nobody waits for the equations."""


def full_car(parameters: Parameters, sections: int = 3) -> Mechanism:
    """The car on its four actuator pads, free in space.

    Parameters
    ----------
    parameters
        As `SCHEMA` declares them: of a body in three sections.
    sections
        Number of body sections n, three or more; the car has 9 + n degrees of freedom. If n is even, one
        spring spans the middle of the body, and one of the two torsional stiffnesses has to be positive.

    Raises
    ------
    ParameterError
        If there are fewer sections than three, or more than `MOST_SECTIONS`.
    """
    symbols = ParameterSymbols(parameters)
    car = Mechanism("full_car", symbols("gravity"))
    front, middle, rear = add_body_sections(car, symbols, sections)
    add_axles(car, symbols, {"front": front, "rear": rear})
    add_body_sensors(car, car.point("sensor", middle, middle.origin))
    return car


def kinematics_and_compliance_rig(parameters: Parameters) -> Mechanism:
    """The same suspension with the body held to the ground: 4 degrees of freedom.

    Set the tyres' longitudinal and lateral rates to zero for pads that are free in the plane.
    """
    symbols = ParameterSymbols(parameters)
    rig = Mechanism("kinematics_and_compliance_rig", symbols("gravity"))
    held = rig.add_body("body", rig.ground, weld(), (0, 0, 0))
    add_axles(rig, symbols, dict.fromkeys(AXLES, held))
    return rig


def add_body_sections(car: Mechanism, symbols: ParameterSymbols, count: int) -> tuple[Body, Body, Body]:
    """The body in sections; returns the front, the free and the rear one.

    The section at index count // 2 is free in space, its origin at the mass centre of the parameters' middle
    section. Every other one turns against it about the body's X axis: coordinates are the twists relative
    to the free section, not to the neighbour, so that the mass matrix couples no two of them.

    Raises
    ------
    ParameterError
        If there are fewer sections than three, or more than `MOST_SECTIONS`.
    """
    if not isinstance(count, int) or not 3 <= count <= MOST_SECTIONS:
        expected = f"a whole number from 3 to {MOST_SECTIONS}"
        raise ParameterError(f"sections: received {shown(count)}, expected {expected}")
    body, middle = SectionedBody(symbols, count), count // 2
    names = ["front", *(f"section_{i}" for i in range(2, count)), "rear"]
    sections = body.sections()
    centre = symbols.vector("body.middle.mass_centre", "xz")
    free_section = _add_section(car, "middle_section", sections[middle], car.ground, free(), centre)
    bodies, twists = [free_section] * count, {}
    for i in (i for i in range(count) if i != middle):
        name = f"{names[i]}_section" if names[i] in AXLES else names[i]
        twist, axis = f"{names[i]}_torsion", (sections[i].mass_centre[0], 0, sections[i].axis_height)
        bodies[i] = _add_section(car, name, sections[i], free_section, revolute(twist, "x"), axis)
        twists[i] = JointPort(car.coordinate(twist))
    for i, spring in enumerate(body.springs()):
        outer, inner = (i, i + 1) if i < middle else (i + 1, i)
        twist_of_spring = twists[outer] if inner == middle else _difference(twists[outer], twists[inner])
        law = Linear(spring.stiffness, spring.damping)
        car.add_force_element(f"{names[outer]}_body_torsion", twist_of_spring, law)
    return bodies[0], free_section, bodies[-1]


def _add_section(
    car: Mechanism, name: str, section: Section, parent: Body, joint: Joint, origin: Place
) -> Body:
    return car.add_body(
        name,
        parent,
        joint,
        origin,
        mass=section.mass,
        mass_centre=section.mass_centre,
        inertia=section.inertia,
    )


def _difference(first: Port, second: Port) -> Port:
    return CombinedPort(((first, 1), (second, -1)))
