"""The equations of one test as a set of equations for harmonics, with their exact derivative.

The residual M q'' + h - Q is sampled along an orbit and its harmonics are taken (alternating frequency-time
method; Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019, chapter 2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.lib.stride_tricks import as_strided

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit

_PER_PERIOD = 2048
"""Samples of a period of the excitation where there are knots to pass."""


@dataclass(frozen=True, eq=False)
class HarmonicEquations:
    """The equations of one test, balanced up to a number of harmonics of its frequency or a fraction of it.

    The unknowns are the real and imaginary parts of all coefficients, packed as `fourier.packed` does.

    Attributes
    ----------
    model, excitation
        The test.
    harmonics
        How many are balanced.
    subharmonic
        Periods of the excitation after which the motion repeats.
    fewest_samples
        Of the residual along an orbit; there are at least as many as `fourier.samples_for` the harmonics.
    """

    model: Model
    excitation: Harmonic
    harmonics: int
    subharmonic: int = 1
    fewest_samples: int = 1

    @classmethod
    def of(cls, orbit: FourierOrbit, fewest_samples: int = 1) -> HarmonicEquations:
        """Those that an orbit is to satisfy."""
        return cls(orbit.model, orbit.excitation, orbit.harmonics, orbit.subharmonic, fewest_samples)

    def orbit(self, unknowns: np.ndarray) -> FourierOrbit:
        """The orbit of some unknowns."""
        coefficients = fourier.unpacked(unknowns, self.model.size)
        return FourierOrbit(self.model, self.excitation, coefficients, self.subharmonic)

    @property
    def angular_frequency(self) -> float:
        """Of the first harmonic (rad/s)."""
        return self.excitation.angular_frequency / self.subharmonic

    @cached_property
    def _tables(self) -> _Tables:
        return _tables(self.harmonics, max(fourier.samples_for(self.harmonics), self.fewest_samples))

    @cached_property
    def _inputs(self) -> np.ndarray:
        """Samples of inputs and their rates."""
        amplitude = self.excitation.vector(self.model)
        both = np.concatenate([amplitude, 1j * self.excitation.angular_frequency * amplitude])
        return self.input_samples(both)

    def input_samples(self, amplitudes: np.ndarray) -> np.ndarray:
        """Samples of what moves with the frequency of the excitation."""
        turning = self._tables.turning[self.subharmonic * np.arange(self._tables.count) % self._tables.count]
        return np.asarray((amplitudes[:, None] * turning).real)

    def arguments(self, unknowns: np.ndarray) -> np.ndarray:
        """The equations' arguments at the samples; accelerations are those of the series."""
        tables, n = self._tables, self.model.size
        moved = (unknowns.reshape(n, -1) @ tables.synthesis).reshape(n, 3, -1)
        arguments = np.empty((3 * n + len(self._inputs), tables.count))
        arguments[:n] = moved[:, 0]
        np.multiply(moved[:, 1], self.angular_frequency, out=arguments[n : 2 * n])
        np.multiply(moved[:, 2], self.angular_frequency**2, out=arguments[2 * n : 3 * n])
        arguments[3 * n :] = self._inputs
        return arguments

    def balanced(self, samples: np.ndarray) -> np.ndarray:
        """Harmonics of sampled signals, packed."""
        return np.asarray((samples @ self._tables.analysis).ravel())

    def residual(self, arguments: np.ndarray) -> np.ndarray:
        """Packed residual of all harmonics (N or N m)."""
        return self.balanced(self.model.residual(arguments))

    def jacobian(self, arguments: np.ndarray) -> np.ndarray:
        """Exact derivative of the packed residual by the unknowns.

        A factor e(t) takes harmonic c exp(i k w t) to harmonic l by its own harmonics l - k and, of the
        conjugate, l + k: these are windows that move over its spectrum.
        """
        n, most = self.model.size, 2 * self.harmonics
        turn = 1j * self.angular_frequency * np.arange(self.harmonics + 1)
        spectrum = self._spectra(arguments)
        step = spectrum.strides[-1]
        shape = (*spectrum.shape[:-1], self.harmonics + 1, self.harmonics + 1)
        centred = spectrum[..., most:]
        later = as_strided(centred, shape, (*spectrum.strides[:-1], step, -step))
        sums = as_strided(centred, shape, (*spectrum.strides[:-1], step, step))
        straight = later[0] + turn * later[1] + turn**2 * later[2]
        mirrored = sums[0] + turn.conj() * sums[1] + turn.conj() ** 2 * sums[2]
        straight[:, 0] *= 0.5
        mirrored[:, 0] *= 0.5
        return _real_blocks(straight + mirrored, straight - mirrored, n)

    def _spectra(self, arguments: np.ndarray) -> np.ndarray:
        """Harmonics -2 H .. 2 H of the residual's derivatives, shape (3, n n, 4 H + 1).

        By coordinates, rates and accelerations; a derivative's place is row n + column.
        """
        n, function = self.model.size, self.model.residual_jacobian
        kinds, columns = np.divmod(function.columns, n)
        found = (function(arguments) @ self._tables.spectrum).view(complex)
        spectrum = np.zeros((3, n * n, found.shape[1]), dtype=complex)
        spectrum[kinds, function.rows * n + columns] = found
        return spectrum


def samples_at_knots(model: Model, subharmonic: int = 1) -> int:
    """Samples of one orbit that make its forces smooth enough to follow it when a parameter changes.

    Each sample that comes to pass a knot of a table makes a corner in the branch; it is the slighter, the
    more samples there are. Without knots there are no corners.
    """
    return subharmonic * _PER_PERIOD if len(model.knot_distances.rows) else 1


def _real_blocks(real: np.ndarray, imaginary: np.ndarray, n: int) -> np.ndarray:
    """Jacobian by packed unknowns.

    Parameters
    ----------
    real, imaginary
        Complex harmonics that a real part makes, and 1/i of those that an imaginary part makes, shape
        (n n, H + 1, H + 1) of pairs, harmonics made and harmonics moved.
    """
    orders = real.shape[1]
    width = 2 * orders - 1
    blocks = np.empty((n, width, n, width))
    places = blocks.transpose(0, 2, 1, 3)
    real, imaginary = (part.reshape(n, n, orders, orders) for part in (real, imaginary))
    places[:, :, :orders, :orders] = real.real
    places[:, :, orders:, :orders] = real.imag[:, :, 1:]
    places[:, :, :orders, orders:] = -imaginary.imag[:, :, :, 1:]
    places[:, :, orders:, orders:] = imaginary.real[:, :, 1:, 1:]
    return blocks.reshape(n * width, n * width)


@dataclass(frozen=True, eq=False)
class _Tables:
    """What depends on the numbers of harmonics and samples alone.

    Attributes
    ----------
    count
        Samples of one period.
    turning
        exp(i phase) at the samples.
    synthesis
        From real unknowns to samples of a signal and its first two derivatives by phase, (2 H + 1, 3 count).
    analysis
        From samples to real unknowns, (count, 2 H + 1).
    spectrum
        From samples to harmonics -2 H .. 2 H, real and imaginary parts in turn, (count, 2 (4 H + 1)).
    """

    count: int
    turning: np.ndarray
    synthesis: np.ndarray
    analysis: np.ndarray
    spectrum: np.ndarray


@lru_cache(maxsize=64)
def _tables(harmonics: int, count: int) -> _Tables:
    base = fourier.basis(harmonics, count).T
    orders = np.arange(1, harmonics + 1)[:, None]
    rates = np.concatenate([0 * base[:1], orders * base[harmonics + 1 :], -orders * base[1 : harmonics + 1]])
    squares = np.concatenate([[0], orders[:, 0], orders[:, 0]])[:, None] ** 2
    analysis = 2.0 / count * base.T
    analysis[:, 0] *= 0.5
    phases = 2 * np.pi * np.arange(count) / count
    spectrum = np.exp(-1j * np.outer(phases, np.arange(-2 * harmonics, 2 * harmonics + 1))) / count
    return _Tables(
        count,
        np.exp(1j * phases),
        np.concatenate([base, rates, -squares * base], axis=1),
        analysis,
        spectrum.view(float),
    )
