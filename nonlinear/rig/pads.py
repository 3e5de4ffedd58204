"""The pads of a rig: inputs that move the wheels, and the words for where they stand."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")

DIRECTIONS = {"longitudinal": "x", "lateral": "y", "vertical": "z"}
"""Axes of the pads, by the directions' names."""

_DIRECTION_OF = {axis: direction for direction, axis in DIRECTIONS.items()}
_PAD = re.compile(r"(?:(?P<place>.+)_)?(?:pad_(?P<axis>[xyz])|road)")


@dataclass(frozen=True)
class Pad:
    """An input that moves a wheel.

    Attributes
    ----------
    input
        Its name, such as ``front_left_pad_z`` or ``rear_road``.
    place
        Where it stands, such as ``front_left`` or ``rear``; empty if it is the only one.
    direction
        One of `DIRECTIONS`; a road is vertical.
    """

    input: str
    place: str
    direction: str

    def is_called(self, words: str) -> bool:
        """Whether the pad is meant by "all", or stands at a place with all these words.

        Examples
        --------
        >>> rear = Pad("rear_left_pad_z", "rear_left", "vertical")
        >>> [rear.is_called(words) for words in ("all", "rear", "rear_left", "right")]
        [True, True, True, False]
        """
        return words == "all" or set(words.split("_")) <= set(self.place.split("_"))


def pads_of(inputs: Iterable[str]) -> tuple[Pad, ...]:
    """The inputs that are pads or roads.

    Examples
    --------
    >>> pads_of(["rear_road", "wind", "front_left_pad_y"])[1]
    Pad(input='front_left_pad_y', place='front_left', direction='lateral')
    """
    matches = filter(None, map(_PAD.fullmatch, inputs))
    return tuple(Pad(each[0], each["place"] or "", _DIRECTION_OF[each["axis"] or "z"]) for each in matches)


PADS = pads_of(f"{corner}_pad_{axis}" for corner in CORNERS for axis in DIRECTIONS.values())
"""Those of the four-post rig."""
