"""Which slope stands for a table in a linear model: rules for its knots, and for motions across them.

Every rule is a weight of the motion: the slope before the first knot, and at every knot the change of slope
times the share of the motion that lies beyond it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Protocol, TypeAlias

import numpy as np
from scipy.special import erfc

from chassym.derivation.table_numbers import TableNumbers

Array = np.ndarray


class SlopeRuleError(ValueError):
    """A rule that is unknown or cannot be applied."""


class SlopeRule(Protocol):
    """A rule for the slope of a table about a place."""

    @property
    def name(self) -> str:
        """As `find_slope_rule` reads it."""

    def share_beyond(self, distance: Array) -> Array:
        """Share of the motion beyond a knot at a distance from the place, 0 to 1."""

    def density(self, distance: Array) -> Array:
        """How fast that share falls as the distance grows: its derivative, with the sign changed."""


SlopeRules: TypeAlias = SlopeRule | Mapping[str, SlopeRule]
"""One rule for all tables, or a rule for every one by its element's name."""


@dataclass(frozen=True)
class OneSided:
    """The slope on one side, or a weighted mean of both: it differs from one to the other at a knot only.

    Attributes
    ----------
    name
        What it is called.
    right
        Weight of the slope on the right.
    """

    name: str
    right: float

    def share_beyond(self, distance: Array) -> Array:
        """One below zero, the weight at zero, and nothing above it."""
        return np.where(distance < 0, 1.0, np.where(distance > 0, 0.0, self.right))

    def density(self, distance: Array) -> Array:
        """Zero: a small change of a knot elsewhere changes nothing, and one at the place follows it."""
        return np.zeros_like(distance)


left_slope = OneSided("left_slope", 0.0)
"""The slope before the place."""

right_slope = OneSided("right_slope", 1.0)
"""The slope behind the place."""

mean_slope = OneSided("mean_slope", 0.5)
"""The mean of both, which is the central difference of small motions: the default."""


@dataclass(frozen=True)
class Secant:
    """Rise of the force from the place to a reach away, per reach: the equivalent of a constant rate.

    Attributes
    ----------
    reach
        Rate (m/s, rad/s) of a damper, deflection (m, rad) of a spring; negative on the rebound side.

    Raises
    ------
    SlopeRuleError
        If the reach is zero or not finite.

    Examples
    --------
    >>> table = TableNumbers(np.array([[0.0], [0.1]]), np.array([[4.0], [1.0], [0.5]]))
    >>> [float(slope_of(table, Secant(reach), 0.0)[0]) for reach in (-0.2, 0.1, 0.2)]
    [4.0, 1.0, 0.75]
    """

    reach: float

    def __post_init__(self) -> None:
        if not _is_finite(self.reach) or self.reach == 0:
            raise SlopeRuleError(f"secant_slope: reach {self.reach} received; expected a number, not zero")

    @property
    def name(self) -> str:
        """With the reach in SI."""
        return f"secant_slope({self.reach:g})"

    def share_beyond(self, distance: Array) -> Array:
        """Part of the way that lies beyond the knot."""
        ends = np.sort([0.0, self.reach])
        return np.clip((ends[1] - distance) / (ends[1] - ends[0]), 0.0, 1.0)

    def density(self, distance: Array) -> Array:
        """One over the way, on it."""
        ends = np.sort([0.0, self.reach])
        return np.where((distance > ends[0]) & (distance < ends[1]), 1 / (ends[1] - ends[0]), 0.0)


@dataclass(frozen=True)
class DescribingFunction:
    """The slope whose force has the same first harmonic under a harmonic motion about the place.

    With x = a cos(t) and a knot at c a, max(x - c a, 0) has the first harmonic a (t0 - c sin t0) / pi, where
    cos t0 = c: Gelb and Vander Velde, Multiple-Input Describing Functions (1968), chapter 2.

    Attributes
    ----------
    amplitude
        Of the rate (m/s, rad/s) of a damper, of the deflection (m, rad) of a spring.

    Raises
    ------
    SlopeRuleError
        If the amplitude is not greater than zero.
    """

    amplitude: float

    def __post_init__(self) -> None:
        if not _is_finite(self.amplitude) or self.amplitude <= 0:
            raise SlopeRuleError(
                f"describing_function: amplitude {self.amplitude} received; expected one greater than zero"
            )

    @property
    def name(self) -> str:
        """With the amplitude in SI."""
        return f"describing_function({self.amplitude:g})"

    def share_beyond(self, distance: Array) -> Array:
        """Share of the first harmonic that is made beyond the knot."""
        cosine = np.clip(distance / self.amplitude, -1.0, 1.0)
        return (np.arccos(cosine) - cosine * np.sqrt(1 - cosine**2)) / np.pi

    def density(self, distance: Array) -> Array:
        """Half a circle over the motion."""
        cosine = np.clip(distance / self.amplitude, -1.0, 1.0)
        return 2 * np.sqrt(1 - cosine**2) / (np.pi * self.amplitude)


@dataclass(frozen=True)
class StatisticalSlope:
    """The slope whose force is least wrong, in the mean square, under a Gaussian random motion.

    It is the mean slope met on the way, by the share of the time beyond every knot: Gelb and Vander Velde,
    chapter 7.

    Attributes
    ----------
    rms
        Root mean square of the rate (m/s, rad/s) of a damper, of the deflection (m, rad) of a spring.

    Raises
    ------
    SlopeRuleError
        If the root mean square is not greater than zero.
    """

    rms: float

    def __post_init__(self) -> None:
        if not _is_finite(self.rms) or self.rms <= 0:
            raise SlopeRuleError(f"statistical_slope: rms {self.rms} received; one above zero is needed")

    @property
    def name(self) -> str:
        """With the root mean square in SI."""
        return f"statistical_slope({self.rms:g})"

    def share_beyond(self, distance: Array) -> Array:
        """Share of the time beyond the knot."""
        return np.asarray(erfc(distance / (self.rms * np.sqrt(2))) / 2)

    def density(self, distance: Array) -> Array:
        """That of the normal distribution."""
        return np.asarray(np.exp(-((distance / self.rms) ** 2) / 2) / (self.rms * np.sqrt(2 * np.pi)))


def rule_of(rules: SlopeRules, element: str) -> SlopeRule:
    """The rule for an element.

    Raises
    ------
    SlopeRuleError
        If the rules are by element and have none for it, or are no rules.
    """
    rule = rules.get(element) if isinstance(rules, Mapping) else rules
    if rule is None:
        raise SlopeRuleError(f"slope_rule: none for element {element!r}; expected one for every table")
    is_rule = all(hasattr(rule, part) for part in ("name", "share_beyond", "density"))
    if not is_rule or isinstance(rule, type):
        raise SlopeRuleError(
            f"slope_rule {rule!r} is no rule; expected left_slope, right_slope, mean_slope, Secant(v), "
            "DescribingFunction(a), StatisticalSlope(rms), or find_slope_rule of a text"
        )
    return rule


def _is_finite(number: object) -> bool:
    return isinstance(number, Real) and bool(np.isfinite(float(number)))


def distance_to_knots(table: TableNumbers, place: Array | float) -> Array:
    """How far every knot is from a place, shape (knots, sets); zero where only rounding lies between."""
    distance = table.knots - place
    return np.where(np.abs(distance) <= _ROUNDING * np.abs(table.knots), 0.0, distance)


def slope_of(table: TableNumbers, rule: SlopeRule, place: Array | float) -> Array:
    """The slope of a table about a place, shape (sets,).

    Raises
    ------
    SlopeRuleError
        If the rule gives no finite number.
    """
    shares = rule.share_beyond(distance_to_knots(table, place))
    slope = table.slopes[0] + (np.diff(table.slopes, axis=0) * shares).sum(axis=0)
    if not np.isfinite(slope).all():
        raise SlopeRuleError(f"slope_rule {rule.name!r} gave {slope.min()}; a finite slope is needed")
    return np.asarray(slope)


def find_slope_rule(text: str) -> SlopeRule:
    """A rule from its name: left, right, mean, secant(v), describing_function(a) or statistical(rms).

    The ending of ``left_slope`` may be given or not.

    Raises
    ------
    SlopeRuleError
        If there is no such rule, or its number cannot be.

    Examples
    --------
    >>> find_slope_rule("mean") is mean_slope, find_slope_rule("secant(-0.15)").name
    (True, 'secant_slope(-0.15)')
    """
    words = re.fullmatch(r"\s*([a-z_]+?)(?:_slope)?\s*(?:\(([^()]*)\))?\s*", text)
    name, number = words.groups() if words else (text, None)
    if name in _AT_KNOTS and number is None:
        return _AT_KNOTS[name]
    if name in _OF_MOTIONS and number is not None:
        try:
            return _OF_MOTIONS[name](float(number))
        except ValueError as error:
            if isinstance(error, SlopeRuleError):
                raise
            raise SlopeRuleError(f"slope_rule {text!r}: {number!r} is no number in SI") from None
    near = difflib.get_close_matches(name, [*_AT_KNOTS, *_OF_MOTIONS], n=1, cutoff=0.5)
    hint = f" (near: {near[0]})" if near else ""
    raise SlopeRuleError(f"slope_rule {text!r} is unknown{hint}; expected {EXPECTED}")


_ROUNDING = 1e-12
"""Distance of a knot, as a part of its own place, that is rounding."""

_AT_KNOTS: Mapping[str, SlopeRule] = {"left": left_slope, "right": right_slope, "mean": mean_slope}
_OF_MOTIONS: Mapping[str, Callable[[float], SlopeRule]] = {
    "secant": Secant,
    "describing_function": DescribingFunction,
    "statistical": StatisticalSlope,
}
EXPECTED = "left, right, mean, secant(NUMBER), describing_function(NUMBER) or statistical(NUMBER)"
"""What `find_slope_rule` reads."""
