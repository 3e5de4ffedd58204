"""The compiled equations in motion: time simulation and the periodic steady state of harmonic tests."""

from chassym.nonlinear import rig
from chassym.nonlinear.chirp import LinearChirp, LogarithmicChirp
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation import Excitation, ExcitationError, Harmonic
from chassym.nonlinear.harmonic_steady_state import harmonic_steady_state
from chassym.nonlinear.loss_of_contact import LossOfContact
from chassym.nonlinear.measured_files import read_time_series
from chassym.nonlinear.metrics import Contact, Metric
from chassym.nonlinear.orbit import Orbit
from chassym.nonlinear.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.result import Statistics, SteadyState
from chassym.nonlinear.simulate import SimulationError, simulate
from chassym.nonlinear.simulation import Simulation
from chassym.nonlinear.steady_state import steady_state
from chassym.nonlinear.step import Step
from chassym.nonlinear.stepped_excitation import SteppedSine
from chassym.nonlinear.superposition import Superposition
from chassym.nonlinear.time_series import PeriodicTimeSeries, TimeSeries

__all__ = [
    "Contact",
    "Excitation",
    "ExcitationError",
    "Harmonic",
    "LinearChirp",
    "LogarithmicChirp",
    "LossOfContact",
    "Metric",
    "NoPeriodicOrbitError",
    "Orbit",
    "PeriodicOrbit",
    "PeriodicTimeSeries",
    "Simulation",
    "SimulationError",
    "Statistics",
    "SteadyState",
    "Step",
    "SteppedSine",
    "Superposition",
    "TimeSeries",
    "read_time_series",
    "harmonic_steady_state",
    "rig",
    "simulate",
    "steady_state",
]
