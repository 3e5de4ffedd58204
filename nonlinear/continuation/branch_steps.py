"""Points of a branch of periodic orbits, with the direction in which it goes on, and steps between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a branch.

    Attributes
    ----------
    unknowns
        Packed coefficients of the orbit.
    value
        The path's parameter.
    tangent
        Direction of the branch, unknowns and parameter counted in the scales: a unit vector.
    scales
        Of unknowns and parameter.
    """

    unknowns: Array = field(repr=False)
    value: float
    tangent: Array = field(repr=False)
    scales: Array = field(repr=False)

    @property
    def turning(self) -> float:
        """How fast the parameter changes along the branch: it passes zero at a fold."""
        return float(self.tangent[-1])

    @property
    def slopes(self) -> Array:
        """Change of the unknowns with the parameter."""
        change = self.tangent * self.scales
        return np.asarray(change[:-1] / change[-1])


@dataclass(frozen=True, eq=False)
class Step:
    """Two neighbouring points and the length of arc between them.

    Attributes
    ----------
    begin, end
        The points. At a corner they are one place, with the tangents before and after it.
    length
        Of arc; zero at a corner.
    ends_in_fold
        Whether the parameter turns about at the end.
    """

    begin: Point
    end: Point
    length: float
    ends_in_fold: bool = False

    @property
    def is_corner(self) -> bool:
        """Whether only the direction changes."""
        return self.length == 0

    @property
    def folds(self) -> bool:
        """Whether the parameter turns about on the way."""
        return self.begin.turning * self.end.turning < 0

    @property
    def straightness(self) -> float:
        """Cosine of the angle between the tangents at both ends."""
        ahead = self.end.tangent * self.end.scales / self.begin.scales
        return float(self.begin.tangent @ ahead / np.linalg.norm(ahead))

    def passes(self, value: float) -> bool:
        """Whether the parameter comes to a value, or beyond it; the beginning does not count."""
        before, after = self.begin.value - value, self.end.value - value
        return before != 0 and before * after <= 0
