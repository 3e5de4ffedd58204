"""A sweep as it is asked for on the command line: what is varied, and the answer."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from chassym import arguments
from chassym.arguments import ArgumentError

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from chassym.derivation import Model
    from chassym.nonlinear.sweep.sampling import Points
    from chassym.nonlinear.sweep.sweep import Sweep

MOST_POINTS = 1_000_000
"""Most points of one sweep."""

MOST_SHOWN = 3
"""Most reasons, and most effects on a metric, that are printed."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_SPACED = re.compile(rf"\s*({_NUMBER})\s*:\s*({_NUMBER})\s*:\s*(\d+)(\s*log)?\b\s*(.*?)\s*")
_LISTED = re.compile(rf"\s*({_NUMBER}(?:\s*,\s*{_NUMBER})*)\s*(.*?)\s*")
_RANGE = re.compile(rf"\s*({_NUMBER})\s*:\s*({_NUMBER})(\s*log)?\b\s*(.*?)\s*")


def find_points(
    model: Model,
    varied: Sequence[str],
    change: str | None,
    hypercube: str | None,
    ranges: Sequence[str],
) -> Points:
    """Where to look, of exactly one of three ways to say it: a grid, one at a time, or a Latin hypercube.

    Raises
    ------
    ArgumentError, SamplingError, ParameterError
        If none or several are given, or something cannot be understood.
    """
    from chassym.nonlinear.sweep.sampling import grid, latin_hypercube, one_at_a_time

    ways = {
        "--vary": bool(varied),
        "--one-at-a-time": change is not None,
        "--latin-hypercube": hypercube is not None,
    }
    given = [name for name, is_given in ways.items() if is_given]
    if len(given) != 1:
        raise ArgumentError("sweep", " and ".join(given) or "nothing to vary", f"one of {', '.join(ways)}")
    if ranges and hypercube is None:
        raise ArgumentError("--range", repr(ranges[0]), "it with --latin-hypercube alone")
    if change is not None:
        return one_at_a_time(model, _share(change))
    if hypercube is None:
        axes = dict(_axis(model, text) for text in _once("--vary", varied))
        _check_count(math.prod(map(len, axes.values())))
        return grid(model, axes)
    count = _check_count(arguments.whole("--latin-hypercube", hypercube))
    found = [_range(model, text) for text in _once("--range", ranges)]
    if not found:
        raise ArgumentError("--latin-hypercube", hypercube, "a --range for every quantity beside it")
    logarithmic = [name for name, _, is_logarithmic in found if is_logarithmic]
    return latin_hypercube(model, count, {name: ends for name, ends, _ in found}, logarithmic=logarithmic)


def print_sweep(sweep: Sweep, results: xarray.Dataset) -> None:
    """Extremes of every metric, what each change does where one thing was changed at a time, and failures."""
    from chassym.tables import print_paragraph, print_table

    failed = results["reason"].values.ravel() != ""
    count = failed.size
    print_paragraph(f"Sweep of {sweep.model.system.name}: {count} points, {int(failed.sum())} failed")
    if not failed.all():
        print_table(["peak to peak", "unit", ">smallest", ">largest"], [*_extremes(sweep, results)])
        _print_soundness(results)
    if "factor" in results.coords and not failed.all():
        _print_effects(sweep, results)
    _print_failures(results)


def _extremes(sweep: Sweep, results: xarray.Dataset) -> list[tuple[str, str, str, str]]:
    names = [*sweep.measured, *(["minimum_patch_force"] if "minimum_patch_force" in results else [])]
    return [
        (
            name.replace("_", " "),
            results[name].attrs["units"],
            f"{float(results[name].min()):.5g}",
            f"{float(results[name].max()):.5g}",
        )
        for name in names
    ]


def _print_soundness(results: xarray.Dataset) -> None:
    from chassym.tables import print_paragraph

    count = results["reason"].size
    for name, is_bad, words in (
        ("minimum_patch_force", lambda x: x <= 0, "contact would have been lost: a tyre cannot pull"),
        ("largest_multiplier", lambda x: x >= 1, "unstable: the vehicle would not settle into this motion"),
    ):
        bad = int(is_bad(results[name].values).sum()) if name in results else 0
        if bad:
            print_paragraph(f"WARNING: {bad} of {count} points: {words}.")


def _print_effects(sweep: Sweep, results: xarray.Dataset) -> None:
    """The largest changes of every metric, relative to the nominal point, which is the first."""
    import numpy as np

    from chassym.tables import print_paragraph, print_table

    varied, factors = results["varied"].values, results["factor"].values
    rows = []
    for name in sweep.measured:
        values = results[name].values
        relative = values / values[0] - 1
        sizes = np.nan_to_num(np.abs(relative[1:]))
        for place in 1 + np.argsort(-sizes, kind="stable")[:MOST_SHOWN]:
            effect = f"{100 * relative[place]:+.3g} %"
            rows.append((name.replace("_", " "), f"{varied[place]} x {factors[place]:g}", effect))
    print_paragraph("Largest changes, one thing at a time:")
    print_table(["peak to peak", "changed", ">effect"], rows)


def _print_failures(results: xarray.Dataset) -> None:
    from collections import Counter

    from chassym.tables import print_paragraph

    reasons = Counter(reason for reason in results["reason"].values.ravel() if reason)
    for reason, count in reasons.most_common(MOST_SHOWN):
        print_paragraph(f"{count} failed: {reason}", indent="  ")
    left = reasons.total() - sum(count for _, count in reasons.most_common(MOST_SHOWN))
    if left:
        print_paragraph(f"{left} failed for other reasons; the variable `reason` has them all")


def _axis(model: Model, text: str) -> tuple[str, np.ndarray]:
    """Name and values of ``NAME=from:to:count unit``, at equal ratios with ``log`` after the count."""
    import numpy as np

    name, given = _assignment("--vary", text)
    spaced, listed = _SPACED.fullmatch(given), _LISTED.fullmatch(given)
    if spaced:
        low, high = (_si(model, name, "--vary", number, spaced[5]) for number in spaced.group(1, 2))
        count = _check_count(arguments.whole("--vary", spaced[3]))
        _check_frequencies("--vary", text, (low, high))
        if spaced[4] and not (low > 0 and high > 0):
            raise ArgumentError("--vary", repr(text), "ends above zero for log")
        return name, np.geomspace(low, high, count) if spaced[4] else np.linspace(low, high, count)
    if listed:
        values = [_si(model, name, "--vary", each, listed[2]) for each in listed[1].split(",")]
        _check_frequencies("--vary", text, values)
        return name, np.array(values)
    expected = "NAME=from:to:count or NAME=a,b,c, with a unit after it or in SI, and log after the count"
    raise ArgumentError("--vary", repr(text), expected)


def _range(model: Model, text: str) -> tuple[str, tuple[float, float], bool]:
    """Name and ends of ``NAME=lowest:highest unit``, and whether its logarithm is spread evenly."""
    name, given = _assignment("--range", text)
    match = _RANGE.fullmatch(given)
    if not match:
        raise ArgumentError("--range", repr(text), "NAME=lowest:highest, with a unit after it or in SI")
    low, high = (_si(model, name, "--range", number, match[4]) for number in match.group(1, 2))
    if not low < high:
        raise ArgumentError("--range", repr(text), "two increasing numbers")
    _check_frequencies("--range", text, (low, high))
    if match[3] and low <= 0:
        raise ArgumentError("--range", repr(text), "ends above zero for log")
    return name, (low, high), bool(match[3])


def _check_frequencies(option: str, text: str, values: Sequence[float]) -> None:
    """Refuse frequencies of the excitation at which nothing moves, before each becomes a point that fails."""
    names = text.partition("=")[0].split("+")
    if "frequency_hz" in map(str.strip, names) and min(values) <= 0:
        raise ArgumentError(option, repr(text), "frequencies above zero")


def _si(model: Model, name: str, option: str, number: str, unit: str) -> float:
    """A number in the SI unit of what it is for; of a parameter, % is relative to its nominal value."""
    from chassym.derivation.quantity import parse_quantity
    from chassym.derivation.schema import ParameterDefinition
    from chassym.nonlinear.sweep.sampling import unit_of

    if unit != "%":
        definition = ParameterDefinition(name, unit_of(model, name))
        value = parse_quantity(definition, f"{number} {unit}".strip(), option)
        assert isinstance(value, float)
        return value
    nominal = {model.parameters.flat().get(part.strip(), 1.0) for part in name.split("+")}
    if len(nominal) > 1:
        raise ArgumentError(option, f"{number} % of {name}", "numbers, as their nominal values differ")
    return float(number) / 100 * nominal.pop()


def _assignment(option: str, text: str) -> tuple[str, str]:
    name, is_given, value = text.partition("=")
    if not (is_given and name.strip() and value.strip()):
        raise ArgumentError(option, repr(text), "NAME=VALUES")
    return name.strip(), value


def _once(option: str, texts: Sequence[str]) -> Sequence[str]:
    names = [text.partition("=")[0].strip() for text in texts]
    for name in names:
        if names.count(name) > 1:
            raise ArgumentError(option, f"{name} twice", "all its values in one")
    return texts


def _share(text: str) -> float:
    """A part of 1, neither none nor all of it, from text such as ``25%`` or ``0.25``."""
    number = text.strip().removesuffix("%")
    if not re.fullmatch(rf"\s*{_NUMBER}\s*", number):
        raise ArgumentError("--one-at-a-time", repr(text), "a share such as 25%")
    share = float(number) / (100 if "%" in text else 1)
    if not 0 < share < 1:
        raise ArgumentError("--one-at-a-time", repr(text), "more than 0% and less than 100%")
    return share


def _check_count(count: int) -> int:
    if not 1 <= count <= MOST_POINTS:
        raise ArgumentError("sweep", f"{count} points", f"1 to {MOST_POINTS}")
    return count
