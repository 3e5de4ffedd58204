"""The names of a mechanism's parts and symbols: each is given once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import sympy

from chassym.derivation.errors import MechanismError


@dataclass
class Names:
    """What is taken in one mechanism.

    Attributes
    ----------
    owner
        The mechanism's name.
    parts
        Kind of every part by its name.
    symbols
        Names of symbols in the equations.
    """

    owner: str
    parts: dict[str, str] = field(default_factory=lambda: {"ground": "body"})
    symbols: set[str] = field(default_factory=set)

    def copy(self) -> Names:
        """The names taken so far, to which others may be added apart."""
        return Names(self.owner, self.parts.copy(), self.symbols.copy())

    def claim(self, *parts: Mapping[str, str], symbols: Sequence[sympy.Symbol] = ()) -> None:
        """Take the names of parts, each with its kind, and of their symbols: all of them or none.

        Raises
        ------
        MechanismError
            If one is taken or kept.
        """
        self.check_free(parts, symbols)
        for part in parts:
            self.parts.update(part)
        self.symbols.update(symbol.name for symbol in symbols)

    def check_free(self, parts: Sequence[Mapping[str, str]], symbols: Sequence[sympy.Symbol] = ()) -> None:
        """Refuse names that are taken or kept.

        Raises
        ------
        MechanismError
            If one is.
        """
        taken = dict(self.parts)
        for name, kind in (pair for part in parts for pair in part.items()):
            if name.startswith("_"):
                raise MechanismError(
                    f"mechanism {self.owner!r}: the name {name!r} begins with an underscore; those are kept "
                    "for intermediate results"
                )
            if name in taken:
                raise MechanismError(
                    f"mechanism {self.owner!r}: the name {name!r} is taken by {_one(taken[name])}; "
                    f"{_one(kind)} needs another one"
                )
            taken[name] = kind
        written = [symbol.name for symbol in symbols]
        double = [name for i, name in enumerate(written) if name in self.symbols or name in written[:i]]
        if double:
            raise MechanismError(
                f"mechanism {self.owner!r}: the name {double[0]!r} is taken; every symbol needs its own"
            )


def _one(kind: str) -> str:
    """A kind of part with its article.

    Examples
    --------
    >>> _one("body"), _one("output")
    ('a body', 'an output')
    """
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
