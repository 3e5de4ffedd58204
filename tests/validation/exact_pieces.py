"""Periodic motions of piecewise-linear systems under harmonic excitation, pieced together from exact ones.

Between two switchings a state x obeys x' = A x + b + B (cos w t, sin w t). With y = (x, 1, cos w t, sin w t)
that is y' = C y, so that y(t + s) = exp(C s) y(t) whatever A is. Switchings happen at roots of linear
functions of y. Forces are continuous, so that deviations pass a switching unchanged, and the derivative of
the map over one period is the product of the pieces' exponentials. This is how S. W. Shaw and P. J. Holmes,
"A periodically forced piecewise linear oscillator", Journal of Sound and Vibration 90 (1983) 129-155, found
periodic motions and their stability; nothing of it is approximate but the rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

Array = np.ndarray
Signs = tuple[bool, ...]

STEPS = 400
"""Steps of a forcing period in which switchings are looked for."""


@dataclass(frozen=True, eq=False)
class PiecewiseLinear:
    """A system whose matrix depends on the signs of some functions of the state.

    Attributes
    ----------
    frequency
        Of the excitation (rad/s).
    switches
        Functions whose signs select a piece, as rows over y.
    rates
        By the signs, x' as rows over y, shape (n, n + 3).
    """

    frequency: float
    switches: Array
    rates: Callable[[Signs], Array]

    @property
    def size(self) -> int:
        return self.switches.shape[1] - 3

    @property
    def period(self) -> float:
        return 2 * np.pi / self.frequency

    def matrix(self, signs: Signs) -> Array:
        """C of one piece."""
        n, w = self.size, self.frequency
        matrix = np.zeros((n + 3, n + 3))
        matrix[:n] = self.rates(signs)
        matrix[n + 1, n + 2], matrix[n + 2, n + 1] = -w, w
        return matrix

    def pieces(self, state: Array, duration: float) -> list[Piece]:
        """The motion from a state at time zero."""
        y = np.concatenate([state, [1.0, 1.0, 0.0]])
        signs = tuple(bool(each > 0) for each in self.switches @ y)
        found: list[Piece] = []
        while duration > 0:
            length, switched = self._until_switch(y, signs, duration)
            found.append(Piece(signs, self.matrix(signs), y, length))
            y, duration = found[-1].end, duration - length
            signs = tuple(sign != (i == switched) for i, sign in enumerate(signs))
        return found

    def _until_switch(self, y: Array, signs: Signs, duration: float) -> tuple[float, int | None]:
        matrix, expected = self.matrix(signs), np.where(signs, 1.0, -1.0)
        step = self.period / STEPS
        map_of_step, time, here = expm(matrix * step), 0.0, y
        while time < duration:
            here = map_of_step @ here
            wrong = np.flatnonzero(expected * (self.switches @ here) < 0)
            if len(wrong):
                roots = [self._root(matrix, y, i, time, time + step) for i in wrong]
                first = int(np.argmin(roots))
                if roots[first] >= duration:
                    break
                return roots[first], int(wrong[first])
            time += step
        return duration, None

    def _root(self, matrix: Array, y: Array, switch: int, before: float, after: float) -> float:
        row = self.switches[switch]
        if before == 0.0:
            before = 1e-9 * after  # the piece may begin on this very switch
        return float(brentq(lambda s: row @ expm(matrix * s) @ y, before, after, xtol=1e-17, rtol=1e-15))

    def orbit(self, start: Array, periods: int = 1, settle: int = 0) -> ExactOrbit:
        """The periodic orbit near a state, which may first settle for some periods."""
        state = np.asarray(start, dtype=float)
        for _ in range(settle):
            state = self.pieces(state, self.period)[-1].end[: self.size]
        for _ in range(40):
            orbit = ExactOrbit(self, self.pieces(state, periods * self.period))
            change = np.linalg.solve(
                orbit.monodromy - np.eye(self.size), orbit.pieces[-1].end[: self.size] - state
            )
            if np.abs(change).max() < 1e-14 * np.abs(state).max():
                return orbit
            state = state - change
        raise RuntimeError(f"no periodic orbit: the last correction was {np.abs(change).max():.1e}")


@dataclass(frozen=True, eq=False)
class Piece:
    """y(s) = exp(C s) y(0) for a while."""

    signs: Signs
    matrix: Array
    start: Array
    duration: float

    @property
    def transition(self) -> Array:
        return np.asarray(expm(self.matrix * self.duration))

    @property
    def end(self) -> Array:
        return np.asarray(self.transition @ self.start)

    def at(self, times: Array) -> Array:
        """y at some times after the beginning, shape (n + 3, times)."""
        return np.asarray(expm(self.matrix * np.asarray(times)[:, None, None]) @ self.start).T


Row = Callable[[Piece], Array]
"""An output as a row over y, which may differ from piece to piece."""


@dataclass(frozen=True, eq=False)
class ExactOrbit:
    """A motion that repeats itself."""

    system: PiecewiseLinear
    pieces: list[Piece]

    @property
    def state(self) -> Array:
        """At time zero."""
        return self.pieces[0].start[: self.system.size]

    @property
    def switchings(self) -> int:
        """How often the piece changes."""
        return len(self.pieces) - 1

    @cached_property
    def monodromy(self) -> Array:
        product = np.eye(self.system.size + 3)
        for piece in self.pieces:
            product = piece.transition @ product
        return np.asarray(product[: self.system.size, : self.system.size])

    @property
    def multipliers(self) -> Array:
        """Floquet multipliers, largest magnitude first."""
        found = np.linalg.eigvals(self.monodromy)
        return np.asarray(found[np.argsort(-np.abs(found))])

    def extremes(self, output: Row) -> tuple[float, float]:
        """Smallest and largest value: at the pieces' ends, or where the rate vanishes."""
        values: list[float] = []
        for piece in self.pieces:
            times = np.linspace(0, piece.duration, 200)
            row, rate = output(piece), output(piece) @ piece.matrix
            rates = rate @ piece.at(times)
            turns = np.flatnonzero(rates[1:] * rates[:-1] < 0)

            def slope(s: float, piece: Piece = piece, rate: Array = rate) -> float:
                return float(rate @ piece.at(np.array([s]))[:, 0])

            roots = [brentq(slope, times[i], times[i + 1], xtol=1e-16, rtol=1e-15) for i in turns]
            values += list(row @ piece.at(np.array([0.0, piece.duration, *roots])))
        return min(values), max(values)

    def peak_to_peak(self, output: Row) -> float:
        low, high = self.extremes(output)
        return high - low

    def harmonics(self, output: Row, count: int) -> Array:
        """c_k of Re sum c_k exp(i k w t / periods), by Gauss' rule on every piece."""
        nodes, weights = np.polynomial.legendre.leggauss(48 + 4 * count)
        total = sum(piece.duration for piece in self.pieces)
        orders, begun = np.arange(count + 1), 0.0
        found = np.zeros(count + 1, dtype=complex)
        for piece in self.pieces:
            times = (nodes + 1) * piece.duration / 2
            waves = np.exp(-2j * np.pi * orders[:, None] * (begun + times) / total)
            found += waves @ (weights * (output(piece) @ piece.at(times))) * piece.duration / total
            begun += piece.duration
        found[0] /= 2
        return found
