"""A function in machine code: carried from process to process, given its parameters, called with arrays."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from chassym.derivation.compilation import cache, machine_code

Array = np.ndarray
_Address = Callable[[int, int, int, int, int, int], None]
_SIGNATURE = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64, ctypes.c_int64
)


@dataclass(frozen=True, eq=False)
class CompiledFunction:
    """A function of the equations' arguments in machine code, for any parameter values.

    It can be pickled; on another processor it is compiled again, from the source that it carries.

    Attributes
    ----------
    entry
        Its source and machine code.
    """

    entry: cache.Entry = field(repr=False)

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of its arguments: the coordinates, rates, accelerations, inputs and input rates, mostly."""
        return self.entry.source.arguments

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

    def __reduce__(self) -> tuple[type[CompiledFunction], tuple[cache.Entry]]:
        return CompiledFunction, (self.entry,)

    @property
    def lanes(self) -> int:
        """Samples that one pass evaluates together."""
        return self.entry.source.lanes

    @cached_property
    def _linked(self) -> machine_code.Linked:
        names = ("constants", "kernel", *(("kernel_of_one", "kernel_of_block") if self.lanes == 1 else ()))
        return machine_code.link(self._object_code(), names, f"function_{id(self)}")

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

    @property
    def address(self) -> int:
        """Address of the machine code of one sample, see `PointFunction`.

        Raises
        ------
        AttributeError
            If the function evaluates several samples together.
        """
        return self._address_of_one("kernel_of_one")

    @property
    def block_address(self) -> int:
        """Address of the same, of one argument: where the three addresses stand one after the other."""
        return self._address_of_one("kernel_of_block")

    def _address_of_one(self, name: str) -> int:
        if self.lanes != 1:
            raise AttributeError(f"address: the function evaluates {self.lanes} samples together, not one")
        return self._linked.addresses[name]

    def bind(self, values: Mapping[str, float]) -> BoundFunction:
        """The function for given parameter values.

        Raises
        ------
        KeyError
            If a parameter has no value.
        """
        return BoundFunction(self, self.constants(values, 1))

    def of_variants(self, values: Mapping[str, Array | float], arguments: Array) -> Array:
        """Evaluate each sample for parameter values of its own.

        Parameters
        ----------
        values
            By name, for every parameter: a number, or an array of shape (samples,).
        arguments
            As for `BoundFunction`, shape (arguments, samples).

        Returns
        -------
        numpy.ndarray
            Shape (results, samples).

        Raises
        ------
        KeyError
            If a parameter has no value.
        ValueError
            If the arguments or a parameter have another shape.
        """
        constants = self.constants(values, arguments.shape[1])
        return self.evaluate(arguments, constants, constants.shape[1])

    def constants(self, values: Mapping[str, Array | float], sets: int) -> Array:
        """Constants of parameter sets as passes take them, shape (passes, rows, lanes).

        One set fills all lanes of a pass.
        """
        given = np.empty((len(self.parameters), self._width(sets)))
        for row, name in zip(given, self.parameters, strict=True):
            row[:sets] = values[name]
            row[sets:] = row[sets - 1]
        constants = np.empty((given.shape[1] // self.lanes, self.entry.source.constants, self.lanes))
        self._prologue(given.ctypes.data, 0, constants.ctypes.data, given.shape[1], given.shape[1], 0)
        return constants

    def evaluate(self, arguments: Array, constants: Array, step: int) -> Array:
        """Results for samples, shape (results, samples), whose passes go on by so many constants."""
        if arguments.ndim != 2 or len(arguments) != len(self.arguments):
            raise ValueError(
                f"arguments: shape {arguments.shape} received; ({len(self.arguments)}, samples) is needed"
            )
        count = arguments.shape[1]
        if count == 0:
            return np.empty((len(self.rows), 0))
        padded = np.empty((len(arguments), self._width(count)))
        padded[:, :count] = arguments
        padded[:, count:] = arguments[:, -1:]
        results = np.empty((len(self.rows), padded.shape[1]))
        filled = -(-count // self.lanes) * self.lanes
        addresses = padded.ctypes.data, constants.ctypes.data, results.ctypes.data
        self._kernel(*addresses, filled, padded.shape[1], step)
        return results[:, :count]

    def _width(self, samples: int) -> int:
        """Columns for whole passes.

        An odd number of lane groups per row keeps rows from falling on the same cache lines.
        """
        return self.lanes * (-(-samples // self.lanes) | 1)


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
        return self.function.evaluate(arguments, self._constants, 0)

    def single(self) -> Callable[[Array], Array]:
        """A function of one sample, shape (arguments,), that reuses its buffers: for inner loops."""
        lanes = self.function.lanes
        arguments = np.zeros((len(self.function.arguments), lanes))
        results = np.zeros((len(self.rows), lanes))
        addresses = arguments.ctypes.data, self._constants.ctypes.data, results.ctypes.data
        kernel, keep = self.function._kernel, (self._constants, self.function)

        def evaluate(sample: Array) -> Array:
            arguments[:] = sample[:, None]
            kernel(*addresses, lanes, lanes, 0)
            return results[:, 0].copy()

        evaluate.owners = keep  # type: ignore[attr-defined]
        return evaluate

    def matrix(self, arguments: Array, shape: tuple[int, int]) -> Array:
        """Evaluate for one sample, shape (arguments,), and put the results in their places."""
        full = np.zeros(shape)
        full[self.rows, self.columns] = self(arguments[:, None])[:, 0]
        return full
