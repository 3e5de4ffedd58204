"""A stepped sine as labelled arrays."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray

from chassym.nonlinear.continuation.stepped_sine import DOWNWARD, UPWARD, SteppedResponse
from chassym.nonlinear.steady.result import SteadyState

Array = np.ndarray


def labelled(test: SteppedResponse) -> xarray.Dataset:
    """Metrics, errors and smallest patch force over direction and the path's parameter, and jumps.

    NaN stands where there is no steady state; `reason` says why.
    """
    dimensions = ("direction", test.path.name)
    runs = (test.upward, test.downward)

    def table(read: Callable[[SteadyState], float]) -> Array:
        return np.array([[np.nan if s is None else read(s) for s in run.states] for run in runs])

    def metric(name: str) -> tuple[Array, Array]:
        return table(lambda s: s.peak_to_peak[name].value), table(lambda s: s.peak_to_peak[name].error)

    first = next((s for run in runs for s in run.states if s is not None), None)
    data: dict[str, tuple[object, Array, dict[str, str]]] = {}
    for name, known in ({} if first is None else first.peak_to_peak).items():
        values, errors = metric(name)
        data[name] = (dimensions, values, {"units": known.unit, "long_name": f"peak-to-peak {name}"})
        data[f"{name}_error"] = (dimensions, errors, {"units": known.unit})
    if first is not None and first.contact is not None:
        forces = table(lambda s: np.nan if s.contact is None else s.contact.value)
        data["minimum_patch_force"] = (dimensions, forces, {"units": "N"})
    data["reason"] = (dimensions, np.array([run.reasons for run in runs]), {})
    return xarray.Dataset(
        {**data, **_jumps(test)},
        coords={
            "direction": [UPWARD, DOWNWARD],
            test.path.name: (test.path.name, test.values, {"units": test.path.unit}),
            "coexisting": (test.path.name, np.isin(test.values, test.coexisting)),
        },
    )


def _jumps(test: SteppedResponse) -> dict[str, tuple[str, Array, dict[str, str]]]:
    """Where from and where to each jump leads, over `jump`."""
    text = {
        "jump_direction": "direction",
        "jump_cause": "cause",
        "jump_output": "output",
        "jump_unit": "unit",
    }
    numbers = {"jump_value": "value", "jump_to_value": "to_value"}
    heights = {"jump_from_amplitude": "from_amplitude", "jump_to_amplitude": "to_amplitude"}

    def column(field: str, kind: type) -> Array:
        return np.array([getattr(jump, field) for jump in test.jumps], dtype=kind)

    found: dict[str, tuple[str, Array, dict[str, str]]] = {}
    found |= {name: ("jump", column(field, str), {}) for name, field in text.items()}
    found |= {name: ("jump", column(field, float), {}) for name, field in heights.items()}
    units = {"units": test.path.unit}
    return found | {name: ("jump", column(field, float), units) for name, field in numbers.items()}
