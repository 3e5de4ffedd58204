"""Variants of a model with other parameters."""

import numpy as np

from chassym.derivation import Model


def scaled_at_random(model: Model, seed: int) -> Model:
    """Multiply every parameter by a factor of its own, 0.7 to 1.4; one for all moments of a body."""
    generator = np.random.default_rng(seed)
    factors: dict[str, float] = {}
    changes: dict[str, list[float] | float] = {}
    for name, parameter in model.parameters.items():
        group = name.rsplit(".", 1)[0] if ".inertia." in name else name
        value = np.multiply(parameter.value, factors.setdefault(group, generator.uniform(0.7, 1.4)))
        changes[name] = value.tolist()
    return model.with_parameters(changes)
