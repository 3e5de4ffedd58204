"""One period of an integrated motion as an orbit in pieces, and its deviations by integration too."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp

from chassym.derivation import Model
from chassym.nonlinear.collocation.floquet import monodromy
from chassym.nonlinear.collocation.mesh import FULL_TURN, fastest_rate
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.orbits.gauss_points import gauss_points
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit
from chassym.nonlinear.simulation.right_hand_side import RightHandSide
from chassym.nonlinear.simulation.simulate import simulate

Array = np.ndarray

_POINTS = 12
"""Gauss points of a piece."""

_PER_PIECE = 3.0
"""Radians that the fastest natural motion goes through in a piece at most; twelve points leave 1e-11."""

_FEWEST = 24
"""Pieces of an orbit that knows no faster motion than its own."""

_MOST_CORRECTIONS = 30
"""Newton steps before an orbit is taken not to close."""

_UNCHANGED = 1e-10
"""Difference of a Floquet multiplier from one below which a deviation comes back unchanged."""

_TOGETHER = 1e-9
"""Share of the orbit below which two events are taken for one."""


@dataclass(frozen=True, eq=False)
class IntegratedOrbit(PiecewiseOrbit):
    """An orbit whose pieces were integrated from a state at phase zero: at its end it need not be closed yet.

    Attributes
    ----------
    end
        Coordinates and rates after the whole orbit, shape (2 n,).
    relative_tolerance
        Of the integration.
    """

    end: Array = field(kw_only=True, repr=False)
    relative_tolerance: float = field(kw_only=True)

    @property
    def gap(self) -> Array:
        """By how much it is not closed, shape (2 n,)."""
        return np.asarray(self.end - self.starts[0])

    @property
    def relative_gap(self) -> float:
        """Largest gap of a rate, relative to the rates."""
        n = self.model.size
        return float(np.abs(self.gap[n:]).max() / self.largest_rate)

    @cached_property
    def closing(self) -> Array:
        """What closes the orbit when added to its first state, small as it is: all that is left to die out.

        Raises
        ------
        NoPeriodicOrbitError
            If nothing brings a deviation back.
        """
        around = self.monodromy
        if np.abs(np.linalg.eigvals(around) - 1).min() < _UNCHANGED:
            raise NoPeriodicOrbitError(
                f"integration at {self.excitation.frequency_hz:g} Hz: nothing brings a deviation back; give "
                "every coordinate some stiffness, and its resonance some damping"
            )
        return np.linalg.solve(np.eye(len(around)) - around, self.gap)

    @cached_property
    def monodromy(self) -> Array:
        """The map of small deviations over the orbit: x' = A(t) x integrated in all pieces side by side.

        A, smooth in every piece, is interpolated between its Gauss points, none of which lies on a knot.
        """
        size, points = 2 * self.model.size, gauss_points(self.points)
        scaled = self.durations_s[:, None, None] * self._systems.reshape(-1, self.points, size * size)

        def change(place: float, deviations: Array) -> Array:
            value, _, _ = points.weights(np.array([place]))
            system = (value @ scaled).reshape(-1, size, size)
            return np.asarray((system @ deviations.reshape(-1, size, size)).ravel())

        start = np.tile(np.eye(size), (len(scaled), 1, 1)).ravel()
        tolerance = self.relative_tolerance
        moved = solve_ivp(change, (0.0, 1.0), start, "DOP853", [1.0], rtol=tolerance, atol=1e-3 * tolerance)
        whole = np.eye(size)
        for piece in moved.y[:, -1].reshape(-1, size, size):
            whole = piece @ whole
        return whole

    @property
    def _systems(self) -> Array:
        """A(t) at the Gauss points of all pieces, one after the other, shape (points, 2 n, 2 n)."""
        points = gauss_points(self.points).places
        rates = RightHandSide(self.model, self.excitation)
        states = self.motion_in_pieces(points)[: 2 * self.model.size].reshape(2 * self.model.size, -1).T
        times = self.phases_of(points).ravel() / self.angular_frequency
        return np.stack([rates.jacobian(t, state) for t, state in zip(times, states, strict=True)])


def integrated_orbit(
    model: Model, excitation: Harmonic, state: Array, relative_tolerance: float, subharmonic: int = 1
) -> IntegratedOrbit:
    """Integrate over one orbit and keep it in pieces between its events.

    Parameters
    ----------
    state
        Coordinates and rates at phase zero, shape (2 n,).
    relative_tolerance
        Of the integration.

    Raises
    ------
    SimulationError
        If it cannot be integrated.
    """
    duration_s, n = subharmonic / excitation.frequency_hz, model.size

    def moved(times_s: Array) -> tuple[Array, Array]:
        found = simulate(model, excitation, times_s, start=state, relative_tolerance=relative_tolerance)
        return found.states, found.event_times_s

    _, events_s = moved(np.array([0.0, duration_s]))
    places = _boundaries(events_s / duration_s, fastest_rate(model) * duration_s)
    points = gauss_points(_POINTS).places.values
    inside = places[:-1, None] + np.diff(places)[:, None] * np.concatenate([[0.0], points])
    states, _ = moved(duration_s * np.append(inside.ravel(), 1.0))
    orbit = IntegratedOrbit(
        model,
        excitation,
        FULL_TURN * places,
        states[:, : -1 : _POINTS + 1].T,
        np.empty((len(places) - 1, _POINTS, n)),
        subharmonic,
        end=states[:, -1],
        relative_tolerance=relative_tolerance,
    )
    at_points = np.arange(states.shape[1] - 1) % (_POINTS + 1) > 0
    phases = FULL_TURN * inside.ravel()[at_points]
    arguments = orbit.with_accelerations(states[:, :-1][:, at_points], orbit.inputs_at(phases))
    orbit.accelerations[:] = arguments[2 * n : 3 * n].T.reshape(orbit.accelerations.shape)
    return orbit


def closed_orbit(
    model: Model, excitation: Harmonic, state: Array, relative_tolerance: float, subharmonic: int = 1
) -> tuple[IntegratedOrbit, int]:
    """Shoot: correct the state at phase zero by Newton's method until the integrated orbit closes.

    Parameters are those of `integrated_orbit`.

    Returns
    -------
    tuple of IntegratedOrbit and int
        The orbit, and how many corrections it took, one at least.

    Raises
    ------
    NoPeriodicOrbitError
        If it does not come to close.
    SimulationError
        If a motion on the way cannot be integrated.
    """
    orbit = integrated_orbit(model, excitation, state, relative_tolerance, subharmonic)
    for iterations in range(1, _MOST_CORRECTIONS + 1):
        state = state + orbit.closing
        orbit = integrated_orbit(model, excitation, state, relative_tolerance, subharmonic)
        if orbit.relative_gap <= relative_tolerance:
            return orbit, iterations
    raise NoPeriodicOrbitError(
        f"shooting at {excitation.frequency_hz:g} Hz: after {_MOST_CORRECTIONS} corrections the orbit still "
        f"misses its start by {orbit.relative_gap:.2g} of its rates; start from a neighbouring orbit"
    )


def _boundaries(events: Array, turns: float) -> Array:
    """Events, and others between as close as the fastest natural motion needs, from 0 to 1 (pieces + 1,)."""
    inside = events[(events > _TOGETHER) & (events < 1 - _TOGETHER)]
    fixed = np.concatenate([[0.0], inside[np.diff(inside, prepend=0.0) > _TOGETHER], [1.0]])
    longest = 1 / max(_FEWEST, turns / _PER_PIECE)
    counts = np.ceil(np.diff(fixed) / longest).astype(int)
    parts = [np.arange(count) / count for count in counts]
    return np.append(
        np.repeat(fixed[:-1], counts) + np.concatenate(parts) * np.repeat(np.diff(fixed), counts), 1.0
    )


@monodromy.register
def _integrated(orbit: IntegratedOrbit) -> np.ndarray:
    return orbit.monodromy
