"""Static equilibrium at the design position: the preloads that hold it, and how well they do."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chassym.derivation.compilation.numeric import CompiledEquations

TOLERANCE = 1e-9
"""Largest residual accepted at an equilibrium, relative to the largest generalised force of the weights."""


class EquilibriumError(ValueError):
    """No static equilibrium at the position asked for."""


def solve_preloads(compiled: CompiledEquations, values: Mapping[str, float]) -> dict[str, float]:
    """Preloads (N or N m) with which the design position is in static equilibrium under gravity.

    The residual at rest is linear in the preloads, r = r0 + A preload, and one column of A is the difference
    that a unit preload makes. The unit is a push, which laws that cannot pull answer, too. Of several
    solutions the one of smallest norm is taken, which shares a load evenly.

    Raises
    ------
    EquilibriumError
        If no preloads balance the weights.
    """
    names = [symbol.name for symbol in compiled.system.preloads]
    without = dict(values) | dict.fromkeys(names, 0.0)
    if not names:
        return {}
    start = design_residual(compiled, without)
    columns = [start - design_residual(compiled, without | {name: -1.0}) for name in names]
    if not np.all(np.isfinite([start, *columns])):
        raise EquilibriumError(
            f"mechanism {compiled.system.name!r}: its forces at the design position are not finite; "
            "a parameter is too large, or one that is divided by is zero"
        )
    solution, *_ = np.linalg.lstsq(np.array(columns).T, -start, rcond=1e-12)
    found = {name: float(value) for name, value in zip(names, solution, strict=True)}
    left = design_residual(compiled, without | found)
    if np.abs(left).max() > TOLERANCE * np.abs(start).max():
        worst = compiled.system.coordinates[int(np.abs(left).argmax())]
        raise EquilibriumError(
            f"mechanism {compiled.system.name!r}: no preload holds the design position; "
            f"{np.abs(left).max():.3g} is left on coordinate {worst.name!r}; "
            "preload an element that acts on it"
        )
    return found


def design_residual(compiled: CompiledEquations, values: Mapping[str, float]) -> np.ndarray:
    """The equations' residual at rest in the design position, length n (N or N m)."""
    size = 3 * len(compiled.system.coordinates) + 2 * len(compiled.system.inputs)
    return np.asarray(compiled.residual.bind(values)(np.zeros((size, 1)))[:, 0])
