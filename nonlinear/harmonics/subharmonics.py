"""A search for sub-harmonic orbits: those that repeat only after several periods of the excitation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.linalg import eig

from chassym.derivation import Model
from chassym.nonlinear.collocation.floquet import is_stable
from chassym.nonlinear.continuation.continuation import first_orbit
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics.harmonic_balance import Balance, newton
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit

_TOLERANCE = 1e-9

_ITERATIONS = 15
"""Of Newton's method from each guess."""

_LEVELS = np.geomspace(0.1, 30.0, 9)
"""Amplitudes of guesses, relative to the motion that repeats with the excitation."""

_PHASES = 8
"""Guesses at each amplitude, over the phases that differ by less than a period of the excitation."""

_VISIBLE = 1e-4
"""Share of the motion from which harmonics between those of the excitation count as there."""


def subharmonic_orbit(
    model: Model, excitation: Harmonic, subharmonic: int, *, harmonics: int | None = None
) -> Balance:
    """Find an orbit that repeats only after a number of periods of the excitation; a stable one if there is.

    No branch leads from the linear response to most of these orbits. Newton's method is therefore started
    from many guesses: the response that repeats with the excitation, and on top of it a mode at rest with the
    fraction of the frequency, the nearest mode first, at several amplitudes and phases.

    Parameters
    ----------
    model, excitation
        The test.
    subharmonic
        Number of periods, at least two.
    harmonics
        Harmonics of the fraction of the frequency; five for each of the excitation by default.

    Returns
    -------
    Balance
        The orbit, and how it was balanced.

    Raises
    ------
    ValueError
        If the number of periods is below two, or there are fewer harmonics.
    NoPeriodicOrbitError
        If none is found. There may be one nevertheless.
    """
    if subharmonic < 2:
        raise ValueError(f"subharmonic: {subharmonic!r} received; a whole number of at least 2 is needed")
    most = 5 * subharmonic if harmonics is None else harmonics
    plain = first_orbit(model, excitation, most, subharmonic=subharmonic, tolerance=_TOLERANCE).orbit
    unstable = None
    for guess in _guesses(plain):
        with suppress(NoPeriodicOrbitError):
            found = newton(guess, _TOLERANCE, _ITERATIONS)
            if not repeats_late(found.orbit):
                continue
            if is_stable(found.orbit):
                return found
            unstable = unstable or found
    if unstable is not None:
        return unstable
    raise NoPeriodicOrbitError(
        f"no orbit of {subharmonic} periods found at {excitation.frequency_hz:g} Hz among "
        f"{model.size * len(_LEVELS) * _PHASES} guesses; try another frequency or a larger amplitude"
    )


def repeats_late(orbit: FourierOrbit) -> bool:
    """Whether harmonics between those of the excitation are there: the orbit does not repeat with it."""
    rates = np.abs(orbit.coefficients * np.arange(orbit.harmonics + 1)).max(axis=0)
    between = np.arange(orbit.harmonics + 1) % orbit.subharmonic != 0
    return bool(rates[between].max(initial=0.0) > _VISIBLE * rates.max())


def _guesses(plain: FourierOrbit) -> Iterator[FourierOrbit]:
    """Orbits to start Newton's method from, the most promising first."""
    size = float(np.abs(plain.coefficients).max())
    for mode in _modes(plain):
        for level in _LEVELS:
            # A shift by one period of the excitation turns the phase by 2 pi / subharmonic: the same orbit.
            for phase in np.arange(_PHASES) * 2 * np.pi / (_PHASES * plain.subharmonic):
                coefficients = plain.coefficients.copy()
                coefficients[:, 1] += level * size * np.exp(1j * phase) * mode
                yield replace(plain, coefficients=coefficients)


def _modes(plain: FourierOrbit) -> list[np.ndarray]:
    """Undamped modes at rest, largest entry one, that nearest to the orbit's frequency first."""
    model, n = plain.model, plain.model.size
    function = model.residual_jacobian
    matrix = function.matrix(np.zeros(model.argument_count), (n, 3 * n))
    squares, shapes = eig(matrix[:, :n], matrix[:, 2 * n :])
    nearest = np.argsort(np.abs(np.sqrt(np.abs(squares.real)) - plain.angular_frequency))
    return [shapes[:, k].real / np.abs(shapes[:, k].real).max() for k in nearest]
