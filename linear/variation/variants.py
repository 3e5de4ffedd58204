"""Linear models of many variants of a model at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from chassym.derivation import Variants
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.linearisation import linearise, slopes_of, split
from chassym.linear.operating_point import RESIDUAL_TOLERANCE, OperatingPointError, design_position
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
        try:
            full[:, n:] = -np.linalg.solve(mass, np.concatenate([stiffness, damping], axis=2))
        except np.linalg.LinAlgError:
            singular = int(np.linalg.cond(mass).argmax())
            raise LinearisationError(
                f"mass matrix of variant {singular} of {self.named.name!r} is singular; give what moves "
                "there a mass or an inertia"
            ) from None
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
    if model.given_preloads is not None or not model.system.preloads:
        _check_balance(variants, at_rest)
    function = model.compiled.linearisation
    entries = function.of_variants(values, at_rest)
    if not np.isfinite(entries).all():
        wrong = int(np.flatnonzero(~np.isfinite(entries).all(axis=0))[0])
        raise LinearisationError(
            f"a derivative of variant {wrong} of {named.name!r} is not finite; check its parameters"
        )
    jacobian = np.zeros((model.size + len(named.outputs), model.argument_count, len(variants)))
    jacobian[function.rows, function.columns] = entries  # variants stay side by side in memory
    return LinearVariants(variants, named, np.moveaxis(jacobian, -1, 0), slopes)


def _check_balance(variants: Variants, at_rest: Array) -> None:
    """Preloads that are found hold every variant; others may not."""
    residual = np.abs(variants.model.compiled.residual.of_variants(variants.values, at_rest)).max(axis=0)
    unloaded = variants.values | {symbol.name: 0.0 for symbol in variants.model.system.preloads}
    held = np.abs(variants.model.compiled.residual.of_variants(unloaded, at_rest)).max(axis=0)
    moved = np.flatnonzero(residual > RESIDUAL_TOLERANCE * held)
    if len(moved):
        raise OperatingPointError(
            f"the design position of variant {moved[0]} of {variants.model.system.name!r} is not an "
            f"equilibrium: {residual[moved[0]]:.3g} is left; use find_equilibrium on it alone"
        )
