"""Parameters as sympy symbols: every value of a vehicle file stands in the equations under its own name."""

from __future__ import annotations

import sympy

from chassym.derivation.parameters import Parameters
from chassym.derivation.vector import Vector, vector


class ParameterSymbols:
    """The symbols of a parameter set; a table has one symbol for each of its entries.

    Only names and the lengths of tables are used, so that one derivation serves every variant.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._names = tuple(parameters.flat())

    def __call__(self, name: str) -> sympy.Symbol:
        """The symbol of a scalar parameter.

        Raises
        ------
        KeyError
            If there is no such parameter.
        """
        if name not in self._names:
            raise KeyError(f"no scalar parameter {name!r}")
        return sympy.Symbol(name, real=True)

    def vector(self, name: str, components: str = "xyz") -> Vector:
        """A vector parameter; components that are not listed are zero by construction."""
        return vector([self(f"{name}.{axis}") if axis in components else 0 for axis in "xyz"])

    def table(self, name: str) -> tuple[sympy.Symbol, ...]:
        """The symbols of a table's entries."""
        entries = tuple(sympy.Symbol(n, real=True) for n in self._names if n.startswith(f"{name}["))
        if not entries:
            raise KeyError(f"no table {name!r}")
        return entries
