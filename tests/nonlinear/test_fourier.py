"""Truncated Fourier series: synthesis, analysis and derivatives against their definitions."""

import numpy as np
import pytest

from chassym.nonlinear.harmonics import fourier

GENERATOR = np.random.default_rng(20161)


@pytest.fixture
def series() -> np.ndarray:
    found = GENERATOR.normal(size=(3, 8)) + 1j * GENERATOR.normal(size=(3, 8))
    found[:, 0] = found[:, 0].real
    return found


def test_samples_follow_the_definition(series: np.ndarray) -> None:
    phases = 2 * np.pi * np.arange(32) / 32
    expected = np.real(sum(np.outer(series[:, k], np.exp(1j * k * phases)) for k in range(8)))
    assert fourier.samples(series, 32) == pytest.approx(expected, abs=1e-13)
    assert fourier.at_phases(series, phases) == pytest.approx(expected, abs=1e-13)


def test_analysis_inverts_synthesis(series: np.ndarray) -> None:
    assert fourier.coefficients(fourier.samples(series, 64), 7) == pytest.approx(series, abs=1e-13)
    assert fourier.unpacked(fourier.packed(series), 3) == pytest.approx(series)


def test_basis_is_the_same_map_for_real_unknowns(series: np.ndarray) -> None:
    unknowns = fourier.packed(series).reshape(3, -1)
    assert unknowns @ fourier.basis(7, 40).T == pytest.approx(fourier.samples(series, 40), abs=1e-13)


def test_values_around_centres_are_values_at_their_sums(series: np.ndarray) -> None:
    centres, offsets = np.array([0.3, 2.0]), np.array([-0.1, 0.0, 0.2])
    expected = fourier.at_phases(series, (centres[:, None] + offsets).ravel()).reshape(3, 2, 3)
    assert fourier.around(series, centres, offsets) == pytest.approx(expected, abs=1e-13)


def test_derivative_agrees_with_a_difference(series: np.ndarray) -> None:
    frequency, step = 7.0, 1e-5
    rates = fourier.derivative(series, frequency)
    late, early = (fourier.at_phases(series, np.array([1.0 + sign * frequency * step])) for sign in (1, -1))
    assert fourier.at_phases(rates, np.array([1.0])) == pytest.approx((late - early) / (2 * step), rel=1e-6)


def test_resizing_keeps_what_fits(series: np.ndarray) -> None:
    assert fourier.resized(series, 20)[:, :8] == pytest.approx(series)
    assert not fourier.resized(series, 20)[:, 8:].any()
    assert fourier.resized(series, 4) == pytest.approx(series[:, :5])
