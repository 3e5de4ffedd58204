"""From equations of motion to state space, modes, frequency response, sensitivities and ride metrics."""

from chassym.linear.control_objects import to_control_frequency_response
from chassym.linear.equivalent import linearise_for_motion
from chassym.linear.export import write_mat
from chassym.linear.frequency_response import FrequencyResponse, frequency_response, heave_response
from chassym.linear.input_conventions import (
    accelerations,
    displacements,
    displacements_and_rates,
    rates,
    rates_from_static_shape,
)
from chassym.linear.linear_model import LinearisationError, LinearModel, StateMatrices
from chassym.linear.linearisation import linearise
from chassym.linear.modal.modal_assurance import compare_modes, modal_assurance
from chassym.linear.modal.mode_tracking import track_modes, without_damping
from chassym.linear.modal.modes import (
    Mode,
    ModeKind,
    UndampedModes,
    damped_modes,
    energy_table,
    undamped_modes,
)
from chassym.linear.modal.motion import dissipation_shares, energy_shares, potential_shares
from chassym.linear.modal.participation import (
    input_output_participation,
    participation,
    participation_table,
)
from chassym.linear.modal.root_locus import parameter_root_locus, root_locus
from chassym.linear.operating_point import OperatingPoint, OperatingPointError, design_position, position
from chassym.linear.road.random_road import (
    RandomResponse,
    dynamic_load_coefficients,
    random_response,
    root_mean_squares,
)
from chassym.linear.road.ride_comfort import (
    SEAT_PITCH,
    SEAT_ROLL,
    SEAT_X,
    SEAT_Y,
    SEAT_YAW,
    SEAT_Z,
    RideComfort,
    ride_comfort,
)
from chassym.linear.road.road_contacts import Contact, Passage, road_contacts
from chassym.linear.road.road_profile import RoadProfile, sample_profile
from chassym.linear.road.road_surface import Road, iso_8608
from chassym.linear.singular_values import singular_values
from chassym.linear.slope_rule import (
    DescribingFunction,
    Secant,
    SlopeRule,
    SlopeRuleError,
    StatisticalSlope,
    find_slope_rule,
    left_slope,
    mean_slope,
    right_slope,
)
from chassym.linear.state_space import select_signals, to_control
from chassym.linear.statics.equilibrium import find_equilibrium, hold_position
from chassym.linear.symbolic import SymbolicStateSpace, symbolic_state_space
from chassym.linear.variation.metrics import (
    DampingRatio,
    Metric,
    NaturalFrequency,
    ResponseAmplitude,
    RoadVibration,
)
from chassym.linear.variation.sensitivity import Sensitivity, sensitivity
from chassym.linear.variation.sweep import DampedModes, Matrices, ModesLike, Quantity, Response, sweep
from chassym.linear.variation.tornado import Tornado, tornado
from chassym.linear.variation.variants import LinearVariants, linearise_variants

__all__ = [
    "Contact",
    "DampedModes",
    "DampingRatio",
    "DescribingFunction",
    "FrequencyResponse",
    "LinearModel",
    "LinearVariants",
    "LinearisationError",
    "Matrices",
    "Metric",
    "Mode",
    "ModeKind",
    "ModesLike",
    "NaturalFrequency",
    "OperatingPoint",
    "OperatingPointError",
    "Passage",
    "Quantity",
    "RandomResponse",
    "Response",
    "ResponseAmplitude",
    "RideComfort",
    "Road",
    "RoadProfile",
    "RoadVibration",
    "SEAT_PITCH",
    "SEAT_ROLL",
    "SEAT_X",
    "SEAT_Y",
    "SEAT_YAW",
    "SEAT_Z",
    "Secant",
    "Sensitivity",
    "SlopeRule",
    "SlopeRuleError",
    "StateMatrices",
    "StatisticalSlope",
    "SymbolicStateSpace",
    "Tornado",
    "UndampedModes",
    "accelerations",
    "compare_modes",
    "damped_modes",
    "design_position",
    "displacements",
    "displacements_and_rates",
    "dissipation_shares",
    "dynamic_load_coefficients",
    "energy_shares",
    "energy_table",
    "find_equilibrium",
    "find_slope_rule",
    "frequency_response",
    "heave_response",
    "hold_position",
    "input_output_participation",
    "iso_8608",
    "left_slope",
    "linearise",
    "linearise_for_motion",
    "linearise_variants",
    "mean_slope",
    "modal_assurance",
    "parameter_root_locus",
    "participation",
    "participation_table",
    "position",
    "potential_shares",
    "random_response",
    "rates",
    "rates_from_static_shape",
    "ride_comfort",
    "right_slope",
    "road_contacts",
    "root_locus",
    "root_mean_squares",
    "sample_profile",
    "select_signals",
    "sensitivity",
    "singular_values",
    "sweep",
    "symbolic_state_space",
    "to_control",
    "to_control_frequency_response",
    "tornado",
    "track_modes",
    "undamped_modes",
    "without_damping",
    "write_mat",
]
