"""The tornado chart: which parameters matter to a metric."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from chassym.linear.plots.style import COLORS, finish, with_unit, words
from chassym.linear.variation.tornado import Tornado


def plot_tornado(axes: Axes, found: Tornado) -> Axes:
    """Draw the change of a metric with each group of parameters as two bars, the first group on top.

    Diamonds show what the exact derivative at the nominal values predicts for the same changes.

    Parameters
    ----------
    axes
        Where to draw; the legend stands to the right of it.
    found
        From `tornado`, which puts the largest change first.
    """
    rows = np.arange(len(found.bars))
    percent = f"{100 * found.change:g} %"
    less, more = (
        axes.barh(rows + side, changes, 0.4, color=COLORS[color], label=f"{sign}{percent}")
        for side, color, sign, changes in (
            (-0.2, 4, "−", [bar.at_less for bar in found.bars]),
            (0.2, 1, "+", [bar.at_more for bar in found.bars]),
        )
    )
    predicted = [change for bar in found.bars for change in (bar.predicted_at_less, bar.predicted_at_more)]
    heights = np.repeat(rows, 2) + np.tile([-0.2, 0.2], len(rows))
    (diamonds,) = axes.plot(predicted, heights, "D", color="black", markersize=4, label="by the derivative")
    diamonds.set_markerfacecolor("white")
    axes.set_yticks(rows, [words(bar.label) for bar in found.bars])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.axvline(0, color="0.3", linewidth=0.8)
    axes.set_xlabel(with_unit(f"change of {found.metric}", found.unit))
    finish(axes, "")
    axes.grid(visible=False, axis="y")
    axes.legend(
        handles=[less, more, diamonds],
        loc="upper left",
        bbox_to_anchor=(1.01, 1),
        frameon=False,
        borderaxespad=0,
    )
    return axes
