"""What the reference thesis reports, as data: figures' axes, numbers and statements, each with its source.

Y. Liu, Investigation of Vehicle Body Stiffness Modification on Vehicle Ride Comfort and Handling Using a
Low-Order Vehicle Model, honors thesis, The Ohio State University, 2016. The curves of its figures are not
available as numbers; the axes of the figures are, and every nominal value lies inside the axis of each figure
that shows it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

METRICS: Mapping[str, tuple[str, str, str]] = {
    "lateral": ("lateral_acceleration", "yaw_rate", "roll_rate"),
    "vertical": ("vertical_acceleration", "pitch_rate", "roll_rate"),
}
"""What the thesis measures in each test, peak to peak."""

UNITS: Mapping[str, str] = {
    "lateral_acceleration": "m/s^2",
    "vertical_acceleration": "m/s^2",
    "roll_rate": "rad/s",
    "pitch_rate": "rad/s",
    "yaw_rate": "rad/s",
}

"""Where the thesis changes the body's torsional stiffness."""


@dataclass(frozen=True)
class Published:
    """A number or a range as published.

    Attributes
    ----------
    text
        As the thesis gives it.
    low, high
        What the text stands for: the ends of a range, or all numbers that round to a printed one.
    unit
        Unit of both.
    source
        Where in the thesis.
    """

    text: str
    low: float
    high: float
    unit: str
    source: str


@dataclass(frozen=True)
class FigureAxis:
    """The axis on which the thesis draws one metric of a test over the stiffness at one place."""

    test: str
    placement: str
    metric: str
    axis: Published


def _range(low: float, high: float, unit: str, source: str) -> Published:
    return Published(f"{low:g} to {high:g}", low, high, unit, source)


def _axes() -> tuple[FigureAxis, ...]:
    """The vertical axes of figures 11 to 16, parts a, b and c being the metrics in order."""
    limits = {
        ("lateral", "front", 11): ((5.4, 7.0), (0.75, 0.95), (0.35, 0.70)),
        ("lateral", "rear", 12): ((6.2, 6.4), (0.70, 1.00), (0.55, 0.75)),
        ("lateral", "both", 13): ((5.6, 7.0), (0.70, 1.00), (0.45, 0.70)),
        ("vertical", "front", 14): ((0.62, 0.72), (0.0120, 0.0145), (0.0, 0.5)),
        ("vertical", "rear", 15): ((0.66, 0.76), (0.0120, 0.0150), (0.15, 0.40)),
        ("vertical", "both", 16): ((0.60, 0.72), (0.010, 0.016), (0.15, 0.23)),
    }
    return tuple(
        FigureAxis(test, placement, metric, _range(low, high, UNITS[metric], f"figure {number}{part}"))
        for (test, placement, number), ranges in limits.items()
        for metric, part, (low, high) in zip(METRICS[test], "abc", ranges, strict=True)
    )


FIGURE_AXES = _axes()
"""Axes of the figures over body stiffness, 100 N m/rad to 1e9 N m/rad."""


def nominal_range(test: str, metric: str) -> Published:
    """The range that holds a nominal value: what the axes of all figures that show it have in common.

    Examples
    --------
    >>> nominal_range("lateral", "lateral_acceleration").text
    '6.2 to 6.4'
    """
    axes = [drawn.axis for drawn in FIGURE_AXES if (drawn.test, drawn.metric) == (test, metric)]
    low, high = max(axis.low for axis in axes), min(axis.high for axis in axes)
    figures = ", ".join(axis.source.removeprefix("figure ") for axis in axes)
    return _range(low, high, UNITS[metric], f"axes of figures {figures}")


FREE_TORSION = Published("30 to 40", 30.0, 40.0, "Hz", "section 2.2")
"""First torsional mode of the body alone, to which its stiffness is matched."""

WHEEL_RATE = Published("15.6", 15.55, 15.65, "N/mm", "section 2.3, figure 7")
"""Slope of the force over the travel of the front right wheel, body held."""

BODY_PEAK = Published("near 1", 0.75, 1.25, "Hz", "section 2.3, figure 8, steps of 0.5 Hz")
"""Peak of the body's displacement in heave."""

WHEEL_PEAK = Published("near 9.5", 9.25, 9.75, "Hz", "section 2.3, figure 8, steps of 0.5 Hz")
"""Peak of the wheel's displacement in heave."""

PATCH, DAMPER, BODY = "contact patch", "damper", "body stiffness"

_LATERAL, _VERTICAL = "section 3.3, figures 17 and 18", "section 3.3, figures 19 and 20"

LARGEST_CHANGES: Mapping[tuple[str, str], Published] = {
    ("lateral", PATCH): Published("1.41", 1.405, 1.415, "m/s^2", _LATERAL),
    ("lateral", DAMPER): Published("0.42", 0.415, 0.425, "m/s^2", _LATERAL),
    ("lateral", BODY): Published("0.024", 0.0235, 0.0245, "m/s^2", _LATERAL),
    ("vertical", PATCH): Published("0.18", 0.175, 0.185, "m/s^2", _VERTICAL),
    ("vertical", DAMPER): Published("0.061", 0.0605, 0.0615, "m/s^2", _VERTICAL),
    ("vertical", BODY): Published("0.0005", 0.00045, 0.00055, "m/s^2", _VERTICAL),
}
"""Largest change of lateral or vertical acceleration, peak to peak, for 25 % less or more of a parameter."""

DOMINANCE = Published("more than 10", 10.0, math.inf, "1", "section 3.3")
"""Effect of the contact patch, and of the damper, over that of the body stiffness: an order of magnitude."""

INCREASES, DECREASES, HARDLY_CHANGES = "increases", "decreases", "hardly changes"

TRENDS: Mapping[tuple[str, str, str], str] = {
    ("lateral", "front", "lateral_acceleration"): INCREASES,
    ("lateral", "front", "yaw_rate"): INCREASES,
    ("lateral", "front", "roll_rate"): INCREASES,
    ("lateral", "rear", "lateral_acceleration"): INCREASES,
    ("lateral", "rear", "yaw_rate"): INCREASES,
    ("lateral", "rear", "roll_rate"): HARDLY_CHANGES,
    ("lateral", "both", "lateral_acceleration"): INCREASES,
    ("lateral", "both", "yaw_rate"): INCREASES,
    ("lateral", "both", "roll_rate"): INCREASES,
    ("vertical", "front", "vertical_acceleration"): DECREASES,
    ("vertical", "front", "pitch_rate"): DECREASES,
    ("vertical", "front", "roll_rate"): DECREASES,
    ("vertical", "rear", "vertical_acceleration"): DECREASES,
    ("vertical", "rear", "pitch_rate"): INCREASES,
    ("vertical", "rear", "roll_rate"): INCREASES,
    ("vertical", "both", "vertical_acceleration"): DECREASES,
    ("vertical", "both", "pitch_rate"): HARDLY_CHANGES,
    ("vertical", "both", "roll_rate"): DECREASES,
}
"""What a metric does where the stiffness at a place falls towards half. Sections 3.1 and 3.2."""
