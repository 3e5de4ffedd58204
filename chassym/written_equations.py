"""The equations of motion of a small mechanism, written out for reading."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy

    from chassym.derivation import EquationsOfMotion
    from chassym.derivation.reading.element_symbols import ElementSymbols

SHORT = 320
"""Most characters of an energy for which it is printed: four lines."""


def written_energies(equations: EquationsOfMotion) -> Iterator[tuple[str, str]]:
    """T, V and Rayleigh's dissipation function D where they are short: left and right-hand sides.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> for left, right in written_energies(load_model("quarter_car").equations):
    ...     print(left, "=", right)
    T = body_bounce_rate**2*sprung.mass/2 + unsprung.mass*wheel_bounce_rate**2/2
    V = body_bounce*gravity*sprung.mass + ... + tyre.stiffness*(-road + wheel_bounce)**2/2
    """
    from chassym.derivation.reading.lagrange_form import is_short

    if not is_short(equations):
        return
    energies = (equations.kinetic_energy, equations.potential_energy, equations.dissipation)
    for name, energy in zip("TVD", energies, strict=True):
        if len(str(energy)) <= SHORT:
            yield name, str(energy)


def written_equations(equations: EquationsOfMotion) -> Iterator[tuple[str, str]]:
    """M q'' = f, entry by entry: left and right-hand sides of equations.

    The force of an element and the rate of its deflection are called ``F_`` and ``v_`` with the element's
    name, and come last. Zeros of M, and its lower half, are left out.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> for left, right in written_equations(load_model("torsion_chain").equations):
    ...     print(left, "=", right)
    M[roll, roll] = inertia.front + inertia.middle + inertia.rear
    M[roll, front_torsion] = inertia.front
    M[roll, rear_torsion] = inertia.rear
    M[front_torsion, front_torsion] = inertia.front
    M[rear_torsion, rear_torsion] = inertia.rear
    f[roll] = 0
    f[front_torsion] = -F_front_shaft
    f[rear_torsion] = -F_rear_shaft
    F_front_shaft = damping.front*v_front_shaft + front_torsion*stiffness.front
    v_front_shaft = front_torsion_rate
    F_rear_shaft = damping.rear*v_rear_shaft + rear_torsion*stiffness.rear
    v_rear_shaft = rear_torsion_rate
    """
    from chassym.derivation.reading.element_symbols import element_symbols
    from chassym.derivation.reading.lagrange_form import masses
    from chassym.derivation.reading.tidy import without_rounding
    from chassym.derivation.reading.written_form import expanded

    symbols, program = element_symbols(equations), equations.program
    names = [coordinate.name for coordinate in equations.coordinates]
    short = {**symbols.printed_rates, **symbols.printed_forces}
    gathered = [*short.values(), *masses(equations)]
    mass = [expanded(program, row, short) for row in equations.mass_matrix]
    for i, row in enumerate(mass):
        for j, entry in enumerate(row[i:], start=i):
            if entry != 0:
                yield f"M[{names[i]}, {names[j]}]", _tidy(entry, gathered)
    forces = expanded(program, equations.generalized_forces, short)
    bias = expanded(program, equations.bias, short)
    for name, row, force, rest in zip(names, mass, forces, bias, strict=True):
        yield f"f[{name}]", _tidy(force - without_rounding(rest, beside=row), gathered)
    yield from _force_laws(program.definitions, symbols, lambda law: expanded(program, [law], short)[0])


def _force_laws(
    definitions: Mapping[sympy.Symbol, sympy.Expr],
    symbols: ElementSymbols,
    write: Callable[[sympy.Expr], sympy.Expr],
) -> Iterator[tuple[str, str]]:
    """The forces of the elements, each with the rate that it mentions, as they were built."""
    rates = {symbol: name for name, symbol in symbols.printed_rates.items()}
    for name, force in symbols.printed_forces.items():
        law = write(definitions[name])
        yield str(force), str(law)
        for rate in [rate for rate in rates if rate in law.free_symbols]:
            yield str(rate), str(write(definitions[rates.pop(rate)]))


def _tidy(built: sympy.Expr, gathered: Sequence[sympy.Symbol]) -> str:
    """An expression as it was built, or sorted by forces and masses, whichever is shorter."""
    from sympy import collect, cos, expand, factor, sin

    from chassym.derivation.reading.tidy import without_rounding

    squares = {sine**2: 1 - cos(*sine.args) ** 2 for sine in built.atoms(sin)}
    spread = without_rounding(expand(expand(built).subs(squares)), beside=[built])
    return min(str(without_rounding(built)), str(collect(spread, gathered, factor)), key=len)
