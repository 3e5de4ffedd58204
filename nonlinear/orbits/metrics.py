"""What is read off an orbit: peak-to-peak values and patch forces, each with an estimate of its error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.orbits.patches import carries_by_contact, is_unilateral, patch_of
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

Array = np.ndarray

ROUNDING = 1e-12
"""Movements below this (SI units) are those of rounding: forces of thousands of newtons cancel at rest."""

_NEGLIGIBLE = 1e-3
"""A metric below this share of the largest one of its unit is asked for to the same absolute accuracy as that
share.
"""


@dataclass(frozen=True)
class Metric:
    """A peak-to-peak value or an extreme with an estimate of its error, both in the unit."""

    value: float
    unit: str
    error: float


@dataclass(frozen=True)
class Contact:
    """The smallest vertical patch force and where it acts.

    Attributes
    ----------
    value
        The force (N); negative if contact would have been lost.
    error
        Its estimated error (N).
    patch
        Where it acts.
    """

    value: float
    error: float
    patch: str

    @property
    def is_kept(self) -> bool:
        """Whether every tyre stays on its pad."""
        return self.value > 0


class Reader:
    """Reads the extremes of outputs off an orbit and judges how they moved."""

    def __init__(self, model: Model, names: Sequence[str]) -> None:
        outputs = {output.name: (row, output.unit) for row, output in enumerate(model.system.outputs)}
        for name in names:
            if name not in outputs:
                raise KeyError(f"output {name!r}: {model.system.name} has {', '.join(outputs)}")
        self.patches = [output.name for output in model.system.outputs if carries_by_contact(output)]
        self.names = [*names, *self.patches]
        self.units = [outputs[name][1] for name in self.names]
        self._rows = [outputs[name][0] for name in self.names]
        self._peaks = len(names)
        at_rest = np.abs(model.outputs(np.zeros((model.argument_count, 1)))[self._rows, 0])
        at_rest[: self._peaks] = 0.0
        lifted = [is_unilateral(model.system.outputs[row]) for row in self._rows[self._peaks :]]
        self._lowest = np.array([0.0] * self._peaks + [0.0 if each else -np.inf for each in lifted])
        self._least_scale = np.maximum(at_rest, ROUNDING)
        _, self._unit_of = np.unique(self.units, return_inverse=True)

    def read(self, orbit: PeriodicOrbit) -> Array:
        """Peak-to-peak values, then smallest patch forces."""
        return self._values(*orbit.extremes(self._rows))

    def read_iterated(self, orbit: PiecewiseOrbit, deviations: Array) -> Array:
        """The same of the orbit after an iteration of Picard's from starts that deviate."""
        return self._values(*orbit.iterated_extremes(self._rows, deviations))

    def _values(self, low: Array, high: Array) -> Array:
        return np.concatenate([(high - low)[: self._peaks], low[self._peaks :]])

    def scale(self, reading: Array) -> Array:
        """What an error of every value is compared with: of a patch force, at least that at rest."""
        sizes = np.abs(reading)
        largest = np.zeros(len(sizes))
        np.maximum.at(largest, self._unit_of, sizes)
        return np.maximum.reduce([sizes, _NEGLIGIBLE * largest[self._unit_of], self._least_scale])

    def is_settled(self, reading: Array, error: Array, tolerance: float) -> bool:
        """Whether every error is within the tolerance, relative to its value."""
        return bool(np.all(error <= tolerance * self.scale(reading) + 2 * ROUNDING))

    def expected(self, reading: Array, error: Array, least: float) -> Array:
        """Errors, each at least a part of the middle metric's, rounding added."""
        scale = self.scale(reading)
        return np.asarray(np.maximum(error, least * np.median(error / scale) * scale) + ROUNDING)

    def unsettled(self, reading: Array, error: Array, how: str, tolerance: float) -> NoPeriodicOrbitError:
        """Why it is given up, naming the worst metric.

        Parameters
        ----------
        how
            What it was read with.
        """
        worst = int(np.argmax(error / self.scale(reading)))
        return NoPeriodicOrbitError(
            f"{self.names[worst]} = {reading[worst]:.6g} {self.units[worst]} still has an error of "
            f"{error[worst]:.2g} {how}, a relative {tolerance:g} was asked for; ask for less accuracy"
        )

    def results(self, reading: Array, error: Array) -> tuple[dict[str, Metric], Contact | None]:
        """The peak-to-peak values by name, and the worst patch."""
        possible = np.maximum(reading, self._lowest)
        values = [Metric(float(v), u, float(e)) for v, u, e in zip(possible, self.units, error, strict=True)]
        peaks = dict(zip(self.names[: self._peaks], values, strict=False))
        forces = dict(zip(self.patches, values[self._peaks :], strict=True))
        if not forces:
            return peaks, None
        worst = min(forces, key=lambda name: forces[name].value)
        return peaks, Contact(forces[worst].value, forces[worst].error, patch_of(worst))
