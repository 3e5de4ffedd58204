"""Run times of linear analysis beside what a user would use otherwise, measured in one run."""

import time

import control
import numpy as np
import pytest
import threadpoolctl

from chassym.derivation import Model, load_model, variants
from chassym.linear import linearise
from chassym.linear.variation.sweep import DampedModes, Matrices, Quantity, Response, sweep

pytestmark = pytest.mark.benchmark

COUNT = 10_000
PADS = dict.fromkeys([f"{a}_{s}_pad_z" for a in ("front", "rear") for s in ("left", "right")], 1.0)


def random_changes(model: Model, count: int) -> dict[str, np.ndarray]:
    """Give every number but moments of inertia and damper tables a factor of its own, 0.75 to 1.25."""
    generator = np.random.default_rng(1)
    return {
        name: np.multiply(parameter.value, generator.uniform(0.75, 1.25, count))
        for name, parameter in model.parameters.items()
        if ".inertia." not in name and not name.endswith(("velocity", "force"))
    }


def numerically_linearised(model: Model) -> control.StateSpace:
    """Linearise the compiled model by python-control's differences, with pads and their rates as inputs."""
    n, p = model.size, len(model.system.inputs)
    accelerations, outputs = model.accelerations.single(), model.outputs.single()

    def arguments(state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        return np.concatenate([state, np.zeros(n), inputs])

    def update(t: float, state: np.ndarray, inputs: np.ndarray, params: dict) -> np.ndarray:
        return np.concatenate([state[n:], accelerations(arguments(state, inputs))])

    def measure(t: float, state: np.ndarray, inputs: np.ndarray, params: dict) -> np.ndarray:
        given = arguments(state, inputs)
        given[2 * n : 3 * n] = accelerations(given)
        return outputs(given)

    system = control.nlsys(
        update, measure, inputs=2 * p, states=2 * n, outputs=len(model.system.outputs), name="numerical"
    )
    return control.linearize(system, np.zeros(2 * n), np.zeros(2 * p))


def test_ten_thousand_variants_of_the_reference_car() -> None:
    """One core: a run to warm up, then the best of ten, as other users of the machine come and go."""
    model = load_model("sedan")
    changes = random_changes(model, COUNT)
    response = Response("vertical_acceleration", PADS, np.geomspace(0.1, 30, 200))
    asked: dict[str, list[Quantity]] = {
        "matrices": [Matrices()],
        "and all damped modes": [Matrices(), DampedModes()],
        "and a response of 200 points": [Matrices(), DampedModes(), response],
    }
    microseconds = {}
    with threadpoolctl.threadpool_limits(1):
        for name, quantities in asked.items():
            times = []
            for _ in range(11):
                start = time.perf_counter()
                found = sweep(model, changes, quantities)
                times.append(time.perf_counter() - start)
            microseconds[name] = min(times[1:]) / COUNT * 1e6
            print(f"\n{name}: {microseconds[name]:.1f} us a variant, {found.nbytes / 1e6:.0f} MB")
        some = [variants(model, changes).one(index) for index in range(20)]
        start = time.perf_counter()
        for each in some:
            numerically_linearised(each)
        own = (time.perf_counter() - start) / len(some) * 1e6
        start = time.perf_counter()
        for each in some:
            linearise(each)
        single = (time.perf_counter() - start) / len(some) * 1e6
    ratio = own / microseconds["matrices"]
    print(f"linearise, one at a time: {single:.0f} us")
    print(f"python-control's linearize of the compiled model: {own:.0f} us, {ratio:.0f} times the matrices")
    assert found.response_error.max() < 1e-9
    assert own > microseconds["matrices"]
