"""The equations of motion of a small mechanism, written out for reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy

    from chassym.derivation import EquationsOfMotion


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
    names = [coordinate.name for coordinate in equations.coordinates]
    short = _short_names(equations)
    full = _expansions(equations, short)
    gathered = [*short.values(), *(body.mass for body in equations.mechanism.bodies if body.mass.is_Symbol)]
    for i, row in enumerate(equations.mass_matrix):
        for j in range(i, len(names)):
            if row[j] != 0:
                yield f"M[{names[i]}, {names[j]}]", _tidy(row[j], full, gathered)
    for name, force, bias in zip(names, equations.generalized_forces, equations.bias, strict=True):
        yield f"f[{name}]", _tidy(force - bias, full, gathered)
    yield from _force_laws(equations, short, full)


def _force_laws(
    equations: EquationsOfMotion,
    short: Mapping[sympy.Symbol, sympy.Symbol],
    full: Mapping[sympy.Symbol, sympy.Expr],
) -> Iterator[tuple[str, str]]:
    """The forces of the elements, each with the rate that it mentions, as they were built."""
    rates = set(map(short.get, equations.element_rates.values()))
    definitions = equations.program.definitions
    for force in equations.element_forces.values():
        law = definitions[force].xreplace(full)
        yield str(short[force]), str(law)
        for rate in (symbol for symbol, name in short.items() if name in law.free_symbols & rates):
            rates.remove(short[rate])
            yield str(short[rate]), str(definitions[rate].xreplace(full))


def _short_names(equations: EquationsOfMotion) -> dict[sympy.Symbol, sympy.Symbol]:
    """The forces and rates of the elements, which are not written out where they occur."""
    from sympy import Symbol

    kinds = {"F": equations.element_forces, "v": equations.element_rates}
    return {
        symbol: Symbol(f"{kind}_{name}", real=True)
        for kind, symbols in kinds.items()
        for name, symbol in symbols.items()
    }


def _expansions(
    equations: EquationsOfMotion, short: Mapping[sympy.Symbol, sympy.Symbol]
) -> dict[sympy.Symbol, sympy.Expr]:
    """What to write for every name of the program."""
    full: dict[sympy.Symbol, sympy.Expr] = {}
    for symbol, expression in equations.program.definitions.items():
        full[symbol] = short.get(symbol, expression.xreplace(full))
    return full


def _tidy(
    expression: sympy.Expr, full: Mapping[sympy.Symbol, sympy.Expr], gathered: Sequence[sympy.Symbol]
) -> str:
    """An expression as it was built, or sorted by forces and masses, whichever is shorter."""
    from sympy import collect, cos, expand, factor, sin, sympify

    built = sympify(expression).xreplace(full)
    squares = {sine**2: 1 - cos(*sine.args) ** 2 for sine in built.atoms(sin)}
    simplified = collect(expand(expand(built).subs(squares)), gathered, factor)
    return min(str(built), str(simplified), key=len)
