"""Three inertias on a shaft with two torsion springs: the body sections alone, free at both ends."""

from __future__ import annotations

from chassym.derivation.characteristic import Linear
from chassym.derivation.joint import revolute
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.output import AngularVelocity
from chassym.derivation.parameters import Parameters
from chassym.derivation.port import JointPort
from chassym.derivation.schema import NONNEGATIVE, POSITIVE, ParameterDefinition, Schema
from chassym.derivation.symbols import ParameterSymbols

SECTIONS = ("front", "middle", "rear")
JOINTS = ("front", "rear")

SCHEMA = Schema(
    "torsion_chain",
    (
        *(ParameterDefinition(f"inertia.{section}", "kg*m^2", POSITIVE) for section in SECTIONS),
        *(ParameterDefinition(f"stiffness.{joint}", "N*m/rad", NONNEGATIVE) for joint in JOINTS),
        *(ParameterDefinition(f"damping.{joint}", "N*m*s/rad", NONNEGATIVE) for joint in JOINTS),
    ),
)


def torsion_chain(parameters: Parameters) -> Mechanism:
    """The middle section turns freely; the end sections turn relative to it."""
    symbols = ParameterSymbols(parameters)
    chain = Mechanism("torsion_chain", gravity=0)
    origin = (0, 0, 0)
    shaft = revolute("roll", "x")
    middle = chain.add_body(
        "middle", chain.ground, shaft, origin, mass=0, inertia=(symbols("inertia.middle"), 0, 0)
    )
    chain.add_output(AngularVelocity("middle_roll_rate", middle, "x", chain.ground))
    for end in JOINTS:
        joint = revolute(f"{end}_torsion", "x")
        section = chain.add_body(end, middle, joint, origin, inertia=(symbols(f"inertia.{end}"), 0, 0))
        law = Linear(symbols(f"stiffness.{end}"), symbols(f"damping.{end}"))
        chain.add_force_element(f"{end}_shaft", JointPort(chain.coordinate(f"{end}_torsion")), law)
        chain.add_output(AngularVelocity(f"{end}_roll_rate", section, "x", chain.ground))
    return chain
