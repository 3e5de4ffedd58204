"""Loss of contact on an orbit: which patches are pulled or in the air, when, and for how long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chassym.nonlinear.orbits.patches import carries_by_contact, is_unilateral, patch_of
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit

SAMPLES = 2048
"""Phases at which a loss of contact is looked for; a shorter one may be missed."""

_HALVINGS = 40
"""Of the distance between two samples, to find where contact ends and begins."""


@dataclass(frozen=True)
class PeriodicLossOfContact:
    """Every time in a period of an orbit that one tyre could not have stayed on its pad, or did not.

    A single time, of a motion that need not repeat, is a `chassym.nonlinear.LossOfContact`.

    Attributes
    ----------
    patch
        Name of the place.
    is_in_the_air
        Whether the tyre lifts, as a unilateral one does; otherwise it is bonded and its pad pulls at it.
    intervals_s
        Beginning and end of every time without contact (s), from the start of the period; one that passes the
        period's end has an end beyond it.
    period_s
        Time after which the motion repeats (s).
    smallest_force
        Smallest vertical force then (N): zero where the tyre lifts, negative where it is bonded to its pad.
    """

    patch: str
    is_in_the_air: bool
    intervals_s: tuple[tuple[float, float], ...]
    period_s: float
    smallest_force: float

    @property
    def duration_s(self) -> float:
        """Time without contact in one period (s)."""
        return sum(end - begin for begin, end in self.intervals_s)

    @property
    def share(self) -> float:
        """Part of the period without contact, 0 to 1."""
        return self.duration_s / self.period_s


def contact_losses(orbit: PeriodicOrbit) -> tuple[PeriodicLossOfContact, ...]:
    """Every patch that loses contact on an orbit, the one with the smallest force first, then the longest."""
    rows = [row for row, output in enumerate(orbit.model.system.outputs) if carries_by_contact(output)]
    phases = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    forces = orbit.outputs_at(phases)[rows] if rows else np.empty((0, SAMPLES))
    found = [
        _loss(orbit, row, phases, force)
        for row, force in zip(rows, forces, strict=True)
        if np.any(force <= 0)
    ]
    return tuple(sorted(found, key=lambda loss: (loss.smallest_force, -loss.duration_s)))


def _loss(orbit: PeriodicOrbit, row: int, phases: np.ndarray, force: np.ndarray) -> PeriodicLossOfContact:
    """What is known of one patch whose force is not positive at some of the phases."""
    output = orbit.model.system.outputs[row]
    period_s = orbit.period_s
    intervals = _intervals(orbit, row, phases, force <= 0)
    return PeriodicLossOfContact(
        patch=patch_of(output.name),
        is_in_the_air=is_unilateral(output),
        intervals_s=tuple((b * period_s / (2 * np.pi), e * period_s / (2 * np.pi)) for b, e in intervals),
        period_s=period_s,
        smallest_force=float(force.min()) + 0.0,
    )


def _intervals(
    orbit: PeriodicOrbit, row: int, phases: np.ndarray, is_off: np.ndarray
) -> list[tuple[float, float]]:
    """Phases between which there is no contact, the changes halved down to rounding."""
    if is_off.all():
        return [(0.0, 2 * np.pi)]
    ends, begins = (
        np.flatnonzero(change) for change in (is_off & ~np.roll(is_off, -1), ~is_off & np.roll(is_off, -1))
    )
    begin, end = (
        _change(orbit, row, phases[which], turns_off) for which, turns_off in ((begins, True), (ends, False))
    )
    if end[0] < begin[0]:
        end = np.append(end[1:], end[0] + 2 * np.pi)
    return [(float(b), float(e)) for b, e in zip(begin, end, strict=True)]


def _change(orbit: PeriodicOrbit, row: int, before: np.ndarray, turns_off: bool) -> np.ndarray:
    """Where between a sample and the next contact ends (turns off) or begins."""
    low, high = before, before + 2 * np.pi / SAMPLES
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_over = (orbit.outputs_at(middle)[row] <= 0) == turns_off
        low, high = np.where(is_over, low, middle), np.where(is_over, middle, high)
    return 0.5 * (low + high)
