"""Harmonic tests of the four-post rig: what the actuator pads do."""

from __future__ import annotations

import numpy as np

from chassym.nonlinear.excitation import Harmonic

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
STANDARD_GRAVITY = 9.81
"""Acceleration (m/s^2) that "g" stands for in amplitudes."""


def lateral(frequency_hz: float = 3.0, amplitude_m: float | None = None, lag_s: float = 0.2) -> Harmonic:
    """Slalom: all pads move in Y, the rear ones behind the front ones by a lag.

    The default amplitude is that of 0.6 g at 3 Hz. Source: Liu 2016, section 2.4.
    """
    amplitude = 0.6 * STANDARD_GRAVITY / (2 * np.pi * 3.0) ** 2 if amplitude_m is None else amplitude_m
    rear = amplitude * np.exp(-2j * np.pi * frequency_hz * lag_s)
    return Harmonic(
        frequency_hz, {f"{corner}_pad_y": amplitude if corner.startswith("front") else rear for corner in CORNERS}
    )


def vertical(frequency_hz: float = 3.0, amplitude_m: float = 0.025, lag_s: float = 0.0) -> Harmonic:
    """Twist: front left and rear right pads rise while the other two fall. Source: Liu 2016, section 2.4."""
    signs = dict(zip(CORNERS, (1, -1, -1, 1), strict=True))
    return _vertical(frequency_hz, {corner: amplitude_m * sign for corner, sign in signs.items()}, lag_s)


def heave(frequency_hz: float = 1.0, amplitude_m: float = 0.01, lag_s: float = 0.0) -> Harmonic:
    """All pads rise and fall together. Source: Liu 2016, section 2.3."""
    return _vertical(frequency_hz, dict.fromkeys(CORNERS, amplitude_m), lag_s)


def _vertical(frequency_hz: float, amplitudes: dict[str, float], lag_s: float) -> Harmonic:
    delay = np.exp(-2j * np.pi * frequency_hz * lag_s)
    return Harmonic(
        frequency_hz,
        {f"{c}_pad_z": a * (delay if c.startswith("rear") else 1.0) for c, a in amplitudes.items()},
    )
