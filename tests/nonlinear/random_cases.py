"""Random vehicles in random harmonic tests."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from chassym.derivation import Model
from chassym.nonlinear import Harmonic

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
OTHERS = {"quarter_car": ("road",), "half_car": ("front_road", "rear_road")}


@dataclass(frozen=True, eq=False)
class RandomCase:
    """A vehicle, what moves it, and how accurately it is asked for."""

    model: Model
    excitation: Harmonic
    tolerance: float


def random_cases(models: Mapping[str, Model], count: int, seed: int) -> Iterator[RandomCase]:
    """Every number but moments of inertia and tables by a factor of its own, 0.75 to 1.25.

    Seven of ten are sedans, whose pads move along z or y; the others quarter and half cars. Amplitudes and
    phases differ from pad to pad; the fastest pad moves at 0.02 to 0.8 m/s, 0.5 to 15 Hz, and tolerances are
    1e-3 to 1e-6.
    """
    generator = np.random.default_rng(seed)
    for _ in range(count):
        name = generator.choice(["sedan", "quarter_car", "half_car"], p=[0.7, 0.15, 0.15])
        axis = "z" if generator.random() < 0.7 else "y"
        inputs = OTHERS.get(name) or [f"{corner}_pad_{axis}" for corner in CORNERS]
        yield RandomCase(
            _varied(models[name], generator),
            _random_excitation(inputs, generator),
            float(np.exp(generator.uniform(np.log(1e-6), np.log(1e-3)))),
        )


def _varied(model: Model, generator: np.random.Generator) -> Model:
    changes = {}
    for name, parameter in model.parameters.items():
        if ".inertia." not in name and not name.endswith(("velocity", "force")):
            changes[name] = float(parameter.value) * generator.uniform(0.75, 1.25)
    return model.with_parameters(changes)


def _random_excitation(inputs: list[str], generator: np.random.Generator) -> Harmonic:
    frequency_hz, velocity = np.exp(generator.uniform(np.log([0.5, 0.02]), np.log([15.0, 0.8])))
    largest = velocity / (2 * np.pi * frequency_hz)
    amplitudes = {
        name: largest * generator.uniform(0.3, 1) * np.exp(2j * np.pi * generator.random()) for name in inputs
    }
    return Harmonic(float(frequency_hz), amplitudes)
