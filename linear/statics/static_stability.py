"""Static stability: whether a model at rest falls over, and which way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from chassym.linear.operating_point import OperatingPoint

Array = np.ndarray

PATIENCE_S = 1000.0
"""What takes longer (s) to grow e-fold does not fall over."""

_ROUNDING = 1e-12
"""Eigenvalues below this part of the largest one are zero."""

_REAL = 1e-6
"""Imaginary part, relative to the eigenvalue, up to which it is real."""


@dataclass(frozen=True, eq=False)
class Divergence:
    """How a position falls over.

    Attributes
    ----------
    rate
        It grows as exp(rate t) without damping (1/s).
    direction
        Coordinates relative to each other, shape (n,).
    coordinate
        The one with the largest part of the kinetic energy.
    """

    rate: float
    direction: Array
    coordinate: str


def find_divergence(point: OperatingPoint) -> Divergence | None:
    """The fastest way in which a position falls over; None if it is statically stable or indifferent.

    It falls over if K v = -rate^2 M v has a real rate greater than 1 / `PATIENCE_S`: for a symmetric K
    wherever it is not positive semidefinite, whatever M is (Sylvester's law of inertia). Where follower
    forces make K unsymmetric an oscillation may grow without any such rate: that is a matter of damped modes,
    not of statics.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear.operating_point import design_position
    >>> print(find_divergence(design_position(load_model("quarter_car"))))
    None
    """
    model, n = point.model, point.model.size
    mass = model.residual_jacobian.matrix(point.arguments, (n, 3 * n))[:, 2 * n :]
    values, directions = eig(point.stiffness, mass)
    moving = np.isfinite(values)  # a direction without inertia has none
    values, directions = values[moving], directions[:, moving].real
    real = np.abs(values.imag) <= _REAL * np.abs(values)
    least = max(PATIENCE_S**-2, _ROUNDING * np.abs(values).max(initial=0.0))
    falling = np.flatnonzero(real & (values.real < -least))
    if not len(falling):
        return None
    fastest = falling[values.real[falling].argmin()]
    direction = directions[:, fastest]
    most = int((np.diag(mass) * direction**2).argmax())
    rate = float(np.sqrt(-values.real[fastest]))
    return Divergence(rate, direction, model.system.coordinates[most].name)
