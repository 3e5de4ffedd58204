"""The heave test: stepped sine of the nonlinear car beside the frequency response of the linear one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model
from chassym.linear import LinearModel, heave_response
from chassym.nonlinear import PeriodicOrbit, rig, steady_state
from chassym.rig_tests import FAILURES

AMPLITUDE_M = 0.01
"""Of all pads. Source: Liu 2016, section 2.3."""

OUTPUTS: Mapping[str, str] = {
    "body": "body_displacement",
    "front wheel": "front_left_wheel_displacement",
    "rear wheel": "rear_left_wheel_displacement",
}
"""What is measured, by the word for it."""

LINEAR_STEPS = 10
"""Frequencies of the linear response to each of the nonlinear test."""


@dataclass(frozen=True)
class HeavePoint:
    """One frequency of the stepped sine.

    Attributes
    ----------
    frequency_hz
        Of the pads.
    amplitudes
        Half the peak-to-peak displacement (m) by the keys of `OUTPUTS`; empty if the solution failed.
    minimum_patch_force
        Smallest vertical patch force (N); below zero contact would have been lost.
    reason
        Why the solution failed; empty if it did not.
    """

    frequency_hz: float
    amplitudes: Mapping[str, float]
    minimum_patch_force: float
    reason: str = ""


@dataclass(frozen=True, eq=False)
class HeaveTest:
    """Amplitudes over frequency.

    Attributes
    ----------
    points
        The nonlinear car, stepped sine.
    linear_frequencies_hz
        Shape (frequencies,).
    linear_amplitudes
        Displacement (m) of the linear car by the keys of `OUTPUTS`, each shape (frequencies,).
    """

    points: tuple[HeavePoint, ...]
    linear_frequencies_hz: np.ndarray
    linear_amplitudes: Mapping[str, np.ndarray]

    def peak_hz(self, what: str) -> float:
        """The frequency of the largest nonlinear amplitude; nan if no frequency was solved."""
        solved = {point.amplitudes[what]: point.frequency_hz for point in self.points if not point.reason}
        return solved[max(solved)] if solved else float("nan")

    def linear_peak_hz(self, what: str) -> float:
        """The frequency of the largest linear amplitude."""
        return float(self.linear_frequencies_hz[self.linear_amplitudes[what].argmax()])

    @property
    def without_contact_hz(self) -> list[float]:
        """Frequencies at which a tyre would have left its pad."""
        return [point.frequency_hz for point in self.points if point.minimum_patch_force < 0]


def run_heave(
    model: Model,
    linear: LinearModel,
    frequencies_hz: Sequence[float],
    tolerance: float,
    announce: Callable[[str], None],
) -> HeaveTest:
    """Run the stepped sine, each frequency starting from the orbit of the last, and the linear response."""
    points, last = [], None
    for frequency in frequencies_hz:
        announce(f"heave test: {frequency:g} Hz")
        point, orbit = _step(model, frequency, tolerance, last)
        last = orbit or last
        points.append(point)
    fine = np.linspace(min(frequencies_hz), max(frequencies_hz), LINEAR_STEPS * (len(frequencies_hz) - 1) + 1)
    response = heave_response(linear, fine)
    amplitudes = {
        what: AMPLITUDE_M * np.abs(response.select(name, "heave")) for what, name in OUTPUTS.items()
    }
    return HeaveTest(tuple(points), fine, amplitudes)


def _step(
    model: Model, frequency_hz: float, tolerance: float, start: PeriodicOrbit | None
) -> tuple[HeavePoint, PeriodicOrbit | None]:
    """One frequency of the stepped sine, and its orbit."""
    excitation = rig.heave(frequency_hz, AMPLITUDE_M)
    try:
        state = steady_state(
            model, excitation, metrics=list(OUTPUTS.values()), tolerance=tolerance, start=start
        )
    except FAILURES as failure:
        return HeavePoint(frequency_hz, {}, float("nan"), str(failure)), None
    amplitudes = {what: 0.5 * state.peak_to_peak[name].value for what, name in OUTPUTS.items()}
    force = state.contact.value if state.contact is not None else float("nan")
    return HeavePoint(frequency_hz, amplitudes, force), state.orbit
