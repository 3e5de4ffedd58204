"""Harmonic balance: the periodic orbit of the full nonlinear equations, found without waiting for transients.

The residual M q'' + h - Q is evaluated along the orbit and balanced harmonic by harmonic (alternating
frequency-time method; Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019, chapter 2).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from chassym.derivation import Model
from chassym.nonlinear import fourier
from chassym.nonlinear.excitation import Harmonic
from chassym.nonlinear.orbit import Orbit


class NoPeriodicOrbitError(RuntimeError):
    """The iteration found no periodic orbit."""


@dataclass(frozen=True, eq=False)
class Balance:
    """A solved harmonic balance.

    Attributes
    ----------
    orbit
        The orbit.
    iterations
        Number of iterations.
    correction
        Last relative correction of the rates.
    factors
        LU factors of the Jacobian that the last correction was made with.
    """

    orbit: Orbit
    iterations: int
    correction: float
    factors: tuple[np.ndarray, np.ndarray]


def samples_for(harmonics: int) -> int:
    """Samples of one period: four to each of the highest harmonic, a power of two."""
    return 1 << (4 * harmonics - 1).bit_length()


def balance_residual(orbit: Orbit) -> np.ndarray:
    """Complex residual of every harmonic, shape (n, harmonics + 1), N or N m."""
    arguments = orbit.arguments(samples_for(orbit.harmonics))
    return fourier.coefficients(orbit.model.residual(arguments), orbit.harmonics)


def relative_correction(change: np.ndarray, coefficients: np.ndarray) -> float:
    """Size of a correction of the rates, relative to the rates or to a nanometre if they are less."""
    orders = np.arange(coefficients.shape[1])
    scale = max(np.abs(orders * coefficients).max(), 1e-9)
    return float(np.abs(np.maximum(orders, 1) * change).max() / scale)


def newton(orbit: Orbit, tolerance: float, most: int = 25) -> Balance:
    """Balance the harmonics of an orbit by Newton's method with the exact Jacobian.

    Raises
    ------
    NoPeriodicOrbitError
        If the corrections do not fall below the tolerance.
    """
    correction = np.inf
    for iteration in range(1, most + 1):
        residual = fourier.packed(balance_residual(orbit))
        factors = _factorised(orbit)
        change = fourier.unpacked(lu_solve(factors, residual, check_finite=False), orbit.model.size)
        orbit = replace(orbit, coefficients=orbit.coefficients - change)
        correction = relative_correction(change, orbit.coefficients)
        if not np.isfinite(correction):
            break
        if correction < tolerance:
            return Balance(orbit, iteration, correction, factors)
    raise NoPeriodicOrbitError(
        f"harmonic balance at {orbit.excitation.frequency_hz:g} Hz: the last of {iteration} corrections was "
        f"{correction:.2g} of the motion, {tolerance:g} is needed; start from a smaller amplitude"
    )


def _factorised(orbit: Orbit) -> tuple[np.ndarray, np.ndarray]:
    """LU factors of the Jacobian.

    Raises
    ------
    NoPeriodicOrbitError
        If it is singular or not finite: an orbit is then not unique, or the motion has run away.
    """
    matrix = jacobian(orbit)
    if not np.all(np.isfinite(matrix)):
        raise NoPeriodicOrbitError(
            f"harmonic balance at {orbit.excitation.frequency_hz:g} Hz: the motion is no longer finite; "
            "start from a smaller amplitude"
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)
        factors = lu_factor(matrix, check_finite=False)
    pivots = np.abs(np.diag(factors[0])).reshape(orbit.model.size, -1).min(axis=1)
    if pivots.min() <= 1e-14 * pivots.max():
        loose = orbit.model.system.coordinates[int(pivots.argmin())].name
        raise NoPeriodicOrbitError(
            f"harmonic balance at {orbit.excitation.frequency_hz:g} Hz: nothing holds the mean position, "
            f"about coordinate {loose!r}; give it some stiffness"
        )
    return factors


def jacobian(orbit: Orbit) -> np.ndarray:
    """Exact derivative of the packed residual by the packed coefficients."""
    count, n = samples_for(orbit.harmonics), orbit.model.size
    function = orbit.model.residual_jacobian
    entries = function(orbit.arguments(count))
    kinds, columns = np.divmod(function.columns, n)
    width = 2 * orbit.harmonics + 1
    series = np.zeros((n * n, count, width))
    for kind, shape in enumerate(_derivative_bases(orbit)):
        chosen = kinds == kind
        series[function.rows[chosen] * n + columns[chosen]] += entries[chosen][:, :, None] * shape
    blocks = _analysis(orbit.harmonics, count) @ series
    return np.asarray(blocks.reshape(n, n, width, width).transpose(0, 2, 1, 3).reshape(n * width, n * width))


def _analysis(harmonics: int, count: int) -> np.ndarray:
    """Matrix from the samples of one signal to its real unknowns, shape (2 H + 1, count)."""
    matrix = fourier.basis(harmonics, count).T * (2.0 / count)
    matrix[0] *= 0.5
    return matrix


def _derivative_bases(orbit: Orbit) -> list[np.ndarray]:
    """Matrices from one signal's real unknowns to samples of the signal, its rate and its acceleration."""
    harmonics, count = orbit.harmonics, samples_for(orbit.harmonics)
    frequency = orbit.excitation.angular_frequency
    base = fourier.basis(harmonics, count)
    rates = np.zeros_like(base)
    orders = frequency * np.arange(1, harmonics + 1)
    rates[:, 1 : harmonics + 1] = orders * base[:, harmonics + 1 :]
    rates[:, harmonics + 1 :] = -orders * base[:, 1 : harmonics + 1]
    squares = np.concatenate([[0.0], orders**2, orders**2])
    return [base, rates, -squares * base]


def at_rest(model: Model, excitation: Harmonic, harmonics: int) -> Orbit:
    """The orbit that does not move: Newton's first step from it is the linear response."""
    return Orbit(model, excitation, np.zeros((model.size, harmonics + 1), dtype=complex))


class Extension:
    """Balances many more harmonics than a Newton iteration could carry, by a chord iteration.

    The low harmonics are corrected by the exact Jacobian of the solved balance; a high one by the mean mass,
    damping and stiffness along the orbit, because inertia dominates it: what couples it to others is smaller
    by the order of the harmonic. Each iteration costs one evaluation of the residual.
    """

    def __init__(self, balance: Balance) -> None:
        self._low = balance.orbit
        self._factors = balance.factors
        function = balance.orbit.model.residual_jacobian
        entries = function(balance.orbit.arguments(samples_for(balance.orbit.harmonics)))
        mean = np.zeros((balance.orbit.model.size, 3 * balance.orbit.model.size))
        mean[function.rows, function.columns] = entries.mean(axis=1)
        self._stiffness, self._damping, self._mass = np.split(mean, 3, axis=1)

    def solve(self, orbit: Orbit, harmonics: int, tolerance: float, most: int = 60) -> Balance:
        """Balance an orbit up to a number of harmonics.

        Raises
        ------
        NoPeriodicOrbitError
            If the corrections do not fall below the tolerance.
        """
        receptance = self._mean_receptance(harmonics)
        orbit = replace(orbit, coefficients=fourier.resized(orbit.coefficients, harmonics))
        for iteration in range(1, most + 1):
            change = self._change(balance_residual(orbit), receptance)
            orbit = replace(orbit, coefficients=orbit.coefficients - change)
            correction = relative_correction(change, orbit.coefficients)
            if correction < tolerance:
                return Balance(orbit, iteration, correction, self._factors)
            if not correction < 1.0:
                break
        raise NoPeriodicOrbitError(
            f"{harmonics} harmonics at {orbit.excitation.frequency_hz:g} Hz: correction {iteration} is still "
            f"{correction:.2g} of the motion: too strongly nonlinear; try a smaller amplitude"
        )

    def _change(self, residual: np.ndarray, receptance: np.ndarray) -> np.ndarray:
        low = self._low.harmonics + 1
        change = np.empty_like(residual)
        packed = fourier.packed(residual[:, :low])
        change[:, :low] = fourier.unpacked(lu_solve(self._factors, packed, check_finite=False), len(residual))
        change[:, low:] = (receptance @ residual.T[low:, :, None])[:, :, 0].T
        return change

    def _mean_receptance(self, harmonics: int) -> np.ndarray:
        """Inverse of the mean dynamic stiffness of every high harmonic, shape (high harmonics, n, n)."""
        orders = np.arange(self._low.harmonics + 1, harmonics + 1)
        s = 1j * self._low.excitation.angular_frequency * orders[:, None, None]
        return np.linalg.inv(self._stiffness + s * self._damping + s**2 * self._mass)
