"""Extremes of an orbit's outputs between the samples, corners included."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit

_POINTS = 17
_REFINEMENTS = 4


def extremes(orbit: FourierOrbit, rows: list[int], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest value of some outputs over one period, each shape (len(rows),).

    The best of `count` samples brackets an extreme; the bracket is then sampled again and shrinks eightfold
    each time. That needs no derivative, so it finds the tip of a corner as well as the top of a smooth wave.
    """
    values = orbit.outputs(count)[rows]
    spacing = 2 * np.pi / count
    lowest, highest = values.argmin(axis=1) * spacing, values.argmax(axis=1) * spacing
    signs = np.repeat([-1.0, 1.0], len(rows))
    centres, best = (
        np.concatenate([lowest, highest]),
        np.concatenate([-values.min(axis=1), values.max(axis=1)]),
    )
    each, both = np.arange(2 * len(rows)), np.array([*rows, *rows])
    for _ in range(_REFINEMENTS):
        offsets = spacing * np.linspace(-1.0, 1.0, _POINTS)
        candidates = signs[:, None] * orbit.outputs_around(centres, offsets)[both, each]
        chosen = candidates.argmax(axis=1)
        centres = centres + offsets[chosen]
        best = np.maximum(best, candidates[each, chosen])
        spacing *= 2.0 / (_POINTS - 1)
    return -best[: len(rows)], best[len(rows) :]
