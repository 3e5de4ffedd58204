"""Which outputs are forces of supports that can only push."""

from __future__ import annotations

from chassym.derivation import ContactForce, Unilateral
from chassym.derivation.system import Measurement


def carries_by_contact(output: Measurement) -> bool:
    """Whether an output is the force of a support that can only push, or should."""
    return output.name.endswith("patch_force_z") or is_unilateral(output)


def is_unilateral(output: Measurement) -> bool:
    """Whether an output is the force of a support that can only push, and so is lifted off."""
    return isinstance(output, ContactForce) and isinstance(output.element.characteristic, Unilateral)


def patch_of(output_name: str) -> str:
    """The place that a patch force is of.

    Examples
    --------
    >>> patch_of("rear_left_patch_force_z")
    'rear_left'
    """
    return output_name.removesuffix("patch_force_z").removesuffix("_")
