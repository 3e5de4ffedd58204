"""Tests of the rig as data: what its pads do, the vehicle on it, and what is read from the steady state."""

from chassym.nonlinear.rig.contact import PeriodicLossOfContact, contact_losses
from chassym.nonlinear.rig.held_body import hold_body
from chassym.nonlinear.rig.pads import CORNERS
from chassym.nonlinear.rig.reading import load_rig_test, rig_test_names
from chassym.nonlinear.rig.rig_test import Motion, Rate, RigTest
from chassym.nonlinear.rig.running import RigResult, RigStep, run
from chassym.nonlinear.rig.shortcuts import heave, lateral, vertical

__all__ = [
    "CORNERS",
    "Motion",
    "PeriodicLossOfContact",
    "Rate",
    "RigResult",
    "RigStep",
    "RigTest",
    "contact_losses",
    "heave",
    "hold_body",
    "lateral",
    "load_rig_test",
    "rig_test_names",
    "run",
    "vertical",
]
