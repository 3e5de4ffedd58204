"""A branch of periodic orbits: over frequency, amplitude or a parameter, with folds and stability."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.collocation.floquet import die_out
from chassym.nonlinear.continuation.arclength import Tracer
from chassym.nonlinear.continuation.paths import Path
from chassym.nonlinear.harmonics.harmonic_equations import samples_at_knots
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit

if TYPE_CHECKING:
    import xarray

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Fold:
    """Where a branch turns back: two orbits meet, and there are none beyond.

    Attributes
    ----------
    value
        The path's parameter there.
    orbit
        The orbit there.
    point
        The fold lies between this point of the branch and the next.
    """

    value: float
    orbit: FourierOrbit = field(repr=False)
    point: int


@dataclass(frozen=True, eq=False)
class Branch:
    """A branch of periodic orbits, in the order in which it was followed.

    Attributes
    ----------
    path
        What changes along the branch.
    values
        Parameter of the path, shape (points,).
    orbits
        Orbit at every point.
    multipliers
        Floquet multipliers, largest magnitude first, shape (points, 2 n).
    folds
        Where the branch turns back.
    """

    path: Path
    values: Array = field(repr=False)
    orbits: tuple[FourierOrbit, ...] = field(repr=False)
    multipliers: Array = field(repr=False)
    folds: tuple[Fold, ...]

    @cached_property
    def is_stable(self) -> Array:
        """Whether small deviations die out, shape (points,)."""
        return die_out(self.multipliers)

    def amplitude(self, output: str) -> Array:
        """Half the peak-to-peak value of an output, in its unit, shape (points,).

        Raises
        ------
        KeyError
            If the model has no output of the name.
        """
        row = output_row(self.orbits[0].model, output)
        return np.array([amplitudes(orbit, [row])[0] for orbit in self.orbits])

    def at(self, value: float) -> tuple[FourierOrbit, ...]:
        """All orbits of the branch at a value of the parameter, in the order of the branch.

        Raises
        ------
        NoPeriodicOrbitError
            If an orbit between two points of the branch is not found.
        """
        first = self.orbits[0]
        fewest = samples_at_knots(first.model, first.subharmonic)
        tracer = Tracer(self.path, 1.0, first.harmonics, first.subharmonic, fewest_samples=fewest)
        found = [first] if self.values[0] == value else []
        for begin, end in pairwise(self._places()):
            if begin.value != value and (begin.value - value) * (end.value - value) <= 0:
                found.append(tracer.balanced(_between(begin, end, value), value))
        return tuple(found)

    def _places(self) -> list[_Place]:
        """Points and folds in order: from one to the next the parameter goes one way."""
        places = [_Place(v, orbit, False) for v, orbit in zip(self.values, self.orbits, strict=True)]
        for fold in reversed(self.folds):
            places.insert(fold.point + 1, _Place(fold.value, fold.orbit, True))
        return places

    def to_xarray(self) -> xarray.Dataset:
        """Parameter, stability and amplitudes of all outputs over `point`, folds over `fold`, with units."""
        import xarray

        outputs = self.orbits[0].model.system.outputs
        columns = np.array([amplitudes(orbit, list(range(len(outputs)))) for orbit in self.orbits]).T
        data = {
            output.name: ("point", column, {"units": output.unit, "long_name": "half peak-to-peak value"})
            for output, column in zip(outputs, columns, strict=True)
        }
        largest = np.abs(self.multipliers).max(axis=1)
        folds = ("fold", np.array([fold.value for fold in self.folds]), {"units": self.path.unit})
        return xarray.Dataset(
            {**data, "fold_value": folds},
            coords={
                self.path.name: ("point", self.values, {"units": self.path.unit}),
                "stable": ("point", self.is_stable),
                "largest_multiplier": ("point", largest, {"units": "1"}),
            },
        )


@dataclass(frozen=True, eq=False)
class _Place:
    value: float
    orbit: FourierOrbit
    is_fold: bool


def output_row(model: Model, output: str) -> int:
    """Where an output stands among those of a model.

    Raises
    ------
    KeyError
        If the model has none of the name.
    """
    if output not in model.output_names:
        raise KeyError(f"output {output!r}: {model.system.name} has {', '.join(model.output_names)}")
    return model.output_names.index(output)


def amplitudes(orbit: PeriodicOrbit, rows: list[int]) -> Array:
    """Half the peak-to-peak values of some outputs, shape (len(rows),)."""
    low, high = orbit.extremes(rows)
    return 0.5 * (high - low)


def _between(begin: _Place, end: _Place, value: float) -> FourierOrbit:
    """A guess of the orbit at a value between two places: off a fold the motion goes as a square root."""
    share = (value - begin.value) / (end.value - begin.value)
    if begin.is_fold != end.is_fold:
        share = np.sqrt(share) if begin.is_fold else 1 - np.sqrt(1 - share)
    change = end.orbit.coefficients - begin.orbit.coefficients
    return replace(begin.orbit, coefficients=begin.orbit.coefficients + share * change)
