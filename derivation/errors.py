"""The refusal of a mechanism that cannot be."""

from __future__ import annotations


class MechanismError(ValueError):
    """A mechanism that cannot be: the message names the part and what would be accepted."""
