"""What is read off an orbit in pieces."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear import Harmonic
from chassym.nonlinear.orbits.gauss_points import gauss_points
from chassym.nonlinear.orbits.piecewise_orbit import PiecewiseOrbit

PIECES, POINTS = 12, 10


def test_of_peaks_too_alike_to_tell_at_places_the_higher_is_found(quarter_car: Model) -> None:
    """The wheel moves as cos 2x - c cos x, at x = pi higher by 2 c than at 0, where a place is at the top."""
    higher, excitation = 1e-5, Harmonic(1.0, {})
    boundaries = 2 * np.pi * (np.arange(PIECES + 1) - 0.5) / PIECES
    boundaries[4:9] += np.pi / PIECES / 32  # places are then half their spacing from pi, but met 0
    phases = boundaries[:-1, None] + np.diff(boundaries)[:, None] * gauss_points(POINTS).places.values
    starts, accelerations = np.zeros((PIECES, 4)), np.zeros((PIECES, POINTS, 2))
    pace, from_ = excitation.angular_frequency, boundaries[:-1]
    starts[:, 1] = np.cos(2 * from_) - higher * np.cos(from_)
    starts[:, 3] = pace * (-2 * np.sin(2 * from_) + higher * np.sin(from_))
    accelerations[:, :, 1] = pace**2 * (-4 * np.cos(2 * phases) + higher * np.cos(phases))
    orbit = PiecewiseOrbit(quarter_car, excitation, boundaries, starts, accelerations)
    _, [highest] = orbit.extremes([quarter_car.output_names.index("wheel_displacement")])
    assert highest == pytest.approx(1 + higher, abs=1e-9)
