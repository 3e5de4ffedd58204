"""What is read off an orbit: peak-to-peak values and patch forces, each with an estimate of its error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chassym.derivation import ContactForce, Model, Unilateral
from chassym.derivation.system import Measurement
from chassym.nonlinear.harmonic_balance import samples_for
from chassym.nonlinear.orbit import Orbit
from chassym.nonlinear.peaks import extremes

_ROUNDING = 1e-12
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
    """The smallest vertical patch force and where it acts; negative if contact would have been lost."""

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
        self.patches = [output.name for output in model.system.outputs if _may_lift(output)]
        self.names = [*names, *self.patches]
        self.units = [outputs[name][1] for name in self.names]
        self._rows = [outputs[name][0] for name in self.names]
        self._peaks = len(names)

    def read(self, orbit: Orbit) -> np.ndarray:
        """Peak-to-peak values, then smallest patch forces."""
        low, high = extremes(orbit, self._rows, samples_for(orbit.harmonics))
        return np.concatenate([(high - low)[: self._peaks], low[self._peaks :]])

    def scale(self, reading: np.ndarray) -> np.ndarray:
        """What an error of every value is compared with."""
        sizes = np.abs(reading)
        largest = {
            unit: max(s for s, u in zip(sizes, self.units, strict=True) if u == unit) for unit in self.units
        }
        return np.maximum(sizes, _NEGLIGIBLE * np.array([largest[unit] for unit in self.units]))

    def is_settled(self, readings: Sequence[np.ndarray], tolerance: float) -> bool:
        """Whether every error is within the tolerance, relative to its value."""
        allowed = tolerance * self.scale(readings[-1]) + 2 * _ROUNDING
        return len(readings) > 2 and bool(np.all(self.error(readings) <= allowed))

    def error(self, readings: Sequence[np.ndarray]) -> np.ndarray:
        """Error estimate of the last reading, as `steady_state` describes it."""
        moved = np.abs(np.diff(readings[-4:], axis=0))[::-1]
        expected = moved * 0.25 ** np.arange(len(moved))[:, None]
        return np.asarray(2 * expected.max(axis=0) + _ROUNDING)

    def results(self, reading: np.ndarray, error: np.ndarray) -> tuple[dict[str, Metric], Contact | None]:
        """The peak-to-peak values by name, and the worst patch."""
        values = [Metric(float(v), u, float(e)) for v, u, e in zip(reading, self.units, error, strict=True)]
        peaks = dict(zip(self.names[: self._peaks], values, strict=False))
        forces = dict(zip(self.patches, values[self._peaks :], strict=True))
        if not forces:
            return peaks, None
        worst = min(forces, key=lambda name: forces[name].value)
        patch = worst.removesuffix("patch_force_z").removesuffix("_")
        return peaks, Contact(forces[worst].value, forces[worst].error, patch)


def _may_lift(output: Measurement) -> bool:
    """Whether an output is the force of a support that can only push."""
    named = output.name.endswith("patch_force_z")
    return named or isinstance(output, ContactForce) and isinstance(output.element.characteristic, Unilateral)
