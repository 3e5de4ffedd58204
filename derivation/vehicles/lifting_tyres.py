"""Tyres that can leave the ground."""

from __future__ import annotations

from dataclasses import replace

from chassym.derivation.characteristic import Unilateral
from chassym.derivation.compilation.numeric import CompiledEquations
from chassym.derivation.errors import MechanismError
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.model import Model
from chassym.derivation.output import ContactForce


def with_lifting_tyres(model: Model) -> Model:
    """A model whose tyres push but do not pull; those of the built-in vehicles are bonded to the ground.

    Every element whose contact force is an output called ``..patch_force_z`` becomes unilateral. What acts
    along the ground stays bonded, in the air, too.

    Raises
    ------
    MechanismError
        If the model has no such output.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> car = with_lifting_tyres(load_model("quarter_car"))
    >>> [element.name for element in car.system.elements if isinstance(element.characteristic, Unilateral)]
    ['tyre']
    """
    mechanism = model.system
    forces = [
        output
        for output in mechanism.outputs
        if isinstance(output, ContactForce) and output.name.endswith("patch_force_z")
    ]
    if not isinstance(mechanism, Mechanism) or not forces:
        raise MechanismError(
            f"{mechanism.name!r} has no tyre to lift: none of its outputs is a contact force called "
            "'..patch_force_z'"
        )
    laws = {output.element.name: Unilateral(output.element.characteristic) for output in forces}
    return replace(model, compiled=CompiledEquations(mechanism.with_characteristics(laws)))
