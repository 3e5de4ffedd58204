"""Continuation of orbits around folds, and the way to a first orbit where Newton's method fails."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from itertools import islice

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.collocation.floquet import multipliers
from chassym.nonlinear.continuation.arclength import Tracer
from chassym.nonlinear.continuation.branch import Branch, Fold
from chassym.nonlinear.continuation.branch_steps import Point
from chassym.nonlinear.continuation.paths import AmplitudePath, Path, place
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_balance import Balance, at_rest, newton
from chassym.nonlinear.harmonics.harmonic_equations import samples_at_knots
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit

Array = np.ndarray

_HASTE = 12
"""Newton's iterations from a guess before it is given up for the way by smaller amplitudes."""

_STRIDE, _MOST_STRIDES = 0.25, 400
"""Longest step of that way, relative to the full amplitude, and how many it may take."""

_SHARES = tuple(0.5**k for k in range(1, 11))
"""Where that way may begin."""


def follow(
    path: Path,
    start: float,
    stop: float,
    *,
    harmonics: int = 7,
    first: PeriodicOrbit | None = None,
    subharmonic: int = 1,
    largest_step: float = 0.05,
    most_points: int = 500,
    tolerance: float = 1e-9,
) -> Branch:
    """Follow a branch of periodic orbits from one value of a path's parameter to another, around its folds.

    The branch ends where it leaves the interval, at the end or back at the start.

    Parameters
    ----------
    path
        What changes.
    start, stop
        First and last value of the path's parameter, in its unit; stop may be the smaller one.
    harmonics
        Harmonics of every orbit.
    first
        Orbit to begin near; that found from the linear response by default.
    subharmonic
        Periods of the excitation after which orbits repeat.
    largest_step
        Longest step, as a share of the interval and of the motion.
    most_points
        Points after which the branch is too long, at least 2.
    tolerance
        Relative correction of the rates at which an orbit is balanced; positive and less than 1.

    Returns
    -------
    Branch
        Orbits from start on, in the order in which they were found, with stability and folds.

    Raises
    ------
    ValueError
        If start and stop are the same or not finite, the longest step, the most points or the tolerance is
        impossible, or there are too few harmonics for the excitation to be among them.
    ExcitationError, ParameterError
        If the path has no test at start.
    NoPeriodicOrbitError
        If there is no orbit to begin with, the branch is lost, or longer than the most points.
    """
    if not (np.isfinite(start) and np.isfinite(stop) and start != stop):
        raise ValueError(
            f"start and stop: {start!r} and {stop!r} received; two finite, different numbers are needed"
        )
    if not 0 < largest_step <= 1:
        raise ValueError(f"largest_step: {largest_step!r} received; a positive number up to 1 is needed")
    if not most_points >= 2:
        raise ValueError(f"most_points: {most_points!r} received; 2 or more are needed")
    if not 0 < tolerance < 1:
        raise ValueError(f"tolerance: {tolerance!r} received; a positive number less than 1 is needed")
    model, excitation = path.at(start)
    fewest = samples_at_knots(model, subharmonic)
    orbit = first_orbit(
        model,
        excitation,
        harmonics,
        first,
        subharmonic=subharmonic,
        tolerance=tolerance,
        fewest_samples=fewest,
    ).orbit
    tracer = Tracer(path, abs(stop - start), harmonics, subharmonic, tolerance, fewest)
    points, turns = _points(tracer, tracer.begin(orbit, start, stop - start), stop, largest_step, most_points)
    orbits = tuple(tracer.orbit(point) for point in points)
    return Branch(
        path,
        np.array([point.value for point in points]),
        orbits,
        np.array([multipliers(orbit) for orbit in orbits]),
        tuple(Fold(fold.value, tracer.orbit(fold), index) for index, fold in turns),
    )


def _points(
    tracer: Tracer, first: Point, stop: float, longest: float, most: int
) -> tuple[list[Point], list[tuple[int, Point]]]:
    """Points of a branch up to where it leaves an interval, and folds, each with the point before it."""
    points, start = [first], first.value
    folds: list[tuple[int, Point]] = []
    for step in tracer.march(first, longest):
        for piece in tracer.pieces(step):
            bound = next((b for b in (stop, start) if piece.passes(b)), None)
            if bound is not None:
                return [*points, tracer.landing(piece, bound).end], folds
            if piece.ends_in_fold:
                folds.append((len(points) - 1, piece.end))
        if not step.is_corner:
            points.append(step.end)
        if len(points) >= most:
            break
    raise NoPeriodicOrbitError(
        f"branch: {most} points lead from {place(tracer.path, start)} only to "
        f"{place(tracer.path, points[-1].value)}, not to {stop:.6g}; allow more points or a longer step"
    )


def first_orbit(
    model: Model,
    excitation: Harmonic,
    harmonics: int,
    start: PeriodicOrbit | None = None,
    *,
    subharmonic: int | None = None,
    tolerance: float = 1e-2,
    fewest_samples: int = 1,
) -> Balance:
    """Balance an orbit with few harmonics, to go on from.

    Newton's method starts from a given orbit, then from rest, where its first step is the linear response.
    Where both fail, the response is followed from rest as the amplitudes grow, around folds if need be.

    Parameters
    ----------
    model, excitation
        The test.
    harmonics
        Of the orbit's own frequency; at least as many as periods of the excitation after which it repeats.
    start
        A neighbouring orbit, with any number of harmonics.
    subharmonic
        Periods of the excitation after which the orbit repeats; as for the start, or one, by default.
    tolerance
        Relative correction of the rates at which it is balanced.
    fewest_samples
        Of the residual along the orbit: more than the few that go with the harmonics, if it is to be
        followed over knots.

    Returns
    -------
    Balance
        The orbit, and how it was balanced.

    Raises
    ------
    ValueError
        If there are too few harmonics for the excitation to be among them.
    NoPeriodicOrbitError
        If none is found.
    """
    if subharmonic is None:
        subharmonic = 1 if start is None else start.subharmonic
    if not 1 <= subharmonic <= harmonics:
        raise ValueError(
            f"harmonics: {harmonics!r} received with subharmonic {subharmonic!r}; the excitation is the "
            "harmonic of that order, so at least as many are needed, and one period or more"
        )
    rest = at_rest(model, excitation, harmonics, subharmonic)
    near = [] if start is None else [replace(rest, coefficients=_spread(start, harmonics, subharmonic))]
    for guess in (*near, rest):
        with suppress(NoPeriodicOrbitError):
            return newton(guess, tolerance, _HASTE, fewest_samples=fewest_samples)
    return _by_amplitude(rest, tolerance, fewest_samples)


def _spread(start: PeriodicOrbit, harmonics: int, subharmonic: int) -> Array:
    """Coefficients of an orbit among harmonics of another fraction of the excitation's frequency."""
    most = max(harmonics * start.subharmonic // subharmonic, 1)
    count = 4 * fourier.samples_for(most)
    motion = start.motion_at(2 * np.pi / count * np.arange(count))[: start.model.size]
    found = np.zeros((len(motion), harmonics + 1), dtype=complex)
    for order, column in enumerate(fourier.coefficients(motion, most).T):
        place, rest = divmod(order * subharmonic, start.subharmonic)
        if rest == 0 and place <= harmonics:
            found[:, place] = column
    return found


def _by_amplitude(rest: FourierOrbit, tolerance: float, fewest_samples: int) -> Balance:
    """Follow the response to small amplitudes as they grow to the full ones."""
    path, orders = AmplitudePath(rest.model, rest.excitation), (rest.harmonics, rest.subharmonic)
    tracer = Tracer(path, 1.0, *orders, tolerance=1e-6, fewest_samples=fewest_samples)
    reached = 0.0
    try:
        reached, small = _small(tracer, rest)
        for step in islice(tracer.march(tracer.begin(small, reached, 1.0), _STRIDE), _MOST_STRIDES):
            reached = step.end.value
            if step.passes(1.0):
                found = tracer.orbit(tracer.landing(step, 1.0).end)
                return newton(found, tolerance, fewest_samples=fewest_samples)
        cause = f"{_MOST_STRIDES} steps were not enough"
    except NoPeriodicOrbitError as error:
        if reached == 0.0:
            raise
        cause = str(error)
    raise NoPeriodicOrbitError(
        f"no periodic orbit found at {rest.excitation.frequency_hz:g} Hz: followed from small motions, the "
        f"response came to {reached:.3g} of the amplitudes ({cause}); try a smaller amplitude"
    )


def _small(tracer: Tracer, rest: FourierOrbit) -> tuple[float, FourierOrbit]:
    """The largest of some shares of the amplitudes whose response is found from rest, and the response.

    None of them is zero: tables with a knot there have no derivative at rest.
    """
    for factor in _SHARES[:-1]:
        with suppress(NoPeriodicOrbitError):
            return factor, tracer.balanced(rest, factor)
    return _SHARES[-1], tracer.balanced(rest, _SHARES[-1])
