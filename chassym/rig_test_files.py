"""The result of a rig test as a file: a table, or labelled arrays."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Sequence
from pathlib import Path

from chassym.derivation.files import replace_file
from chassym.nonlinear.rig import RigResult, RigStep
from chassym.rig_test_answer import Labels, units_of

_CONTACT_HEADINGS = (
    "smallest patch force (N)",
    "patch",
    "longest time without contact (s)",
    "stable",
    "reason",
)


def write(result: RigResult, labels: Labels, file: Path) -> None:
    """Write a table to a ``.csv`` file, or labelled arrays to a ``.nc`` file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    if file.suffix == ".csv":
        replace_file(file, as_csv(result, labels).encode())
    else:
        replace_file(file, bytes(result.to_xarray().to_netcdf(engine="scipy")))


def as_csv(result: RigResult, labels: Labels) -> str:
    """One row for every step, a column for every number, each with its unit in brackets."""
    units = next((units_of(step.state) for step in result.steps if step.state is not None), {})
    names = [name for name in labels if name in units]
    rates = {name: rate.unit for step in result.steps for name, rate in step.rates.items()}
    both = [(labels[n], units[n]) for n in names] + list(rates.items())
    headings = itertools.chain.from_iterable((f"{n} ({u})", f"error of {n} ({u})") for n, u in both)
    rows = [["direction", "frequency (Hz)", *headings, *_CONTACT_HEADINGS]]
    rows += [_csv_row(step, names, list(rates)) for step in result.steps]
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue()


def _csv_row(step: RigStep, names: Sequence[str], rates: Sequence[str]) -> list[str]:
    place = [step.direction, repr(step.frequency_hz)]
    if step.state is None:
        return [*place, *[""] * (2 * (len(names) + len(rates)) + 4), step.reason]
    found = [step.state.peak_to_peak[name] for name in names] + [step.rates[name] for name in rates]
    numbers = itertools.chain.from_iterable((repr(each.value), repr(each.error)) for each in found)
    contact = step.state.contact
    force = ["", ""] if contact is None else [repr(contact.value), contact.patch]
    lost = max((loss.duration_s for loss in step.contact_losses), default=0.0)
    return [*place, *numbers, *force, repr(lost), "yes" if step.state.is_stable else "no", ""]
