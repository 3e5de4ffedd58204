"""From equations of motion to state space, modes and frequency response."""

from chassym.linear.export import write_mat
from chassym.linear.frequency_response import FrequencyResponse, frequency_response, heave_response
from chassym.linear.modes import Mode, UndampedModes, damped_modes, undamped_modes
from chassym.linear.motion import energy_shares
from chassym.linear.operating_point import OperatingPointError
from chassym.linear.state_space import (
    LinearisationError,
    LinearModel,
    StateMatrices,
    linearise,
    to_control,
)

__all__ = [
    "FrequencyResponse",
    "LinearModel",
    "LinearisationError",
    "Mode",
    "OperatingPointError",
    "StateMatrices",
    "UndampedModes",
    "damped_modes",
    "energy_shares",
    "frequency_response",
    "heave_response",
    "linearise",
    "to_control",
    "undamped_modes",
    "write_mat",
]
