"""Variants of the car in both tests: sensitivity, half the stiffness, stiffness sweeps, other readings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from chassym.derivation import Model
from chassym.nonlinear import PeriodicOrbit
from chassym.rig_tests import Outcome, TestRecord, outcome

Announce = Callable[[str], None]
"""Told before every solution what is being solved."""

FACTORS = (0.75, 1.25)
"""25 % less and more. Source: Liu 2016, section 3.3."""

HALF = 0.5

FRONT_STIFFNESS = "body.front.torsional_stiffness"
REAR_STIFFNESS = "body.rear.torsional_stiffness"

PLACES: Mapping[str, tuple[str, ...]] = {
    "front": (FRONT_STIFFNESS,),
    "rear": (REAR_STIFFNESS,),
    "both": (FRONT_STIFFNESS, REAR_STIFFNESS),
}
"""Parameters of the body's torsional stiffness; its damping is proportional and follows."""

GROUPS: Mapping[str, tuple[str, ...]] = {
    "contact patch stiffness": ("tyre.front.stiffness", "tyre.rear.stiffness"),
    "contact patch stiffness and damping": ("tyre",),
    "damper": ("suspension.front.damper.force", "suspension.rear.damper.force"),
    "body stiffness": PLACES["both"],
}
"""Parameters that the sensitivity study scales together, by what they are."""


@dataclass(frozen=True)
class Reading:
    """Another understanding of an ambiguous source, as parameters to multiply or to set."""

    name: str
    factors: Mapping[str, float]
    values: Mapping[str, float]

    def applied(self, model: Model) -> Model:
        """The car as it would be under this reading."""
        for name, factor in self.factors.items():
            model = model.scaled(name, factor=factor)
        return model.with_parameters(self.values)


READINGS = (
    Reading(
        "damper tables without their lever ratios",
        {},
        {"suspension.front.damper.lever_ratio": 1.0, "suspension.rear.damper.lever_ratio": 1.0},
    ),
    Reading(
        "anti-roll bars at half the rate",
        {"suspension.front.anti_roll_bar.rate": 0.5, "suspension.rear.anti_roll_bar.rate": 0.5},
        {},
    ),
)
"""Where the thesis can be understood in another way."""


@dataclass(frozen=True)
class Scaled:
    """A group of parameters times a factor, and what it does in one test."""

    group: str
    factor: float
    outcome: Outcome


@dataclass(frozen=True)
class Stiffened:
    """The body's torsional stiffness (N m/rad) at one place, and what it does in one test."""

    placement: str
    stiffness: float
    outcome: Outcome


@dataclass(frozen=True)
class Reread:
    """An alternative reading, and what it does in one test."""

    reading: str
    outcome: Outcome


@dataclass(frozen=True, eq=False)
class VariantRunner:
    """Runs variants of one car, starting from its nominal orbits.

    Attributes
    ----------
    model
        The nominal car.
    nominal
        Its record in every test.
    tolerance
        Largest stated error of a metric, relative.
    announce
        Told before every solution.
    """

    model: Model
    nominal: Mapping[str, TestRecord]
    tolerance: float
    announce: Announce

    def scaled(self) -> Iterator[Scaled]:
        """Every group of parameters 25 % less and more, one at a time."""
        for record in self.nominal.values():
            for group, names in GROUPS.items():
                for factor in FACTORS:
                    self.announce(f"sensitivity, {record.test.name} test: {group} times {factor:g}")
                    found, _ = self._run(self.model.scaled(*names, factor=factor), record)
                    yield Scaled(group, factor, found)

    def halved(self) -> Iterator[Stiffened]:
        """Half the nominal body stiffness at every place."""
        for record in self.nominal.values():
            for place, names in PLACES.items():
                self.announce(f"half body stiffness, {record.test.name} test: {place}")
                variant = self.model.scaled(*names, factor=HALF)
                found, _ = self._run(variant, record)
                yield Stiffened(place, variant.values[names[0]], found)

    def reread(self) -> Iterator[Reread]:
        """Every alternative reading."""
        for record in self.nominal.values():
            for reading in READINGS:
                self.announce(f"alternative reading, {record.test.name} test: {reading.name}")
                found, _ = self._run(reading.applied(self.model), record)
                yield Reread(reading.name, found)

    def sweep(self, stiffnesses: Sequence[float]) -> Iterator[Stiffened]:
        """Every body stiffness (N m/rad) at every place, the others nominal; ascending."""
        for record in self.nominal.values():
            for place in PLACES:
                found = [
                    *self._branch(record, place, stiffnesses, -1),
                    *self._branch(record, place, stiffnesses, 1),
                ]
                yield from sorted(found, key=lambda point: point.stiffness)

    def _branch(
        self, record: TestRecord, place: str, stiffnesses: Sequence[float], sign: int
    ) -> Iterator[Stiffened]:
        """Stiffnesses below (-1) or above (+1) the nominal one, going away, each from the last orbit."""
        nominal = self.model.values[PLACES[place][0]]
        ahead = [s for s in stiffnesses if (s < nominal if sign < 0 else s >= nominal)]
        last = record.orbit
        for stiffness in sorted(ahead, reverse=sign < 0):
            self.announce(f"body stiffness sweep, {record.test.name} test: {place} {stiffness:.3g} N m/rad")
            variant = self.model.with_parameters(dict.fromkeys(PLACES[place], stiffness))
            found, orbit = self._run(variant, record, last)
            last = orbit or last
            yield Stiffened(place, stiffness, found)

    def _run(
        self, variant: Model, record: TestRecord, *starts: PeriodicOrbit
    ) -> tuple[Outcome, PeriodicOrbit | None]:
        return outcome(variant, record, self.tolerance, starts or (record.orbit,))


def sweep_curves(sweep: Sequence[Stiffened]) -> dict[tuple[str, str], list[Stiffened]]:
    """The points of a sweep by test and place."""
    return {
        key: list(points)
        for key, points in groupby(sweep, key=lambda point: (point.outcome.test, point.placement))
    }
