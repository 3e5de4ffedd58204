"""What a study is asked for and what it returns, as values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from chassym.comparison import Comparison
from chassym.derivation import Parameters
from chassym.heave import HeaveTest
from chassym.linear import Mode
from chassym.rig_tests import TESTS, TestRecord
from chassym.variants import FACTORS, GROUPS, PLACES, READINGS, Reread, Scaled, Stiffened
from chassym.wheel_rate import WheelRate


@dataclass(frozen=True)
class StudyPlan:
    """How much to compute and how accurately.

    Attributes
    ----------
    stiffnesses
        Body torsional stiffnesses of the sweeps (N m/rad).
    heave_frequencies_hz
        Of the stepped sine.
    tolerance
        Largest stated error of the metrics of the lateral and vertical tests, relative.
    heave_tolerance
        The same for the amplitudes of the heave test.
    """

    stiffnesses: tuple[float, ...] = tuple(float(value) for value in np.logspace(2, 9, 29))
    heave_frequencies_hz: tuple[float, ...] = tuple(0.5 * step for step in range(1, 31))
    tolerance: float = 1e-4
    heave_tolerance: float = 1e-3

    @property
    def solutions(self) -> int:
        """Steps that a study announces."""
        per_test = 1 + len(FACTORS) * len(GROUPS) + len(READINGS) + len(PLACES) * (1 + len(self.stiffnesses))
        return 4 + len(self.heave_frequencies_hz) + len(TESTS) * per_test


@dataclass(frozen=True)
class EquationsSummary:
    """The equations of motion and how well they hold the design position.

    Attributes
    ----------
    degrees_of_freedom
        Coordinates.
    operations
        Arithmetic operations by what they compute.
    derivation_s
        Time that the derivation took (s).
    design_residual
        Largest residual at rest in the design position, relative to the car's weight.
    weight
        Of the whole car (N).
    """

    degrees_of_freedom: int
    operations: Mapping[str, int]
    derivation_s: float
    design_residual: float
    weight: float


@dataclass(frozen=True, eq=False)
class StudyResults:
    """Everything that a study computed.

    Attributes
    ----------
    parameters
        Of the car.
    changed
        Names of the parameters that differ from those of the reference sedan.
    plan
        How much was computed.
    equations
        Size, speed and consistency of the equations of motion.
    linear_description
        What was linearised, with the slopes used at the knots of tables.
    modes
        Damped modes of the car on its tyres.
    free_torsion_hz
        Natural frequencies of the three body sections alone, the rigid one first.
    wheel_rates
        Of the axles, by how the test was loaded.
    heave
        The heave test.
    tests
        The nominal lateral and vertical tests, by name.
    sensitivity, halved, sweep, rereadings
        Variants of the car in both tests.
    comparisons
        The thesis beside what was computed.
    version
        Of chassym.
    created
        When the study was finished.
    duration_s
        How long it took (s).
    """

    parameters: Parameters
    changed: tuple[str, ...]
    plan: StudyPlan
    equations: EquationsSummary
    linear_description: str
    modes: tuple[Mode, ...]
    free_torsion_hz: tuple[float, ...]
    wheel_rates: Mapping[str, Mapping[str, WheelRate]]
    heave: HeaveTest
    tests: Mapping[str, TestRecord]
    sensitivity: tuple[Scaled, ...]
    halved: tuple[Stiffened, ...]
    sweep: tuple[Stiffened, ...]
    rereadings: tuple[Reread, ...]
    comparisons: tuple[Comparison, ...]
    version: str
    created: datetime
    duration_s: float

    @property
    def failures(self) -> tuple[tuple[str, str], ...]:
        """What could not be solved, and why."""
        found = [(f"heave test, {p.frequency_hz:g} Hz", p.reason) for p in self.heave.points]
        found += [
            (f"{s.outcome.test} test, {s.group} times {s.factor:g}", s.outcome.reason)
            for s in self.sensitivity
        ]
        stiffened = (*self.halved, *self.sweep)
        found += [
            (
                f"{s.outcome.test} test, {s.placement} body stiffness {s.stiffness:.4g} N m/rad",
                s.outcome.reason,
            )
            for s in stiffened
        ]
        found += [(f"{r.outcome.test} test, {r.reading}", r.outcome.reason) for r in self.rereadings]
        return tuple((what, reason) for what, reason in found if reason)
