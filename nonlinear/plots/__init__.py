"""Drawings of measurements, orbits and branches; they take and return matplotlib axes."""

from chassym.nonlinear.plots.measurements import (
    mark_frequencies,
    mark_nominal,
    plot_changes,
    plot_force_over_travel,
    plot_linear_response,
    plot_stepped_sine,
    plot_sweep,
    plot_waveform,
    readable_unit,
)
from chassym.nonlinear.plots.orbits import (
    plot_branch,
    plot_harmonics,
    plot_multipliers,
    plot_orbit,
    plot_steps,
    shown_unit,
)

__all__ = [
    "mark_frequencies",
    "mark_nominal",
    "plot_branch",
    "plot_changes",
    "plot_force_over_travel",
    "plot_harmonics",
    "plot_linear_response",
    "plot_multipliers",
    "plot_orbit",
    "plot_steps",
    "plot_stepped_sine",
    "plot_sweep",
    "plot_waveform",
    "readable_unit",
    "shown_unit",
]
