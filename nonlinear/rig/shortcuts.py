"""The excitations of the best-known built-in tests on a four-post rig, in one call.

For any test on any vehicle: `load_rig_test(name).excitation(model)`.
"""

from __future__ import annotations

from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.rig.reading import load_rig_test


def lateral(
    frequency_hz: float | None = None, amplitude_m: float | None = None, lag_s: float | None = None
) -> Harmonic:
    """Slalom: all pads move in Y, the rear ones behind the front ones by a lag.

    What is not given is the built-in test's: 3 Hz, the amplitude of 0.6 g there, 0.2 s.
    """
    return _changed("lateral", frequency_hz, amplitude_m, lag_s)


def vertical(
    frequency_hz: float | None = None, amplitude_m: float | None = None, lag_s: float | None = None
) -> Harmonic:
    """Twist: front left and rear right pads rise while the other two fall; 3 Hz and 25 mm by default."""
    return _changed("vertical", frequency_hz, amplitude_m, lag_s)


def heave(
    frequency_hz: float | None = None, amplitude_m: float | None = None, lag_s: float | None = None
) -> Harmonic:
    """All pads rise and fall together; 1 Hz and 10 mm by default."""
    return _changed("heave", frequency_hz, amplitude_m, lag_s)


def _changed(
    name: str, frequency_hz: float | None, amplitude_m: float | None, lag_s: float | None
) -> Harmonic:
    test = load_rig_test(name)
    if amplitude_m is not None:
        test = test.with_amplitude(amplitude_m)
    if lag_s is not None:
        test = test.with_rear_lag(lag_s)
    return test.harmonic(frequency_hz=frequency_hz)
