"""Equations of motion as compiled functions of arrays."""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import sympy

from chassym.derivation import cache, machine_code
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.lagrange import derive
from chassym.derivation.machine_code import LANES, Kernel
from chassym.derivation.mechanism import Mechanism
from chassym.derivation.program import Program
from chassym.derivation.structure import describe

Array = np.ndarray
_SIGNATURE = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64
)


@dataclass(frozen=True)
class CompiledFunction:
    """A function of the equations' arguments in machine code, for any parameter values.

    Attributes
    ----------
    arguments
        Number of arguments.
    parameters
        Names of the parameters it depends on.
    rows, columns
        Position of every result in the matrix it stands for; a vector has the columns zero.
    """

    arguments: int
    parameters: tuple[str, ...]
    rows: Array
    columns: Array
    _constants: int
    _prologue: Callable[[int, int, int, int, int], None]
    _kernel: Callable[[int, int, int, int, int], None]
    _owner: machine_code.Linked

    def bind(self, values: Mapping[str, float]) -> BoundFunction:
        """The function for given parameter values.

        Raises
        ------
        KeyError
            If a parameter has no value.
        """
        given = np.array([values[name] for name in self.parameters], dtype=float)
        repeated = np.ascontiguousarray(np.broadcast_to(given[:, None], (len(given), LANES)))
        constants = np.empty((max(self._constants, 1), LANES))
        self._prologue(repeated.ctypes.data, 0, constants.ctypes.data, LANES, LANES)
        return BoundFunction(self, np.ascontiguousarray(constants[:, 0]))


class BoundFunction:
    """A compiled function with its parameter values."""

    def __init__(self, function: CompiledFunction, constants: Array) -> None:
        self.function = function
        self._constants = constants

    @property
    def rows(self) -> Array:
        """Row of every result in the matrix it stands for."""
        return self.function.rows

    @property
    def columns(self) -> Array:
        """Column of every result in the matrix it stands for."""
        return self.function.columns

    def __call__(self, arguments: Array) -> Array:
        """Evaluate for many samples.

        Parameters
        ----------
        arguments
            Coordinates, rates, accelerations, inputs and input rates, shape (arguments, samples).

        Returns
        -------
        numpy.ndarray
            Shape (results, samples).

        Raises
        ------
        ValueError
            If the arguments have another shape.
        """
        if arguments.ndim != 2 or len(arguments) != self.function.arguments or not arguments.size:
            raise ValueError(
                f"arguments: shape {arguments.shape} received; ({self.function.arguments}, samples) is needed"
            )
        count = arguments.shape[1]
        filled = -(-count // LANES) * LANES
        # An odd number of lane groups per row keeps rows from falling on the same cache lines.
        stride = filled + LANES * (1 - filled // LANES % 2)
        padded = np.empty((len(arguments), stride))
        padded[:, :count] = arguments
        padded[:, count:] = arguments[:, -1:]
        results = np.empty((len(self.rows), stride))
        self.function._kernel(
            padded.ctypes.data, self._constants.ctypes.data, results.ctypes.data, filled, stride
        )
        return results[:, :count]

    def single(self) -> Callable[[Array], Array]:
        """A function of one sample, shape (arguments,), that reuses its buffers: for inner loops."""
        arguments = np.zeros((self.function.arguments, LANES))
        results = np.zeros((len(self.rows), LANES))
        addresses = arguments.ctypes.data, self._constants.ctypes.data, results.ctypes.data
        kernel, keep = self.function._kernel, (self._constants, self.function)

        def evaluate(sample: Array) -> Array:
            arguments[:] = sample[:, None]
            kernel(*addresses, LANES, LANES)
            return results[:, 0].copy()

        evaluate.owners = keep  # type: ignore[attr-defined]
        return evaluate

    def matrix(self, arguments: Array, shape: tuple[int, int]) -> Array:
        """Evaluate for one sample, shape (arguments,), and put the results in their places."""
        full = np.zeros(shape)
        full[self.rows, self.columns] = self(arguments[:, None])[:, 0]
        return full


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


class CompiledEquations:
    """The functions of a mechanism, derived and compiled when first asked for, or taken from disk."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    @cached_property
    def equations(self) -> EquationsOfMotion:
        """The equations of motion."""
        return derive(self.mechanism)

    @cached_property
    def residual(self) -> CompiledFunction:
        """M q'' + h - Q, length n."""
        return self._function("residual", lambda e: _vector(e.residual))

    @cached_property
    def residual_jacobian(self) -> CompiledFunction:
        """Derivatives of the residual by coordinates, rates and accelerations, shape (n, 3 n)."""
        return self._function("residual_jacobian", lambda e: _matrix(e.residual_jacobian))

    @cached_property
    def accelerations(self) -> CompiledFunction:
        """q'' from coordinates, rates, inputs and input rates, length n."""
        return self._function("accelerations", lambda e: _vector(e.accelerations))

    @cached_property
    def outputs(self) -> CompiledFunction:
        """Every output of the mechanism."""
        return self._function("outputs", lambda e: _vector(list(e.outputs.values())))

    @cached_property
    def knot_distances(self) -> CompiledFunction:
        """Distance of the rates of tables from their knots."""
        return self._function("knot_distances", lambda e: _vector(e.knot_distances))

    @cached_property
    def linearisation(self) -> CompiledFunction:
        """Derivatives of residual and outputs by all arguments, with stated slopes at the knots of tables."""
        return self._function("linearisation", lambda e: _matrix(e.linearisation))

    def _function(self, name: str, choose: Callable[[EquationsOfMotion], _Results]) -> CompiledFunction:
        def build() -> cache.Entry:
            return _build(self.equations, choose(self.equations))

        identity = self._identity
        entry = build() if identity is None else cache.fetch(cache.key([name, identity]), build)
        linked = machine_code.link(entry.object_code, ("constants", "kernel"), f"{name}_{id(self)}")
        return CompiledFunction(
            3 * len(self.mechanism.coordinates) + 2 * len(self.mechanism.inputs),
            entry.parameters,
            np.array(entry.rows, dtype=int),
            np.array(entry.columns, dtype=int),
            entry.constants,
            _SIGNATURE(linked.addresses["constants"]),
            _SIGNATURE(linked.addresses["kernel"]),
            linked,
        )

    @cached_property
    def _identity(self) -> str | None:
        """The mechanism's structure, and the versions and sources of what makes code of it.

        None if a class has no source to be read, as one typed at a prompt: its code then goes to no disk.
        """
        described, classes = describe(self.mechanism)
        try:
            modules = {Path(inspect.getfile(c)) for c in classes} | set(Path(__file__).parent.glob("*.py"))
            sources = [path.read_text(encoding="utf-8") for path in sorted(modules)]
        except (OSError, TypeError):
            return None
        return "\0".join([described, sympy.__version__, np.__version__, machine_code.processor(), *sources])


def _build(equations: EquationsOfMotion, results: _Results) -> cache.Entry:
    """Compile expressions: what depends on parameters alone is evaluated once for each parameter set."""
    program = equations.program
    arguments = {symbol: row for row, symbol in enumerate(equations.arguments)}
    fixed, varying = _separate(program, results.entries, arguments)
    used = _free_symbols([*varying.values(), *results.entries]) - set(arguments) - set(varying)
    constants = {symbol: row for row, symbol in enumerate(sorted(used, key=lambda s: s.name))}
    needed = program.required(list(constants))
    names = sorted(
        _free_symbols([*needed.values(), *constants]) - set(program.definitions), key=lambda s: s.name
    )
    rows = {symbol: row for row, symbol in enumerate(names)}
    prologue = Kernel("constants", rows, {}, {s: fixed[s] for s in needed}, list(constants))
    kernel = Kernel("kernel", arguments, constants, varying, results.entries)
    code = machine_code.compile_assembly(machine_code.assembly([prologue, kernel]))
    return cache.Entry(tuple(s.name for s in names), len(constants), results.rows, results.columns, code)


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
