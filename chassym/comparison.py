"""The thesis beside what was computed: every statement with its deviation and a verdict in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from chassym import thesis
from chassym.heave import HeaveTest
from chassym.nonlinear import Metric
from chassym.rig_tests import Outcome, TestRecord
from chassym.thesis import Published
from chassym.variants import Scaled, Stiffened, sweep_curves
from chassym.wheel_rate import WheelRate

NEGLIGIBLE = 1e-3
"""A metric that changes by less than this part of its nominal value hardly changes."""

UNDECIDED = "undecided"
NOT_SOLVED = "not solved"

STATED_GROUPS: Mapping[str, str] = {
    "contact patch stiffness": thesis.PATCH,
    "contact patch stiffness and damping": thesis.PATCH,
    "damper": thesis.DAMPER,
    "body stiffness": thesis.BODY,
}
"""Groups of parameters by the word the thesis has for them."""


@dataclass(frozen=True)
class Comparison:
    """One statement of the thesis beside the computed value.

    Attributes
    ----------
    topic
        What part of the thesis it belongs to.
    quantity
        What is compared.
    unit
        Of the numbers.
    published
        The statement as published.
    low, high
        Its range; nan where it is words.
    computed, error
        The computed value and the estimate of its error; nan if it could not be computed.
    deviation
        Of the computed value from the nearest end of the range, relative to the end; 0 inside, nan for words.
    verdict
        In words.
    source
        Where in the thesis.
    """

    topic: str
    quantity: str
    unit: str
    published: str
    low: float
    high: float
    computed: float
    error: float
    deviation: float
    verdict: str
    source: str


def compare(
    topic: str, quantity: str, published: Published, computed: float, error: float = 0.0
) -> Comparison:
    """A number beside a published range.

    Examples
    --------
    >>> from chassym.thesis import nominal_range
    >>> compare("tests", "ay", nominal_range("lateral", "lateral_acceleration"), 5.7).verdict
    'outside by 8.06 % (below)'
    """
    deviation = _deviation(published, computed)
    return Comparison(
        topic,
        quantity,
        published.unit,
        published.text,
        published.low,
        published.high,
        computed,
        error,
        deviation,
        _verdict(published, computed, error, deviation),
        published.source,
    )


def _deviation(published: Published, computed: float) -> float:
    if published.low <= computed <= published.high:
        return 0.0
    end = published.low if computed < published.low else published.high
    return (computed - end) / end if end else math.copysign(math.inf, computed - end)


def _verdict(published: Published, computed: float, error: float, deviation: float) -> str:
    if math.isnan(computed):
        return NOT_SOLVED
    if deviation == 0:
        return "inside"
    if published.low - error <= computed <= published.high + error:
        return "inside within the error"
    percent, side = 100 * abs(deviation), "below" if deviation < 0 else "above"
    return f"outside by {percent:{'.3g' if percent < 1000 else '.0f'}} % ({side})"


def direction(changed: Metric, nominal: Metric) -> str:
    """Whether a metric increases, decreases or hardly changes; undecided if its error exceeds the change."""
    if abs(changed.value) <= changed.error:
        return UNDECIDED
    if abs(changed.value) < NEGLIGIBLE * nominal.value:
        return thesis.HARDLY_CHANGES
    return thesis.INCREASES if changed.value > 0 else thesis.DECREASES


def words(name: str) -> str:
    """A name of the program as text."""
    return name.replace("_", " ")


def verification(
    torsion_hz: Sequence[float], wheel_rates: Mapping[str, WheelRate], heave: HeaveTest
) -> Iterator[Comparison]:
    """Section 2: free torsion, wheel rates by how the test was loaded, peaks in heave."""
    topic = "verification"
    yield compare(topic, "first torsional mode of the body alone", thesis.FREE_TORSION, torsion_hz[1])
    for loading, rate in wheel_rates.items():
        yield compare(
            topic, f"front wheel rate, {loading}", thesis.WHEEL_RATE, 1e-3 * rate.slope, 1e-3 * rate.error
        )
    resolution = 0.5 * _step(heave)
    yield compare(topic, "heave: peak of the body", thesis.BODY_PEAK, heave.peak_hz("body"), resolution)
    for wheel in ("front wheel", "rear wheel"):
        yield compare(
            topic, f"heave: peak of the {wheel}", thesis.WHEEL_PEAK, heave.peak_hz(wheel), resolution
        )


def _step(heave: HeaveTest) -> float:
    """The largest step between frequencies (Hz)."""
    frequencies = [point.frequency_hz for point in heave.points]
    return max((b - a for a, b in zip(frequencies, frequencies[1:], strict=False)), default=0.0)


def nominal(tests: Mapping[str, TestRecord]) -> Iterator[Comparison]:
    """Section 3: the nominal values of both tests."""
    for name, record in tests.items():
        for metric in record.test.metrics:
            value = record.metrics[metric]
            quantity = f"{name} test: {words(metric)}, peak to peak"
            yield compare(
                "nominal tests", quantity, thesis.nominal_range(name, metric), value.value, value.error
            )


def sensitivities(tests: Mapping[str, TestRecord], scaled: Sequence[Scaled]) -> Iterator[Comparison]:
    """Section 3.3: the largest change of each acceleration by every group, and how the groups compare."""
    for name in tests:
        largest = {group: largest_change(tests, scaled, name, group) for group in STATED_GROUPS}
        for group, found in largest.items():
            published = thesis.LARGEST_CHANGES[name, STATED_GROUPS[group]]
            quantity = f"{name} test: largest change of acceleration, {group}"
            yield compare("sensitivity", quantity, published, found.value, found.error)
        body = largest["body stiffness"]
        for group in (group for group in largest if group != "body stiffness"):
            ratio, error = _ratio(largest[group], body)
            quantity = f"{name} test: effect of {group} over that of body stiffness"
            yield compare("sensitivity", quantity, thesis.DOMINANCE, ratio, error)


def largest_change(
    tests: Mapping[str, TestRecord], scaled: Iterable[Scaled], test: str, group: str
) -> Metric:
    """The largest change of a test's acceleration, as a size; nan if one of the group's solutions failed."""
    record = tests[test]
    acceleration = record.test.metrics[0]
    chosen = [each.outcome for each in scaled if (each.outcome.test, each.group) == (test, group)]
    if not chosen or any(found.reason for found in chosen):
        return Metric(math.nan, record.metrics[acceleration].unit, math.nan)
    largest = max((found.changes[acceleration] for found in chosen), key=lambda each: abs(each.value))
    return Metric(abs(largest.value), largest.unit, largest.error)


def _ratio(large: Metric, small: Metric) -> tuple[float, float]:
    """The ratio of two sizes, and its error."""
    if not small.value:
        return math.nan, math.nan
    ratio = large.value / small.value
    return ratio, (large.error + ratio * small.error) / small.value


def trends(tests: Mapping[str, TestRecord], halved: Iterable[Stiffened]) -> Iterator[Comparison]:
    """Sections 3.1 and 3.2: what half the body stiffness does to every metric, in percent."""
    for each in halved:
        record = tests[each.outcome.test]
        for metric in record.test.metrics:
            yield _trend(each.placement, each.outcome, metric, record.metrics[metric])


def _trend(placement: str, found: Outcome, metric: str, nominal_metric: Metric) -> Comparison:
    stated = thesis.TRENDS[found.test, placement, metric]
    percent = error = math.nan
    if found.reason:
        verdict = NOT_SOLVED
    else:
        changed = found.changes[metric]
        if nominal_metric.value > 0:
            percent, error = (100 * each / nominal_metric.value for each in (changed.value, changed.error))
        computed = direction(changed, nominal_metric)
        agreement = "agrees: " if computed == stated else "differs: "
        verdict = computed if computed == UNDECIDED else agreement + computed
    return Comparison(
        topic="trend",
        quantity=f"{found.test} test, half the {_where(placement)} body stiffness: {words(metric)}",
        unit="%",
        published=stated,
        low=math.nan,
        high=math.nan,
        computed=percent,
        error=error,
        deviation=math.nan,
        verdict=verdict,
        source="section 3.1" if found.test == "lateral" else "section 3.2",
    )


def sweep_spans(sweep: Sequence[Stiffened]) -> Iterator[Comparison]:
    """Figures 11 to 16: smallest and largest value over a stiffness sweep beside the axis of the figure."""
    curves = sweep_curves(sweep)
    for drawn in thesis.FIGURE_AXES:
        points = curves.get((drawn.test, drawn.placement), [])
        solved = [point.outcome.metrics[drawn.metric] for point in points if not point.outcome.reason]
        for which, choose in (("smallest", min), ("largest", max)):
            end = choose(
                solved, key=lambda metric: metric.value, default=Metric(math.nan, drawn.axis.unit, math.nan)
            )
            quantity = (
                f"{drawn.test} test, {_where(drawn.placement)} stiffness sweep: {which} {words(drawn.metric)}"
            )
            yield compare("sweep span", quantity, drawn.axis, end.value, end.error)


def _where(placement: str) -> str:
    return "front and rear" if placement == "both" else placement
