"""The steady state of a harmonic test, by whatever method it was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from chassym.nonlinear.collocation.floquet import die_out, multipliers
from chassym.nonlinear.orbits.metrics import Contact, Metric
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit

Array = np.ndarray


@dataclass(frozen=True)
class Statistics:
    """What an orbit took.

    Attributes
    ----------
    method
        How it was found.
    unknowns
        Numbers that describe it.
    iterations
        Steps of Newton's method, or others, of all solves together.
    correction
        Last relative correction of the rates, or what is left of the transients.
    """

    method: str
    unknowns: int
    iterations: int
    correction: float


@dataclass(frozen=True, eq=False)
class SteadyState:
    """The periodic response to a harmonic excitation.

    Attributes
    ----------
    orbit
        The orbit; its `harmonic_content` are the outputs' harmonics.
    peak_to_peak
        Metric of every output asked for, by the output's name.
    contact
        Smallest vertical patch force: of the outputs called ``..patch_force_z`` and of the contact forces of
        unilateral elements. None for a system without any.
    statistics
        What it took.
    """

    orbit: PeriodicOrbit = field(repr=False)
    peak_to_peak: Mapping[str, Metric]
    contact: Contact | None
    statistics: Statistics

    @cached_property
    def multipliers(self) -> Array:
        """Floquet multipliers, largest magnitude first."""
        return multipliers(self.orbit)

    @property
    def is_stable(self) -> bool:
        """Whether small deviations die out."""
        return bool(die_out(self.multipliers))
