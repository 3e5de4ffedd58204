"""From a vehicle file to symbolic equations of motion, state space and nonlinear steady state.

>>> import chassym
>>> car = chassym.load_model("quarter_car")
>>> [round(mode.frequency_hz, 1) for mode in chassym.damped_modes(chassym.linearise(car))]
[1.1, 8.9]
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chassym.derivation import (
        Mechanism,
        Model,
        ParameterError,
        build_model,
        derive,
        from_bodies,
        from_lagrangian,
        load_model,
        vehicle_names,
    )
    from chassym.linear import (
        LinearModel,
        damped_modes,
        find_equilibrium,
        frequency_response,
        heave_response,
        linearise,
        to_control,
        undamped_modes,
        write_mat,
    )
    from chassym.nonlinear import Harmonic, Simulation, SteadyState, rig, simulate, steady_state

__all__ = [
    "Harmonic",
    "LinearModel",
    "Mechanism",
    "Model",
    "ParameterError",
    "Simulation",
    "SteadyState",
    "build_model",
    "damped_modes",
    "derive",
    "find_equilibrium",
    "frequency_response",
    "from_bodies",
    "from_lagrangian",
    "heave_response",
    "linearise",
    "load_model",
    "rig",
    "simulate",
    "steady_state",
    "to_control",
    "undamped_modes",
    "vehicle_names",
    "write_mat",
]

_STAGES = ("chassym.derivation", "chassym.linear", "chassym.nonlinear")


def __getattr__(name: str) -> object:
    """Import a stage when one of its names is first used: the command line's help needs none of them."""
    if name in __all__:
        for stage in map(import_module, _STAGES):
            if name in stage.__all__:
                return getattr(stage, name)
    raise AttributeError(f"module 'chassym' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
