"""Thousands of variants in one call: what is asked of each, as labelled arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from chassym.derivation import Model, variants
from chassym.linear.frequency_response import checked_frequencies, index_of
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.linearisation import linearise
from chassym.linear.modal.modes import Mode, damped_modes
from chassym.linear.slope_rule import SlopeRules, mean_slope
from chassym.linear.variation.channel import Channel
from chassym.linear.variation.variants import LinearVariants, linearise_like

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

_TOGETHER = 1000
"""Variants evaluated together: enough to make calls cheap, few enough to stay in the processor's caches."""

_CHECKED = 4
"""Frequencies at which a response by modes is compared with its direct solution."""

_ACCEPTED = 1e-9
"""Relative difference up to which the response by modes is taken."""

_SMALL = 1e-6
"""Part of the largest response below which differences are relative to that part."""


Columns = Mapping[str, tuple[tuple[str, ...], Array, Mapping[str, str]]]
"""Dimensions, values and attributes by name, as `xarray.Dataset` takes them."""


class Quantity(Protocol):
    """What is computed of every variant."""

    def of(self, linear: LinearVariants) -> Columns:
        """Values whose first dimension is ``variant``."""

    def labels(self, named: LinearModel) -> Columns:
        """Coordinates of their other dimensions."""


@dataclass(frozen=True)
class Matrices:
    """M, C, K, B_u, B_u' and the output matrices, by the names of `LinearModel`."""

    def of(self, linear: LinearVariants) -> Columns:
        """Every matrix over coordinates, inputs and outputs."""
        return {name: (("variant", *_SIDES[name]), each, {}) for name, each in linear.matrices.items()}

    def labels(self, named: LinearModel) -> Columns:
        """Names."""
        coordinates = np.array(named.coordinates)
        return {
            "coordinate": (("coordinate",), coordinates, {}),
            "column": (("column",), coordinates, {}),
            "input": (("input",), np.array(named.inputs, dtype=str), {}),
            "output": (("output",), np.array(named.outputs, dtype=str), {}),
        }


_SIDES = {
    "mass": ("coordinate", "column"),
    "damping": ("coordinate", "column"),
    "stiffness": ("coordinate", "column"),
    "input_stiffness": ("coordinate", "input"),
    "input_damping": ("coordinate", "input"),
    "output_by_coordinates": ("output", "coordinate"),
    "output_by_rates": ("output", "coordinate"),
    "output_by_accelerations": ("output", "coordinate"),
    "output_by_inputs": ("output", "input"),
    "output_by_input_rates": ("output", "input"),
}


@dataclass(frozen=True)
class DampedModes:
    """All eigenvalues in ascending order of magnitude, with frequencies, damping ratios and shapes."""

    def of(self, linear: LinearVariants) -> Columns:
        """Eigenvalues (1/s), |eigenvalue| / (2 pi), -Re / |eigenvalue| and shapes with q^H M q = 1."""
        values, vectors = linear.eigensystem
        order = np.lexsort((-values.imag, np.abs(values).round(9)), axis=1)
        values = np.take_along_axis(values, order, axis=1)
        shapes = np.take_along_axis(vectors[:, : vectors.shape[1] // 2], order[:, None], axis=2)
        weights = (shapes.conj() * (linear.matrices["mass"] @ shapes)).real.sum(axis=1)
        size, roots = np.abs(values), ("variant", "root")
        return {
            "eigenvalue": (roots, values, {"units": "1/s"}),
            "natural_frequency_hz": (roots, size / (2 * np.pi), {"units": "Hz"}),
            "damping_ratio": (roots, -values.real / np.where(size > 0, size, 1.0), {"units": "1"}),
            "shape": (("variant", "coordinate", "root"), shapes / np.sqrt(weights)[:, None], {}),
        }

    def labels(self, named: LinearModel) -> Columns:
        """Names of the coordinates."""
        return {"coordinate": (("coordinate",), np.array(named.coordinates), {})}


@dataclass(frozen=True, eq=False)
class ModesLike:
    """The damped modes of a linear model, found again in every variant by their shapes.

    Every oscillation of a variant is given to that mode of the model whose shape it resembles most, all
    together as well as can be, by the modal assurance criterion with the model's mass.

    Attributes
    ----------
    model
        The linear model with which variants are compared: the nominal one, say.
    """

    model: LinearModel

    def of(self, linear: LinearVariants) -> Columns:
        """Frequency and damping ratio over ``mode``, and how much the shapes resemble, 0 to 1.

        What is not there, because it does not oscillate, is NaN.
        """
        from scipy.optimize import linear_sum_assignment

        nominal = self._oscillations()
        values, vectors = linear.eigensystem
        shapes = vectors[:, : vectors.shape[1] // 2]
        weighted = self.model.mass @ shapes
        sizes = (shapes.conj() * weighted).real.sum(axis=1)
        products = np.abs(np.array([mode.shape.conj() for mode in nominal]) @ weighted) ** 2
        assurance = np.where(values.imag[:, None] > 0, products / sizes[:, None], 0.0)
        columns = np.array([linear_sum_assignment(-each)[1] for each in assurance])
        found = np.take_along_axis(assurance, columns[:, :, None], axis=2)[:, :, 0]
        chosen = np.where(found > 0, np.take_along_axis(values, columns, axis=1), np.nan)
        modes = ("variant", "mode")
        return {
            "mode_frequency_hz": (modes, np.abs(chosen) / (2 * np.pi), {"units": "Hz"}),
            "mode_damping_ratio": (modes, -chosen.real / np.abs(chosen), {"units": "1"}),
            "mode_assurance": (modes, found, {"units": "1"}),
        }

    def labels(self, named: LinearModel) -> Columns:
        """Names of the modes."""
        return {"mode": (("mode",), np.array([mode.name for mode in self._oscillations()]), {})}

    def _oscillations(self) -> list[Mode]:
        return [mode for mode in damped_modes(self.model) if mode.eigenvalue.imag > 0]


@dataclass(frozen=True)
class Response:
    """Frequency response of one output to inputs that move together.

    It is summed over the damped modes, and compared with the direct solution at some frequencies; variants in
    which they differ, having nearly multiple eigenvalues, are solved directly at all frequencies.

    Attributes
    ----------
    output
        Name of the output.
    amplitudes
        Complex amplitude of every input that moves, by its name.
    frequencies_hz
        Frequencies (Hz), shape (frequencies,), at least one.
    name
        What the result is called: several responses in one sweep need a name each, and the same frequencies.
    """

    output: str
    amplitudes: Mapping[str, complex]
    frequencies_hz: ArrayLike
    name: str = "response"

    def of(self, linear: LinearVariants) -> Columns:
        """``response``, complex, over ``frequency_hz``, and how far it is from direct solutions, relatively.

        Raises
        ------
        LinearisationError
            If there is no such output or input, or a frequency is negative or not finite.
        """
        channel = Channel.of(linear, self.output, self.amplitudes)
        frequencies = checked_frequencies(self.frequencies_hz)
        if not len(frequencies):
            raise LinearisationError("frequencies_hz: none received; at least one is needed")
        s = 2j * np.pi * frequencies
        response = channel.by_modes(s)
        probes = np.unique(np.linspace(0, len(s) - 1, _CHECKED).astype(int))
        direct = channel.directly(s[probes])
        size = np.maximum(np.abs(direct), _SMALL * np.abs(response).max(axis=1, keepdims=True))
        error = (np.abs(response[:, probes] - direct) / np.where(size > 0, size, 1.0)).max(axis=1)
        wrong = ~(error <= _ACCEPTED)
        if wrong.any():
            response[wrong] = channel.part(wrong).directly(s)
            error[wrong] = 0.0
        unit = linear.named.output_units[index_of("output", self.output, linear.named.outputs)]
        return {
            self.name: (("variant", "frequency_hz"), response, {"units": unit, "output": self.output}),
            f"{self.name}_error": (("variant",), error, {"units": "1"}),
        }

    def labels(self, named: LinearModel) -> Columns:
        """Frequencies."""
        return {
            "frequency_hz": (("frequency_hz",), checked_frequencies(self.frequencies_hz), {"units": "Hz"})
        }


def sweep(
    model: Model,
    changes: Mapping[str, ArrayLike],
    quantities: Sequence[Quantity],
    slope_rule: SlopeRules = mean_slope,
    progress: Callable[[float], None] = lambda fraction: None,
) -> xarray.Dataset:
    """Compute quantities of many variants of a model, each balanced by its own preloads.

    Equations are not derived and nothing is compiled again. Memory beyond the result does not grow with the
    number of variants.

    Parameters
    ----------
    model
        The model.
    changes
        Numbers in SI by parameter name, shape (count,) each; see `chassym.derivation.variants`.
    quantities
        What to compute: `Matrices()`, `DampedModes()`, `ModesLike(model)`, `Response(...)`, or anything with
        their methods ``of`` and ``labels``.
    slope_rule
        As for `linearise`.
    progress
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        The quantities and the changed parameters, over ``variant``.

    Raises
    ------
    ParameterError, EquilibriumError, OperatingPointError, LinearisationError
        For the first variant that is impossible, cannot be balanced, or has no linear model.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> car = load_model("quarter_car")
    >>> found = sweep(car, {"sprung.mass": [300.0, 350.0, 400.0]}, [DampedModes()])
    >>> found.natural_frequency_hz.sel(variant=1)[0].round(2).item()
    1.06
    """
    import xarray  # it takes a while to import: only for those who ask for it

    for quantity in quantities:
        if isinstance(quantity, type) or not (hasattr(quantity, "of") and hasattr(quantity, "labels")):
            raise LinearisationError(
                f"quantities: {quantity!r} received; expected Matrices(), DampedModes(), ModesLike(model) or "
                "Response(...)"
            )
    every = variants(model, changes)
    named = linearise(every.one(0), slope_rule)
    found: dict[str, tuple[tuple[str, ...], Array, Mapping[str, str]]] = {}
    for start in range(0, len(every), _TOGETHER):
        part = every[start : start + _TOGETHER]
        linear = linearise_like(named, part, slope_rule)
        for name, (dimensions, values, attributes) in _merged(q.of(linear) for q in quantities).items():
            if name not in found:
                whole = np.empty_like(values, shape=(len(every), *values.shape[1:]))
                found[name] = (dimensions, whole, attributes)
            found[name][1][start : start + len(part)] = values
        progress((start + len(part)) / len(every))
    units = {name: each.unit for name, each in model.parameters.items()}
    given = {
        name: (("variant",), numbers, {"units": units[name.partition("[")[0]]})
        for name, numbers in every.changes.items()
    }
    attributes = {"model": named.name, "slope_rule": named.slope_rule}
    return xarray.Dataset(found, _merged(q.labels(named) for q in quantities) | given, attributes)


def _merged(columns: Iterable[Columns]) -> dict[str, tuple[tuple[str, ...], Array, Mapping[str, str]]]:
    """All columns together; equal ones, as the names of coordinates, may come twice.

    Raises
    ------
    LinearisationError
        If two different ones have the same name.
    """
    found: dict[str, tuple[tuple[str, ...], Array, Mapping[str, str]]] = {}
    for name, column in (item for each in columns for item in each.items()):
        if name in found and not np.array_equal(found[name][1], column[1]):
            raise LinearisationError(
                f"quantities: two of them give a different {name!r}; give responses names of their own and "
                "the same frequencies"
            )
        found[name] = column
    return found
