"""From equations of motion to compiled functions: what is generated, and what the disk already has."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import RLock

import numpy as np
import sympy

from chassym.derivation.compilation import cache, machine_code
from chassym.derivation.compilation.assembly import assembly
from chassym.derivation.compilation.compiled_function import CompiledFunction
from chassym.derivation.compilation.instructions import LANES
from chassym.derivation.compilation.parts import Kernel
from chassym.derivation.compilation.structure import describe
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.lagrange import derive
from chassym.derivation.program import Program
from chassym.derivation.system import System


@dataclass(frozen=True)
class _Results:
    """Expressions to compile and where they stand in a matrix."""

    entries: Sequence[sympy.Expr]
    rows: tuple[int, ...]
    columns: tuple[int, ...]


def _vector(entries: Sequence[sympy.Expr]) -> _Results:
    return _Results(entries, tuple(range(len(entries))), (0,) * len(entries))


def _matrix(rows: Sequence[Sequence[sympy.Expr]]) -> _Results:
    """The entries that are not structurally zero."""
    places = [(i, j) for i, row in enumerate(rows) for j, entry in enumerate(row) if entry != 0]
    return _Results([rows[i][j] for i, j in places], tuple(i for i, _ in places), tuple(j for _, j in places))


def _full(rows: Sequence[Sequence[sympy.Expr]]) -> _Results:
    """All entries, row by row."""
    places = [(i, j) for i, row in enumerate(rows) for j in range(len(row))]
    return _Results(
        [e for row in rows for e in row], tuple(i for i, _ in places), tuple(j for _, j in places)
    )


class CompiledEquations:
    """The functions of a system, derived and compiled when first asked for, or taken from disk.

    Several threads may ask at once: they wait for each other, as all functions grow on one program.

    Parameters
    ----------
    source
        A system as it is now; what is added to it later does not count. Or equations that are derived.
    """

    def __init__(self, source: System | EquationsOfMotion) -> None:
        self._lock = RLock()
        self._equations = source if isinstance(source, EquationsOfMotion) else None
        self.system = source.system if isinstance(source, EquationsOfMotion) else source.snapshot()
        self._jacobians: dict[tuple[str, ...], CompiledFunction] = {}

    def __getstate__(self) -> dict[str, object]:
        """The system and the functions that are there.

        The equations are derived again where they are needed, and the identity holds on this machine only.
        """
        left_out = ("_equations", "_identity", "_lock")
        return {name: value for name, value in vars(self).copy().items() if name not in left_out}

    def __setstate__(self, state: Mapping[str, object]) -> None:
        vars(self).update(state, _equations=None, _lock=RLock())

    @property
    def equations(self) -> EquationsOfMotion:
        """The equations of motion."""
        with self._lock:
            if self._equations is None:
                self._equations = derive(self.system)
            return self._equations

    @property
    def argument_count(self) -> int:
        """Number of coordinates, rates, accelerations, inputs and input rates together."""
        return 3 * len(self.system.coordinates) + 2 * len(self.system.inputs)

    @cached_property
    def residual(self) -> CompiledFunction:
        """M q'' + h - Q, length n."""
        return self._function("residual", lambda e: _vector(e.residual))

    @cached_property
    def residual_jacobian(self) -> CompiledFunction:
        """Derivatives of the residual by coordinates, rates and accelerations, shape (n, 3 n)."""
        return self._function("residual_jacobian", lambda e: _matrix(e.residual_jacobian))

    @cached_property
    def preload_action(self) -> CompiledFunction:
        """Derivatives of the residual by the preloads, shape (n, preloads)."""
        return self._function("preload_action", lambda e: _matrix(e.preload_action))

    @cached_property
    def accelerations(self) -> CompiledFunction:
        """q'' from coordinates, rates, inputs and input rates, length n."""
        return self._function("accelerations", lambda e: _vector(e.accelerations))

    @cached_property
    def right_hand_side(self) -> CompiledFunction:
        """Rates of the state from `EquationsOfMotion.state_arguments`, one sample at a time, length 2 n."""
        return self._of_one_state("right_hand_side", lambda e: _vector(e.right_hand_side))

    @cached_property
    def right_hand_side_jacobian(self) -> CompiledFunction:
        """Derivatives of the right-hand side by the state, of the same arguments, row by row, zeros too."""
        return self._of_one_state("right_hand_side_jacobian", lambda e: _full(e.right_hand_side_jacobian))

    @cached_property
    def state_knot_distances(self) -> CompiledFunction:
        """The knot distances, of the same arguments, one sample at a time."""
        return self._of_one_state("state_knot_distances", lambda e: _vector(e.knot_distances))

    @cached_property
    def held_right_hand_side(self) -> CompiledFunction:
        """The right-hand side with every law held on one side of its knots, one sample at a time.

        Its arguments are those of the right-hand side and then `EquationsOfMotion.sides`.
        """
        return self._function(
            "held_right_hand_side",
            lambda e: _vector(e.held_right_hand_side),
            lambda e: (*e.state_arguments, *e.sides),
            lanes=1,
        )

    def _of_one_state(self, name: str, choose: Callable[[EquationsOfMotion], _Results]) -> CompiledFunction:
        return self._function(name, choose, lambda e: e.state_arguments, lanes=1)

    @cached_property
    def outputs(self) -> CompiledFunction:
        """Every output of the system."""
        return self._function("outputs", lambda e: _vector(list(e.outputs.values())))

    @cached_property
    def knot_distances(self) -> CompiledFunction:
        """Expressions whose change of sign along a motion makes the residual jump or bend.

        Instead of a column, each has the number of its `EquationsOfMotion.kinks`.
        """
        return self._function(
            "knot_distances",
            lambda e: _Results(e.knot_distances, tuple(range(len(e.kinks))), tuple(map(int, e.kinks))),
        )

    @cached_property
    def singularities(self) -> CompiledFunction:
        """Distance of every rotation sequence from its singularity."""
        return self._function("singularities", lambda e: _vector(list(e.singularities.values())))

    @cached_property
    def linearisation(self) -> CompiledFunction:
        """Derivatives of residual and outputs by all arguments, with stated slopes at the knots of tables."""
        return self._function("linearisation", lambda e: _matrix(e.linearisation))

    @cached_property
    def tables(self) -> CompiledFunction:
        """Knots, slopes and spacings of every table, one table after the other."""
        return self._function("tables", lambda e: _vector(e.table_numbers))

    @cached_property
    def table_variables(self) -> CompiledFunction:
        """The deflection or rate that every table is over."""
        return self._function("table_variables", lambda e: _vector(list(e.table_variables.values())))

    @cached_property
    def linearisation_change(self) -> CompiledFunction:
        """`EquationsOfMotion.linearisation_change`, of the arguments, a motion and a change.

        The arguments are followed by the amplitude of each, and then by the changes of what `change_names`
        says.
        """
        return self._function(
            "linearisation_change",
            lambda e: _vector(e.linearisation_change),
            lambda e: (*e.arguments, *e.motion.values(), *e.change.values()),
        )

    @cached_property
    def statics_change(self) -> CompiledFunction:
        """`EquationsOfMotion.statics_change`, of the arguments and a change."""
        return self._function(
            "statics_change",
            lambda e: _vector(e.statics_change),
            lambda e: (*e.arguments, *e.change.values()),
        )

    @property
    def change_names(self) -> tuple[str, ...]:
        """Arguments, parameters, preloads and slopes, in the order in which their changes are taken."""
        changes = self.statics_change.arguments[self.argument_count :]
        return tuple(name.removeprefix("_").removesuffix(".change") for name in changes)

    def jacobian(self, names: Sequence[str]) -> CompiledFunction:
        """Derivatives of residual and outputs by some arguments or parameters, shape (n + outputs, names).

        At a corner of a force law they are what `EquationsOfMotion.jacobian` says.

        Parameters
        ----------
        names
            Coordinates ("pitch"), rates ("pitch_rate"), accelerations ("pitch_acceleration"), inputs, input
            rates, parameters ("body.mass") and preloads ("tyre.preload").

        Raises
        ------
        TypeError
            If the names are one string.
        ValueError
            If the equations mention no such name.
        """
        if isinstance(names, str):
            raise TypeError(f"names: a sequence of names is needed; the string {names!r} received")
        chosen = tuple(names)
        title = "\0".join(["jacobian", *chosen])
        with self._lock:
            if chosen not in self._jacobians:
                self._jacobians[chosen] = self._function(title, lambda e: _matrix(_derivatives(e, chosen)))
            return self._jacobians[chosen]

    def _function(
        self,
        name: str,
        choose: Callable[[EquationsOfMotion], _Results],
        vary: Callable[[EquationsOfMotion], Sequence[sympy.Symbol]] = lambda e: e.arguments,
        lanes: int = LANES,
    ) -> CompiledFunction:
        """A function of results that are chosen among the equations' expressions, and of what varies."""

        def build() -> cache.Source:
            return _generate(self.equations.program, choose(self.equations), vary(self.equations), lanes)

        def compiled() -> bytes:
            return machine_code.compile_assembly(source.assembly)

        processor = machine_code.processor()
        with self._lock:
            if self._identity is None:
                source = build()
                code = compiled()
            else:
                source = cache.fetch_source(cache.key([name, self._identity]), build)
                code = cache.fetch_object_code(source, processor, compiled)
        return CompiledFunction(cache.Entry(source, processor, code))

    @cached_property
    def _identity(self) -> str | None:
        """The system's structure, and the versions and sources of what makes code of it.

        None if a force law cannot be described, or a class has no source to be read, as one typed at a
        prompt: its code then goes to no disk.
        """
        folder = Path(__file__).parent
        try:
            described, classes = describe(self.system)
            compiling, deriving = folder.glob("*.py"), folder.parent.glob("*.py")
            modules = {Path(inspect.getfile(c)) for c in classes} | {*compiling, *deriving}
            sources = [path.read_text(encoding="utf-8") for path in sorted(modules)]
            return "\0".join([described, sympy.__version__, np.__version__, *sources])
        except (OSError, TypeError, ValueError):
            return None


def _derivatives(equations: EquationsOfMotion, names: Sequence[str]) -> list[list[sympy.Expr]]:
    """Derivatives of residual and outputs by names, shape (n + outputs, names)."""
    symbols = {symbol.name: symbol for symbol in (*equations.arguments, *equations.parameters)}
    for name in names:
        if name not in symbols:
            near = ", ".join(difflib.get_close_matches(name, symbols, cutoff=0))
            raise ValueError(f"names: {name!r} is no argument or parameter of the equations; near: {near}")
    return equations.jacobian([symbols[name] for name in names])


def _generate(
    program: Program, results: _Results, varying_symbols: Sequence[sympy.Symbol], lanes: int
) -> cache.Source:
    """Assembly of expressions: what depends on parameters alone is evaluated once for each parameter set."""
    arguments = {symbol: row for row, symbol in enumerate(varying_symbols)}
    fixed, varying = _separate(program, results.entries, arguments)
    used = _free_symbols([*varying.values(), *results.entries]) - set(arguments) - set(varying)
    constants = {symbol: row for row, symbol in enumerate(sorted(used, key=lambda s: s.name))}
    needed = program.required(list(constants))
    names = sorted(
        _free_symbols([*needed.values(), *constants]) - set(program.definitions), key=lambda s: s.name
    )
    rows = {symbol: row for row, symbol in enumerate(names)}
    prologue = Kernel("constants", rows, {}, {s: fixed[s] for s in needed}, list(constants), by_pass=True)
    kernel = Kernel("kernel", arguments, constants, varying, results.entries)
    packed = cache.pack(assembly([prologue, kernel], lanes))
    parameters = tuple(symbol.name for symbol in names)
    taken = tuple(symbol.name for symbol in arguments)
    return cache.Source(taken, parameters, len(constants), results.rows, results.columns, packed, lanes)


def _separate(
    program: Program, results: Sequence[sympy.Expr], arguments: Mapping[sympy.Symbol, int]
) -> tuple[dict[sympy.Symbol, sympy.Expr], dict[sympy.Symbol, sympy.Expr]]:
    """The assignments that results need: those of parameters alone, and those that vary along a motion."""
    fixed: dict[sympy.Symbol, sympy.Expr] = {}
    varying: dict[sympy.Symbol, sympy.Expr] = {}
    for symbol, expression in program.required(results).items():
        depends = any(s in arguments or s in varying for s in expression.free_symbols)
        (varying if depends else fixed)[symbol] = expression
    return fixed, varying


def _free_symbols(expressions: Sequence[sympy.Expr]) -> set[sympy.Symbol]:
    return set().union(*(sympy.sympify(e).free_symbols for e in expressions))
