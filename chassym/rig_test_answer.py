"""The answer to a rig test: one JSON object, or tables that fit 80 columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from chassym.nonlinear import SteadyState
from chassym.nonlinear.rig import PeriodicLossOfContact, RigResult, RigStep
from chassym.tables import print_paragraph, print_table, with_error

METRICS_BESIDE = 3
"""Metrics of a stepped sine that fit beside each other."""

QUANTITIES = {"m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}

Labels = Mapping[str, str]
"""Names that metrics are answered under, by the name of the output."""


def as_data(result: RigResult, labels: Labels) -> dict[str, Any]:
    """The answer as one JSON object; a stepped sine has a list of steps."""
    if not result.test.is_stepped:
        return _conditions(result) | _step_as_data(result.steps[0], labels)
    return _conditions(result) | {
        "steps": [{"direction": step.direction} | _step_as_data(step, labels) for step in result.steps],
        "jumps": [
            {
                "direction": jump.direction,
                "frequency_hz": float(jump.value),
                "to_frequency_hz": float(jump.to_value),
                "output": jump.output,
                "from_amplitude": float(jump.from_amplitude),
                "to_amplitude": float(jump.to_amplitude),
                "unit": jump.unit,
                "cause": jump.cause,
            }
            for jump in result.jumps
        ],
        "coexisting_hz": list(result.coexisting_hz),
        "converged": all(step.state is not None for step in result.steps),
    }


def _conditions(result: RigResult) -> dict[str, Any]:
    return result.test.conditions | {"vehicle": result.model.parameters.schema.model}


def _step_as_data(step: RigStep, labels: Labels) -> dict[str, Any]:
    state = step.state
    if state is None:
        return {"frequency_hz": step.frequency_hz, "converged": False, "reason": step.reason}
    contact = state.contact
    found = {
        "frequency_hz": step.frequency_hz,
        "metrics": {
            labels[name]: {"peak_to_peak": metric.value, "unit": metric.unit, "error": metric.error}
            for name, metric in state.peak_to_peak.items()
            if name in labels
        },
        "minimum_patch_force": contact
        and {"value": contact.value, "unit": "N", "patch": contact.patch, "error": contact.error},
        "lost_contact": [
            {
                "patch": loss.patch,
                "in_the_air": loss.is_in_the_air,
                "share_of_period": loss.share,
                "intervals_s": [list(interval) for interval in loss.intervals_s],
            }
            for loss in step.contact_losses
        ],
        "converged": True,
        "stable": state.is_stable,
        "method": state.statistics.method,
        "unknowns": state.statistics.unknowns,
        "iterations": state.statistics.iterations,
    }
    if step.rates:
        found["rates"] = {
            name: {"value": rate.value, "unit": rate.unit, "error": rate.error}
            for name, rate in step.rates.items()
        }
    return found


def print_test(result: RigResult, labels: Labels) -> None:
    """The answer as tables, with a warning where no car would do this."""
    test, vehicle = result.test, _words(result.model.parameters.schema.model)
    unit = test.amplitude_unit
    size = f"{QUANTITIES[unit]} amplitude {test.amplitude:.4g} {unit}{test.peculiarities}"
    if test.is_stepped:
        first, last = test.frequencies_hz[0], test.frequencies_hz[-1]
        where = f"stepped from {first:g} to {last:g} Hz and back"
        print_paragraph(f"{_heading(test.name)} test of {vehicle}, {where}, {size}")
        print()
        _print_steps(result, labels)
    else:
        at = f"at {test.frequencies_hz[0]:.4g} Hz"
        print_paragraph(f"{_heading(test.name)} test of {vehicle} {at}, {size}, steady state")
        print()
        _print_step(result.steps[0], labels)


def _print_step(step: RigStep, labels: Labels) -> None:
    state = step.state
    assert state is not None, "a test of one frequency raises an error instead"
    rows = [
        (_words(labels[name]), _shown(metric.value, metric.error), metric.unit)
        for name, metric in state.peak_to_peak.items()
        if name in labels
    ]
    print_table(["", ">peak to peak", "unit"], rows)
    if step.rates:
        slopes = [(_words(n), _shown(r.value, r.error), _unit(r.unit)) for n, r in step.rates.items()]
        print_table(["slope", ">value", "unit"], slopes)
    if state.contact is not None:
        print_paragraph(f"Smallest patch force: {_force(state)}")
    for line in _contact_lines(step.contact_losses):
        print_paragraph(line, indent="  ")
    largest = abs(state.multipliers[0])
    steps = state.statistics.iterations
    took = f"{state.statistics.unknowns} unknowns, {steps} iteration{'' if steps == 1 else 's'}"
    print_paragraph(
        f"Found by {state.statistics.method}: {took}; largest Floquet multiplier: {_multiplier(largest)}"
    )
    if not state.is_stable:
        print_paragraph("WARNING: unstable: the vehicle would not settle into this motion.")


def _contact_lines(losses: Sequence[PeriodicLossOfContact]) -> Iterator[str]:
    """One line about bonded patches, whose pads pull, and one about tyres in the air."""
    pulled = [loss for loss in losses if not loss.is_in_the_air]
    lifted = [loss for loss in losses if loss.is_in_the_air]
    if pulled:
        told = "; ".join(
            f"{_place(loss)}for {_while(loss)}, down to {loss.smallest_force:.4g} N" for loss in pulled
        )
        yield f"WARNING: contact would have been lost {told}: a tyre cannot pull. --tyres lifting lets it go."
    if lifted:
        told = "; ".join(f"{loss.patch or 'tyre'} for {_while(loss)}" for loss in lifted)
        yield f"In the air: {told}."


def _stepped_contact_lines(steps: Sequence[RigStep]) -> Iterator[str]:
    """A line about the frequencies without contact and the worst of them."""
    found = [(step, loss) for step in steps for loss in step.contact_losses]
    if not found:
        return
    frequencies = sorted({step.frequency_hz for step, _ in found})
    step, worst = max(found, key=lambda each: each[1].share)
    between = f"at {len(frequencies)} frequencies from {frequencies[0]:.4g} to {frequencies[-1]:.4g} Hz"
    longest = f"longest at {step.frequency_hz:.4g} Hz, {_place(worst)}for {_while(worst)}"
    if worst.is_in_the_air:
        yield f"In the air {between}; {longest}."
    else:
        yield f"WARNING: contact would have been lost {between}; {longest}: a tyre cannot pull."


def _while(loss: PeriodicLossOfContact) -> str:
    """For how long, and when if that is one stretch of time."""
    length = f"{1e3 * loss.duration_s:.3g} ms, {100 * loss.share:.2g} % of the period"
    if len(loss.intervals_s) != 1 or loss.share == 1:
        return length
    begin, end = (360 * t / loss.period_s for t in loss.intervals_s[0])
    return f"{length}, phase {begin:.0f} to {end:.0f} degrees"


def _print_steps(result: RigResult, labels: Labels) -> None:
    upward, downward = (
        [step for step in result.steps if step.direction == direction] for direction in ("upward", "downward")
    )
    _print_frequencies(upward, labels)
    others = [step for step in downward if step.frequency_hz in result.coexisting_hz]
    if others:
        print_paragraph("Downward, where another motion is found than upward:")
        _print_frequencies(sorted(others, key=lambda step: step.frequency_hz), labels)
    for line in _stepped_contact_lines(result.steps):
        print_paragraph(line, indent="  ")
    for name, label in labels.items():
        print_paragraph(_largest(result.steps, name, label), indent="  ")
    for jump in result.jumps:
        change = f"from {jump.from_amplitude:.4g} to {jump.to_amplitude:.4g} {jump.unit}"
        where = f"between {jump.value:.4g} and {jump.to_value:.4g} Hz"
        amplitude = f"amplitude of {_words(labels.get(jump.output, jump.output))}"
        print_paragraph(f"Jump {jump.direction} {where}: {amplitude} {change}; {jump.cause}", indent="  ")
    if not result.jumps:
        print_paragraph("No jumps: upward and downward the same motions.")
    for step in result.steps:
        if step.state is None:
            print_paragraph(f"Not found, {step.direction}: {step.reason}", indent="  ")


def _print_frequencies(steps: Sequence[RigStep], labels: Labels) -> None:
    """Metrics over frequency, a few beside each other; contact and stability beside the first ones."""
    units = next((units_of(step.state) for step in steps if step.state is not None), {})
    names = [name for name in labels if name in units]
    for first in range(0, len(names), METRICS_BESIDE):
        chosen = names[first : first + METRICS_BESIDE]
        headings = [">Hz", *(f">{labels[n].replace('_', chr(10))}\n{units[n]}" for n in chosen)]
        rows = [[f"{step.frequency_hz:.4g}", *_values(step, chosen)] for step in steps]
        if first == 0 and any(_lowest(step) != "-" for step in steps):
            headings.append(">smallest\npatch force\nN")
            rows = [[*row, _lowest(step)] for row, step in zip(rows, steps, strict=True)]
        notes = [_note(step) for step in steps]
        if first == 0 and any(notes):
            headings.append("note")
            rows = [[*row, note] for row, note in zip(rows, notes, strict=True)]
        print_table(headings, rows)


def _values(step: RigStep, names: Sequence[str]) -> list[str]:
    return ["-" if step.state is None else f"{step.state.peak_to_peak[name].value:.4g}" for name in names]


def _lowest(step: RigStep) -> str:
    contact = None if step.state is None else step.state.contact
    return "-" if contact is None else f"{contact.value:.4g}"


def _note(step: RigStep) -> str:
    """What is wrong with a step, in few words."""
    if step.state is None:
        return "not found"
    lost = max((loss.share for loss in step.contact_losses), default=0.0)
    told = [f"no contact {100 * lost:.2g} %"] if lost else []
    return ", ".join([*told, *([] if step.state.is_stable else ["unstable"])])


def _largest(steps: Sequence[RigStep], name: str, label: str) -> str:
    found = [(step.state.peak_to_peak[name], step.frequency_hz) for step in steps if step.state is not None]
    if not found:
        return f"{_heading(label)}: no steady state found"
    metric, frequency = max(found, key=lambda each: each[0].value)
    worst = max(each.error / each.value for each, _ in found if each.value > 0)
    most = f"{_shown(metric.value, metric.error)} {metric.unit} at {frequency:.4g} Hz"
    return f"{_heading(label)}: largest {most}; errors up to {100 * worst:.2g} %"


def units_of(state: SteadyState | None) -> dict[str, str]:
    """Unit of every metric by the output's name."""
    return {} if state is None else {name: metric.unit for name, metric in state.peak_to_peak.items()}


def _force(state: SteadyState) -> str:
    assert state.contact is not None
    place = f" at {state.contact.patch}" if state.contact.patch else ""
    return f"{_shown(state.contact.value, state.contact.error)} N{place}"


def _multiplier(magnitude: float) -> str:
    """Its size, where it is not but rounding."""
    return "0" if magnitude < 1e-12 else f"{magnitude:.3g}"


def _place(loss: PeriodicLossOfContact) -> str:
    return f"at {loss.patch} " if loss.patch else ""


def _shown(value: float, error: float) -> str:
    """A value to the first digit of its error, yet with six significant digits at most.

    Examples
    --------
    >>> _shown(5.718268, 0.00019972), _shown(-2725.98743812, 8e-11)
    ('5.7183 ± 0.0002', '-2725.99 ± 8e-11')
    """
    if 0 < error < 1e-6 * abs(value):
        return f"{value:.6g} ± {error:.0e}"
    return with_error(value, error)


def _unit(unit: str) -> str:
    """A unit as it stands in a table: none for a plain number."""
    return "" if unit == "1" else unit


def _words(name: str) -> str:
    return name.replace("_", " ")


def _heading(name: str) -> str:
    words = _words(name)
    return words[:1].upper() + words[1:]
