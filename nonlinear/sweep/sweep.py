"""Sweeps: the steady state of many variants of a model, side by side, kept as they come, and gone on with."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.orbits.metrics import Reader
from chassym.nonlinear.orbits.periodic_orbit import PeriodicOrbit
from chassym.nonlinear.rig.rig_test import RigTest
from chassym.nonlinear.steady.result import SteadyState
from chassym.nonlinear.steady.steady_state import measured_names, steady_state
from chassym.nonlinear.sweep.sampling import Points, SamplingError
from chassym.nonlinear.sweep.store import Row, Store
from chassym.nonlinear.sweep.sweep_results import Column, to_dataset
from chassym.nonlinear.sweep.varied_excitation import ExcitationRule, excitation_fields, varied_excitation
from chassym.nonlinear.sweep.workers import Workers, usual_workers

if TYPE_CHECKING:
    import xarray

NEIGHBOURS = 8
"""Points that are computed, and kept, together."""

_CONTACT = (
    Column("minimum_patch_force", "N", "smallest vertical patch force"),
    Column("minimum_patch_force_error", "N", "estimate of its error"),
)
_MULTIPLIER = Column(
    "largest_multiplier", "1", "largest magnitude of a Floquet multiplier, below 1 if stable"
)


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep is.

    Attributes
    ----------
    finished, failed, count
        Points that are done, those of them that have no solution, and all points.
    remaining_s
        Estimate of the time to the end (s); infinite before the first point of this run.
    """

    finished: int
    failed: int
    count: int
    remaining_s: float


Progress = Callable[[SweepProgress], None]


@dataclass(frozen=True, eq=False)
class Sweep:
    """What is to be computed: everything that the numbers depend on, and nothing else.

    Attributes
    ----------
    model
        The nominal model.
    excitation
        A harmonic excitation, whose ``frequency_hz`` and ``amplitude`` (a factor) points may set; a test of
        the rig, with ``frequency_hz``, ``amplitude_m`` and ``lag_s``; or a function that returns a harmonic
        one, such as `rig.lateral`, whose arguments they may set.
    points
        What is set where.
    metrics
        Outputs whose peak-to-peak value is wanted; all accelerations and angular rates by default.
    tolerance
        As for `steady_state`.
    with_stability
        Whether to compute the largest Floquet multiplier of every orbit.
    neighbours
        Points that are computed and kept together. Those of them that follow each other along a grid start
        from the orbit before, the others from rest; with 1 all do. Where several orbits exist, the start
        decides which is found.

    Raises
    ------
    SamplingError
        If a point sets what is neither a parameter nor a field of the excitation.
    KeyError
        If the model lacks an output that is asked for.
    ValueError
        If the tolerance is not positive, there is nothing to measure, or nothing computed together.
    """

    model: Model
    excitation: Harmonic | RigTest | ExcitationRule
    points: Points
    metrics: Sequence[str] | None = None
    tolerance: float = 1e-3
    with_stability: bool = True
    neighbours: int = NEIGHBOURS
    _rule: ExcitationRule = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_rule", varied_excitation(self.excitation, self.model))
        if not self.tolerance > 0:
            raise ValueError(f"tolerance: {self.tolerance!r} received; a positive number is needed")
        if self.neighbours < 1:
            raise ValueError(f"neighbours: {self.neighbours!r} received; 1 or more is needed")
        if not self.measured:
            raise ValueError(f"metrics: none to measure; {self.model.system.name} has no such outputs")
        fields = excitation_fields(self._rule)
        for name in self.points.numbers:
            if name not in self._parameters and name not in fields:
                raise SamplingError(
                    f"sweep: {name!r} is no parameter of {self.model.system.name} and no field of the "
                    f"excitation, which has {', '.join(fields) or 'none'}"
                )
        Reader(self.model, self.measured)

    def __getstate__(self) -> dict[str, object]:
        """What travels to workers, with the machine code that they need, so that none has to compile."""
        _ = self._is_compiled
        return vars(self).copy()

    @cached_property
    def _is_compiled(self) -> bool:
        """Whether the nominal model could be solved; that compiles what a solution takes."""
        with suppress(Exception), np.errstate(all="ignore"):
            steady_state(self.model, self._rule(), metrics=self.measured, tolerance=self.tolerance)
            return True
        return False

    @property
    def measured(self) -> tuple[str, ...]:
        """Names of the outputs that are measured."""
        return tuple(measured_names(self.model) if self.metrics is None else self.metrics)

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The numbers that are kept of every point."""
        reader = Reader(self.model, self.measured)
        units = dict(zip(reader.names, reader.units, strict=True))
        return (
            *(Column(name, units[name], f"{name}, peak to peak") for name in self.measured),
            *(Column(f"{name}_error", units[name], "estimate of its error") for name in self.measured),
            *(_CONTACT if reader.patches else ()),
            *((_MULTIPLIER,) if self.with_stability else ()),
        )

    @cached_property
    def _parameters(self) -> Mapping[str, float]:
        return self.model.parameters.flat()

    @cached_property
    def identity(self) -> Mapping[str, str]:
        """A word for each part of what the results depend on; it is the same in another process."""
        model, points = self.model, self.points
        compiled = (model.compiled.residual, model.compiled.outputs)
        labels = [(name, c.dimensions, c.values.tolist(), c.unit) for name, c in points.coordinates.items()]
        settings = self.measured, self.tolerance, self.with_stability, self.neighbours
        return {
            "model": _digest(
                *(function.entry.source.assembly for function in compiled), sorted(model.values.items())
            ),
            "excitation": _digest(*(self._excitation_described(number) for number in range(len(points)))),
            "table of points": _digest(
                dict(points.shape),
                labels,
                points.follows.tobytes(),
                *((name, x.tobytes()) for name, x in points.numbers.items()),
            ),
            "choice of metrics or accuracy": _digest(*settings),
            "version of chassym": version("chassym"),
        }

    def variant(self, number: int) -> Model:
        """The model at one point.

        Raises
        ------
        ParameterError
            If a number is impossible.
        """
        changes: dict[str, float | list[float]] = {}
        for name, value in self.points.settings(number).items():
            base, is_entry, index = name.partition("[")
            if name not in self._parameters:
                continue
            if is_entry:
                whole = changes.setdefault(base, list(np.atleast_1d(self.model.parameters[base].value)))
                assert isinstance(whole, list)
                whole[int(index.rstrip("]"))] = value
            else:
                changes[base] = value
        return self.model.with_parameters(changes) if changes else self.model

    def excitation_at(self, number: int) -> Harmonic:
        """The excitation at one point.

        Raises
        ------
        ExcitationError
            If a number is impossible.
        """
        settings = self.points.settings(number)
        return self._rule(**{name: x for name, x in settings.items() if name not in self._parameters})

    def evaluate(self, numbers: Sequence[int]) -> list[Row]:
        """Points one after the other; one without a solution is kept with the reason."""
        rows, last = [], None
        for number in numbers:
            last = last if self.points.follows[number] else None
            try:
                with np.errstate(all="ignore"):  # what overflows ends as a reason
                    state = self._solved(number, last)
                    rows.append(self._row(number, state))
            except Exception as failure:  # whatever it is, it is this point's alone
                rows.append(Row(number, (np.nan,) * len(self.columns), "", _reason(failure)))
            else:
                last = state.orbit
        return rows

    def _solved(self, number: int, start: PeriodicOrbit | None) -> SteadyState:
        """The steady state at one point; where it is not found from a neighbour's orbit, from rest."""
        variant, excitation = self.variant(number), self.excitation_at(number)

        def solve(start: PeriodicOrbit | None) -> SteadyState:
            return steady_state(
                variant, excitation, metrics=self.measured, tolerance=self.tolerance, start=start
            )

        if start is not None:
            try:
                return solve(start)
            except (RuntimeError, ArithmeticError, np.linalg.LinAlgError):
                pass
        return solve(None)

    def _row(self, number: int, state: SteadyState) -> Row:
        found = [state.peak_to_peak[name] for name in self.measured]
        numbers = [metric.value for metric in found] + [metric.error for metric in found]
        if state.contact is not None:
            numbers += [state.contact.value, state.contact.error]
        if self.with_stability:
            numbers.append(float(np.abs(state.multipliers[0])))
        return Row(number, tuple(numbers), "" if state.contact is None else state.contact.patch, "")

    def _excitation_described(self, number: int) -> str:
        try:
            found = self.excitation_at(number)
        except ValueError as error:
            return str(error)
        return repr((found.frequency_hz, sorted((n, complex(u)) for n, u in found.amplitudes.items())))


def run_sweep(
    sweep: Sweep,
    *,
    store: str | Path | None = None,
    workers: Workers | None = None,
    progress: Progress = lambda state: None,
) -> xarray.Dataset:
    """Compute the points of a sweep that are not in its store yet, and return all of them.

    Parameters
    ----------
    store
        A file that takes every point as it is finished. Where it is there already, what it holds is not
        computed again. None keeps the points in memory.
    workers
        Where to compute: `in_this_process`, `on_processes` or `on_dask`. By default a Dask cluster if
        DASK_SCHEDULER_ADDRESS is set, otherwise the cores of this machine. The numbers do not depend on it.
    progress
        Told how far it is, before the first point and whenever points were finished.

    Returns
    -------
    xarray.Dataset
        Peak-to-peak value and error of every metric, the smallest patch force and where it is, the largest
        Floquet multiplier, and ``reason``: why a point failed, empty where it did not.

    Raises
    ------
    StoreError
        If the store belongs to another sweep or cannot be written.
    WorkersError
        If the cluster is not there, or workers keep dying.
    """
    path = None if store is None else Path(store)
    with Store(path, sweep.identity) as kept:
        finished = {row.number: bool(row.reason) for row in kept.rows()}
        tracker = _Tracker(len(sweep.points), finished, progress)
        chunks = _chunks(len(sweep.points), sweep.neighbours, finished)
        with closing((workers or usual_workers())(sweep.evaluate, chunks)) as results:
            for rows in results:
                kept.add(rows)
                tracker.add(rows)
        return to_dataset(sweep.points, sweep.columns, list(kept.rows()), _attributes(sweep))


def _chunks(count: int, size: int, finished: Collection[int]) -> list[list[int]]:
    """Numbers of neighbours that are computed together: the same ones whatever is finished already."""
    every = (range(first, min(first + size, count)) for first in range(0, count, size))
    return [[*chunk] for chunk in every if not all(number in finished for number in chunk)]


class _Tracker:
    """Counts finished points and estimates the remaining time from the pace of this run."""

    def __init__(self, count: int, finished: Mapping[int, bool], progress: Progress) -> None:
        self._count, self._progress = count, progress
        self._before = self._finished = len(finished)
        self._failed = sum(finished.values())
        self._started = time.monotonic()
        self._tell()

    def add(self, rows: Sequence[Row]) -> None:
        self._finished += len(rows)
        self._failed += sum(bool(row.reason) for row in rows)
        self._tell()

    def _tell(self) -> None:
        computed, left = self._finished - self._before, self._count - self._finished
        elapsed = time.monotonic() - self._started
        remaining = elapsed / computed * left if computed else (np.inf if left else 0.0)
        self._progress(SweepProgress(self._finished, self._failed, self._count, remaining))


def _attributes(sweep: Sweep) -> dict[str, str | float]:
    test = sweep.excitation.conditions if isinstance(sweep.excitation, RigTest) else {}
    return test | {
        "title": f"sweep of {sweep.model.system.name}",
        "vehicle": sweep.model.parameters.description,
        "tolerance": sweep.tolerance,
        "source": f"chassym {version('chassym')}",
        "identity": _digest(*sweep.identity.values()),
    }


def _reason(failure: Exception) -> str:
    message = " ".join(str(failure).split())
    own = type(failure).__module__.startswith("chassym.")
    return message if own and message else f"{type(failure).__name__}: {message}"


def _digest(*parts: object) -> str:
    return hashlib.sha256("\0".join(map(repr, parts)).encode()).hexdigest()[:40]
