"""What a change of each parameter does to a metric: finite changes beside the exact derivative."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from chassym.derivation import Model
from chassym.linear.linear_model import LinearModel
from chassym.linear.linearisation import linearise
from chassym.linear.slope_rule import SlopeRules, mean_slope
from chassym.linear.variation.metrics import Metric
from chassym.linear.variation.sensitivity import sensitivity


@dataclass(frozen=True)
class Bar:
    """Change of a metric with one group of parameters.

    Attributes
    ----------
    label
        What is changed.
    at_less, at_more
        Change of the metric when the parameters are less, and more, by the relative change.
    predicted_at_less, predicted_at_more
        The same by the exact derivative.
    """

    label: str
    at_less: float
    at_more: float
    predicted_at_less: float
    predicted_at_more: float

    @property
    def size(self) -> float:
        """The larger one of both changes."""
        return max(abs(self.at_less), abs(self.at_more))


@dataclass(frozen=True)
class Tornado:
    """Changes of a metric, the largest first.

    Attributes
    ----------
    metric
        Its name.
    unit
        Its unit.
    nominal
        Its value without a change.
    change
        Relative change of the parameters.
    bars
        One for every group of parameters.
    """

    metric: str
    unit: str
    nominal: float
    change: float
    bars: tuple[Bar, ...]


def tornado(
    model: Model,
    metric: Metric,
    parameters: Sequence[str] | Mapping[str, Sequence[str]],
    change: float = 0.25,
    slope_rule: SlopeRules = mean_slope,
) -> Tornado:
    """Change parameters up and down, one group at a time.

    Parameters
    ----------
    model
        The model.
    metric
        What is looked at.
    parameters
        Names, or prefixes of names, each changed alone; or groups of them by label, changed together.
    change
        Relative change: 0.25 takes every parameter to 75 and 125 %.
    slope_rule
        As for `linearise`.

    Raises
    ------
    ParameterError
        If a name is unknown, or a changed value impossible.
    LinearisationError
        If a variant has no linear model or no such metric.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear.variation.metrics import NaturalFrequency
    >>> car = load_model("quarter_car")
    >>> found = tornado(car, NaturalFrequency("bounce"), ["spring", "tyre", "sprung"])
    >>> [bar.label for bar in found.bars]
    ['sprung', 'spring', 'tyre']
    """
    if isinstance(parameters, str) or (
        isinstance(parameters, Mapping) and any(isinstance(names, str) for names in parameters.values())
    ):
        raise TypeError(f"parameters: {parameters!r} received; sequences of names are needed")
    groups = parameters if isinstance(parameters, Mapping) else {name: [name] for name in parameters}
    exact = sensitivity(model, None, slope_rule)
    by_logarithm = dict(zip(exact.parameters, metric.derivative(exact) * exact.values * change, strict=True))
    nominal = metric.of(exact.linear)
    bars = []
    for label, names in groups.items():

        def linear_at(factor: float, names: Sequence[str] = names) -> LinearModel:
            return linearise(model.scaled(*names, factor=factor), slope_rule)

        less, more = (metric.followed(linear_at, factor) - nominal for factor in (1 - change, 1 + change))
        predicted = float(sum(value for name, value in by_logarithm.items() if _is_among(name, names)))
        bars.append(Bar(label, less, more, -predicted, predicted))
    bars.sort(key=lambda bar: bar.size, reverse=True)
    return Tornado(metric.name, metric.unit(exact.linear), nominal, change, tuple(bars))


def _is_among(number: str, names: Sequence[str]) -> bool:
    """Whether a number belongs to one of the parameters, or to a group below one of the prefixes."""
    return any(f"{number.partition('[')[0]}.".startswith(f"{name}.") for name in names)
