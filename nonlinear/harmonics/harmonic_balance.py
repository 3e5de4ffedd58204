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
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_equations import HarmonicEquations
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit


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

    orbit: FourierOrbit
    iterations: int
    correction: float
    factors: tuple[np.ndarray, np.ndarray]


def balance_residual(orbit: FourierOrbit) -> np.ndarray:
    """Complex residual of every harmonic, shape (n, harmonics + 1), N or N m."""
    arguments = orbit.arguments(fourier.samples_for(orbit.harmonics))
    return fourier.coefficients(orbit.model.residual(arguments), orbit.harmonics)


def jacobian(orbit: FourierOrbit) -> np.ndarray:
    """Exact derivative of the packed residual by the packed coefficients."""
    equations = HarmonicEquations.of(orbit)
    return equations.jacobian(equations.arguments(fourier.packed(orbit.coefficients)))


def relative_correction(change: np.ndarray, coefficients: np.ndarray) -> float:
    """Size of a correction of the rates, relative to the rates or to a nanometre if they are less."""
    orders = np.arange(coefficients.shape[1])
    scale = max(np.abs(orders * coefficients).max(), 1e-9)
    return float(np.abs(np.maximum(orders, 1) * change).max() / scale)


def newton(orbit: FourierOrbit, tolerance: float, most: int = 25, *, fewest_samples: int = 1) -> Balance:
    """Balance the harmonics of an orbit by Newton's method with the exact Jacobian.

    Parameters
    ----------
    orbit
        Where it starts.
    tolerance
        Relative correction of the rates at which it ends.
    most
        Iterations.
    fewest_samples
        Of the residual along the orbit; few are made by default, in proportion to the harmonics.

    Raises
    ------
    NoPeriodicOrbitError
        If the corrections do not fall below the tolerance.
    """
    equations = HarmonicEquations.of(orbit, fewest_samples)
    unknowns = fourier.packed(orbit.coefficients)
    correction = np.inf
    for iteration in range(1, most + 1):
        arguments = equations.arguments(unknowns)
        factors = _factorised(equations, arguments)
        change = lu_solve(factors, equations.residual(arguments), check_finite=False)
        unknowns = unknowns - change
        found = equations.orbit(unknowns)
        correction = relative_correction(fourier.unpacked(change, orbit.model.size), found.coefficients)
        if not np.isfinite(correction):
            break
        if correction < tolerance:
            return Balance(found, iteration, correction, factors)
    raise NoPeriodicOrbitError(
        f"harmonic balance at {orbit.excitation.frequency_hz:g} Hz: the last of {iteration} corrections was "
        f"{correction:.2g} of the motion, {tolerance:g} is needed; "
        "start from a smaller amplitude, or give its resonance some damping"
    )


def _factorised(equations: HarmonicEquations, arguments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """LU factors of the Jacobian.

    Raises
    ------
    NoPeriodicOrbitError
        If it is singular or not finite: an orbit is then not unique, or the motion has run away.
    """
    model, frequency_hz = equations.model, equations.excitation.frequency_hz
    matrix = equations.jacobian(arguments)
    if not np.isfinite(matrix.sum()):
        raise NoPeriodicOrbitError(
            f"harmonic balance at {frequency_hz:g} Hz: the motion is no longer finite; "
            "start from a smaller amplitude"
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)
        factors = lu_factor(matrix, overwrite_a=True, check_finite=False)
    pivots = np.abs(np.diag(factors[0])).reshape(model.size, -1).min(axis=1)
    if pivots.min() <= 1e-14 * pivots.max():
        loose = model.system.coordinates[int(pivots.argmin())].name
        raise NoPeriodicOrbitError(
            f"harmonic balance at {frequency_hz:g} Hz: nothing holds the mean position, "
            f"about coordinate {loose!r}; give it some stiffness"
        )
    return factors


def at_rest(model: Model, excitation: Harmonic, harmonics: int, subharmonic: int = 1) -> FourierOrbit:
    """The orbit that does not move: Newton's first step from it is the linear response."""
    still = np.zeros((model.size, harmonics + 1), dtype=complex)
    return FourierOrbit(model, excitation, still, subharmonic)


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
        entries = function(balance.orbit.arguments(fourier.samples_for(balance.orbit.harmonics)))
        mean = np.zeros((balance.orbit.model.size, 3 * balance.orbit.model.size))
        mean[function.rows, function.columns] = entries.mean(axis=1)
        self._stiffness, self._damping, self._mass = np.split(mean, 3, axis=1)

    def solve(self, orbit: FourierOrbit, harmonics: int, tolerance: float, most: int = 60) -> Balance:
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
        s = 1j * self._low.angular_frequency * orders[:, None, None]
        return np.linalg.inv(self._stiffness + s * self._damping + s**2 * self._mass)
