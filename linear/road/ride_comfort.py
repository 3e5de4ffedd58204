"""Ride comfort by ISO 2631-1: frequency weightings, weighted accelerations and their total on a random road.

Sources: ISO 2631-1:1997, Mechanical vibration and shock - Evaluation of human exposure to whole-body
vibration, annexes A and C and clause 8; ISO 8041:2005, table 3, for the parameters of the weightings.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.road.random_road import RootMeanSquare, Weight, root_mean_squares
from chassym.linear.road.road_contacts import Passage

if TYPE_CHECKING:
    import control

Array = np.ndarray


@dataclass(frozen=True)
class Transition:
    """From proportional to acceleration to proportional to velocity: (1 + s/w3) / (1 + s/(Q4 w4) + (s/w4)^2).

    Attributes
    ----------
    zero_hz, pole_hz, quality
        w3 / 2 pi, infinite where there is no zero; w4 / 2 pi; Q4.
    """

    zero_hz: float
    pole_hz: float
    quality: float


@dataclass(frozen=True)
class UpwardStep:
    """A rise in proportion to jerk: (w5/w6)^2 (1 + s/(Q5 w5) + (s/w5)^2) / (1 + s/(Q6 w6) + (s/w6)^2).

    Attributes
    ----------
    zero_hz, zero_quality, pole_hz, pole_quality
        w5 / 2 pi, Q5, w6 / 2 pi, Q6.
    """

    zero_hz: float
    zero_quality: float
    pole_hz: float
    pole_quality: float


@dataclass(frozen=True)
class Weighting:
    """A frequency weighting of ISO 2631-1.

    Attributes
    ----------
    name
        As in the standard.
    lowest_hz, highest_hz
        Corner frequencies of the two Butterworth filters of second order that limit the band.
    transition, step
        None where the weighting has none.
    """

    name: str
    lowest_hz: float
    highest_hz: float
    transition: Transition | None = None
    step: UpwardStep | None = None

    def polynomials(self) -> tuple[Array, Array]:
        """Numerator and denominator in s (rad/s), highest power first."""
        quality = math.sqrt(0.5)
        numerator = np.array([(2 * np.pi * self.lowest_hz) ** -2, 0.0, 0.0])
        denominator = np.polymul(
            _second_order(self.lowest_hz, quality), _second_order(self.highest_hz, quality)
        )
        if self.transition is not None:
            zero = np.array([1 / (2 * np.pi * self.transition.zero_hz), 1.0])
            numerator = np.polymul(numerator, zero)
            pole = _second_order(self.transition.pole_hz, self.transition.quality)
            denominator = np.polymul(denominator, pole)
        if self.step is not None:
            gain = (self.step.zero_hz / self.step.pole_hz) ** 2
            zero = _second_order(self.step.zero_hz, self.step.zero_quality)
            numerator = np.polymul(gain * numerator, zero)
            pole = _second_order(self.step.pole_hz, self.step.pole_quality)
            denominator = np.polymul(denominator, pole)
        return np.trim_zeros(numerator, "f"), denominator

    def response(self, frequencies_hz: ArrayLike) -> Array:
        """Complex response to frequencies (Hz), of their shape.

        Examples
        --------
        >>> float(abs(WK.response(6.3)).round(3))
        1.054
        """
        s = 2j * np.pi * np.asarray(frequencies_hz, dtype=float)
        numerator, denominator = self.polynomials()
        return np.polyval(numerator, s) / np.polyval(denominator, s)

    def to_control(self) -> control.TransferFunction:
        """The weighting as a python-control system from acceleration to weighted acceleration."""
        import control  # it takes a second to import: only for those who ask for it

        return control.TransferFunction(
            *self.polynomials(), inputs=["acceleration"], outputs=["weighted_acceleration"], name=self.name
        )


WK = Weighting("Wk", 0.4, 100.0, Transition(12.5, 12.5, 0.63), UpwardStep(2.37, 0.91, 3.35, 0.91))
"""Vertical, on the seat and at the feet; along the spine when lying."""

WD = Weighting("Wd", 0.4, 100.0, Transition(2.0, 2.0, 0.63))
"""Horizontal."""

WF = Weighting("Wf", 0.08, 0.63, Transition(math.inf, 0.25, 0.86), UpwardStep(0.0625, 0.80, 0.1, 0.80))
"""Motion sickness."""

WC = Weighting("Wc", 0.4, 100.0, Transition(8.0, 8.0, 0.63))
"""Fore and aft at the backrest."""

WE = Weighting("We", 0.4, 100.0, Transition(1.0, 1.0, 0.63))
"""Rotational."""

WJ = Weighting("Wj", 0.4, 100.0, None, UpwardStep(3.75, 0.91, 5.32, 0.91))
"""Vertical at the head when lying."""


@dataclass(frozen=True)
class Axis:
    """What a person feels along or about an axis.

    Attributes
    ----------
    weighting
        Of the frequencies.
    factor
        k, by which the weighted acceleration counts in the total; without a unit along an axis, in m/rad
        about one.
    unit
        Of the acceleration.
    """

    weighting: Weighting
    factor: float
    unit: str = "m/s^2"


SEAT_X = SEAT_Y = Axis(WD, 1.0)
SEAT_Z = Axis(WK, 1.0)
SEAT_ROLL = Axis(WE, 0.63, "rad/s^2")
SEAT_PITCH = Axis(WE, 0.4, "rad/s^2")
SEAT_YAW = Axis(WE, 0.2, "rad/s^2")
BACKREST_X = Axis(WC, 0.8)
BACKREST_Y = Axis(WD, 0.5)
BACKREST_Z = Axis(WD, 0.4)
FEET_X = FEET_Y = Axis(WK, 0.25)
FEET_Z = Axis(WK, 0.4)
"""Comfort of a seated person, ISO 2631-1:1997, 8.2.2."""

WORDS = (
    ("not uncomfortable", 0.0, 0.315),
    ("a little uncomfortable", 0.315, 0.63),
    ("fairly uncomfortable", 0.5, 1.0),
    ("uncomfortable", 0.8, 1.6),
    ("very uncomfortable", 1.25, 2.5),
    ("extremely uncomfortable", 2.0, math.inf),
)
"""ISO 2631-1:1997, C.2.3: reactions in public transport to totals from and up to (m/s^2); they overlap."""


@dataclass(frozen=True, eq=False)
class RideComfort:
    """What a seated person feels.

    Attributes
    ----------
    weighted
        Weighted acceleration by the output's name, without the factor k (m/s^2 or rad/s^2).
    total
        The vibration total value (m/s^2).
    words
        What people say of it, one or two of `WORDS`.
    """

    weighted: Mapping[str, RootMeanSquare]
    total: float
    words: tuple[str, ...]


def ride_comfort(linear: LinearModel, passage: Passage, axes: Mapping[str, Axis]) -> RideComfort:
    """Comfort on a random road, from the accelerations that the model measures.

    Parameters
    ----------
    linear
        The linear model.
    passage
        The road, its contacts and the speed.
    axes
        What each output is felt as, by its name, such as ``{"vertical_acceleration": SEAT_Z, "roll_rate":
        SEAT_ROLL}``. A velocity is differentiated.

    Raises
    ------
    LinearisationError
        As for `random_response`, or if there is no such output or it has another unit than the axis.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> from chassym.linear.road.road_contacts import road_contacts
    >>> from chassym.linear.road.road_surface import iso_8608
    >>> model = load_model("half_car")
    >>> passage = Passage(iso_8608("C"), road_contacts(model), speed=20.0)
    >>> comfort = ride_comfort(linearise(model), passage, {"vertical_acceleration": SEAT_Z})
    >>> round(comfort.total, 2), comfort.words
    (0.7, ('fairly uncomfortable',))
    """
    weights = {output: _weight(linear, output, axis) for output, axis in axes.items()}
    weighted = root_mean_squares(linear, passage, weights)
    total = total_value((weighted[output].value, axis.factor) for output, axis in axes.items())
    return RideComfort(weighted, total, comfort_words(total))


def total_value(weighted: Iterable[tuple[float, float]]) -> float:
    """Root of the sum of squares of weighted accelerations times their factors k (m/s^2).

    Examples
    --------
    >>> total_value([(0.3, 1.0), (0.8, 0.5)])
    0.5
    """
    return math.hypot(*(acceleration * factor for acceleration, factor in weighted))


def comfort_words(total: float) -> tuple[str, ...]:
    """What people say of a vibration total value (m/s^2): one or two of `WORDS`, whose ranges overlap.

    Raises
    ------
    LinearisationError
        If the value is negative or not a number.

    Examples
    --------
    >>> comfort_words(0.55)
    ('a little uncomfortable', 'fairly uncomfortable')
    """
    if not total >= 0:
        raise LinearisationError(
            f"total {total!r} received; an acceleration of zero or more (m/s^2) is needed"
        )
    return tuple(words for words, least, most in WORDS if least <= total < most)


def _weight(linear: LinearModel, output: str, axis: Axis) -> Weight:
    """The axis' weighting, with the derivative that makes an acceleration of the output."""
    weight = axis.weighting.response
    units = dict(zip(linear.outputs, linear.output_units, strict=True))
    if output not in units or units[output] == axis.unit:
        return weight
    if f"{units[output]}^2" == axis.unit:
        return lambda frequencies: 2j * np.pi * frequencies * weight(frequencies)
    raise LinearisationError(
        f"output {output!r} is in {units[output]}; {axis.unit} is needed, or its integral over time"
    )


def _second_order(frequency_hz: float, quality: float) -> Array:
    """1 + s / (Q w) + (s / w)^2, highest power first."""
    circular = 2 * np.pi * frequency_hz
    return np.array([circular**-2, 1 / (quality * circular), 1.0])
