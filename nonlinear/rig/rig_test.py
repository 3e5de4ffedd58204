"""A test of the rig: what every pad does, at which frequencies, and what is measured."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chassym.derivation import Model, ParameterError, with_lifting_tyres
from chassym.derivation.schema import refusal
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.rig.held_body import hold_body
from chassym.nonlinear.rig.pads import CORNERS, PADS, Pad, pads_of
from chassym.nonlinear.steady.steady_state import measured_names

ORDERS: Mapping[str, int] = {"m": 0, "m/s": 1, "m/s^2": 2}
"""Which derivative of a pad's displacement an amplitude is of, by its unit."""

_GIVEN = 3
"""Names that a refusal offers."""


@dataclass(frozen=True)
class Motion:
    """What some pads do together: their displacement is Re(a exp(i (w (t - lag) + phase))).

    Of an amplitude of velocity or acceleration, a is that divided by w or its square.

    Attributes
    ----------
    pads
        Words that choose pads: "all", or words of their places such as "front" or "rear_left".
    direction
        "longitudinal", "lateral" or "vertical".
    amplitude
        Of displacement, velocity or acceleration, in SI; a negative one is the opposite motion.
    phase_rad, lag_s
        Lead (rad) and delay (s).
    """

    pads: tuple[str, ...]
    direction: str
    amplitude: float
    phase_rad: float = 0.0
    lag_s: float = 0.0

    def moves(self, pad: Pad) -> bool:
        """Whether a pad is one of those meant."""
        return pad.direction == self.direction and any(map(pad.is_called, self.pads))


@dataclass(frozen=True)
class Rate:
    """The slope of one output over another, by the regression line through a period."""

    name: str
    of: str
    over: str


@dataclass(frozen=True)
class RigTest:
    """A test as data; `load_rig_test` reads one from a file.

    Attributes
    ----------
    name, description, source
        For reading.
    frequencies_hz
        One, or those of a stepped sine, increasing.
    motions
        What the pads do; motions of the same pad add up.
    amplitude_unit
        One of `ORDERS`: displacement, velocity or acceleration is the same at all frequencies.
    rear_lag_s
        By how much the rear pads are later, in addition to the lags of the motions.
    body_is_held
        Whether the body is fixed to the ground and the pads are free in the plane, as on a K&C rig.
    tyres_lift
        Whether tyres leave the pads instead of being bonded to them.
    metrics
        Outputs to measure peak to peak; all accelerations and angular rates if None.
    rates
        Slopes to measure.
    tolerance
        Largest error, relative to a metric.

    Raises
    ------
    ParameterError
        If it moves nothing.
    """

    name: str
    description: str
    source: str
    frequencies_hz: tuple[float, ...]
    motions: tuple[Motion, ...]
    amplitude_unit: str = "m"
    rear_lag_s: float = 0.0
    body_is_held: bool = False
    tyres_lift: bool = False
    metrics: tuple[str, ...] | None = None
    rates: tuple[Rate, ...] = ()
    tolerance: float = 1e-3

    def __post_init__(self) -> None:
        if not any(motion.amplitude for motion in self.motions):
            raise refusal(f"{self.name} test", "motion", "no amplitude", "one that is not zero")

    @property
    def is_stepped(self) -> bool:
        """Whether the frequency is stepped."""
        return len(self.frequencies_hz) > 1

    @property
    def amplitude(self) -> float:
        """The largest amplitude of a motion, in the amplitude's unit."""
        return max(abs(motion.amplitude) for motion in self.motions)

    def measured(self, model: Model) -> tuple[str, ...]:
        """The metrics, and whatever the rates are slopes of."""
        metrics = measured_names(model) if self.metrics is None else self.metrics
        return tuple(dict.fromkeys([*metrics, *(n for r in self.rates for n in (r.of, r.over))]))

    @property
    def conditions(self) -> dict[str, str | float]:
        """What a result was measured under, for its labels; the amplitude is the largest one."""
        return {
            "test": self.name,
            "amplitude": self.amplitude,
            "amplitude_unit": self.amplitude_unit,
            "rear_lag_s": self.rear_lag_s,
            "body": "held" if self.body_is_held else "free",
            "tyres": "lifting" if self.tyres_lift else "bonded",
            "tolerance": self.tolerance,
        }

    @property
    def peculiarities(self) -> str:
        """What a heading adds to the amplitude: lag and lifting tyres, if there are any."""
        lag = f", rear {self.rear_lag_s:g} s later" if self.rear_lag_s else ""
        return lag + (", lifting tyres" if self.tyres_lift else "")

    def at(self, frequency_hz: float) -> RigTest:
        """The same test at one frequency."""
        return replace(self, frequencies_hz=(frequency_hz,))

    def with_amplitude(self, amplitude: float, unit: str = "m") -> RigTest:
        """The same test with all amplitudes in proportion, the largest one as given."""
        factor = amplitude / self.amplitude
        motions = tuple(replace(motion, amplitude=factor * motion.amplitude) for motion in self.motions)
        return replace(self, motions=motions, amplitude_unit=unit)

    def with_rear_lag(self, lag_s: float) -> RigTest:
        """The same test with another delay of the rear pads (s)."""
        return replace(self, rear_lag_s=lag_s)

    def mounted(self, model: Model) -> Model:
        """The model as it stands on the rig, with its body held or its tyres free if the test asks for that.

        Raises
        ------
        MechanismError
            If tyres are to lift and the vehicle has none that can.
        ParameterError
            If the body is to be held and the vehicle is not one whose body can be, or if it lacks an output.
        """
        mounted = hold_body(model, self.name) if self.body_is_held else model
        if self.tyres_lift:
            mounted = with_lifting_tyres(mounted)
        asked = [("metrics", name) for name in self.metrics or ()]
        for rate in self.rates:
            asked += [(f"rate {rate.name!r}: of", rate.of), (f"rate {rate.name!r}: over", rate.over)]
        for key, name in asked:
            if name not in mounted.output_names:
                near = difflib.get_close_matches(name, mounted.output_names, n=_GIVEN, cutoff=0.0)
                received = f"{name!r}, which a {mounted.system.name} does not measure"
                raise refusal(f"{self.name} test", key, received, f"outputs such as {', '.join(near)}")
        return mounted

    def excitation(self, model: Model, frequency_hz: float | None = None) -> Harmonic:
        """What the test does to the inputs of a model.

        Parameters
        ----------
        model
            A vehicle with pads or a road.
        frequency_hz
            The test's own, the first if it is stepped, by default.

        Raises
        ------
        ParameterError
            If the model lacks the pads that the test moves.
        ExcitationError
            If the frequency is not positive.
        """
        inputs = [each.name for each in model.system.inputs]
        pads = pads_of(inputs)
        for motion in self.motions:
            if not any(map(motion.moves, pads)):
                raise self._without_pads(model.system.name, inputs)
        return self.harmonic(pads, frequency_hz)

    def harmonic(self, pads: Sequence[Pad] = PADS, frequency_hz: float | None = None) -> Harmonic:
        """What the test does to some pads, those of the four-post rig by default."""
        frequency = self.frequencies_hz[0] if frequency_hz is None else frequency_hz
        angular_frequency = 2 * np.pi * frequency
        amplitudes: dict[str, complex] = {}
        for motion in self.motions:
            size = motion.amplitude / angular_frequency ** ORDERS[self.amplitude_unit]
            for pad in filter(motion.moves, pads):
                angle = motion.phase_rad - angular_frequency * self._lag_s(motion, pad)
                moved = size * np.exp(1j * angle) if angle else size
                amplitudes[pad.input] = amplitudes.get(pad.input, 0) + moved
        return Harmonic(frequency, amplitudes)

    def lags_s(self, pads: Sequence[Pad]) -> dict[str, float]:
        """Delay of every pad that moves late (s), by its input.

        Raises
        ------
        ParameterError
            If motions of different lags add up on one pad: no single delay describes it.
        """
        found: dict[str, float] = {}
        for motion in self.motions:
            for pad in filter(motion.moves, pads):
                lag = self._lag_s(motion, pad)
                if found.setdefault(pad.input, lag) != lag:
                    received = f"{lag:g} s and {found[pad.input]:g} s of {pad.input}"
                    raise refusal(f"{self.name} test", "lag", received, "one lag for motions that add up")
        return {name: lag for name, lag in found.items() if lag}

    def _lag_s(self, motion: Motion, pad: Pad) -> float:
        return motion.lag_s + (self.rear_lag_s if pad.is_called("rear") else 0.0)

    def _without_pads(self, vehicle: str, inputs: Sequence[str]) -> ParameterError:
        needed = [pad.input for pad in PADS if any(motion.moves(pad) for motion in self.motions)]
        if not needed:
            words = ", ".join(dict.fromkeys(word for motion in self.motions for word in motion.pads))
            expected = f'"all", or words of places such as {", ".join(CORNERS)}'
            return refusal(f"{self.name} test", "pads", repr(words), expected)
        received = f"a {vehicle}, whose inputs are {', '.join(inputs) or 'none'}"
        return refusal(f"{self.name} test", "vehicle", received, f"one with {', '.join(needed)}")
