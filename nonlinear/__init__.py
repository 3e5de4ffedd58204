"""The compiled equations in motion: time simulation and the periodic steady state of harmonic tests."""

from chassym.nonlinear import rig
from chassym.nonlinear.excitation import ExcitationError, Harmonic
from chassym.nonlinear.harmonic_balance import NoPeriodicOrbitError
from chassym.nonlinear.metrics import Contact, Metric
from chassym.nonlinear.orbit import Orbit
from chassym.nonlinear.simulate import Simulation, SimulationError, simulate
from chassym.nonlinear.steady_state import SteadyState, steady_state

__all__ = [
    "Contact",
    "ExcitationError",
    "Harmonic",
    "Metric",
    "NoPeriodicOrbitError",
    "Orbit",
    "Simulation",
    "SimulationError",
    "SteadyState",
    "rig",
    "simulate",
    "steady_state",
]
