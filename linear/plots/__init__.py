"""Pictures of linear analysis, drawn on axes that are handed in and returned."""

from chassym.linear.plots.amplitude_scale import DECIBEL, LOGARITHMIC, AmplitudeScale
from chassym.linear.plots.eigenvalues import plot_poles, plot_root_locus
from chassym.linear.plots.frequency import (
    plot_bode,
    plot_frequency_response,
    plot_phase,
    plot_singular_values,
    plot_spectrum,
    save_bode,
)
from chassym.linear.plots.modes import plot_modes, plot_tracked_modes
from chassym.linear.plots.nyquist import plot_nyquist
from chassym.linear.plots.tornado import plot_tornado

__all__ = [
    "DECIBEL",
    "LOGARITHMIC",
    "AmplitudeScale",
    "plot_bode",
    "plot_frequency_response",
    "plot_modes",
    "plot_nyquist",
    "plot_phase",
    "plot_poles",
    "plot_root_locus",
    "plot_singular_values",
    "plot_spectrum",
    "plot_tornado",
    "plot_tracked_modes",
    "save_bode",
]
