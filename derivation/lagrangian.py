"""Lagrange's equations of somebody's own Lagrangian: d/dt(dL/dq') - dL/dq + dD/dq' = Q on a program.

With the momenta p = dL/dq', the mass matrix is dp/dq' and the bias dp/dq q' + dp/du u' - dL/dq (Goldstein,
Poole and Safko, Classical Mechanics, 3rd ed., sections 1.4, 1.5 and 8.1).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy.core.function import AppliedUndef

from chassym.derivation.body import Input
from chassym.derivation.energies import Energies
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate
from chassym.derivation.lagrange import derive
from chassym.derivation.program import Program
from chassym.derivation.table import Knotted

_NO_NUMBER = (sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)


@dataclass(frozen=True)
class ExpressionOutput:
    """A measured quantity as an expression of coordinates and inputs, and of their derivatives."""

    name: str
    unit: str
    expression: sympy.Expr


@dataclass(frozen=True)
class Lagrangian:
    """A system by its Lagrangian L = T - V, in the symbols of its coordinates and inputs.

    Parameters
    ----------
    name
        For reading.
    lagrangian
        L (J) in coordinates, rates, inputs and input rates. Terms of the sum that contain a rate count as
        kinetic energy, the others as potential energy; a product of sums is a sum of products, a power is
        one term.
    coordinates, inputs, outputs
        In order; outputs may contain accelerations.
    dissipation
        Rayleigh's dissipation function D (W): half the power that linear dampers lose.
    forces
        Generalised force of any other origin on every coordinate, length n (N or N m).

    Raises
    ------
    MechanismError
        If a name is taken twice, or an expression contains what it may not.

    Examples
    --------
    >>> from chassym.derivation import derive
    >>> x, (m, k) = Coordinate("x", "m"), sympy.symbols("m k", positive=True)
    >>> energy = m * x.rate**2 / 2 - k * x.position**2 / 2
    >>> equations = derive(Lagrangian("oscillator", energy, (x,), (), (), sympy.S.Zero, (sympy.S.Zero,)))
    >>> equations.program.expand(equations.residual)
    [k*x + m*x_acceleration]
    """

    name: str
    lagrangian: sympy.Expr
    coordinates: tuple[Coordinate, ...]
    inputs: tuple[Input, ...]
    outputs: tuple[ExpressionOutput, ...]
    dissipation: sympy.Expr
    forces: tuple[sympy.Expr, ...]

    def __post_init__(self) -> None:
        if not self.coordinates or len(self.forces) != len(self.coordinates):
            raise MechanismError(
                f"system {self.name!r}: {len(self.forces)} forces on {len(self.coordinates)} coordinates "
                "received; expected one coordinate or more, and one force on each"
            )
        parts: list[Coordinate | Input] = [*self.coordinates, *self.inputs]
        arguments = [symbol for part in parts for symbol in derivatives(part)]
        self._check_names([*(part.name for part in parts), *(output.name for output in self.outputs)])
        self._check_names([symbol.name for symbol in arguments])
        accelerations = [c.acceleration for c in self.coordinates]
        _check("lagrangian", self.lagrangian, arguments, accelerations)
        _check("dissipation", self.dissipation, arguments, accelerations)
        for coordinate, force in zip(self.coordinates, self.forces, strict=True):
            _check(f"force on {coordinate.name!r}", force, arguments, accelerations)
        for output in self.outputs:
            _check(f"output {output.name!r}", output.expression, arguments, [])

    def _check_names(self, names: Sequence[str]) -> None:
        for index, name in enumerate(names):
            if not name or name.startswith("_"):
                raise MechanismError(
                    f"system {self.name!r}: the name {name!r} is empty or begins with an underscore; those "
                    "are kept for intermediate results"
                )
            if name in names[:index]:
                raise MechanismError(
                    f"system {self.name!r}: the name {name!r} is taken; every coordinate, rate, "
                    "acceleration, input and output needs its own"
                )

    def snapshot(self) -> Lagrangian:
        """Itself: it cannot change."""
        return self

    @property
    def rotation_sequences(self) -> tuple[str, ...]:
        """None: where coordinates are singular is not known from a Lagrangian."""
        return ()

    @property
    def preloads(self) -> tuple[sympy.Symbol, ...]:
        """None: whether the position zero is an equilibrium is up to the Lagrangian."""
        return ()

    @property
    def slopes(self) -> dict[str, sympy.Symbol]:
        """None: no force is a table, and sympy states the slopes of the others."""
        return {}

    @property
    def knotted(self) -> dict[str, Knotted]:
        """None."""
        return {}


def derivatives(part: Coordinate | Input) -> tuple[sympy.Symbol, ...]:
    """The symbols of a coordinate or an input and of its derivatives by time, in order."""
    if isinstance(part, Coordinate):
        return part.position, part.rate, part.acceleration
    return part.position, part.rate


def _check(
    what: str,
    expression: sympy.Expr,
    arguments: Sequence[sympy.Symbol],
    accelerations: Sequence[sympy.Symbol],
) -> None:
    """Refuse what is neither a parameter nor an argument, and accelerations where they may not be."""
    functions = expression.atoms(AppliedUndef, sympy.Derivative, sympy.Integral)
    if functions:
        raise MechanismError(
            f"{what} contains {min(map(str, functions))}; expected symbols of coordinates, inputs and "
            "parameters"
        )
    if expression.has(*_NO_NUMBER):
        raise MechanismError(f"{what}: {expression} received; expected a real and finite expression")
    own = {symbol.name: symbol for symbol in arguments}
    for symbol in sorted(expression.free_symbols, key=lambda each: str(each.name)):
        if symbol in accelerations:
            raise MechanismError(f"{what} contains the acceleration {symbol}; expected rates at most")
        if symbol != own.get(symbol.name, symbol):
            raise MechanismError(
                f"{what} contains a symbol {symbol.name!r} that is not the one of the coordinate or input of "
                "that name; take its .position or .rate, or another name"
            )
        if symbol.name.startswith("_"):
            raise MechanismError(
                f"{what} contains the symbol {symbol.name!r}; names that begin with an underscore are kept "
                "for intermediate results"
            )


@derive.register
def _of_lagrangian(system: Lagrangian) -> EquationsOfMotion:
    """The equations of a Lagrangian."""
    start = time.perf_counter()
    program = Program()
    positions, rates = [c.position for c in system.coordinates], [c.rate for c in system.coordinates]
    inputs, input_rates = [u.position for u in system.inputs], [u.rate for u in system.inputs]
    kinetic, potential = _split(program, system.lagrangian, {*rates, *input_rates})
    gradient = program.differentiate([program.let(kinetic - potential)], [*rates, *positions])[0]
    momenta, slopes = gradient[: len(rates)], gradient[len(rates) :]
    matrix = program.differentiate(momenta, rates)
    _check_inertia(system, matrix)
    _check_base(system, program.differentiate(momenta, input_rates))
    drift = program.differentiate(momenta, [*positions, *inputs])
    bias = [
        program.let(sympy.Add(-slope, *(p * v for p, v in zip(row, [*rates, *input_rates], strict=True))))
        for slope, row in zip(slopes, drift, strict=True)
    ]
    dissipation, applied = program.absorb(system.dissipation), tuple(map(program.absorb, system.forces))
    losses = program.differentiate([dissipation], rates)[0]
    return EquationsOfMotion(
        system=system,
        program=program,
        mass_matrix=tuple(map(tuple, matrix)),
        bias=tuple(bias),
        generalized_forces=tuple(program.let(q - loss) for q, loss in zip(applied, losses, strict=True)),
        elements={},
        outputs={output.name: program.absorb(output.expression) for output in system.outputs},
        energies=Energies(kinetic, potential, dissipation, applied),
        singularities={},
        derivation_s=time.perf_counter() - start,
    )


def _split(
    program: Program, lagrangian: sympy.Expr, rates: set[sympy.Symbol]
) -> tuple[sympy.Expr, sympy.Expr]:
    """The terms of the sum that contain rates, and the others with their sign changed."""
    moving, still = _parted(lagrangian, rates)
    return program.absorb(moving), program.absorb(-still)


def _parted(expression: sympy.Expr, rates: set[sympy.Symbol]) -> tuple[sympy.Expr, sympy.Expr]:
    """The terms that contain rates, and the others, of a sum whose products are multiplied out if mixed.

    (a + b) (c + d) with the rates in a and c is a (c + d) + b c, and b d: as many terms as factors.
    """
    if not expression.free_symbols & rates:
        return sympy.S.Zero, expression
    if not (expression.is_Add or expression.is_Mul):
        return expression, sympy.S.Zero
    parts = [_parted(each, rates) for each in expression.args]
    if expression.is_Add:
        return sympy.Add(*(moving for moving, _ in parts)), sympy.Add(*(still for _, still in parts))
    if any(still == 0 for _, still in parts):
        return expression, sympy.S.Zero
    products, before = [], sympy.S.One
    for place, (moving, still) in enumerate(parts, start=1):
        products.append(before * moving * sympy.Mul(*expression.args[place:]))
        before *= still
    return sympy.Add(*products), before


def _check_inertia(system: Lagrangian, matrix: Sequence[Sequence[sympy.Expr]]) -> None:
    """Refuse a coordinate whose own entry of M is structurally zero: no mass matrix may have such a one."""
    for index, coordinate in enumerate(system.coordinates):
        if matrix[index][index] == 0:
            raise MechanismError(
                f"coordinate {coordinate.name!r} moves no mass: the lagrangian of {system.name!r} does not "
                f"contain the square of {coordinate.rate}; add its kinetic energy"
            )


def _check_base(system: Lagrangian, by_input_rates: Sequence[Sequence[sympy.Expr]]) -> None:
    """Refuse momenta that depend on the rate of an input: their derivatives contain its second derivative."""
    for coordinate, row in zip(system.coordinates, by_input_rates, strict=True):
        for each, slope in zip(system.inputs, row, strict=True):
            if slope != 0:
                raise MechanismError(
                    f"input {each.name!r}: its second derivative would enter the equations, as the momentum "
                    f"of {coordinate.name!r} depends on {each.rate}; measure {coordinate.name!r} from the "
                    f"ground, not from what {each.name!r} moves, or make {each.name!r} a coordinate on a "
                    "stiff spring"
                )
