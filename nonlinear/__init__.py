"""The compiled equations in motion: time simulation and the periodic steady state of harmonic tests."""

from chassym.nonlinear import rig
from chassym.nonlinear.continuation.backbone import Backbone, backbone
from chassym.nonlinear.continuation.branch import Branch, Fold
from chassym.nonlinear.continuation.continuation import first_orbit, follow
from chassym.nonlinear.continuation.paths import (
    ACCELERATION,
    DISPLACEMENT,
    VELOCITY,
    AmplitudePath,
    FrequencyPath,
    ParameterPath,
)
from chassym.nonlinear.continuation.stepped_sine import Jump, SteppedResponse, stepped_sine
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.chirp import LinearChirp, LogarithmicChirp
from chassym.nonlinear.excitation.excitation import Excitation, ExcitationError, Harmonic
from chassym.nonlinear.excitation.measured_files import read_time_series
from chassym.nonlinear.excitation.step import Step
from chassym.nonlinear.excitation.stepped_excitation import SteppedSine
from chassym.nonlinear.excitation.superposition import Superposition
from chassym.nonlinear.excitation.time_series import PeriodicTimeSeries, TimeSeries
from chassym.nonlinear.harmonics.subharmonics import subharmonic_orbit
from chassym.nonlinear.orbits.distortion import distortion
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.orbits.knots import knot_phases
from chassym.nonlinear.orbits.metrics import Contact, Metric
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit
from chassym.nonlinear.simulation.loss_of_contact import LossOfContact
from chassym.nonlinear.simulation.right_hand_side import RightHandSide
from chassym.nonlinear.simulation.simulate import SimulationError, simulate
from chassym.nonlinear.simulation.simulation import Simulation
from chassym.nonlinear.steady.harmonic_steady_state import harmonic_steady_state
from chassym.nonlinear.steady.result import Statistics, SteadyState
from chassym.nonlinear.steady.shooting import shooting_steady_state
from chassym.nonlinear.steady.steady_state import steady_state
from chassym.nonlinear.steady.waiting import waited_steady_state
from chassym.nonlinear.sweep.sampling import (
    Points,
    SamplingError,
    grid,
    latin_hypercube,
    one_at_a_time,
    random_sample,
    table,
)
from chassym.nonlinear.sweep.store import StoreError
from chassym.nonlinear.sweep.sweep import Sweep, SweepProgress, run_sweep
from chassym.nonlinear.sweep.sweep_results import write_results
from chassym.nonlinear.sweep.workers import (
    WorkersError,
    in_this_process,
    on_dask,
    on_processes,
    usual_workers,
)

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
    "FourierOrbit",
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
    "SteppedResponse",
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
    "knot_phases",
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
