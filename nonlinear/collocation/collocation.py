"""Periodic orbits by collocation in pieces that end where a force bends.

Between the instants at which the motion passes the knots of tables the equations are smooth, and Gauss
collocation converges with the number of points as fast as for any smooth problem, without the slow tail that
corners leave in a Fourier series. The accelerations at the Gauss points of a piece are eliminated in it; what
is left, the states at the boundaries, form a cyclic chain of small systems whose product is the monodromy
matrix (Ascher, Mattheij and Russell, Numerical Solution of Boundary Value Problems, 1995, sections 5.4, 7.3;
Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sections II.7 and II.14).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.collocation.cyclic_chain import CyclicChain
from chassym.nonlinear.collocation.saltation import saltations
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.orbits.gauss_points import gauss_points
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

Array = np.ndarray


_TOGETHER = 40000
"""Numbers in the matrices of the pieces that are solved together: few enough to stay in the caches."""


_ALIKE = 0.5
"""Part of a piece by which its start may have moved for the piece to be taken for the same."""


class Linearisation:
    """The collocation equations of an orbit, linearised about it and condensed to its boundaries.

    Parameters
    ----------
    orbit
        What is linearised about; it need not be balanced yet.
    """

    def __init__(self, orbit: PiecewiseOrbit) -> None:
        self._orbit = orbit
        self._points = gauss_points(orbit.points)
        n, (pieces, points) = orbit.model.size, orbit.accelerations.shape[:2]
        arguments = orbit.arguments_in_pieces(self._points.places)
        solved = np.empty((pieces, points, n, 2 * n + 1))
        together = max(1, _TOGETHER // (points * n) ** 2)
        for start in range(0, pieces, together):
            part = slice(start, start + together)
            solved[part] = self._condensed(part, arguments[:, start * points : (start + together) * points])
        self._end = self._points.moved_by_end(solved, orbit.durations_s)
        self._solved = solved.reshape(pieces, -1, 2 * n + 1)

    def _condensed(self, part: slice, arguments: Array) -> Array:
        """Accelerations by the state at the start of some pieces, and by the residual.

        Parameters
        ----------
        arguments
            The equations' arguments at the points of these pieces.

        Returns
        -------
        numpy.ndarray
            Shape (pieces, points, n, 2 n + 1).
        """
        durations, points, model = self._orbit.durations_s[part, None, None], self._points, self._orbit.model
        n, shape = model.size, (len(durations), points.count)
        derivatives = _derivatives(model, arguments).reshape(*shape, 3, n * n)
        unit = np.broadcast_to(np.eye(points.count), (*shape, points.count))
        weights = np.stack([durations**2 * points.second, durations * points.first, unit], axis=-1)
        blocks = (weights @ derivatives).reshape(*shape, points.count, n, n)
        stiffness, damping = (derivatives[:, :, kind].reshape(*shape, n, n) for kind in range(2))
        right = np.empty((*shape, n, 2 * n + 1))
        right[..., :n] = stiffness
        right[..., n:-1] = damping + (durations * points.places.values[:, None])[..., None] * stiffness
        right[..., -1] = model.residual(arguments).T.reshape(*shape, n)
        size = points.count * n
        matrix = blocks.swapaxes(2, 3).reshape(-1, size, size)
        solved = np.linalg.solve(matrix, right.reshape(-1, size, 2 * n + 1))
        return np.asarray(solved.reshape(right.shape))

    @cached_property
    def _maps(self) -> Array:
        """What becomes of a small deviation at the start of every piece by its end, (pieces, 2 n, 2 n)."""
        n = self._orbit.model.size
        maps = -self._end[:, :, :-1]
        diagonal, rates = np.arange(2 * n), np.arange(n)
        maps[:, diagonal, diagonal] += 1.0
        maps[:, rates, n + rates] += self._orbit.durations_s[:, None]
        return maps

    @property
    def _gaps(self) -> Array:
        """By how much a piece, its equations fulfilled, would miss the start of the next, (pieces, 2 n)."""
        return self._orbit.jumps - self._end[:, :, -1]

    @cached_property
    def _chain(self) -> CyclicChain:
        return CyclicChain(self._maps)

    @property
    def monodromy(self) -> Array:
        """The map of small deviations from the first boundary over one orbit, shape (2 n, 2 n)."""
        at_starts = saltations(self._orbit)
        if at_starts is None:
            return self._chain.product
        return CyclicChain(np.roll(at_starts, -1, axis=0) @ self._maps).product

    def deviations(self, other: PiecewiseOrbit) -> Array | None:
        """By how much the starts of another orbit are off, as its jumps tell by the maps of this one.

        Parameters
        ----------
        other
            One whose pieces are those of this one or parts of them, moved by less than half of their lengths.

        Returns
        -------
        numpy.ndarray or None
            Shape (pieces, 2 n). None if it is cut in another way: the maps are not its own then.
        """
        here, there = (np.exp(1j * each.boundaries[:-1]) for each in (self._orbit, other))
        apart = np.abs(here[:, None] - there)
        begins = apart.argmin(axis=1)
        if np.any(apart.min(axis=1) > _ALIKE * np.diff(other.boundaries)[begins]):
            return None
        order = begins.argsort()
        owner = order[np.searchsorted(begins[order], np.arange(len(there)), side="right") - 1]
        gaps = np.zeros_like(self._orbit.starts)
        np.add.at(gaps, owner, other.iterated_jumps)
        return self._solution(gaps)[owner]

    def corrected(self) -> PiecewiseOrbit:
        """The orbit after one step of Newton's method.

        Raises
        ------
        NoPeriodicOrbitError
            If a small deviation comes back unchanged, so the orbit is not unique.
        """
        deviations = self._solution(self._gaps)
        deviations = np.concatenate([deviations, np.ones((len(deviations), 1))], axis=1)
        change = (self._solved @ deviations[:, :, None])[:, :, 0]
        orbit = self._orbit
        return replace(
            orbit,
            starts=orbit.starts + deviations[:, :-1],
            accelerations=orbit.accelerations - change.reshape(orbit.accelerations.shape),
        )

    def _solution(self, gaps: Array) -> Array:
        """Deviations of the starts that close gaps between the pieces.

        Raises
        ------
        NoPeriodicOrbitError
            If a small deviation comes back unchanged, so the orbit is not unique.
        """
        try:
            return self._chain.solution(gaps)
        except np.linalg.LinAlgError:
            raise NoPeriodicOrbitError(
                f"at {self._orbit.excitation.frequency_hz:g} Hz nothing brings a deviation back; give every "
                "coordinate some stiffness, and its resonance some damping"
            ) from None


def _derivatives(model: Model, arguments: Array) -> Array:
    """Of the residual by coordinates, rates and accelerations, shape (samples, 3, n n)."""
    n, function = model.size, model.residual_jacobian
    kinds, columns = np.divmod(function.columns, n)
    full = np.zeros((arguments.shape[1], 3, n * n))
    full[:, kinds, function.rows * n + columns] = function(arguments).T
    return full


def in_pieces(orbit: PeriodicOrbit, boundaries: Array, points: int) -> PiecewiseOrbit:
    """An orbit cut at boundaries, its accelerations taken from the equations of motion at Gauss points."""
    phases = boundaries[:-1, None] + np.diff(boundaries)[:, None] * gauss_points(points).places.values
    n, count = orbit.model.size, phases.size
    every = np.concatenate([phases.ravel(), boundaries[:-1]])
    moved = orbit.motion_at(every)
    arguments = orbit.with_accelerations(moved[:, :count], orbit.inputs_at(every[:count]))
    return PiecewiseOrbit(
        orbit.model,
        orbit.excitation,
        boundaries,
        moved[:, count:].T,
        arguments[2 * n : 3 * n].T.reshape(*phases.shape, n),
        orbit.subharmonic,
    )
