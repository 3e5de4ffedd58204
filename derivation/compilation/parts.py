"""A kernel, its statements in the order of need, and the parts that are compiled one by one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import sympy

_UNDIVIDED = 4000
_PART = 250
"""Operations of the largest kernel that stays whole, and of a part of a larger one.

The time of register allocation grows faster than a function: with parts it grows as the model does. In a
small kernel the values that parts hand on through memory would cost more time than the parts save.
"""


@dataclass(frozen=True)
class Kernel:
    """A function of varying arguments and of constants, to be evaluated for many samples.

    Attributes
    ----------
    name
        Symbol in the machine code.
    arguments
        Row of every varying symbol in the kernel's input.
    constants
        Row of every symbol that does not vary from sample to sample.
    definitions
        Assignments in order.
    results
        What is returned, row by row.
    by_pass
        Whether the results of a pass stand together, as the constants of another kernel do, instead of those
        of a row.
    """

    name: str
    arguments: Mapping[sympy.Symbol, int]
    constants: Mapping[sympy.Symbol, int]
    definitions: Mapping[sympy.Symbol, sympy.Expr]
    results: Sequence[sympy.Expr]
    by_pass: bool = False


@dataclass(frozen=True)
class Statement:
    """A value to compute and where it goes.

    Attributes
    ----------
    target
        The symbol that it is assigned to, or the row of the results that it is put into.
    expression
        The value.
    needs
        Assigned symbols in the expression, in the order of their assignments.
    """

    target: sympy.Symbol | int
    expression: sympy.Expr
    needs: tuple[sympy.Symbol, ...]


def in_order_of_need(kernel: Kernel) -> list[Statement]:
    """Statements with every value computed as late, and every result put away as early, as possible.

    Fewer values then wait at a time. Results come in the order in which the definitions complete them, and
    every one of them after the definitions that it needs and that are not there yet.
    """
    place = {symbol: number for number, symbol in enumerate(kernel.definitions)}

    def statement(target: sympy.Symbol | int, expression: sympy.Expr) -> Statement:
        needs = sorted((s for s in expression.free_symbols if s in place), key=place.__getitem__)
        return Statement(target, expression, tuple(needs))

    assigned = {symbol: statement(symbol, expression) for symbol, expression in kernel.definitions.items()}
    last = [statement(row, sympy.sympify(result)) for row, result in enumerate(kernel.results)]
    ordered: dict[sympy.Symbol | int, Statement] = {}
    for result in sorted(last, key=lambda s: place[s.needs[-1]] if s.needs else -1):
        for each in _with_needs(result, assigned, ordered):
            ordered[each.target] = each
    return list(ordered.values())


def _with_needs(
    statement: Statement,
    assigned: Mapping[sympy.Symbol, Statement],
    done: Mapping[sympy.Symbol | int, Statement],
) -> Iterator[Statement]:
    """What a statement needs and is not done, depth first, then the statement itself."""
    waiting = [(statement, iter(statement.needs))]
    while waiting:
        current, needs = waiting[-1]
        missing = next((symbol for symbol in needs if symbol not in done), None)
        if missing is None:
            waiting.pop()
            yield current
        else:
            waiting.append((assigned[missing], iter(assigned[missing].needs)))


def divide(statements: Sequence[Statement]) -> list[list[Statement]]:
    """Parts of consecutive statements; a small kernel is one part."""
    sizes = [_operations(statement.expression) for statement in statements]
    if sum(sizes) <= _UNDIVIDED:
        return [list(statements)]
    parts: list[list[Statement]] = [[]]
    size = 0
    for statement, own in zip(statements, sizes, strict=True):
        if size >= _PART:
            parts.append([])
            size = 0
        parts[-1].append(statement)
        size += own
    return parts


def _operations(expression: sympy.Basic) -> int:
    """Number of operations, about; a loading or storing statement counts as one."""
    if not expression.args:
        return 1
    return len(expression.args) - 1 + sum(_operations(a) for a in expression.args if a.args) or 1


def scratch_places(parts: Sequence[Sequence[Statement]]) -> dict[sympy.Symbol, int]:
    """Place in scratch memory of every symbol that a later part needs.

    Places are used again after the last part that needs them, so that scratch memory stays small.
    """
    last = {symbol: number for number, part in enumerate(parts) for each in part for symbol in each.needs}
    released: dict[int, list[int]] = {}
    places: dict[sympy.Symbol, int] = {}
    free: list[int] = []
    count = 0
    for number, part in enumerate(parts):
        for target in (each.target for each in part):
            if isinstance(target, int) or last.get(target, number) == number:
                continue
            if not free:
                free.append(count)
                count += 1
            places[target] = free.pop()
            released.setdefault(last[target], []).append(places[target])
        free += released.pop(number, [])
    return places
