"""Whether a periodic orbit is stable: small deviations from it die out."""

from __future__ import annotations

import numpy as np

from chassym.nonlinear.collocation.floquet import multipliers
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit


def die_out(multipliers: np.ndarray) -> np.ndarray:
    """Whether deviations with some Floquet multipliers die out: all magnitudes are below one.

    Parameters
    ----------
    multipliers
        Complex, shape (2 n,) or (orbits, 2 n).

    Returns
    -------
    numpy.ndarray
        Of bool, shape () or (orbits,).

    Examples
    --------
    >>> die_out(np.array([[0.5 + 0.5j, 0.5 - 0.5j], [1.2, 0.1]]))
    array([ True, False])
    """
    return np.asarray(np.abs(multipliers).max(axis=-1) < 1.0)


def is_stable(orbit: PeriodicOrbit) -> bool:
    """Whether small deviations from an orbit die out."""
    return bool(die_out(multipliers(orbit)))
