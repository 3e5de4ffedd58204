"""The compiled equations in motion: time simulation and the periodic steady state of harmonic tests."""

from chassym.nonlinear import rig
from chassym.nonlinear.backbone import Backbone, backbone
from chassym.nonlinear.branch import Branch, Fold
from chassym.nonlinear.chirp import LinearChirp, LogarithmicChirp
from chassym.nonlinear.continuation import first_orbit, follow
from chassym.nonlinear.distortion import distortion
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation import Excitation, ExcitationError, Harmonic
from chassym.nonlinear.harmonic_steady_state import harmonic_steady_state
from chassym.nonlinear.loss_of_contact import LossOfContact
from chassym.nonlinear.measured_files import read_time_series
from chassym.nonlinear.metrics import Contact, Metric
from chassym.nonlinear.orbit import Orbit
from chassym.nonlinear.paths import (
    ACCELERATION,
    DISPLACEMENT,
    VELOCITY,
    AmplitudePath,
    FrequencyPath,
    ParameterPath,
)
from chassym.nonlinear.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.piecewise_orbit import PiecewiseOrbit
from chassym.nonlinear.result import Statistics, SteadyState
from chassym.nonlinear.right_hand_side import RightHandSide
from chassym.nonlinear.sampling import (
    Points,
    SamplingError,
    grid,
    latin_hypercube,
    one_at_a_time,
    random_sample,
    table,
)
from chassym.nonlinear.shooting import shooting_steady_state
from chassym.nonlinear.simulate import SimulationError, simulate
from chassym.nonlinear.simulation import Simulation
from chassym.nonlinear.steady_state import steady_state
from chassym.nonlinear.step import Step
from chassym.nonlinear.stepped_excitation import SteppedSine
from chassym.nonlinear.stepped_sine import Jump, stepped_sine
from chassym.nonlinear.store import StoreError
from chassym.nonlinear.subharmonics import subharmonic_orbit
from chassym.nonlinear.superposition import Superposition
from chassym.nonlinear.sweep import Sweep, SweepProgress, run_sweep
from chassym.nonlinear.sweep_results import write_results
from chassym.nonlinear.time_series import PeriodicTimeSeries, TimeSeries
from chassym.nonlinear.waiting import waited_steady_state
from chassym.nonlinear.workers import WorkersError, in_this_process, on_dask, on_processes, usual_workers

__all__ = [
    "ACCELERATION",
    "AmplitudePath",
    "Backbone",
    "Branch",
    "Contact",
    "DISPLACEMENT",
    "Excitation",
    "ExcitationError",
    "Fold",
    "FrequencyPath",
    "Harmonic",
    "Jump",
    "LinearChirp",
    "LogarithmicChirp",
    "LossOfContact",
    "Metric",
    "NoPeriodicOrbitError",
    "Orbit",
    "ParameterPath",
    "PeriodicOrbit",
    "PeriodicTimeSeries",
    "PiecewiseOrbit",
    "Points",
    "RightHandSide",
    "SamplingError",
    "Simulation",
    "SimulationError",
    "Statistics",
    "SteadyState",
    "Step",
    "SteppedSine",
    "StoreError",
    "Superposition",
    "Sweep",
    "SweepProgress",
    "TimeSeries",
    "VELOCITY",
    "WorkersError",
    "backbone",
    "distortion",
    "first_orbit",
    "follow",
    "grid",
    "harmonic_steady_state",
    "in_this_process",
    "latin_hypercube",
    "on_dask",
    "on_processes",
    "one_at_a_time",
    "random_sample",
    "read_time_series",
    "rig",
    "run_sweep",
    "shooting_steady_state",
    "simulate",
    "steady_state",
    "stepped_sine",
    "subharmonic_orbit",
    "table",
    "usual_workers",
    "waited_steady_state",
    "write_results",
]
