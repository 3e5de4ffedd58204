"""Lagrange's equations written out: T, V, D and what follows from them, in the coordinates' own symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import sympy

from chassym.derivation.errors import MechanismError
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.program import Program
from chassym.derivation.reading.tidy import sorted_by, tidied, without_rounding

if TYPE_CHECKING:
    from chassym.derivation.body import Input
    from chassym.derivation.equations_of_motion import EquationsOfMotion
    from chassym.derivation.joint import Coordinate

LARGEST = 3000
"""Most arithmetic operations of what is written out: about three printed pages."""


def written_size(program: Program, results: Sequence[sympy.Expr]) -> int:
    """Arithmetic operations of results written out without intermediate names, found without writing them.

    Examples
    --------
    >>> x = sympy.Symbol("x")
    >>> program, value = Program(), x
    >>> for _ in range(100):
    ...     value = program.let(sympy.sin(value) * (value + 1))
    >>> written_size(program, [value]) == 3 * (2**100 - 1)
    True
    """
    sizes: dict[sympy.Symbol, int] = {}
    for symbol, expression in program.required(results).items():
        sizes[symbol] = _size(expression, sizes)
    return sum(_size(sympy.sympify(result), sizes) for result in results)


def _size(expression: sympy.Basic, sizes: Mapping[sympy.Symbol, int]) -> int:
    if not expression.args:
        return sizes.get(expression, 0)
    own = len(expression.args) - 1 if expression.is_Add or expression.is_Mul else 1
    return own + sum(_size(each, sizes) for each in expression.args)


def written_out(equations: EquationsOfMotion, results: Sequence[sympy.Expr]) -> list[sympy.Expr]:
    """Results on the program in the symbols of coordinates, inputs and parameters, lightly tidied.

    Raises
    ------
    MechanismError
        If they would be too long to read.
    """
    check_size(equations, results)
    return [tidied(result) for result in equations.program.expand(results)]


def is_short(equations: EquationsOfMotion) -> bool:
    """Whether the equations of motion can be written out."""
    return written_size(equations.program, equations.residual) <= LARGEST


def check_size(equations: EquationsOfMotion, results: Sequence[sympy.Expr]) -> None:
    """Refuse results on the program that would be too long to read when written out.

    Raises
    ------
    MechanismError
        If they would.
    """
    size = written_size(equations.program, results)
    if size > LARGEST:
        raise MechanismError(
            f"{equations.system.name!r} written out has {sympy.Float(size, 2)} operations, expected at most "
            f"{LARGEST}; read `program.definitions` instead, or the straight-line form that `to_latex` gives"
        )


def lagrange_equations(equations: EquationsOfMotion) -> tuple[sympy.Eq, ...]:
    """d/dt(dT/dq') - dT/dq + dV/dq + dD/dq' = Q for every coordinate.

    T, V and D are differentiated as they are written out; second derivatives are the accelerations' symbols.
    What a coordinate's equation says is residual = 0, found in another way.

    Raises
    ------
    MechanismError
        If they would be too long to read.
    """
    check_size(equations, equations.residual)
    energies = equations.energies
    kinetic, potential, dissipation = written_out(
        equations, [energies.kinetic, energies.potential, energies.dissipation]
    )
    right = written_out(equations, energies.applied)
    found = []
    for coordinate, applied in zip(equations.coordinates, right, strict=True):
        forces = potential.diff(coordinate.position) + dissipation.diff(coordinate.rate)
        left = sympy.Add(_inertia(equations, kinetic, coordinate), tidied(_without_steps(forces)))
        found.append(sympy.Eq(left, applied, evaluate=False))
    return tuple(found)


def _inertia(equations: EquationsOfMotion, kinetic: sympy.Expr, coordinate: Coordinate) -> sympy.Expr:
    """d/dt(dT/dq') - dT/dq by the chain rule, each acceleration with its factor."""
    momentum = kinetic.diff(coordinate.rate)
    terms = [tidied(momentum.diff(c.rate)) * c.acceleration for c in equations.coordinates]
    moving: list[Coordinate | Input] = [*equations.coordinates, *equations.system.inputs]
    changes = sympy.Add(*(momentum.diff(each.position) * each.rate for each in moving))
    rest = sorted_by(
        changes - kinetic.diff(coordinate.position), [each.rate for each in moving], masses(equations)
    )
    return sympy.Add(*terms, without_rounding(tidied(rest), beside=terms))


def masses(equations: EquationsOfMotion) -> list[sympy.Symbol]:
    """The symbols of the bodies' masses, by which sums are sorted; a system without bodies has none."""
    system = equations.system
    bodies = system.bodies if isinstance(system, Mechanism) else []
    return list(dict.fromkeys(body.mass for body in bodies if body.mass.is_Symbol))


def _without_steps(expression: sympy.Expr) -> sympy.Expr:
    """The same without the unit steps that sympy puts beside the powers of a Max that it differentiates."""

    def is_product(part: sympy.Basic) -> bool:
        return bool(part.is_Mul and part.has(sympy.Heaviside))

    def reduced(product: sympy.Expr) -> sympy.Expr:
        ramps = {_ramp(factor.as_base_exp()[0]) for factor in product.args}
        return sympy.Mul(
            *(f for f in product.args if not (isinstance(f, sympy.Heaviside) and f.args[0] in ramps))
        )

    return expression.replace(is_product, reduced)


def _ramp(expression: sympy.Expr) -> sympy.Expr | None:
    """The x of Max(0, x)."""
    if isinstance(expression, sympy.Max) and len(expression.args) == 2 and sympy.S.Zero in expression.args:
        return next(each for each in expression.args if each != 0)
    return None


def functions_of_time(equations: EquationsOfMotion, time: sympy.Symbol) -> dict[sympy.Symbol, sympy.Expr]:
    """What to put for the symbols of coordinates, rates, accelerations and inputs to get functions of time.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> chain = load_model("torsion_chain").equations
    >>> chain.potential_energy.xreplace(functions_of_time(chain, sympy.Symbol("t")))
    stiffness.front*front_torsion(t)**2/2 + stiffness.rear*rear_torsion(t)**2/2
    """
    found: dict[sympy.Symbol, sympy.Expr] = {}
    for coordinate in equations.coordinates:
        motion = sympy.Function(coordinate.name)(time)
        found |= {coordinate.position: motion, coordinate.rate: motion.diff(time)}
        found[coordinate.acceleration] = motion.diff(time, 2)
    for prescribed in equations.system.inputs:
        motion = sympy.Function(prescribed.name)(time)
        found |= {prescribed.position: motion, prescribed.rate: motion.diff(time)}
    return found
