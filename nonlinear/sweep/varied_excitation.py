"""Excitations whose fields a sweep sets."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import TypeAlias

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.rig.rig_test import RigTest

ExcitationRule: TypeAlias = Callable[..., Harmonic]
"""A function of named numbers, its fields, that each have a usual value; such as `rig.lateral`."""


def varied_excitation(excitation: Harmonic | RigTest | ExcitationRule, model: Model) -> ExcitationRule:
    """A rule for an excitation.

    A harmonic one has the fields ``frequency_hz`` and ``amplitude``, a factor; a test of the rig has
    ``frequency_hz``, ``amplitude_m`` and ``lag_s``, that of the rear pads.

    Raises
    ------
    ParameterError
        If the model lacks the pads that a test moves.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> rule = varied_excitation(Harmonic(3.0, {"road": 0.01}), load_model("quarter_car"))
    >>> excitation_fields(rule)
    ('frequency_hz', 'amplitude')
    >>> rule(amplitude=2.0)
    Harmonic(frequency_hz=3.0, amplitudes={'road': 0.02})
    """
    if isinstance(excitation, Harmonic):
        return functools.partial(_changed, excitation)
    if isinstance(excitation, RigTest):
        excitation.excitation(model)
        return functools.partial(_tested, excitation, model)
    return excitation


def excitation_fields(rule: ExcitationRule) -> tuple[str, ...]:
    """Names of the numbers that a rule takes."""
    parameters = inspect.signature(rule).parameters.values()
    return tuple(p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY))


def _changed(excitation: Harmonic, *, frequency_hz: float | None = None, amplitude: float = 1.0) -> Harmonic:
    frequency = excitation.frequency_hz if frequency_hz is None else frequency_hz
    return Harmonic(frequency, excitation.scaled(amplitude).amplitudes)


def _tested(
    test: RigTest,
    model: Model,
    *,
    frequency_hz: float | None = None,
    amplitude_m: float | None = None,
    lag_s: float | None = None,
) -> Harmonic:
    if amplitude_m is not None:
        test = test.with_amplitude(amplitude_m)
    if lag_s is not None:
        test = test.with_rear_lag(lag_s)
    return test.excitation(model, frequency_hz)
