"""How near a motion comes to where a rotation sequence loses a degree of freedom."""

from __future__ import annotations

from dataclasses import dataclass

LIMIT = 1e-3
"""Distance below which accelerations are not to be trusted: they lose twice the digits that it has zeros."""


@dataclass(frozen=True)
class Singularity:
    """The nearest approach to the singularity of a rotation sequence.

    Attributes
    ----------
    body
        The body on the three rotations.
    distance
        1 far from it, 0 there: |cos| of the second angle for three different axes, |sin| for two.
    sample
        Index of the sample where it is that near.
    """

    body: str
    distance: float
    sample: int

    @property
    def is_harmful(self) -> bool:
        """Whether it is too near for the accelerations to be trusted."""
        return not self.distance >= LIMIT

    def __str__(self) -> str:
        """One line."""
        return (
            f"the rotation sequence of body {self.body!r} comes to {self.distance:.2g} from its singularity "
            f"(1 is far, {LIMIT:g} the limit)"
        )

    @property
    def refusal(self) -> str:
        """One line with the remedy."""
        return f"{self}; choose another sequence for its joint"
