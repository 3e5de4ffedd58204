"""Pairs of eigenvalues followed while a linear model changes, in steps as short as they have to be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.modal.mode_pairs import ModePairs, conjugate_pairs, continuation, undamped_pairs
from chassym.linear.modal.spectrum import EQUAL, spectrum

Array = np.ndarray

RESOLVED = 0.1
"""Least distance of two eigenvalues within a step, as a part of the change of their difference."""

SHORTEST = 1e-12
"""Shortest step, as a part of the whole one."""


class PartnersLostError(LinearisationError):
    """Pairs that no step is short enough to follow.

    Attributes
    ----------
    pairs
        Their indices.
    value
        Where.
    """

    def __init__(self, pairs: tuple[int, ...], value: float) -> None:
        super().__init__(f"pairs {pairs} of eigenvalues cannot be told apart at {value:.6g}")
        self.pairs, self.value = pairs, value


def paired(linear: LinearModel) -> ModePairs:
    """The pairs of a linear model, in ascending order of frequency.

    Two conjugates are a pair, and so are two eigenvalues that are the only real ones. Where there are more,
    or modes are equal, undamped modes tell: each is a pair by itself, and where it leads while damping, and
    what part of K is not symmetric, grow from nothing to their size is a pair with damping.

    Raises
    ------
    LinearisationError
        If M is singular.
    PartnersLostError
        If two pairs exchange eigenvalues on the way; its value is the part of the damping.
    """
    obvious = conjugate_pairs(spectrum(linear))
    if obvious is not None:
        return obvious
    symmetric = (linear.stiffness + linear.stiffness.T) / 2

    def with_part(part: float) -> LinearModel:
        stiffness = (1 - part) * symmetric + part * linear.stiffness
        return replace(linear, damping=part * linear.damping, stiffness=stiffness)

    grown = followed(with_part, undamped_pairs(linear), 0.0, 1.0)
    return grown.taken(np.argsort(np.abs(grown.products), kind="stable"))


def followed(
    linear_at: Callable[[float], LinearModel], start: ModePairs, begin: float, end: float
) -> ModePairs:
    """What becomes of pairs between two values.

    A step is divided where the overlaps leave a doubt, and where two eigenvalues may come so near on the way
    that their modes mix between its ends and part again. Between positive values steps are ratios.

    Parameters
    ----------
    linear_at
        The linear model at a value.
    start
        The pairs at ``begin``.

    Raises
    ------
    PartnersLostError
        If no step is short enough.
    """
    scale, back = (np.log, np.exp) if begin > 0 and end > 0 else (float, float)
    place, pairs = float(scale(begin)), start
    ahead = [(float(scale(end)), spectrum(linear_at(end)))]
    shortest = SHORTEST * abs(ahead[0][0] - place)
    while ahead:
        there, found = ahead[-1]
        reached = continuation(pairs, found)
        short = abs(there - place) <= shortest
        part: float | None = 0.5
        if isinstance(reached, ModePairs):
            part = None if short else _nearest_approach(pairs, reached)
        elif short:
            raise PartnersLostError(reached, float(back(there)))
        if isinstance(reached, ModePairs) and part is None:
            place, pairs = there, reached
            ahead.pop()
        elif part is not None:
            between = place + part * (there - place)
            ahead.append((between, spectrum(linear_at(float(back(between))))))
    return pairs


def _nearest_approach(before: ModePairs, after: ModePairs) -> float | None:
    """Where in a step two eigenvalues of different pairs might meet, as a part of it; None if they do not.

    They are taken to change linearly. Where they are equal at an end of the step there is nothing to find.
    """
    i, j = np.triu_indices(len(before.planes), k=1)
    first, last = (
        (p.eigenvalues[i][:, :, None] - p.eigenvalues[j][:, None, :]).ravel() for p in (before, after)
    )
    size = np.abs(before.eigenvalues[i]).max(axis=1).repeat(4)
    change = last - first
    at = -(change.conj() * first).real / np.maximum(np.abs(change) ** 2, np.finfo(float).tiny)
    distance = np.abs(first + at * change)
    meet = (at > 0) & (at < 1) & (distance < RESOLVED * np.abs(change))
    meet &= np.minimum(np.abs(first), np.abs(last)) > 10 * EQUAL * size
    if not meet.any():
        return None
    # Beyond the first steps eigenvalues do not change linearly: a place near an end is not to be trusted.
    return float(np.clip(at[meet][0], 0.1, 0.9))
