"""Pictures that join the linear and the nonlinear stage, drawn on axes that are handed in."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from chassym.finite_amplitudes import AmplitudeResponse
from chassym.linear.frequency_response import continuous_phase_degrees
from chassym.linear.plots.frequency import PHASE_STEPS
from chassym.linear.plots.style import GRADUAL, finish, over_frequency, readable_unit, words
from chassym.linear.singular_values import unit_ratio

Array = np.ndarray

_LIGHTEST = 0.85
"""End of the colours: lighter ones are hard to see on white."""

_EQUIVALENT, _PULLED = "describing function", "a tyre would have to pull"


def plot_amplitude_response(axes_pair: tuple[Axes, Axes], found: AmplitudeResponse) -> tuple[Axes, Axes]:
    """Draw the Bode plot of a motion at several amplitudes: nonlinear, and by describing functions.

    Dots are first harmonics of nonlinear steady states, hollow where a tyre would have to pull; dashed lines
    of the same colour are the linear models with the describing functions of these motions. Curves of
    `chassym.linear.plots.plot_bode` may be on the same axes.

    Parameters
    ----------
    axes_pair
        Where to draw the amplitude and the phase: ``figure.subplots(2, 1, sharex=True)``.

    Returns
    -------
    tuple of Axes
        The pair.
    """
    above, below = axes_pair
    unit = readable_unit(unit_ratio(found.output_unit, found.input_unit))
    colors = GRADUAL(np.linspace(0, _LIGHTEST, len(found.amplitudes)))
    rows = zip(found.amplitudes, found.nonlinear, found.equivalent, found.smallest_patch_force, strict=True)
    for color, (amplitude, nonlinear, equivalent, force) in zip(colors, rows, strict=True):
        above.plot(found.frequencies_hz, np.abs(equivalent), "--", color=color)
        label = _size(float(amplitude), found.input_unit)
        _dots(above, found.frequencies_hz, np.abs(nonlinear), force, color, label)
        below.plot(found.frequencies_hz, _phase(equivalent), "--", color=color)
        _dots(below, found.frequencies_hz, _phase(nonlinear), force, color, label)
    above.set_yscale("log")
    above.set_ylabel(f"amplitude per unit of {words(found.motion)}\n({unit})")
    below.set_ylabel(f"phase against {words(found.motion)}\n(degrees)")
    step = next((step for step in PHASE_STEPS if below.dataLim.height < 7 * step), PHASE_STEPS[-1])
    below.yaxis.set_major_locator(MultipleLocator(step))
    for axes in axes_pair:
        over_frequency(axes)
        finish(axes, "")
    above.set_xlabel("")
    above.set_title(words(found.output), loc="left", fontsize="medium")
    _legend(above, bool(np.any(found.smallest_patch_force < 0)))
    return above, below


def _dots(axes: Axes, frequencies_hz: Array, values: Array, force: Array, color: Array, label: str) -> None:
    """Dots, hollow where the patch force is negative."""
    for chosen, filled, said in ((~(force < 0), color, label), (force < 0, "white", None)):
        axes.plot(
            frequencies_hz[chosen],
            values[chosen],
            "o",
            markersize=4.5,
            color=color,
            markerfacecolor=filled,
            label=said,
        )


def _legend(axes: Axes, is_pulled: bool) -> None:
    """The amplitudes, and what dashes and hollow dots mean."""
    axes.plot([], [], "--", color="0.4", label=_EQUIVALENT)
    if is_pulled:
        axes.plot([], [], "o", color="0.4", markersize=4.5, markerfacecolor="white", label=_PULLED)
    axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))


def _phase(response: Array) -> Array:
    """Continuous phase (degrees) of what is known, shape (frequencies,)."""
    known = np.isfinite(response)
    phase = np.full(len(response), np.nan)
    if known.any():
        phase[known] = continuous_phase_degrees(response[known])
    return phase


def _size(amplitude: float, unit: str) -> str:
    """An amplitude in the legend: lengths in millimetres."""
    return f"{1e3 * amplitude:g} mm" if unit == "m" else f"{amplitude:g} {readable_unit(unit)}"
