"""The variants that the reference thesis looks at, and those of every group of parameters, as sweeps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear.sweep.sampling import Points, grid, joined, one_at_a_time, parameter_groups
from chassym.nonlinear.sweep.sweep import Sweep
from chassym.rig_tests import TESTS
from chassym.variants import GROUPS, PLACES

STIFFNESSES = tuple(float(stiffness) for stiffness in np.logspace(2, 9, 29))
"""Body torsional stiffnesses (N m/rad). Source: Liu 2016, figures 11 to 16."""

CHANGE = 0.25
"""Of a group of parameters, relative. Source: Liu 2016, section 3.3."""


def thesis_grid(
    model: Model, stiffnesses: Sequence[float] = STIFFNESSES, tolerance: float = 1e-3
) -> dict[str, Sweep]:
    """The sweeps of the lateral and of the vertical test, by its name.

    Their points are the nominal car and every group of parameters 25 % less and more, labelled ``varied`` and
    ``factor``; and the body's torsional stiffness at the front, at the rear and at both, labelled ``varied``
    and ``stiffness``.
    """
    points = _points(model, stiffnesses)
    return {
        name: Sweep(model, test.excitation, points, metrics=test.metrics, tolerance=tolerance)
        for name, test in TESTS.items()
    }


def _points(model: Model, stiffnesses: Sequence[float]) -> Points:
    groups = {name: (name,) for name in parameter_groups(model)} | dict(GROUPS)
    swept = [
        grid(model, {"+".join(names): stiffnesses})
        .renamed("+".join(names), "stiffness")
        .labelled("varied", f"{place} body stiffness")
        for place, names in PLACES.items()
    ]
    return joined([one_at_a_time(model, CHANGE, groups), *swept])
