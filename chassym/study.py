"""The study of the reference car: all that its source reports, computed, beside what the source says."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version

import numpy as np

from chassym import comparison
from chassym.derivation import Model, ParameterError, Parameters, load_model
from chassym.heave import run_heave
from chassym.linear import damped_modes, linearise, undamped_modes
from chassym.rig_tests import TESTS, TestRecord, record
from chassym.study_results import EquationsSummary, StudyPlan, StudyResults
from chassym.variants import VariantRunner
from chassym.wheel_rate import WheelRate, measure_wheel_rates

__all__ = ["EquationsSummary", "Progress", "StudyPlan", "StudyResults", "run_study"]

MODEL = "full_car"
"""The model that the study is about."""

REFERENCE = "sedan"
"""The built-in vehicle with the parameters of the thesis."""

Progress = Callable[[str, float], None]
"""Told what is being done and what part of the study is done, 0 to 1."""


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


def run_study(
    model: Model, progress: Progress = ignore_progress, *, plan: StudyPlan | None = None
) -> StudyResults:
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
    results = _computed(model, plan, _Announcer(progress, plan.solutions))
    progress("done", 1.0)
    return results


def _computed(model: Model, plan: StudyPlan, announce: _Announcer) -> StudyResults:
    started = time.perf_counter()
    announce("equations of motion")
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
    front_rates = {loading: rates["front"] for loading, rates in wheel_rates.items()}
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
            *comparison.verification(torsion, front_rates, heave),
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
    """Natural frequencies (Hz) of a car's three body sections twisting without suspension; ascending."""
    values = parameters.flat()
    changes = {
        f"inertia.{section}": values[f"body.{section}.inertia.xx"] for section in ("front", "middle", "rear")
    }
    for joint in ("front", "rear"):
        changes[f"stiffness.{joint}"] = values[f"body.{joint}.torsional_stiffness"]
    chain = linearise(load_model("torsion_chain", changes))
    return tuple(float(frequency) for frequency in undamped_modes(chain).frequencies_hz)


def changed_parameters(parameters: Parameters) -> tuple[str, ...]:
    """Names of the parameters whose values differ from those of the reference sedan."""
    reference = load_model(REFERENCE).parameters
    return tuple(name for name, parameter in parameters.items() if parameter.value != reference[name].value)


def _check_model(model: Model) -> None:
    received = model.parameters.schema.model
    if received != MODEL:
        raise ParameterError(
            f"study: received a vehicle of model {received!r}, expected one of {MODEL!r}, such as {REFERENCE}"
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
