"""Stepped sine: up and down through values of a test, as a rig goes, with jumps and coexisting orbits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from chassym.nonlinear.continuation.branch import amplitudes
from chassym.nonlinear.continuation.paths import Path, place
from chassym.nonlinear.continuation.stepping import Arrival, Departure, Stepper
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.steady.result import SteadyState
from chassym.nonlinear.steady.steady_state import measured_names, steady_state
from chassym.nonlinear.threads import one_thread

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

UPWARD, DOWNWARD = "upward", "downward"

_SAMPLES = 256
"""Instants at which orbits are compared."""

_SAME = 1e-4
"""Distance of two orbits, relative to their size, below which they are one."""

_NEAR = 0.1
"""Distance of a refined orbit from the balanced one, relative to it, above which it is another."""

_TINY = 1e-12
"""Motion that counts as none (SI units)."""

Progress = Callable[[float], None]
"""Told the share of the steps that are done."""


@dataclass(frozen=True)
class Jump:
    """Where a test leaves one motion for another.

    Attributes
    ----------
    value, to_value
        The path's parameter where the first motion ends, and at the step that shows the other one.
    output, unit
        The output that changes most, relative to its size.
    from_amplitude, to_amplitude
        Half its peak-to-peak values.
    direction
        ``"upward"`` or ``"downward"``.
    cause
        ``"fold"``: the first motion ceases to be; ``"stability lost"``; or ``"branch lost"``: it cannot be
        followed.
    """

    value: float
    to_value: float
    output: str
    from_amplitude: float
    to_amplitude: float
    unit: str
    direction: str
    cause: str


@dataclass(frozen=True, eq=False)
class Run:
    """One way through the values.

    Attributes
    ----------
    values
        Of the path's parameter, ascending, shape (steps,).
    states
        Steady state at every value; None if none was found.
    reasons
        Why; empty if there is one.
    jumps
        In the order of the values that they led to.
    """

    values: Array = field(repr=False)
    states: tuple[SteadyState | None, ...] = field(repr=False)
    reasons: tuple[str, ...] = field(repr=False)
    jumps: tuple[Jump, ...]

    def peak_to_peak(self, output: str) -> Array:
        """Peak-to-peak values of a measured output, NaN where there is no steady state, shape (steps,).

        Raises
        ------
        KeyError
            If there are steady states, but the output was not measured.
        """
        for state in self.states:
            if state is not None and output not in state.peak_to_peak:
                raise KeyError(f"output {output!r}: measured were {', '.join(state.peak_to_peak)}")
        return np.array([np.nan if s is None else s.peak_to_peak[output].value for s in self.states])


@dataclass(frozen=True, eq=False)
class SteppedResponse:
    """A test upward and downward.

    Attributes
    ----------
    path
        What the steps change.
    values
        At the steps, ascending, shape (steps,).
    upward, downward
        What was found on both ways.
    coexisting
        Values at which the two ways found different motions.
    """

    path: Path
    values: Array = field(repr=False)
    upward: Run
    downward: Run
    coexisting: Array

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Those of both ways, upward first."""
        return (*self.upward.jumps, *self.downward.jumps)

    def to_xarray(self) -> xarray.Dataset:
        """Metrics, their errors and the smallest patch force over direction and parameter, and the jumps."""
        from chassym.nonlinear.continuation.stepped_sine_labels import labelled

        return labelled(self)


def stepped_sine(
    path: Path,
    values: Sequence[float] | Array,
    *,
    metrics: Sequence[str] | None = None,
    tolerance: float = 1e-3,
    harmonics: int = 7,
    progress: Progress = lambda share: None,
) -> SteppedResponse:
    """Step a test up and down, and report at each step the stable orbit that a rig would find.

    Each step starts from the orbit of the last. Where its branch folds or loses its stability on the way, the
    motion jumps; where to, the branch beyond the fold tells, or integration in time.

    Parameters
    ----------
    path
        What the steps change: a `FrequencyPath` at constant displacement, velocity or acceleration, or an
        `AmplitudePath`, for instance.
    values
        At least two, ascending, in the path's unit.
    metrics, tolerance
        As for `steady_state`.
    harmonics
        Of the orbits that are followed; what is measured is refined as the tolerance asks.
    progress
        Called after every step.

    Raises
    ------
    ValueError
        If the values do not ascend, or as for `steady_state`.
    ExcitationError, KeyError
        As for `steady_state`.
    """
    steps = np.asarray(values, dtype=float)
    if steps.ndim != 1 or len(steps) < 2 or not np.all(np.diff(steps) > 0):
        raise ValueError(f"values: {values!r} received; at least two ascending numbers are needed")
    names = measured_names(path.at(float(steps[0]))[0]) if metrics is None else list(metrics)
    test = _Test(path, steps, names, tolerance, harmonics, progress)
    with one_thread():
        upward = test.measured(UPWARD, ())
        downward = test.measured(DOWNWARD, upward)
    differ = [
        a.orbit is not None and b.orbit is not None and not _is_same(a.orbit, b.orbit)
        for a, b in zip(upward, downward, strict=True)
    ]
    runs = test.run(UPWARD, upward), test.run(DOWNWARD, downward)
    return SteppedResponse(path, steps, *runs, steps[np.array(differ)])


@dataclass(frozen=True, eq=False)
class _Measured:
    """A step: the orbit that was balanced, the steady state it was refined to, or why there is none."""

    orbit: FourierOrbit | None
    state: SteadyState | None
    reason: str
    departure: Departure | None


@dataclass(frozen=True, eq=False)
class _Test:
    path: Path
    values: Array
    metrics: Sequence[str]
    tolerance: float
    harmonics: int
    progress: Progress

    def measured(self, direction: str, known: Sequence[_Measured]) -> list[_Measured]:
        """The steps of one way, ascending; what the other way measured is not measured again."""
        order = list(range(len(self.values)))[:: 1 if direction == UPWARD else -1]
        found: dict[int, _Measured] = {}
        for index, arrival in self._arrivals(order, known):
            other = known[index] if known else None
            found[index] = self._measured(arrival, float(self.values[index]), other)
            self.progress((len(known) + len(found)) / (2 * len(order)))
        return [found[index] for index in range(len(order))]

    def _arrivals(self, order: Sequence[int], known: Sequence[_Measured]) -> Iterator[tuple[int, Arrival]]:
        """The stable orbit of each step, from that of the last; after a step without one, from rest.

        Where the other way came without a jump from this step to the last one's orbit, it leads back.
        """
        stepper = Stepper(self.path, float(self.values[0]), float(self.values[-1]), self.harmonics)
        orbit, before = None, -1
        for index in order:
            value = float(self.values[index])
            if orbit is None:
                arrival = stepper.first(value)
            elif known and _leads_back(known[index], known[before], orbit):
                arrival = Arrival(known[index].orbit)
            else:
                arrival = stepper.next(orbit, float(self.values[before]), value)
            yield index, arrival
            orbit, before = arrival.orbit, index

    def _measured(self, arrival: Arrival, value: float, other: _Measured | None) -> _Measured:
        orbit = arrival.orbit
        if orbit is None:
            return _Measured(None, None, self._reason(arrival), arrival.departure)
        if other is not None and other.orbit is not None and _is_same(orbit, other.orbit):
            return replace(other, departure=arrival.departure)
        model, excitation = self.path.at(value)
        try:
            state = steady_state(
                model, excitation, metrics=self.metrics, tolerance=self.tolerance, start=orbit
            )
        except NoPeriodicOrbitError as error:
            return _Measured(orbit, None, str(error), arrival.departure)
        if _distance(state.orbit, orbit) > _NEAR:
            reason = (
                f"{place(self.path, value)}: {orbit.harmonics} harmonics do not describe "
                "the motion well enough to follow it; take more"
            )
            return _Measured(orbit, None, reason, arrival.departure)
        return _Measured(orbit, state, "", arrival.departure)

    def _reason(self, arrival: Arrival) -> str:
        """Why a step has no orbit, and where the last motion ended."""
        end = arrival.departure
        if end is None:
            return arrival.reason
        return f"{end.cause} at {place(self.path, end.value)}; {arrival.reason}"

    def run(self, direction: str, steps: Sequence[_Measured]) -> Run:
        """What is kept of the steps of one way."""
        jumps = [
            self._jump(step.departure, step.orbit, float(value), direction)
            for step, value in zip(steps, self.values, strict=True)
            if step.departure is not None and step.orbit is not None
        ]
        return Run(
            self.values,
            tuple(step.state for step in steps),
            tuple(step.reason for step in steps),
            tuple(jumps),
        )

    def _jump(self, departure: Departure, orbit: FourierOrbit, value: float, direction: str) -> Jump:
        outputs = {output.name: (row, output.unit) for row, output in enumerate(orbit.model.system.outputs)}
        rows = [outputs[name][0] for name in self.metrics]
        before, after = (amplitudes(each, rows) for each in (departure.orbit, orbit))
        most = int(np.argmax(np.abs(after - before) / np.maximum(np.maximum(before, after), _TINY)))
        name = self.metrics[most]
        return Jump(
            departure.value,
            value,
            name,
            float(before[most]),
            float(after[most]),
            outputs[name][1],
            direction,
            departure.cause,
        )


def _distance(one: PeriodicOrbit, other: PeriodicOrbit) -> float:
    """Largest distance of coordinates and rates, each relative to the largest of its kind."""
    phases = 2 * np.pi / _SAMPLES * np.arange(_SAMPLES)
    a, b = (each.motion_at(phases).reshape(2, -1) for each in (one, other))
    return float((np.abs(a - b).max(axis=1) / np.maximum(np.abs(b).max(axis=1), _TINY)).max())


def _leads_back(there: _Measured, here: _Measured, orbit: FourierOrbit) -> bool:
    """Whether the other way came without a jump from there to an orbit here."""
    came = there.orbit is not None and here.orbit is not None and here.departure is None
    return came and here.orbit is not None and _is_same(orbit, here.orbit)


def _is_same(one: FourierOrbit, other: FourierOrbit) -> bool:
    return _distance(one, other) < _SAME
