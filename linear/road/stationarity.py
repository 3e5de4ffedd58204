"""Whether random vibration becomes stationary: every motion of the model has to decay."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eig

from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.motion import mode_names

STABILITY = 1e-7
"""Decay rates below this part of the largest eigenvalue are those of no decay."""


def check_stationarity(linear: LinearModel) -> None:
    """Refuse a model that does not come to rest.

    Raises
    ------
    LinearisationError
        If a motion grows, or lasts for ever: a root mean square on a random road does not exist then.
    """
    values, vectors = eig(displacements_and_rates(linear).A)
    worst = int(values.real.argmax())
    if values[worst].real < -STABILITY * np.abs(values).max():
        return
    name = mode_names(linear, [vectors[: len(linear.coordinates), worst]], [True])[0]
    verb = "grows" if values[worst].real > STABILITY * np.abs(values).max() else "does not decay"
    raise LinearisationError(
        f"{linear.name!r} on a random road: {name!r} at {abs(values[worst]) / (2 * np.pi):.4g} Hz {verb} "
        f"(eigenvalue {values[worst]:.4g} 1/s): no root mean square exists; add damping or a spring"
    )
