"""What an error of a metric is compared with."""

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.nonlinear.orbits.metrics import ROUNDING, Reader


def test_a_metric_counts_for_at_least_a_thousandth_of_the_largest_of_its_unit(quarter_car: Model) -> None:
    reader = Reader(
        quarter_car, ["body_displacement", "wheel_displacement", "wheel_travel", "vertical_acceleration"]
    )
    assert reader.names[4:] == ["patch_force_z"]
    found = reader.scale(np.array([5.0, 1e-9, 2.0, 1e-9, 1.0]))
    weight = quarter_car.outputs(np.zeros((quarter_car.argument_count, 1)))[-1, 0]
    assert found == pytest.approx([5.0, 5e-3, 2.0, 1e-9, weight])


def test_nothing_is_compared_with_less_than_rounding(quarter_car: Model) -> None:
    reader = Reader(quarter_car, ["body_displacement"])
    assert reader.scale(np.array([0.0, 0.0]))[0] == ROUNDING
