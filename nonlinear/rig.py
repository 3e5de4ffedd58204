"""Harmonic tests of the four-post rig: what the actuator pads do."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation import Harmonic

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
PADS = tuple(f"{corner}_pad_z" for corner in CORNERS)
"""Vertical motions of the pads."""

THESIS_GRAVITY = 9.81
"""Acceleration (m/s^2) that "g" stands for in amplitudes."""

_VERTICAL_INPUT = re.compile(r"(.+_)?(pad_z|road)")


def lateral(frequency_hz: float = 3.0, amplitude_m: float | None = None, lag_s: float = 0.2) -> Harmonic:
    """Slalom: all pads move in Y, the rear ones behind the front ones by a lag.

    The default amplitude is that of 0.6 g at 3 Hz. Source: Liu 2016, section 2.4.
    """
    amplitude = 0.6 * THESIS_GRAVITY / (2 * np.pi * 3.0) ** 2 if amplitude_m is None else amplitude_m
    rear = amplitude * np.exp(-2j * np.pi * frequency_hz * lag_s)
    return Harmonic(
        frequency_hz,
        {f"{corner}_pad_y": amplitude if corner.startswith("front") else rear for corner in CORNERS},
    )


def vertical(frequency_hz: float = 3.0, amplitude_m: float = 0.025, lag_s: float = 0.0) -> Harmonic:
    """Twist: front left and rear right pads rise while the other two fall. Source: Liu 2016, section 2.4."""
    signs = dict(zip(PADS, (1, -1, -1, 1), strict=True))
    return _vertical(frequency_hz, {pad: amplitude_m * sign for pad, sign in signs.items()}, lag_s)


def heave(
    frequency_hz: float = 1.0,
    amplitude_m: float = 0.01,
    lag_s: float = 0.0,
    inputs: Sequence[str] = PADS,
) -> Harmonic:
    """All pads, or the inputs that `heave_inputs` names, rise and fall together.

    Source: Liu 2016, section 2.3.
    """
    return _vertical(frequency_hz, dict.fromkeys(inputs, amplitude_m), lag_s)


def heave_inputs(model: Model) -> tuple[str, ...]:
    """The inputs that move the wheels of a model vertically: its pads or its road.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> heave_inputs(load_model("half_car"))
    ('front_road', 'rear_road')
    """
    return tuple(u.name for u in model.system.inputs if _VERTICAL_INPUT.fullmatch(u.name))


def _vertical(frequency_hz: float, amplitudes: dict[str, float], lag_s: float) -> Harmonic:
    delay = np.exp(-2j * np.pi * frequency_hz * lag_s)
    return Harmonic(
        frequency_hz,
        {name: a * (delay if name.startswith("rear") else 1.0) for name, a in amplitudes.items()},
    )
