"""A motion in time, as it was integrated: states, outputs, what happened on the way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from chassym.derivation import Model, Singularity
from chassym.nonlinear.excitation.excitation import Excitation
from chassym.nonlinear.simulation.loss_of_contact import LossOfContact

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

Signal = tuple[str, str, Array]
"""Name, unit and values over time."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A motion in time.

    Attributes
    ----------
    model, excitation
        What moves and what moves it.
    time_s
        Shape (samples,).
    states
        Coordinates, then rates, shape (2 n, samples).
    events
        How often the integration was started anew, by kind: a "knot" of a table or another corner of a law
        was passed, "contact lost" or "contact made" by what can only push, an "excitation break".
    event_times_s
        When knots, of whatever kind, were passed, ascending; those passed together are one.
    contact_losses
        Every time at which a patch force was not a push, in order; also between the samples.
    steps, evaluations
        Steps of the integrator and evaluations of the equations of motion.
    """

    model: Model
    excitation: Excitation
    time_s: Array = field(repr=False)
    states: Array = field(repr=False)
    events: Mapping[str, int]
    event_times_s: Array = field(repr=False)
    contact_losses: tuple[LossOfContact, ...]
    steps: int
    evaluations: int

    @cached_property
    def nearest_singularity(self) -> Singularity | None:
        """The nearest approach to the singularity of a rotation sequence; None if there is no sequence."""
        return self.model.nearest_singularity(self.arguments())

    def arguments(self) -> Array:
        """The equations' arguments with the accelerations, shape (arguments, samples)."""
        values, rates = self.excitation.signals(self.model, self.time_s)
        still = np.zeros((self.model.size, len(self.time_s)))
        arguments = np.concatenate([self.states, still, values, rates])
        n = self.model.size
        arguments[2 * n : 3 * n] = self.model.accelerations(arguments)
        return arguments

    def outputs(self) -> Array:
        """Every output of the system, shape (outputs, samples)."""
        return self.model.outputs(self.arguments())

    def to_xarray(self) -> xarray.Dataset:
        """Outputs, coordinates and inputs by name over `time`, each with its unit.

        Rates of coordinates and inputs are called ``rate_of_..``; a coordinate or an input that has the name
        of an output, ``coordinate_..`` or ``input_..``. Attributes tell what happened on the way.
        """
        import xarray  # it takes a second to import: only for those who ask for it

        variables: dict[str, tuple[str, Array, dict[str, str]]] = {}
        for kind, signals in (
            ("output", self._outputs()),
            ("coordinate", self._coordinates()),
            ("input", self._inputs()),
        ):
            for name, unit, values in signals:
                taken = name in variables
                variables[f"{kind}_{name}" if taken else name] = ("time", values, {"units": unit})
        told = {
            "system": self.model.system.name,
            **{f"{kind.replace(' ', '_')}_events": count for kind, count in self.events.items()},
            "contact_losses": "; ".join(map(str, self.contact_losses)),
        }
        return xarray.Dataset(variables, {"time": ("time", self.time_s, {"units": "s"})}, told)

    def _outputs(self) -> Iterator[Signal]:
        for output, values in zip(self.model.system.outputs, self.outputs(), strict=True):
            yield output.name, output.unit, values

    def _coordinates(self) -> Iterator[Signal]:
        coordinates, n = self.model.system.coordinates, self.model.size
        for coordinate, position, rate in zip(coordinates, self.states[:n], self.states[n:], strict=True):
            yield coordinate.name, coordinate.unit, position
            yield f"rate_of_{coordinate.name}", f"{coordinate.unit}/s", rate

    def _inputs(self) -> Iterator[Signal]:
        signals = self.excitation.signals(self.model, self.time_s)
        for motion, value, rate in zip(self.model.system.inputs, *signals, strict=True):
            yield motion.name, motion.unit, value
            yield f"rate_of_{motion.name}", f"{motion.unit}/s", rate
