"""Force elements: a characteristic at a port."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from chassym.derivation.characteristic import Characteristic
from chassym.derivation.port import Port


@dataclass(frozen=True, eq=False)
class ForceElement:
    """A characteristic at a port, with a constant preload on top where it has one."""

    name: str
    port: Port
    characteristic: Characteristic
    preload: sympy.Symbol | None = None

    @property
    def constant_force(self) -> sympy.Expr:
        """The preload; zero without one."""
        return sympy.S.Zero if self.preload is None else self.preload

    @property
    def unit(self) -> str:
        """Unit of its force: that which works on the port's deflection."""
        return "N*m" if self.port.unit == "rad" else "N"


@dataclass(frozen=True)
class ElementAnswer:
    """An element's deflection, rate and resisting force, as names of a program.

    The part of the force that a table states, if there is one, has a name of its own: `tabulated`, otherwise
    the force.
    """

    deflection: sympy.Symbol
    rate: sympy.Symbol
    force: sympy.Symbol
    tabulated: sympy.Symbol
