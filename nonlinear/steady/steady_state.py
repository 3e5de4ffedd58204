"""The steady state of a harmonic test: its orbit, and what is read off it with an estimate of the error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import count

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.collocation.refinement import refinements
from chassym.nonlinear.continuation.continuation import first_orbit
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.harmonics.fourier import coefficients
from chassym.nonlinear.harmonics.harmonic_balance import Extension, at_rest, newton
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.orbits.metrics import ROUNDING, Reader
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.simulation.simulate import SimulationError, simulate
from chassym.nonlinear.steady.result import Statistics, SteadyState
from chassym.nonlinear.threads import one_thread

Array = np.ndarray

SMALLEST_TOLERANCE = 1e-12
"""Relative error that rounding leaves."""

_FEW, _MORE, _EXTENDED = 3, 7, 31
"""Harmonics of a guess: those that Newton's method begins with, those that it goes on with if need be, and
those that a chord iteration adds, which tell well where knots are passed.
"""

_EXTENDED_TOLERANCE, _MOST_EXTENSIONS = 2e-4, 12
"""Relative correction at which the added ones are balanced, and iterations that they may take."""

_MANY_HARMONICS, _HASTE = 15, 12
"""Harmonics of the next guess, and Newton's iterations that it may take."""

_WAITED_PERIODS, _WAITED_SAMPLES = 40, 512
"""Periods that a motion from rest goes on where no harmonics balance, and samples of the period after."""

_WAITED_TOLERANCE, _MOST_WAITED_STEPS = 1e-5, 5000
"""Relative tolerance of that integration, and steps after which it is given up."""

_BALANCED = 0.1
"""Relative correction at which a guess is good enough."""

_ROUGH = 10.0
"""Roughness of a piece that stays whole, divided by the square root of the tolerance."""

_SMOOTHER = np.array([1.0, 1e-2])
"""Parts of that roughness with which refinement is tried in turn."""

_CERTAINTY = 10.0
"""By how much the error stated exceeds what a metric is expected to miss."""

_LEAST = 0.1
"""Part of the error of the middle metric that every metric is taken to have at least."""


def steady_state(
    model: Model,
    excitation: Harmonic,
    *,
    metrics: Sequence[str] | None = None,
    tolerance: float = 1e-3,
    start: PeriodicOrbit | None = None,
    subharmonic: int = 1,
) -> SteadyState:
    """Find the periodic response and measure it.

    Balanced harmonics are cut in pieces where the motion passes the knots of tables, and refined there by
    collocation, until no metric is expected to be further off than the tolerance. How far is told by one more
    correction: the orbit is cut at its own knots; what it misses from piece to piece is propagated around it
    by the last step's maps, and an iteration of Picard's integrates the accelerations that the motion then
    asks for. What that changes is stated tenfold, which covers 19 of 20 true errors of random vehicles in
    random tests.

    Parameters
    ----------
    model, excitation
        The test.
    metrics
        Outputs whose peak-to-peak value is wanted; all accelerations and angular rates by default.
    tolerance
        Largest stated error, relative to the metric.
    start
        A neighbouring orbit to start from; one that repeats after other periods is of no use.
    subharmonic
        Periods of the excitation after which the orbit repeats.

    Returns
    -------
    SteadyState
        The orbit, and what was read off it with its errors.

    Raises
    ------
    ExcitationError
        If the model lacks an input that the excitation moves, or the test is too slow to be followed.
    KeyError
        If it lacks an output that is asked for.
    ValueError
        If the tolerance is less than rounding leaves or not less than 1, or there is nothing to measure.
    NoPeriodicOrbitError
        If no periodic orbit is found, the tolerance is not reached, or a rotation sequence comes too near its
        singularity.
    """
    reader = checked_reader(model, metrics, tolerance)
    reasons = []
    with one_thread():
        for guess in _guesses(model, excitation, start, subharmonic):
            try:
                return _refined(guess(), reader, tolerance)
            except NoPeriodicOrbitError as error:
                reasons.append(error)
    raise reasons[-3]  # that of the first of the three guesses from rest


def checked_reader(model: Model, metrics: Sequence[str] | None, tolerance: float) -> Reader:
    """What reads the metrics.

    Raises
    ------
    KeyError
        If the model lacks an output that is asked for.
    ValueError
        If the tolerance is less than rounding leaves or not less than 1, or there is nothing to measure.
    """
    if not SMALLEST_TOLERANCE <= tolerance < 1:
        raise ValueError(
            f"tolerance: {tolerance!r} received; a number less than 1 is needed, and not less than "
            f"{SMALLEST_TOLERANCE:g}, which rounding leaves"
        )
    reader = Reader(model, measured_names(model) if metrics is None else metrics)
    if not reader.names:
        raise ValueError(
            f"metrics: none to measure; {model.system.name} has "
            f"{', '.join(model.output_names) or 'no outputs'}"
        )
    return reader


def measured_names(model: Model) -> list[str]:
    """Outputs that a rig test reports: accelerations and angular rates."""
    return [o.name for o in model.system.outputs if o.unit in ("m/s^2", "rad/s")]


def _guesses(
    model: Model, excitation: Harmonic, start: PeriodicOrbit | None, subharmonic: int
) -> Iterator[Callable[[], PeriodicOrbit]]:
    """What finds orbits to start from, the cheapest first."""
    if start is not None and start.subharmonic == subharmonic:
        yield partial(start.under, model, excitation)
    yield partial(_balanced, model, excitation, subharmonic)
    yield partial(_balanced_from_rest, model, excitation, subharmonic)
    yield partial(_after_waiting, model, excitation, subharmonic)


def _balanced(model: Model, excitation: Harmonic, subharmonic: int) -> FourierOrbit:
    """An orbit of a few harmonics, by way of smaller amplitudes if need be, and of many that go with them."""
    few, more, extended = (harmonics * subharmonic for harmonics in (_FEW, _MORE, _EXTENDED))
    found = first_orbit(model, excitation, few, subharmonic=subharmonic, tolerance=_BALANCED)
    with suppress(NoPeriodicOrbitError):
        return Extension(found).solve(found.orbit, extended, _EXTENDED_TOLERANCE, _MOST_EXTENSIONS).orbit
    return first_orbit(
        model, excitation, more, found.orbit, subharmonic=subharmonic, tolerance=_BALANCED
    ).orbit


def _balanced_from_rest(model: Model, excitation: Harmonic, subharmonic: int) -> FourierOrbit:
    """An orbit of many harmonics, which are balanced at times where few are not."""
    rest = at_rest(model, excitation, _MANY_HARMONICS * subharmonic, subharmonic)
    return newton(rest, _BALANCED, _HASTE).orbit


def _after_waiting(model: Model, excitation: Harmonic, subharmonic: int) -> FourierOrbit:
    """The motion from rest after a while, as if it repeated itself then."""
    steps = count()

    def stop_in_time(time_s: float) -> None:
        if next(steps) == _MOST_WAITED_STEPS:
            raise NoPeriodicOrbitError(
                f"at {excitation.frequency_hz:g} Hz the motion from rest is so rough that it has not gone "
                f"further than {time_s:.3g} s in {_MOST_WAITED_STEPS} steps; start from a smaller amplitude"
            )

    last = subharmonic * np.arange(_WAITED_SAMPLES) / _WAITED_SAMPLES
    times = excitation.period_s * np.concatenate([[0.0], _WAITED_PERIODS * subharmonic + last])
    try:
        moved = simulate(
            model, excitation, times, relative_tolerance=_WAITED_TOLERANCE, progress=stop_in_time
        ).states[: model.size, 1:]
    except SimulationError as error:
        raise NoPeriodicOrbitError(str(error)) from None
    return FourierOrbit(model, excitation, coefficients(moved, _WAITED_SAMPLES // 8), subharmonic)


def _refined(guess: PeriodicOrbit, reader: Reader, tolerance: float) -> SteadyState:
    """The first of ever more accurate orbits whose metrics are within the tolerance.

    Raises
    ------
    NoPeriodicOrbitError
        If none is.
    """
    reason = NoPeriodicOrbitError(
        f"collocation at {guess.excitation.frequency_hz:g} Hz does not settle which knots the motion passes; "
        "start from a neighbouring orbit"
    )
    for rough in _ROUGH * np.sqrt(tolerance) * _SMOOTHER:
        for found in refinements(guess, rough):
            if found.deviations is None or found.correction > np.sqrt(tolerance):
                continue  # where Newton's method has converged, the next correction is about the square
            reading = reader.read(found.orbit)
            moved = np.abs(reader.read_iterated(found.orbit, found.deviations) - reading)
            missed = np.maximum(moved - ROUNDING, 0.0)
            error = reader.expected(reading, _CERTAINTY * missed, _LEAST)
            if reader.is_settled(reading, error, tolerance):
                refuse_singular(found.orbit)
                peaks, contact = reader.results(reading, error)
                unknowns = found.orbit.accelerations.size + found.orbit.starts.size
                statistics = Statistics("collocation", unknowns, found.iterations, found.correction)
                return SteadyState(found.orbit, peaks, contact, statistics)
            how = f"with {found.orbit.points} points in each of {len(found.orbit.starts)} pieces"
            reason = reader.unsettled(reading, error, how, tolerance)
    raise reason


def refuse_singular(orbit: PeriodicOrbit) -> None:
    """Refuse an orbit on which a rotation sequence comes too near its singularity.

    Raises
    ------
    NoPeriodicOrbitError
        If one does.
    """
    near = orbit.nearest_singularity
    if near is not None and near.is_harmful:
        raise NoPeriodicOrbitError(f"at {orbit.excitation.frequency_hz:g} Hz {near.refusal}")
