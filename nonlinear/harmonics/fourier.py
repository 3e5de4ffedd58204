"""Truncated Fourier series of periodic signals: q(phi) = Re sum_k c_k exp(i k phi), k = 0 ... H."""

from __future__ import annotations

import numpy as np


def samples_for(harmonics: int) -> int:
    """Samples of one period: more than four to each of the highest harmonic, a power of two.

    The harmonics of a cube, up to three times as high, then leave those that are balanced alone.
    """
    return 1 << int(4 * harmonics).bit_length()


def samples(coefficients: np.ndarray, count: int) -> np.ndarray:
    """Values at `count` equidistant phases, shape (signals, count), of coefficients (signals, H + 1)."""
    spectrum = 0.5 * count * coefficients
    spectrum[:, 0] = count * coefficients[:, 0].real
    return np.fft.irfft(spectrum, count, axis=1)


def coefficients(values: np.ndarray, harmonics: int) -> np.ndarray:
    """Coefficients, shape (signals, H + 1), of equidistant samples, shape (signals, count)."""
    found = 2.0 / values.shape[1] * np.fft.rfft(values, axis=1)[:, : harmonics + 1]
    found[:, 0] = 0.5 * found[:, 0].real
    return found


def at_phases(coefficients: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """Values at any phases, shape (signals, len(phases))."""
    orders = np.arange(coefficients.shape[1])
    return np.asarray((coefficients @ np.exp(1j * np.outer(orders, phases))).real)


def around(coefficients: np.ndarray, centres: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Values at the phases centre + offset, shape (signals, len(centres), len(offsets)).

    exp(i k (centre + offset)) is a product, so few exponentials serve many phases.
    """
    orders = np.arange(coefficients.shape[1])
    shifted = coefficients[:, None, :] * np.exp(1j * np.outer(centres, orders))
    return np.asarray((shifted @ np.exp(1j * np.outer(orders, offsets))).real)


def derivative(coefficients: np.ndarray, angular_frequency: float) -> np.ndarray:
    """Coefficients of the time derivative."""
    return np.asarray(1j * angular_frequency * np.arange(coefficients.shape[1]) * coefficients)


def resized(coefficients: np.ndarray, harmonics: int) -> np.ndarray:
    """The series cut or filled with zeros to a number of harmonics."""
    found = np.zeros((len(coefficients), harmonics + 1), dtype=complex)
    kept = min(coefficients.shape[1], harmonics + 1)
    found[:, :kept] = coefficients[:, :kept]
    return found


def packed(coefficients: np.ndarray) -> np.ndarray:
    """Real unknowns (Re c_0, Re c_1 ... Re c_H, Im c_1 ... Im c_H) of every signal, as one vector."""
    return np.concatenate([coefficients.real, coefficients.imag[:, 1:]], axis=1).ravel()


def unpacked(unknowns: np.ndarray, signals: int) -> np.ndarray:
    """The inverse of `packed`."""
    rows = unknowns.reshape(signals, -1)
    harmonics = rows.shape[1] // 2
    found = rows[:, : harmonics + 1].astype(complex)
    found[:, 1:] += 1j * rows[:, harmonics + 1 :]
    return found


def basis(harmonics: int, count: int) -> np.ndarray:
    """Matrix from the real unknowns of one signal to its samples, shape (count, 2 H + 1)."""
    phases = 2 * np.pi * np.outer(np.arange(count), np.arange(harmonics + 1)) / count
    return np.concatenate([np.cos(phases), -np.sin(phases[:, 1:])], axis=1)
