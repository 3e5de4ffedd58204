"""A compiled function of one sample, without overhead: for inner and compiled loops and other languages."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from functools import cached_property, partial

import numpy as np

from chassym.derivation.compilation.compiled_function import CompiledFunction

Array = np.ndarray
_SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_BLOCK = ctypes.c_void_p * 3
_SIGNATURE_OF_BLOCK = ctypes.CFUNCTYPE(None)
"""Of one argument, made ready for the call beforehand: ctypes then converts nothing."""


class PointFunction:
    """A compiled function of one sample with its parameter values.

    The machine code at `address` is a C function ::

        void f(const double *arguments, const double *constants, double *results);

    of contiguous float64: arguments in the order of `arguments`, the numbers in `constants`, and room for
    `size` results. It keeps no state, allocates nothing and may run in several threads, on arrays of their
    own. `pointer` is the same for ctypes, and for loops compiled by numba, which call it with addresses,
    ``pointer(arguments.ctypes.data, constants.ctypes.data, results.ctypes.data)``. Address and constants
    hold as long as this object lives, in this process.

    Parameters
    ----------
    function
        A function whose passes evaluate one sample.
    values
        A value for every parameter, by name.

    Attributes
    ----------
    constants
        What the machine code takes of the parameters, computed once; shape (constants,).

    Raises
    ------
    KeyError
        If a parameter has no value.
    """

    def __init__(self, function: CompiledFunction, values: Mapping[str, float]) -> None:
        self.function = function
        self.constants: Array = function.constants(values, 1).ravel()

    def __getstate__(self) -> dict[str, object]:
        """Without the pointer, which holds in this process only."""
        return {"function": self.function, "constants": self.constants}

    @property
    def address(self) -> int:
        """Address of the machine code."""
        return self.function.address

    @cached_property
    def pointer(self) -> Callable[[int, int, int], None]:
        """The machine code as a function of three addresses."""
        return _SIGNATURE(self.address)

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of the arguments, in order."""
        return self.function.arguments

    @property
    def size(self) -> int:
        """Number of results."""
        return len(self.function.rows)

    def __call__(self, arguments: Array) -> Array:
        """Evaluate for one sample, shape (arguments,); results of shape (size,)."""
        given, results = np.array(arguments, dtype=float), np.empty(self.size)
        self.between(given, results)()
        return results

    def between(self, arguments: Array, results: Array) -> Callable[[], object]:
        """A function without arguments that evaluates what is in one array into another, again and again.

        Raises
        ------
        ValueError
            If an array has another shape than (arguments,) and (size,), or is not contiguous float64.
        """
        for name, array, length in (
            ("arguments", arguments, len(self.arguments)),
            ("results", results, self.size),
        ):
            if array.shape != (length,) or array.dtype != float or not array.flags.c_contiguous:
                raise ValueError(
                    f"{name}: {array.dtype} of shape {array.shape} received; contiguous float64 of shape "
                    f"({length},) is needed"
                )
        arrays = arguments, self.constants, results
        block = ctypes.byref(_BLOCK(*(array.ctypes.data for array in arrays)))
        evaluate = partial(_SIGNATURE_OF_BLOCK(self.function.block_address), block)
        evaluate.owners = (self, *arrays)  # type: ignore[attr-defined]
        return evaluate
