"""The built-in vehicles and the models that vehicle files may name."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from chassym.derivation.compilation.numeric import CompiledEquations
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.model import Model
from chassym.derivation.parameters import Parameters, load_parameters
from chassym.derivation.quantity import shown
from chassym.derivation.schema import ParameterError, Schema
from chassym.derivation.vehicles import (
    full_car,
    half_car,
    half_car_roll,
    quarter_car,
    ride_model,
    rigid_car,
    torsion_chain,
)


@dataclass(frozen=True)
class ModelKind:
    """What a vehicle file's ``model`` stands for: the parameters it takes and the mechanism they make."""

    schema: Schema
    build: Callable[[Parameters], Mechanism]


KINDS: Mapping[str, ModelKind] = {
    "full_car": ModelKind(full_car.SCHEMA, full_car.full_car),
    "half_car": ModelKind(half_car.SCHEMA, half_car.half_car),
    "half_car_roll": ModelKind(half_car_roll.SCHEMA, half_car_roll.half_car_roll),
    "quarter_car": ModelKind(quarter_car.SCHEMA, quarter_car.quarter_car),
    "ride_model": ModelKind(ride_model.SCHEMA, ride_model.ride_model),
    "rigid_car": ModelKind(rigid_car.SCHEMA, rigid_car.rigid_car),
    "torsion_chain": ModelKind(torsion_chain.SCHEMA, torsion_chain.torsion_chain),
}


def vehicle_names() -> list[str]:
    """Names of the built-in vehicles."""
    folder = resources.files("chassym.derivation.vehicles")
    return sorted(file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml"))


def load_model(
    vehicle: str | Path = "sedan",
    changes: Mapping[str, float | Sequence[float] | str] | None = None,
    *,
    origin: str = "override",
    sections: int | None = None,
) -> Model:
    """A model from a built-in vehicle's name or a TOML file, with some parameters changed.

    Parameters
    ----------
    vehicle
        Name of a built-in vehicle, or path of a file.
    changes
        New values by name, numbers in SI or text with a unit; see `Parameters.replace`.
    origin
        Where the changes come from: begins error messages and becomes the source of the new values.
    sections
        Number of body sections of a ``full_car``, three or more; three unless given. See `full_car`.

    Raises
    ------
    ParameterError
        If there is no such vehicle, or its parameters, the changes or the sections are not acceptable.

    Examples
    --------
    >>> car = load_model("quarter_car", {"sprung.mass": "400 kg"})
    >>> [coordinate.name for coordinate in car.system.coordinates]
    ['body_bounce', 'wheel_bounce']
    >>> load_model("sedan", sections=12).size
    21
    """
    parameters = load_parameters(_source(vehicle), *(kind.schema for kind in KINDS.values()))
    if changes:
        parameters = parameters.replace(changes, origin=origin)
    return Model(parameters, CompiledEquations(_mechanism(parameters, sections)))


def _mechanism(parameters: Parameters, sections: int | None) -> Mechanism:
    model = parameters.schema.model
    if sections is None:
        return KINDS[model].build(parameters)
    if model != full_car.SCHEMA.model:
        raise ParameterError(
            f"sections: received {shown(sections)} for a vehicle of model {model!r}, expected one of model "
            f"{full_car.SCHEMA.model!r}"
        )
    return full_car.full_car(parameters, sections)


def _source(vehicle: str | Path) -> Path | resources.abc.Traversable:
    if str(vehicle) in vehicle_names():
        return resources.files("chassym.derivation.vehicles") / f"{vehicle}.toml"
    if not os.path.isfile(vehicle):  # unlike Path.is_file it answers for names too long for a file, too
        raise ParameterError(
            f"vehicle {shown(str(vehicle))} is neither a file nor a built-in vehicle; "
            f"built in are {', '.join(vehicle_names())}"
        )
    return Path(vehicle)
