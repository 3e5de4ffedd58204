"""Linear models of many variants of a model at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from chassym.derivation import Variants
from chassym.linear.jump import BESIDE, CONTINUOUS
from chassym.linear.linear_model import LEAST_INERTIA, LinearisationError, LinearModel
from chassym.linear.linearisation import linearise, slopes_of, split
from chassym.linear.operating_point import (
    RESIDUAL_TOLERANCE,
    ROUNDING,
    OperatingPointError,
    design_position,
)
from chassym.linear.slope_rule import SlopeRules, mean_slope

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class LinearVariants:
    """The matrices of `LinearModel` for every variant, one variant along the first axis.

    Attributes
    ----------
    variants
        What was linearised.
    named
        A linear model with the names and units of all.
    jacobian
        Derivatives of residual, then outputs, by q, q', q'', u, u', shape (count, n + outputs, arguments).
    slopes
        The slope used for every table, shape (count,), by its element's name.
    """

    variants: Variants
    named: LinearModel
    jacobian: Array
    slopes: dict[str, Array]

    def __len__(self) -> int:
        return len(self.jacobian)

    def __getitem__(self, index: int) -> LinearModel:
        """The linear model of one variant."""
        model = self.variants.one(index)
        return replace(
            self.named,
            **{name: matrices[index] for name, matrices in self.matrices.items()},
            slopes={name: float(slopes[index]) for name, slopes in self.slopes.items()},
            operating_point=design_position(model),
        )

    @cached_property
    def matrices(self) -> dict[str, Array]:
        """Every matrix of `LinearModel` by its attribute's name, shape (count, rows, columns)."""
        return split(self.jacobian, len(self.named.coordinates), len(self.named.inputs))

    @cached_property
    def state_matrix(self) -> Array:
        """A in x' = A x + ..., states the coordinates, then their rates; shape (count, 2 n, 2 n).

        Raises
        ------
        LinearisationError
            If the mass matrix of a variant is singular.
        """
        mass, damping, stiffness = (self.matrices[name] for name in ("mass", "damping", "stiffness"))
        n = mass.shape[-1]
        full = np.zeros((len(self), 2 * n, 2 * n))
        full[:, :n, n:] = np.eye(n)
        singular = np.flatnonzero(_is_singular(mass))
        if len(singular):
            raise LinearisationError(
                f"mass matrix of variant {self.variants.start + singular[0]} of {self.named.name!r} is "
                "singular; give what moves there a mass or an inertia"
            )
        full[:, n:] = -np.linalg.solve(mass, np.concatenate([stiffness, damping], axis=2))
        return full

    @cached_property
    def eigensystem(self) -> tuple[Array, Array]:
        """Eigenvalues and eigenvectors of the state matrices, shapes (count, 2 n) and (count, 2 n, 2 n)."""
        values, vectors = np.linalg.eig(self.state_matrix)
        return values.astype(complex), vectors.astype(complex)


def linearise_variants(variants: Variants, slope_rule: SlopeRules = mean_slope) -> LinearVariants:
    """Linearise every variant about its design position, with its own preloads.

    Parameters
    ----------
    variants
        From `chassym.derivation.variants`.
    slope_rule
        As for `linearise`.

    Raises
    ------
    OperatingPointError
        If the design position of a variant is not an equilibrium.
    SlopeRuleError, LinearisationError
        As for `linearise`.

    Examples
    --------
    >>> from chassym.derivation import load_model, variants
    >>> heavier = variants(load_model("quarter_car"), {"sprung.mass": [350.0, 400.0, 450.0]})
    >>> linearise_variants(heavier).matrices["mass"][:, 0, 0]
    array([350., 400., 450.])
    """
    return linearise_like(linearise(variants.one(0), slope_rule), variants, slope_rule)


def linearise_like(named: LinearModel, variants: Variants, slope_rule: SlopeRules) -> LinearVariants:
    """Linearise every variant, with the names and units of a linear model of one of them."""
    model = variants.model
    slopes = slopes_of(variants.tables, named.operating_point.table_places, slope_rule)
    symbols = model.system.slopes
    values = variants.values | {symbols[name].name: slope for name, slope in slopes.items()}
    at_rest = np.zeros((model.argument_count, len(variants)))
    _check_continuity(variants, at_rest, slope_rule)
    function = model.compiled.linearisation
    entries = function.of_variants(values, at_rest)
    if not np.isfinite(entries).all():
        wrong = int(np.flatnonzero(~np.isfinite(entries).all(axis=0))[0])
        raise LinearisationError(
            f"a derivative of variant {variants.start + wrong} of {named.name!r} is not finite; check its "
            "parameters"
        )
    jacobian = np.zeros((model.size + len(named.outputs), model.argument_count, len(variants)))
    jacobian[function.rows, function.columns] = entries  # variants stay side by side in memory
    jacobian.flags.writeable = False
    if model.given_preloads is not None or not model.system.preloads:
        stiffness = np.abs(jacobian[: model.size, : model.size]).max(axis=(0, 1))
        _check_balance(variants, at_rest, stiffness)
    return LinearVariants(variants, named, np.moveaxis(jacobian, -1, 0), slopes)


def _is_singular(mass: Array) -> Array:
    """The rule of `LinearModel.mass_factor` for many mass matrices."""
    diagonal = np.diagonal(mass, axis1=1, axis2=2)
    massless = np.any(diagonal <= 0, axis=1)
    scale = 1 / np.sqrt(np.where(massless[:, None], 1.0, diagonal))
    smallest = np.linalg.eigvalsh(mass * scale[:, :, None] * scale[:, None, :])[:, 0]
    return np.asarray(massless | (smallest <= mass.shape[-1] * LEAST_INERTIA))


def _check_continuity(variants: Variants, at_rest: Array, slope_rule: SlopeRules) -> None:
    """Look for jumps in one direction of all arguments together; a variant that has one is refused alone."""
    directions = np.sqrt(np.arange(2, 2 + len(at_rest)))[:, None] * BESIDE
    residual = variants.model.compiled.residual
    beside = [residual.of_variants(variants.values, at_rest + step) for step in (directions, -directions)]
    for suspect in np.flatnonzero((np.abs(beside[0] - beside[1]) > CONTINUOUS).any(axis=0)):
        try:
            linearise(variants.one(int(suspect)), slope_rule)
        except LinearisationError as error:
            raise LinearisationError(f"variant {variants.start + suspect}: {error}") from None


def _check_balance(variants: Variants, at_rest: Array, stiffness: Array) -> None:
    """Preloads that are found hold every variant; others may not."""
    residual = np.abs(variants.model.compiled.residual.of_variants(variants.values, at_rest)).max(axis=0)
    held = np.zeros_like(residual)
    if variants.model.system.preloads:
        unloaded = variants.values | {symbol.name: 0.0 for symbol in variants.model.system.preloads}
        held = np.abs(variants.model.compiled.residual.of_variants(unloaded, at_rest)).max(axis=0)
    moved = np.flatnonzero(residual > np.maximum(RESIDUAL_TOLERANCE * held, ROUNDING * stiffness))
    if len(moved):
        raise OperatingPointError(
            f"the design position of variant {variants.start + moved[0]} of {variants.model.system.name!r} "
            f"is not an equilibrium: {residual[moved[0]]:.3g} is left; use find_equilibrium on it alone"
        )
