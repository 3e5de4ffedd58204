"""Static equilibrium at the design position: the preloads that hold it, and how well they do."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chassym.derivation.compilation.numeric import CompiledEquations

TOLERANCE = 1e-9
"""Largest residual accepted at an equilibrium, relative to the largest generalised force of the weights."""

_WELL_CONDITIONED = 1e6
"""Condition number up to which a matrix has full rank for sure."""

_RESEMBLES = 0.9
"""Distance from the unit matrix up to which normal equations are solved: their condition is then below 19."""


class EquilibriumError(ValueError):
    """No static equilibrium at the position asked for."""


def solve_preloads(
    compiled: CompiledEquations, values: Mapping[str, np.ndarray | float], sets: int
) -> dict[str, np.ndarray]:
    """Preloads (N or N m) with which the design position is in static equilibrium under gravity.

    The residual at rest is linear in the preloads, r = r0 + A preload. A is its derivative where every
    preload is a push, which laws that cannot pull answer, too. Of several solutions the one of smallest norm
    is taken, which shares a load evenly.

    Parameters
    ----------
    compiled
        The system.
    values
        By parameter name: a number, or an array of shape (sets,).
    sets
        Number of parameter sets.

    Returns
    -------
    dict of str to numpy.ndarray
        By preload name, shape (sets,).

    Raises
    ------
    EquilibriumError
        If no preloads balance the weights.
    """
    names = [symbol.name for symbol in compiled.system.preloads]
    without = dict(values) | dict.fromkeys(names, 0.0)
    if not names:
        return {}
    start = design_residual(compiled, without, sets)
    action = compiled.preload_action
    pushed = dict(values) | dict.fromkeys(names, -1.0)
    matrices = np.zeros((sets, len(start), len(names)))
    matrices[:, action.rows, action.columns] = action.of_variants(pushed, _at_rest(compiled, sets)).T
    if not (np.isfinite(start).all() and np.isfinite(matrices).all()):
        raise EquilibriumError(
            f"mechanism {compiled.system.name!r}: its forces at the design position are not finite; "
            "a parameter is too large, or one that is divided by is zero"
        )
    solution = _least_squares(matrices, -start.T)
    found = dict(zip(names, solution.T, strict=True))
    left = np.abs(design_residual(compiled, without | found, sets))
    refused = np.flatnonzero(left.max(axis=0) > TOLERANCE * np.abs(start).max(axis=0))
    if len(refused):
        worst = int(left[:, refused[0]].argmax())
        coordinate = compiled.system.coordinates[worst]
        raise EquilibriumError(
            f"mechanism {compiled.system.name!r}: no preload holds the design position; "
            f"{left[worst, refused[0]]:.3g} is left on coordinate {coordinate.name!r}; "
            "preload an element that acts on it"
        )
    return found


def _least_squares(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Least-squares solutions x of A x = b, of several that of smallest norm, shape (sets, unknowns).

    The triangular factor of the mean matrix, if that has full rank, makes the columns of those that resemble
    it nearly orthonormal: their normal equations then lose no digits. The others take a pseudo-inverse.

    Parameters
    ----------
    matrices, right
        A and b, shapes (sets, equations, unknowns) and (sets, equations).
    """
    factor = np.asarray(np.linalg.qr(matrices.mean(axis=0), mode="r"))
    solutions = np.empty((len(matrices), matrices.shape[2]))
    resembling = np.zeros(len(matrices), dtype=bool)
    if factor.shape[0] == factor.shape[1] and np.linalg.cond(factor) < _WELL_CONDITIONED:
        to_unknowns = np.linalg.inv(factor)
        columns = matrices @ to_unknowns
        lengths = np.sqrt((columns**2).sum(axis=1))
        columns /= lengths[:, None]
        normal = columns.swapaxes(1, 2) @ columns
        resembling = np.linalg.norm(normal - np.eye(len(factor)), axis=(1, 2)) < _RESEMBLES
        products = (right[:, None] @ columns)[resembling].swapaxes(1, 2)
        parts = np.linalg.solve(normal[resembling], products)[:, :, 0] / lengths[resembling]
        solutions[resembling] = parts @ to_unknowns.T
    rest = ~resembling
    if rest.any():
        inverses = np.linalg.pinv(matrices[rest], rcond=1e-12)
        solutions[rest] = (inverses @ right[rest][:, :, None])[:, :, 0]
    return solutions


def design_residual(
    compiled: CompiledEquations, values: Mapping[str, np.ndarray | float], sets: int
) -> np.ndarray:
    """The equations' residual at rest in the design position (N or N m), shape (n, sets)."""
    return compiled.residual.of_variants(values, _at_rest(compiled, sets))


def _at_rest(compiled: CompiledEquations, sets: int) -> np.ndarray:
    """Arguments of compiled functions at rest in the design position, shape (arguments, sets)."""
    return np.zeros((compiled.argument_count, sets))
