"""From parameters and a mechanism to equations of motion and compiled functions."""

from chassym.derivation.body import Body, Input, Point
from chassym.derivation.characteristic import (
    Actuator,
    Characteristic,
    ForceLaw,
    Linear,
    Polynomial,
    Unilateral,
)
from chassym.derivation.compilation.compiled_function import BoundFunction, CompiledFunction
from chassym.derivation.compilation.expressions import UnsupportedExpressionError
from chassym.derivation.compilation.numeric import CompiledEquations
from chassym.derivation.compilation.point_function import PointFunction
from chassym.derivation.direction import Direction
from chassym.derivation.element import ElementAnswer, ForceElement
from chassym.derivation.energies import Energies
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.equilibrium import EquilibriumError
from chassym.derivation.errors import MechanismError
from chassym.derivation.from_sympy import from_bodies, from_lagrangian
from chassym.derivation.joint import (
    Coordinate,
    Joint,
    cylindrical,
    free,
    planar,
    prismatic,
    revolute,
    spherical,
    weld,
)
from chassym.derivation.lagrange import derive
from chassym.derivation.lagrangian import ExpressionOutput, Lagrangian
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.model import Model
from chassym.derivation.output import (
    AngularAcceleration,
    AngularVelocity,
    ContactForce,
    Deflection,
    DeflectionRate,
    ElementForce,
    Output,
    PointAcceleration,
    PointDisplacement,
    PointPosition,
    PointVelocity,
    UserOutput,
)
from chassym.derivation.parameters import Parameter, Parameters, load_parameters, parse_parameters
from chassym.derivation.port import (
    CombinedPort,
    JointPort,
    LineOfSightPort,
    Port,
    PrescribedPort,
    TravelPort,
)
from chassym.derivation.program import Program
from chassym.derivation.reading.glossary import Entry, glossary
from chassym.derivation.reading.lagrange_form import functions_of_time
from chassym.derivation.reading.latex import to_latex
from chassym.derivation.schema import ParameterDefinition, ParameterError, Schema
from chassym.derivation.singularity import Singularity
from chassym.derivation.system import System
from chassym.derivation.table import HELD, DamperTable, Knotted, SpringTable
from chassym.derivation.table_numbers import TableNumbers
from chassym.derivation.values import build_model
from chassym.derivation.variants import Variants, variants
from chassym.derivation.vehicles.library import load_model, vehicle_names
from chassym.derivation.vehicles.lifting_tyres import with_lifting_tyres

__all__ = [
    "Actuator",
    "AngularAcceleration",
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
    "DeflectionRate",
    "Direction",
    "ElementAnswer",
    "ElementForce",
    "Energies",
    "Entry",
    "EquationsOfMotion",
    "EquilibriumError",
    "ExpressionOutput",
    "ForceElement",
    "ForceLaw",
    "HELD",
    "Input",
    "Joint",
    "JointPort",
    "Knotted",
    "Lagrangian",
    "LineOfSightPort",
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
    "PointFunction",
    "PointPosition",
    "PointVelocity",
    "Polynomial",
    "Port",
    "PrescribedPort",
    "Program",
    "Schema",
    "Singularity",
    "SpringTable",
    "System",
    "TableNumbers",
    "TravelPort",
    "Unilateral",
    "UnsupportedExpressionError",
    "UserOutput",
    "Variants",
    "build_model",
    "cylindrical",
    "derive",
    "free",
    "from_bodies",
    "from_lagrangian",
    "functions_of_time",
    "glossary",
    "load_model",
    "load_parameters",
    "parse_parameters",
    "planar",
    "prismatic",
    "revolute",
    "spherical",
    "to_latex",
    "vehicle_names",
    "weld",
    "with_lifting_tyres",
    "variants",
]
