"""A rig test as it is asked for on the command line: which one, with what changed, what is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from chassym import arguments
from chassym.arguments import ArgumentError

if TYPE_CHECKING:
    from chassym.derivation import Model
    from chassym.nonlinear.rig import RigTest

TESTS = (
    "lateral",
    "vertical",
    "heave",
    "pitch",
    "roll",
    "warp",
    "heave_sweep",
    "lateral_sweep",
    "kinematics_and_compliance",
    "kinematics_and_compliance_roll",
)
"""The built-in tests; listed here so that help comes without reading them."""

TYRES = ("bonded", "lifting")
"""What tyres do on the pads."""

AXES = {"ground": "", "body": "body_axes_"}
"""Prefixes of the names of what is measured along the axes of the ground and of the body."""


def find_test(
    name: str,
    *,
    frequency: str | None = None,
    amplitude: str | None = None,
    lag: str | None = None,
    tolerance: str | None = None,
    tyres: str | None = None,
) -> RigTest:
    """A built-in test or the one of a file, with what the options change.

    Raises
    ------
    ArgumentError, ParameterError
        If there is no such test, or the file or an option cannot be accepted.
    """
    if name not in TESTS and not name.endswith(".toml"):
        raise ArgumentError("test", repr(name), f"one of {', '.join(TESTS)}, or a file that ends in .toml")
    changes: list[Callable[[RigTest], RigTest]] = []
    if frequency is not None:
        hertz = arguments.frequency_hz("--frequency", frequency)
        changes.append(lambda test: test.at(hertz))
    if amplitude is not None:
        size, unit = arguments.amplitude("--amplitude", amplitude)
        changes.append(lambda test: test.with_amplitude(size, unit))
    if lag is not None:
        seconds = arguments.finite("--lag", lag, "s")
        changes.append(lambda test: test.with_rear_lag(seconds))
    if tolerance is not None:
        from chassym.nonlinear.rig.reading import checked_tolerance

        error = checked_tolerance(arguments.positive("--tolerance", tolerance, "1"), "command line")
        changes.append(lambda test: replace(test, tolerance=error))
    if tyres is not None:
        lift = arguments.choice("--tyres", tyres, TYRES) == "lifting"
        changes.append(lambda test: replace(test, tyres_lift=lift))
    from chassym.nonlinear.rig import load_rig_test

    test = load_rig_test(name)
    for change in changes:
        test = change(test)
    return test


def find_vehicle(positional: str | None, option: str | None) -> str:
    """The vehicle, given in either of two ways; the reference sedan if in none.

    Raises
    ------
    ArgumentError
        If it is given in both.
    """
    if positional is not None and option is not None:
        raise ArgumentError("--vehicle", f"{option!r} beside {positional!r}", "one vehicle")
    given = option if positional is None else positional
    return "sedan" if given is None else given


def find_metrics(model: Model, test: RigTest, axes: str) -> dict[str, str]:
    """Names that metrics are answered under, by the name of the output.

    Accelerations and rates along some `AXES`, or, if the test names its metrics, those; along the body's axes
    the outputs that correspond to them.

    Raises
    ------
    ArgumentError
        If the model measures none along these axes.
    """
    if test.metrics is not None:
        prefix = AXES[axes]
        missing = [name for name in test.metrics if prefix + name not in model.output_names]
        if prefix and missing:
            expected = f"ground, as a {model.system.name} measures no {prefix}{missing[0]}"
            raise ArgumentError("--axes", repr(axes), expected)
        return {prefix + name: name for name in test.metrics}
    return _accelerations_and_rates(model, axes)


def _accelerations_and_rates(model: Model, axes: str) -> dict[str, str]:
    from chassym.nonlinear.steady.steady_state import measured_names

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
