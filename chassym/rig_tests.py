"""The lateral and the vertical rig test of a car: one steady state each, with what is read from it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from chassym.derivation import EquilibriumError, Model
from chassym.nonlinear import (
    Contact,
    Harmonic,
    Metric,
    NoPeriodicOrbitError,
    PeriodicOrbit,
    SteadyState,
    rig,
    steady_state,
)
from chassym.thesis import METRICS

FAILURES = (NoPeriodicOrbitError, EquilibriumError, np.linalg.LinAlgError)
"""What may stop one variant without stopping a study."""

SAMPLES = 720


@dataclass(frozen=True, eq=False)
class StudyTest:
    """A harmonic test and what is compared of it."""

    name: str
    excitation: Harmonic
    metrics: tuple[str, ...]


TESTS: Mapping[str, StudyTest] = {
    "lateral": StudyTest("lateral", rig.lateral(), METRICS["lateral"]),
    "vertical": StudyTest("vertical", rig.vertical(), METRICS["vertical"]),
}
"""The tests of Liu 2016, section 2.4, by name."""


@dataclass(frozen=True, eq=False)
class TestRecord:
    """The steady state of one test in full.

    Attributes
    ----------
    test
        Which one.
    metrics
        Peak-to-peak value of every acceleration and angular rate in ground and in body axes, by output.
    contact
        Smallest vertical patch force.
    unknowns
        Numbers that describe the orbit.
    largest_multiplier
        Magnitude of the largest Floquet multiplier: below 1 the orbit is stable.
    time_s
        Shape (samples + 1,): one period, both ends included.
    waveforms
        Every metric's signal over that time, by the output's name.
    orbit
        Where variants may start.
    """

    __test__ = False  # a name that starts so is no test of pytest's

    test: StudyTest
    metrics: Mapping[str, Metric]
    contact: Contact
    unknowns: int
    largest_multiplier: float
    time_s: np.ndarray
    waveforms: Mapping[str, np.ndarray]
    orbit: PeriodicOrbit = field(repr=False)


@dataclass(frozen=True)
class Outcome:
    """What one variant of the car does in one test: metrics, or the reason why there are none.

    Attributes
    ----------
    test
        Name of the test.
    metrics
        Peak-to-peak values by the output's name; empty if the solution failed.
    changes
        Their differences from the nominal ones, likewise.
    minimum_patch_force
        Smallest vertical patch force (N), nan if the solution failed.
    largest_multiplier
        Magnitude of the largest Floquet multiplier, nan if the solution failed.
    reason
        Why the solution failed; empty if it did not.
    """

    test: str
    metrics: Mapping[str, Metric]
    changes: Mapping[str, Metric]
    minimum_patch_force: float
    largest_multiplier: float
    reason: str = ""

    @property
    def is_sound(self) -> bool:
        """Whether the steady state is stable and every tyre stays on its pad."""
        return self.minimum_patch_force > 0 and self.largest_multiplier < 1


def record(model: Model, test: StudyTest, tolerance: float) -> TestRecord:
    """Run a test and keep everything.

    Raises
    ------
    NoPeriodicOrbitError
        If there is no steady state to be found.
    """
    state = steady_state(model, test.excitation, tolerance=tolerance)
    outputs = dict(zip(model.output_names, state.orbit.outputs(SAMPLES), strict=True))
    return TestRecord(
        test=test,
        metrics=state.peak_to_peak,
        contact=_contact(state),
        unknowns=state.statistics.unknowns,
        largest_multiplier=float(np.abs(state.multipliers[0])),
        time_s=np.linspace(0.0, test.excitation.period_s, SAMPLES + 1),
        waveforms={name: np.append(outputs[name], outputs[name][0]) for name in state.peak_to_peak},
        orbit=state.orbit,
    )


def outcome(
    model: Model, nominal: TestRecord, tolerance: float, starts: Sequence[PeriodicOrbit]
) -> tuple[Outcome, PeriodicOrbit | None]:
    """Run a test on a variant of the nominal car, from neighbouring orbits in their order and then from rest.

    Returns what it does, or why it failed, and its orbit.
    """
    test, reason = nominal.test, ""
    for start in (*starts, None):
        try:
            state = steady_state(
                model, test.excitation, metrics=test.metrics, tolerance=tolerance, start=start
            )
        except FAILURES as failure:
            reason = str(failure)
            continue
        found = state.peak_to_peak
        changes = {name: change(metric, nominal.metrics[name]) for name, metric in found.items()}
        multiplier = float(np.abs(state.multipliers[0]))
        return Outcome(test.name, found, changes, _contact(state).value, multiplier), state.orbit
    return Outcome(test.name, {}, {}, math.nan, math.nan, reason), None


def change(varied: Metric, nominal: Metric) -> Metric:
    """The difference between two metrics; its error is at most the sum of theirs."""
    return Metric(varied.value - nominal.value, nominal.unit, varied.error + nominal.error)


def _contact(state: SteadyState) -> Contact:
    if state.contact is None:
        raise ValueError(
            f"mechanism {state.orbit.model.system.name!r} has no contact patches; a full car is needed"
        )
    return state.contact
