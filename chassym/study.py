"""The study of the reference car: everything its source reports, computed, with errors, beside what the source says."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version

import numpy as np

from chassym import comparison
from chassym.comparison import Comparison
from chassym.derivation import Model, ParameterError, Parameters, load_model
from chassym.heave import HeaveTest, run_heave
from chassym.linear import LinearModel, Mode, damped_modes, linearise, undamped_modes
from chassym.rig_tests import TESTS, TestRecord, record
from chassym.variants import FACTORS, GROUPS, PLACES, READINGS, Reread, Scaled, Stiffened, VariantRunner
from chassym.wheel_rate import WheelRate, measure_wheel_rates

MODEL = "full_car"
"""The model that the study is about."""

REFERENCE = "sedan"
"""The built-in vehicle with the parameters of the thesis."""

Progress = Callable[[str, float], None]
"""Told what is being done and what part of the study is done, 0 to 1."""


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
        found += [(f"{s.outcome.test} test, {s.group} times {s.factor:g}", s.outcome.reason) for s in self.sensitivity]
        stiffened = (*self.halved, *self.sweep)
        found += [
            (f"{s.outcome.test} test, {s.placement} body stiffness {s.stiffness:.4g} N m/rad", s.outcome.reason)
            for s in stiffened
        ]
        found += [(f"{r.outcome.test} test, {r.reading}", r.outcome.reason) for r in self.rereadings]
        return tuple((what, reason) for what, reason in found if reason)


def ignore_progress(what: str, fraction: float) -> None:
    """Progress for nobody."""


@dataclass
class _Announcer:
    """Turns what is being done into progress."""

    progress: Progress
    steps: int
    done: int = field(default=0)

    def __call__(self, what: str) -> None:
        self.progress(what, min(self.done / self.steps, 1.0))
        self.done += 1


def run_study(model: Model, progress: Progress = ignore_progress, *, plan: StudyPlan | None = None) -> StudyResults:
    """Run the study.

    A variant or frequency that cannot be solved is kept with the reason; the nominal car has to be solvable.

    Parameters
    ----------
    model
        A full car; the thesis is about the one with the parameters of the built-in sedan.
    progress
        Told what is being done and what part is done.
    plan
        How much to compute; the whole study by default.

    Raises
    ------
    ParameterError
        If the vehicle is of another model.
    NoPeriodicOrbitError
        If the nominal car has no steady state in one of the tests.
    OperatingPointError
        If its design position is not an equilibrium.
    """
    _check_model(model)
    plan = plan or StudyPlan()
    started = time.perf_counter()
    announce = _Announcer(progress, plan.solutions)
    announce("deriving the equations of motion")
    equations = summarise(model)
    announce("modes")
    linear = linearise(model)
    torsion = free_torsion_frequencies(model.parameters)
    wheel_rates = _wheel_rates(model, announce)
    heave = run_heave(model, linear, plan.heave_frequencies_hz, plan.heave_tolerance, announce)
    tests = _nominal_tests(model, plan, announce)
    runner = VariantRunner(model, tests, plan.tolerance, announce)
    sensitivity, halved = tuple(runner.scaled()), tuple(runner.halved())
    rereadings, sweep = tuple(runner.reread()), tuple(runner.sweep(plan.stiffnesses))
    progress("done", 1.0)
    return StudyResults(
        parameters=model.parameters,
        changed=changed_parameters(model.parameters),
        plan=plan,
        equations=equations,
        linear_description=linear.description,
        modes=damped_modes(linear),
        free_torsion_hz=torsion,
        wheel_rates=wheel_rates,
        heave=heave,
        tests=tests,
        sensitivity=sensitivity,
        halved=halved,
        sweep=sweep,
        rereadings=rereadings,
        comparisons=(
            *comparison.verification(torsion, {loading: rates["front"] for loading, rates in wheel_rates.items()}, heave),
            *comparison.nominal(tests),
            *comparison.sensitivities(tests, sensitivity),
            *comparison.trends(tests, halved),
            *comparison.sweep_spans(sweep),
        ),
        version=version("chassym"),
        created=datetime.now(UTC),
        duration_s=time.perf_counter() - started,
    )


def summarise(model: Model) -> EquationsSummary:
    """Size, speed and consistency of a car's equations of motion."""
    values = model.parameters.flat()
    sections = sum(values[f"body.{section}.mass"] for section in ("front", "middle", "rear"))
    wheels = sum(2 * values[f"suspension.{axle}.unsprung.mass"] for axle in ("front", "rear"))
    weight = values["gravity"] * (sections + wheels)
    return EquationsSummary(
        degrees_of_freedom=model.size,
        operations=model.equations.operations,
        derivation_s=model.equations.derivation_s,
        design_residual=float(np.abs(model.design_residual).max()) / weight,
        weight=weight,
    )


def free_torsion_frequencies(parameters: Parameters) -> tuple[float, ...]:
    """Natural frequencies (Hz) of a car's three body sections twisting freely, without suspension; ascending."""
    values = parameters.flat()
    changes = {f"inertia.{section}": values[f"body.{section}.inertia.xx"] for section in ("front", "middle", "rear")}
    for joint in ("front", "rear"):
        stiffness = values[f"body.{joint}.torsional_stiffness"]
        changes[f"stiffness.{joint}"] = stiffness
        changes[f"damping.{joint}"] = stiffness * values[f"body.{joint}.stiffness_proportional_damping"]
    chain: LinearModel = linearise(load_model("torsion_chain", changes))
    return tuple(float(frequency) for frequency in undamped_modes(chain).frequencies_hz)


def changed_parameters(parameters: Parameters) -> tuple[str, ...]:
    """Names of the parameters whose values differ from those of the reference sedan."""
    reference = load_model(REFERENCE).parameters
    return tuple(name for name, parameter in parameters.items() if parameter.value != reference[name].value)


def _check_model(model: Model) -> None:
    received = model.parameters.schema.model
    if received != MODEL:
        raise ParameterError(
            f"study: received a vehicle of the model {received!r}, expected one of {MODEL!r} such as {REFERENCE!r}"
        )


def _wheel_rates(model: Model, announce: _Announcer) -> dict[str, dict[str, WheelRate]]:
    found = {}
    for loading, static in (("with the static load", True), ("without the static load", False)):
        announce(f"wheel rates {loading}")
        found[loading] = measure_wheel_rates(model, static_load=static)
    return found


def _nominal_tests(model: Model, plan: StudyPlan, announce: _Announcer) -> dict[str, TestRecord]:
    found = {}
    for name, test in TESTS.items():
        announce(f"{name} test")
        found[name] = record(model, test, plan.tolerance)
    return found
