"""A rig test as it is asked for on the command line: which inputs move, what is measured, and the answer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from chassym.arguments import ArgumentError

if TYPE_CHECKING:
    from chassym.derivation import Model
    from chassym.nonlinear import Harmonic, SteadyState

TESTS = ("lateral", "vertical", "heave")

AXES = {"ground": "", "body": "body_axes_"}
"""Prefixes of the names of what is measured along the axes of the ground and of the body."""


def find_excitation(name: str, model: Model, settings: Mapping[str, float]) -> Harmonic:
    """What the test does to the inputs of a model.

    Parameters
    ----------
    name
        One of `TESTS`.
    settings
        Those of ``frequency_hz``, ``amplitude_m`` and ``lag_s`` that are not the test's own.

    Raises
    ------
    ArgumentError
        If the model lacks the inputs that the test moves.
    """
    from chassym.nonlinear import rig

    moves = {"lateral": rig.lateral, "vertical": rig.vertical}
    if name in moves:
        excitation = moves[name](**settings)
    else:
        excitation = rig.heave(**settings, inputs=rig.heave_inputs(model) or rig.PADS)
    inputs = [each.name for each in model.system.inputs]
    if not set(excitation.amplitudes) <= set(inputs):
        vehicle = f"a {model.system.name}, whose inputs are {', '.join(inputs) or 'none'}"
        raise ArgumentError(f"{name} test", vehicle, f"a vehicle with {', '.join(excitation.amplitudes)}")
    return excitation


def find_metrics(model: Model, axes: str) -> dict[str, str]:
    """Names of the accelerations and rates along some `AXES`, by the name of the output.

    Raises
    ------
    ArgumentError
        If the model measures none along them.
    """
    from chassym.nonlinear.steady_state import measured_names

    measured: dict[str, dict[str, str]] = {}
    for name in measured_names(model):
        along = max(AXES, key=lambda each: len(AXES[each]) if name.startswith(AXES[each]) else -1)
        measured.setdefault(along, {})[name] = name.removeprefix(AXES[along])
    if axes not in measured:
        expected = (
            f"{' or '.join(measured) or 'another vehicle'}, as a {model.system.name} measures nothing else"
        )
        raise ArgumentError("--axes", repr(axes), expected)
    return measured[axes]


def as_data(name: str, metrics: Mapping[str, str], state: SteadyState) -> dict[str, Any]:
    """The answer as one JSON object; metrics under the names that they are given by their outputs."""
    contact = state.contact
    return {
        "test": name,
        "frequency_hz": state.orbit.excitation.frequency_hz,
        "metrics": {
            metrics[output]: {"peak_to_peak": metric.value, "unit": metric.unit, "error": metric.error}
            for output, metric in state.peak_to_peak.items()
        },
        "minimum_patch_force": contact
        and {"value": contact.value, "unit": "N", "patch": contact.patch, "error": contact.error},
        "converged": True,
        "stable": state.is_stable,
        "harmonics": state.harmonics,
    }


def print_test(name: str, metrics: Mapping[str, str], state: SteadyState) -> None:
    """The answer as a table, with a warning where no car would do this."""
    from chassym.tables import print_paragraph, print_table, with_error

    rows = [
        (metrics[output].replace("_", " "), with_error(metric.value, metric.error), metric.unit)
        for output, metric in state.peak_to_peak.items()
    ]
    vehicle, frequency = state.orbit.model.system.name, state.orbit.excitation.frequency_hz
    amplitude = max(abs(amplitude) for amplitude in state.orbit.excitation.amplitudes.values())
    print_paragraph(
        f"{name.capitalize()} test of {vehicle} at {frequency:g} Hz and {amplitude:.4g} m, steady state"
    )
    print_table(["", ">peak to peak", "unit"], rows)
    if state.contact is not None:
        force = with_error(state.contact.value, state.contact.error)
        place = f" at {state.contact.patch}" if state.contact.patch else ""
        print_paragraph(f"Smallest patch force: {force} N{place}")
        if not state.contact.is_kept:
            print_paragraph(f"WARNING: contact would have been lost{place}: a tyre cannot pull.")
    largest = abs(state.multipliers[0])
    print_paragraph(f"Harmonics: {state.harmonics}; largest Floquet multiplier: {largest:.3g}")
    if not state.is_stable:
        print_paragraph("WARNING: unstable: the vehicle would not settle into this motion.")
