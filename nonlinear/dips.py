"""Where a quantity may pass zero and come back between two of its samples."""

from __future__ import annotations

import numpy as np

Array = np.ndarray

_CLOSE = 0.1
"""How near zero a parabola's extreme must come for the quantity itself to be looked at there, as a part of
the parabola's second difference: the two differ by less where samples describe the quantity at all.
"""


def possible_dips(values: Array) -> tuple[Array, Array]:
    """Extremes between samples that come so near zero that they may lie beyond it.

    A parabola is laid through every sample and its neighbours; each answers for half the way to its
    neighbours, the outermost for the whole way.

    Parameters
    ----------
    values
        Equidistant samples of several quantities, shape (quantities, samples), three samples at least.

    Returns
    -------
    tuple of numpy.ndarray
        Quantities and places of the extremes, in samples from the first, shape (dips,) each.

    Examples
    --------
    >>> possible_dips(np.array([[1.2, 0.2, 0.01, 0.6, 2.0], [5.0, 4.0, 3.0, 4.0, 5.0]]))[0]
    array([0])
    """
    before, here, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    second = before - 2 * here + after
    shift = 0.5 * (before - after) / np.where(second == 0, np.inf, second)
    reach = np.full((2, here.shape[1]), 0.5)
    reach[0, 0] = reach[1, -1] = 1.0
    side = np.where(here >= 0, 1.0, -1.0)
    extreme = here - 0.25 * (before - after) * shift
    stays = ((before >= 0) == (here >= 0)) & ((after >= 0) == (here >= 0))
    is_near = (side * second > 0) & (side * extreme < _CLOSE * np.abs(second))
    quantity, sample = np.nonzero(stays & is_near & (-reach[0] <= shift) & (shift <= reach[1]))
    return quantity, sample + 1 + shift[quantity, sample]
