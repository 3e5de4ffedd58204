"""Periodic orbits of Duffing's equation by shooting: an independent solver that knows no Fourier series.

m x'' + c x' + k x + g x^3 = P cos(w t) is integrated with its variational equation as a system of first order
(Dormand and Prince's method of eighth order), and Newton's method closes the orbit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

Array = np.ndarray


@dataclass(frozen=True)
class Duffing:
    """Parameters of the equation; `periods` is how many of the force one orbit takes."""

    mass: float
    damping: float
    stiffness: float
    cubic: float
    force: float
    frequency: float
    periods: int = 1

    @property
    def duration(self) -> float:
        return 2 * np.pi * self.periods / self.frequency

    def rates(self, time: float, y: Array) -> Array:
        """Of (x, x', deviations from an x, deviations from an x')."""
        x, v = y[:2]
        deviations = y[2:].reshape(2, 2)
        pull = self.damping * v + self.stiffness * x + self.cubic * x**3
        slope = self.stiffness + 3 * self.cubic * x**2
        second = -(slope * deviations[0] + self.damping * deviations[1]) / self.mass
        push = self.force * np.cos(self.frequency * time)
        return np.array([v, (push - pull) / self.mass, *deviations[1], *second])

    def move(self, y: Array, start: float, stop: float) -> Array:
        moved = solve_ivp(self.rates, (start, stop), y, method="DOP853", rtol=2.5e-14, atol=1e-15)
        return np.asarray(moved.y[:, -1])

    def map(self, state: Array) -> tuple[Array, Array]:
        """The state after one orbit's duration and its derivative."""
        end = self.move(np.array([*state, 1.0, 0.0, 0.0, 1.0]), 0.0, self.duration)
        return end[:2], end[2:].reshape(2, 2)

    def orbit(self, start: Array) -> ShotOrbit:
        """The periodic orbit near a state at time zero."""
        state = np.asarray(start, dtype=float)
        for _ in range(30):
            end, monodromy = self.map(state)
            change = np.linalg.solve(monodromy - np.eye(2), end - state)
            state = state - change
            if np.abs(change).max() < 1e-12 * np.abs(state).max():
                return ShotOrbit(self, state, self.map(state)[1])
        raise RuntimeError(f"no periodic orbit: the last correction was {np.abs(change).max():.1e}")

    def fold(self, start: Array) -> ShotOrbit:
        """The fold near a frequency and a state: the orbit repeats and has a multiplier of one."""

        def residual(unknown: Array) -> Array:
            end, monodromy = replace(self, frequency=float(unknown[2])).map(unknown[:2])
            return np.array([*(end - unknown[:2]), np.linalg.det(monodromy - np.eye(2))])

        found = root(residual, start, tol=1e-12, options={"eps": 1e-8})
        if np.abs(found.fun).max() > 1e-9:
            raise RuntimeError(f"no fold: {found.message}")
        at_fold = replace(self, frequency=float(found.x[2]))
        return ShotOrbit(at_fold, found.x[:2], at_fold.map(found.x[:2])[1])


@dataclass(frozen=True, eq=False)
class ShotOrbit:
    """An orbit by its state at time zero."""

    equation: Duffing
    state: Array
    monodromy: Array

    @property
    def multipliers(self) -> Array:
        """Largest magnitude first."""
        found = np.linalg.eigvals(self.monodromy)
        return np.asarray(found[np.argsort(-np.abs(found))])

    def samples(self, count: int = 128) -> Array:
        """x and x' at equidistant times, each integrated to (nothing is interpolated), shape (2, count)."""
        times = np.linspace(0, self.equation.duration, count + 1)
        y = np.array([*self.state, 1.0, 0.0, 0.0, 1.0])
        found = [y]
        for start, stop in zip(times[:-2], times[1:-1], strict=True):
            found.append(self.equation.move(found[-1], start, stop))
        return np.array(found)[:, :2].T

    def harmonics(self, count: int = 20) -> Array:
        """c_k of x = Re sum c_k exp(i k w t / periods)."""
        found = np.fft.rfft(self.samples()[0])[: count + 1] / 64
        found[0] /= 2
        return np.asarray(found)

    def peak_to_peak(self) -> float:
        """Of x, from its Fourier series at very many phases and Newton's method."""
        series = np.fft.rfft(self.samples()[0]) / 64
        series[0] /= 2
        orders = np.arange(len(series))

        def at(phases: Array, derivative: int) -> Array:
            factors = (1j * orders) ** derivative * series
            return (np.exp(1j * np.multiply.outer(phases, orders)) @ factors).real

        phases = np.linspace(0, 2 * np.pi, 4096)
        values = at(phases, 0)
        ends = phases[[values.argmin(), values.argmax()]]
        for _ in range(4):
            ends = ends - at(ends, 1) / at(ends, 2)
        return float(np.ptp(at(ends, 0)))
