"""Duffing's oscillator as a model, and its orbits by shooting: z'' + c z' + k z + k3 z^3 = F cos(w t)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

from chassym.derivation import (
    Actuator,
    JointPort,
    Mechanism,
    Model,
    PointDisplacement,
    Polynomial,
    build_model,
    prismatic,
)
from chassym.nonlinear import Harmonic

Array = np.ndarray


@dataclass(frozen=True)
class Duffing:
    damping: float = 0.05
    stiffness: float = 1.0
    cubic: float = 1.0
    force: float = 0.2

    def model(self) -> Model:
        mechanism = Mechanism("duffing", gravity=0)
        mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1.0)
        port = JointPort(mechanism.coordinate("z"))
        mechanism.add_force_element(
            "spring", port, Polynomial((self.stiffness, 0, self.cubic), (self.damping,))
        )
        mechanism.add_force_element("shaker", port, Actuator(mechanism.add_input("push", "N")))
        point = mechanism.point("point", mass, (0, 0, 0))
        mechanism.add_output(PointDisplacement("displacement", point, "z", mechanism.ground))
        return build_model(mechanism, {})

    def excitation(self, frequency: float = 1.0) -> Harmonic:
        """The force at a frequency in rad/s."""
        return Harmonic(frequency / (2 * np.pi), {"push": self.force})

    def one_harmonic(self, frequency: float, amplitude: float) -> float:
        """What the closed form of one harmonic leaves: (k - w^2 + 3/4 k3 A^2)^2 A^2 + (c w A)^2 - F^2."""
        stretch = self.stiffness - frequency**2 + 0.75 * self.cubic * amplitude**2
        return (stretch * amplitude) ** 2 + (self.damping * frequency * amplitude) ** 2 - self.force**2

    def mapped(self, state: Array, frequency: float, periods: int = 1) -> tuple[Array, Array]:
        """State and its derivative by the one at time zero, after periods of the force."""

        def rates(time: float, y: Array) -> Array:
            z, v = y[:2]
            push = self.force * np.cos(frequency * time)
            slope = np.array([[0.0, 1.0], [-self.stiffness - 3 * self.cubic * z**2, -self.damping]])
            pull = self.damping * v + self.stiffness * z + self.cubic * z**3
            return np.array([v, push - pull, *(slope @ y[2:].reshape(2, 2)).ravel()])

        stop = 2 * np.pi * periods / frequency
        start = np.array([*state, 1.0, 0.0, 0.0, 1.0])
        end = solve_ivp(rates, (0.0, stop), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        return end[:2], end[2:].reshape(2, 2)

    def shot(self, state: Array, frequency: float, periods: int = 1) -> tuple[Array, Array]:
        """State at time zero of the orbit near a state, and its Floquet multipliers."""
        for _ in range(12):
            end, derivative = self.mapped(state, frequency, periods)
            state = state - np.linalg.solve(derivative - np.eye(2), end - state)
        return state, np.linalg.eigvals(derivative)

    def fold(self, state: Array, frequency: float) -> float:
        """Frequency (rad/s) near which an orbit's multiplier is one: it closes, and so does a neighbour."""

        def left(unknowns: Array) -> Array:
            end, derivative = self.mapped(unknowns[:2], unknowns[2])
            return np.append(end - unknowns[:2], np.linalg.det(derivative - np.eye(2)))

        found = root(left, [*state, frequency], tol=1e-12)
        assert np.abs(left(found.x)).max() < 1e-9
        return float(found.x[2])
