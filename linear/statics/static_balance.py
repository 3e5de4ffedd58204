"""The search for static balance: where no force is left, by least squares and by settling slowly."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from chassym.linear.operating_point import OperatingPoint, OperatingPointError

Array = np.ndarray

_TOLERANCE = 4 * np.finfo(float).eps
"""Least change, relative to the unknowns or to the squared forces, with which the search goes on."""

BALANCED = 1e-10
"""Largest residual that balances, relative to the largest force."""

_ROUNDING = 1e-15
"""Part of a metre or radian that counts as rounding: the force that it makes balances, too."""

_FINE = 1e-6
"""Unit of forces, relative to the largest one: the search stops at a gradient of `_TOLERANCE` in it."""

_SETTLED = 1e-3
"""Velocity at which settling ends, relative to the one at its start."""

_SETTLING_TIME = 100.0
"""Length of settling (s^2): that of what swings once in half a minute is over by then."""


@dataclass(frozen=True, eq=False)
class Balance:
    """The forces that are left, as functions of unknowns: free coordinates, then preloads.

    Everything is scaled: coordinates so that their stiffness is one, forces by their work on them, preloads
    by the largest force.

    Attributes
    ----------
    begin
        Where to begin. Its other coordinates stay, as do its inputs, loads and other preloads.
    free
        Indices of the coordinates to find.
    preloads
        Names of the preloads to find.
    """

    begin: OperatingPoint
    free: Array
    preloads: tuple[str, ...] = ()

    @cached_property
    def force_scale(self) -> Array:
        """Force (N or N m) on every coordinate that does the same work, shape (n,)."""
        motion = self.begin.coordinate_scale
        return (self.begin.largest_force * motion.max() or 1.0) / motion

    @cached_property
    def unknown_scale(self) -> Array:
        """Unit of every unknown."""
        moved = self.begin.coordinate_scale**2 * self.force_scale
        return np.append(moved[self.free], [self.begin.largest_force or 1.0] * len(self.preloads))

    @cached_property
    def first(self) -> Array:
        """Unknowns at the beginning."""
        preloads = [self.begin.model.preloads[name] for name in self.preloads]
        return np.append(self.begin.coordinates[self.free], preloads) / self.unknown_scale

    def at(self, unknowns: Array) -> OperatingPoint:
        """The position, and the model with its preloads, that unknowns mean."""
        model, coordinates = self.begin.model, self.begin.coordinates.copy()
        coordinates[self.free], preloads = np.split(unknowns * self.unknown_scale, [len(self.free)])
        if self.preloads:
            adjusted = dict(zip(self.preloads, preloads.tolist(), strict=True))
            model = replace(model, given_preloads={**model.preloads, **adjusted})
        return replace(self.begin, model=model, coordinates=coordinates)

    def forces(self, unknowns: Array) -> Array:
        """Forces left, shape (n,)."""
        return self.at(unknowns).residual / (_FINE * self.force_scale)

    def jacobian(self, unknowns: Array) -> Array:
        """Their exact derivatives by the unknowns, shape (n, unknowns)."""
        point = self.at(unknowns)
        derivatives = point.stiffness[:, self.free]
        if self.preloads:
            model = point.model
            shape = model.size + len(model.system.outputs), len(self.preloads)
            by_preload = model.compiled.jacobian(self.preloads).bind(model.values)
            derivatives = np.hstack([derivatives, by_preload.matrix(point.arguments, shape)[: model.size]])
        check_finite(point, derivatives)
        return derivatives * self.unknown_scale / (_FINE * self.force_scale[:, None])


def solved(balance: Balance, reluctance: float = 0.0) -> OperatingPoint:
    """Where the forces left are least.

    Parameters
    ----------
    balance
        What is sought, and where to begin.
    reluctance
        What a change of preloads counts, relative to a force that is left.
    """
    first = balance.first
    if not len(first):
        return balance.begin
    cost = reluctance / _FINE * np.eye(len(first))[len(balance.free) :]

    def forces(unknowns: Array) -> Array:
        return np.append(balance.forces(unknowns), cost @ (unknowns - first))

    def jacobian(unknowns: Array) -> Array:
        return np.vstack([balance.jacobian(unknowns), cost])

    found = least_squares(forces, first, jacobian, ftol=_TOLERANCE, xtol=_TOLERANCE, gtol=_TOLERANCE)
    return balance.at(found.x)


def settled(begin: OperatingPoint) -> OperatingPoint:
    """Where it is after a motion in thick oil, which drags every coordinate in proportion to its inertia.

    The velocity is the force over the inertia, so that time is in s^2. Where this motion ends no force is
    left, and it leaves what falls over.
    """
    n = begin.model.size
    inertia = np.diag(begin.model.residual_jacobian.matrix(begin.arguments, (n, 3 * n))[:, 2 * n :])
    inertia = np.where(inertia > 0, inertia, 1.0)

    def velocity(time: float, coordinates: Array) -> Array:
        return -replace(begin, coordinates=coordinates).residual / inertia

    def jacobian(time: float, coordinates: Array) -> Array:
        point = replace(begin, coordinates=coordinates)
        check_finite(point, point.stiffness)
        return -point.stiffness / inertia[:, None]

    def speed(coordinates: Array) -> float:
        return float(np.abs(velocity(0.0, coordinates)).max())

    def is_moving(time: float, coordinates: Array) -> float:
        return speed(coordinates) - _SETTLED * speed(begin.coordinates)

    is_moving.terminal = True  # type: ignore[attr-defined]
    span = (0.0, _SETTLING_TIME)
    motion = solve_ivp(velocity, span, begin.coordinates, "Radau", jac=jacobian, events=is_moving)
    return replace(begin, coordinates=motion.y[:, -1])


def is_balanced(point: OperatingPoint) -> bool:
    """Whether what is left is a small part of the forces, or may be rounding."""
    left = np.abs(point.residual).max()
    if left <= BALANCED * point.largest_force:
        return True
    reach = 1 + np.abs(point.coordinates).max()
    return bool(left <= _ROUNDING * reach * np.abs(point.stiffness).max())


def check_finite(point: OperatingPoint, numbers: Array) -> None:
    """Refuse forces or derivatives that are not finite.

    Raises
    ------
    OperatingPointError
        If one is not.
    """
    if not np.isfinite(numbers).all():
        raise OperatingPointError(
            f"{point.model.system.name!r} {point.description}: a force or its derivative is not finite; "
            "check the parameters, or start elsewhere"
        )
