"""Extremes of an orbit's outputs between the samples, corners included."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from chassym.nonlinear.harmonics.fourier import samples_for

if TYPE_CHECKING:
    from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit

_POINTS, _REFINEMENTS = 17, 4
"""Places in a bracket, and how often it shrinks: 8^4-fold in all. A wave of the highest harmonic is then read
to 2e-8 of its amplitude, a corner as steep as that wave to 2e-4.
"""


def extremes(orbit: FourierOrbit, rows: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest value of some outputs over one period, each shape (len(rows),).

    The best of equidistant samples brackets an extreme; the bracket is then sampled again and shrinks
    eightfold each time. That needs no derivative, so it finds the tip of a corner as well as the top of a
    smooth wave.
    """
    count = samples_for(orbit.harmonics)
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
