"""From parameters and a mechanism to equations of motion and compiled functions."""

from chassym.derivation.body import Body, Input, Point
from chassym.derivation.characteristic import Characteristic, DamperTable, Linear, mean_slope
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.equilibrium import EquilibriumError
from chassym.derivation.joint import Coordinate, Joint, MechanismError, free, prismatic, revolute, weld
from chassym.derivation.lagrange import derive
from chassym.derivation.mechanism import ForceElement, Mechanism
from chassym.derivation.model import Model
from chassym.derivation.numeric import BoundFunction, CompiledEquations, CompiledFunction
from chassym.derivation.output import (
    AngularVelocity,
    ContactForce,
    Deflection,
    Output,
    PointAcceleration,
    PointDisplacement,
)
from chassym.derivation.parameters import Parameter, Parameters, load_parameters, parse_parameters
from chassym.derivation.port import CombinedPort, JointPort, Port, TravelPort
from chassym.derivation.program import Program
from chassym.derivation.schema import ParameterDefinition, ParameterError, Schema
from chassym.derivation.vehicles.library import load_model, vehicle_names

__all__ = [
    "AngularVelocity",
    "Body",
    "BoundFunction",
    "Characteristic",
    "CombinedPort",
    "CompiledEquations",
    "CompiledFunction",
    "ContactForce",
    "Coordinate",
    "DamperTable",
    "Deflection",
    "EquationsOfMotion",
    "EquilibriumError",
    "ForceElement",
    "Input",
    "Joint",
    "JointPort",
    "Linear",
    "Mechanism",
    "MechanismError",
    "Model",
    "Output",
    "Parameter",
    "ParameterDefinition",
    "ParameterError",
    "Parameters",
    "Point",
    "PointAcceleration",
    "PointDisplacement",
    "Port",
    "Program",
    "Schema",
    "TravelPort",
    "derive",
    "free",
    "load_model",
    "load_parameters",
    "mean_slope",
    "parse_parameters",
    "prismatic",
    "revolute",
    "vehicle_names",
    "weld",
]
