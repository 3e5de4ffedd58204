"""A function in machine code: carried from process to process, given its parameters, called with arrays."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from chassym.derivation.compilation import cache, machine_code
from chassym.derivation.compilation.instructions import LANES

Array = np.ndarray
_Address = Callable[[int, int, int, int, int], None]
_SIGNATURE = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64
)


@dataclass(frozen=True, eq=False)
class CompiledFunction:
    """A function of the equations' arguments in machine code, for any parameter values.

    It can be pickled; on another processor it is compiled again, from the source that it carries.

    Attributes
    ----------
    arguments
        Number of arguments.
    entry
        Its source and machine code.
    """

    arguments: int
    entry: cache.Entry = field(repr=False)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters it depends on."""
        return self.entry.source.parameters

    @cached_property
    def rows(self) -> Array:
        """Row of every result in the matrix it stands for."""
        return np.array(self.entry.source.rows, dtype=int)

    @cached_property
    def columns(self) -> Array:
        """Column of every result in the matrix it stands for; a vector has the columns zero."""
        return np.array(self.entry.source.columns, dtype=int)

    def __reduce__(self) -> tuple[type[CompiledFunction], tuple[int, cache.Entry]]:
        return CompiledFunction, (self.arguments, self.entry)

    @cached_property
    def _linked(self) -> machine_code.Linked:
        return machine_code.link(self._object_code(), ("constants", "kernel"), f"function_{id(self)}")

    def _object_code(self) -> bytes:
        source = self.entry.source
        if self.entry.processor == machine_code.processor():
            return self.entry.object_code
        return cache.fetch_object_code(
            source, machine_code.processor(), lambda: machine_code.compile_assembly(source.assembly)
        )

    @cached_property
    def _prologue(self) -> _Address:
        return _SIGNATURE(self._linked.addresses["constants"])

    @cached_property
    def _kernel(self) -> _Address:
        return _SIGNATURE(self._linked.addresses["kernel"])

    def bind(self, values: Mapping[str, float]) -> BoundFunction:
        """The function for given parameter values.

        Raises
        ------
        KeyError
            If a parameter has no value.
        """
        given = np.array([values[name] for name in self.parameters], dtype=float)
        repeated = np.ascontiguousarray(np.broadcast_to(given[:, None], (len(given), LANES)))
        constants = np.empty((max(self.entry.source.constants, 1), LANES))
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
            Shape (results, samples). There may be no samples.

        Raises
        ------
        ValueError
            If the arguments have another shape.
        """
        if arguments.ndim != 2 or len(arguments) != self.function.arguments:
            raise ValueError(
                f"arguments: shape {arguments.shape} received; ({self.function.arguments}, samples) is needed"
            )
        count = arguments.shape[1]
        if count == 0:
            return np.empty((len(self.rows), 0))
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
