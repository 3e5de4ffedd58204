"""Straight-line programs as machine code: LLVM assembly written out, compiled and linked by llvmlite.

Every statement works on `LANES` samples at once, so that a batch of samples runs on the processor's vector
units.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import llvmlite.binding as llvm
import sympy

LANES = 8
"""Samples that one pass of a kernel evaluates together."""


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
    """

    name: str
    arguments: Mapping[sympy.Symbol, int]
    constants: Mapping[sympy.Symbol, int]
    definitions: Mapping[sympy.Symbol, sympy.Expr]
    results: Sequence[sympy.Expr]


class UnsupportedExpressionError(NotImplementedError):
    """A sympy function that has no machine code."""


def assembly(kernels: Sequence[Kernel]) -> str:
    """LLVM assembly of several kernels, as one module.

    Every function takes the addresses of its inputs, constants and results, the number of samples (a multiple
    of `LANES`) and the distance between rows of the inputs and results, both in numbers of float64.

    Raises
    ------
    UnsupportedExpressionError
        If an expression contains a function without machine code.
    """
    return "\n".join([*_DECLARATIONS, *(_function(kernel) for kernel in kernels)])


def compile_assembly(text: str) -> bytes:
    """Object code of an LLVM module for the processor of this machine."""
    module = llvm.parse_assembly(text)
    machine = _target_machine()
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


def link(object_code: bytes, names: Sequence[str], identity: str) -> Linked:
    """Load object code into this process; `identity` tells apart the libraries of one process."""
    library = llvm.JITLibraryBuilder().add_object_img(object_code).add_current_process()
    for name in names:
        library.export_symbol(name)
    jit = llvm.create_lljit_compiler(_target_machine())
    tracker = library.link(jit, identity)
    return Linked({name: tracker[name] for name in names}, (jit, tracker))


@dataclass(frozen=True)
class Linked:
    """Addresses of functions, and what keeps them in memory."""

    addresses: Mapping[str, int]
    owners: tuple[object, ...]


@cache
def _target_machine() -> llvm.TargetMachine:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    features = llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=2, jit=True)


def processor() -> str:
    """What object code depends on besides its source: LLVM's version, the processor and its features."""
    features = llvm.get_host_cpu_features().flatten()
    return f"{llvm.llvm_version_info} {llvm.get_process_triple()} {llvm.get_host_cpu_name()} {features}"


_VECTOR = f"<{LANES} x double>"
_PARAMETERS = "ptr noalias %x, ptr noalias %c, ptr noalias %y, i64 %count, i64 %stride"
_BOOLEAN = f"<{LANES} x i1>"
_UNARY = {"sin": "sin", "cos": "cos", "exp": "exp", "log": "log", "Abs": "fabs", "sqrt": "sqrt"}
_DECLARATIONS = [
    *(f"declare {_VECTOR} @llvm.{name}.v{LANES}f64({_VECTOR})" for name in _UNARY.values()),
    *(f"declare {_VECTOR} @llvm.{name}.v{LANES}f64({_VECTOR}, {_VECTOR})" for name in ("maxnum", "minnum")),
]


def _splat(number: float) -> str:
    """A constant in every lane, written bit by bit so that no digit is lost."""
    bits = f"double 0x{_bits(number):016X}"
    return "<" + ", ".join([bits] * LANES) + ">"


def _bits(number: float) -> int:
    return int(struct.unpack("<Q", struct.pack("<d", number))[0])


def _function(kernel: Kernel) -> str:
    body = _Body(kernel)
    for symbol, expression in kernel.definitions.items():
        body.values[symbol] = body.operand(expression)
    stores = [
        body.store(row, body.operand(sympy.sympify(result))) for row, result in enumerate(kernel.results)
    ]
    return "\n".join(
        [
            f"define void @{kernel.name}({_PARAMETERS}) {{",
            "entry:",
            *body.prologue,
            "  br label %loop",
            "loop:",
            "  %i = phi i64 [ 0, %entry ], [ %next, %loop ]",
            *body.lines,
            *(line for lines in stores for line in lines),
            f"  %next = add i64 %i, {LANES}",
            "  %more = icmp slt i64 %next, %count",
            "  br i1 %more, label %loop, label %done",
            "done:",
            "  ret void",
            "}",
            "",
        ]
    )


class _Body:
    """The statements of one kernel in the making."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.values: dict[sympy.Symbol, str] = {}
        self.prologue: list[str] = []
        self.lines: list[str] = []
        self._count = 0

    def _new(self, instruction: str) -> str:
        name = f"%v{self._count}"
        self._count += 1
        self.lines.append(f"  {name} = {instruction}")
        return name

    def operand(self, expression: sympy.Expr) -> str:
        """The name, or literal, that holds an expression's value."""
        if expression.is_Symbol:
            return self._symbol(expression)
        if expression.is_number:
            return _splat(float(expression))
        method = self._methods.get(type(expression).__name__)
        if method is None:
            raise UnsupportedExpressionError(
                f"{type(expression).__name__} in {expression} has no machine code; "
                f"use sums, products, powers and {', '.join(sorted(self._methods))}"
            )
        return method(self, expression)

    def _symbol(self, symbol: sympy.Symbol) -> str:
        if symbol not in self.values:
            load = self._load_argument if symbol in self.kernel.arguments else self._load_constant
            self.values[symbol] = load(symbol)
        return self.values[symbol]

    def _load_argument(self, symbol: sympy.Symbol) -> str:
        row = self._new(f"mul i64 %stride, {self.kernel.arguments[symbol]}")
        place = self._new(f"add i64 {row}, %i")
        address = self._new(f"getelementptr double, ptr %x, i64 {place}")
        return self._new(f"load {_VECTOR}, ptr {address}, align 8")

    def _load_constant(self, symbol: sympy.Symbol) -> str:
        address = self._new(f"getelementptr double, ptr %c, i64 {self.kernel.constants[symbol]}")
        scalar = self._new(f"load double, ptr {address}, align 8")
        first = self._new(f"insertelement {_VECTOR} poison, double {scalar}, i64 0")
        mask = f"<{LANES} x i32> zeroinitializer"
        return self._new(f"shufflevector {_VECTOR} {first}, {_VECTOR} poison, {mask}")

    def store(self, row: int, value: str) -> list[str]:
        """Instructions that put a value into a row of the results."""
        start = len(self.lines)
        offset = self._new(f"mul i64 %stride, {row}")
        place = self._new(f"add i64 {offset}, %i")
        address = self._new(f"getelementptr double, ptr %y, i64 {place}")
        self.lines.append(f"  store {_VECTOR} {value}, ptr {address}, align 8")
        stores, self.lines = self.lines[start:], self.lines[:start]
        return stores

    def _binary(self, operation: str, left: str, right: str) -> str:
        return self._new(f"{operation} contract {_VECTOR} {left}, {right}")

    def _call(self, function: str, *operands: str) -> str:
        listed = ", ".join(f"{_VECTOR} {operand}" for operand in operands)
        return self._new(f"call {_VECTOR} @llvm.{function}.v{LANES}f64({listed})")

    def _add(self, expression: sympy.Expr) -> str:
        positive = [term for term in expression.args if not _is_negative(term)]
        negative = [-term for term in expression.args if _is_negative(term)]
        total = self.operand(positive[0]) if positive else _splat(0.0)
        for term in positive[1:]:
            total = self._binary("fadd", total, self.operand(term))
        for term in negative:
            total = self._binary("fsub", total, self.operand(term))
        return total

    def _mul(self, expression: sympy.Expr) -> str:
        if _is_negative(expression) and expression.args[0] == -1:
            return self._binary("fsub", _splat(0.0), self.operand(-expression))
        over = [f for f in expression.args if not (f.is_Pow and f.exp.is_negative)]
        under = [1 / f for f in expression.args if f.is_Pow and f.exp.is_negative]
        product = self._product(over)
        return self._binary("fdiv", product, self._product(under)) if under else product

    def _product(self, factors: Sequence[sympy.Expr]) -> str:
        if not factors:
            return _splat(1.0)
        product = self.operand(factors[0])
        for factor in factors[1:]:
            product = self._binary("fmul", product, self.operand(factor))
        return product

    def _pow(self, expression: sympy.Expr) -> str:
        base, exponent = expression.args
        if exponent.is_negative:
            return self._binary("fdiv", _splat(1.0), self.operand(base**-exponent))
        if exponent == sympy.Rational(1, 2):
            return self._call("sqrt", self.operand(base))
        if not exponent.is_Integer:
            raise UnsupportedExpressionError(
                f"the power {expression} has no machine code; use integers or 1/2"
            )
        factor = self.operand(base)
        product = factor
        for _ in range(int(exponent) - 1):
            product = self._binary("fmul", product, factor)
        return product

    def _unary(self, expression: sympy.Expr) -> str:
        return self._call(_UNARY[type(expression).__name__], self.operand(expression.args[0]))

    def _extremum(self, expression: sympy.Expr) -> str:
        function = {"Max": "maxnum", "Min": "minnum"}[type(expression).__name__]
        first, *others = (self.operand(argument) for argument in expression.args)
        for other in others:
            first = self._call(function, first, other)
        return first

    def _heaviside(self, expression: sympy.Expr) -> str:
        """One beyond zero, zero before it, one half at it: the mean of the slopes at a knot."""
        argument = self.operand(expression.args[0])
        above = self._new(f"fcmp ogt {_VECTOR} {argument}, {_splat(0.0)}")
        below = self._new(f"fcmp olt {_VECTOR} {argument}, {_splat(0.0)}")
        lower = self._new(f"select {_BOOLEAN} {below}, {_VECTOR} {_splat(0.0)}, {_VECTOR} {_splat(0.5)}")
        return self._new(f"select {_BOOLEAN} {above}, {_VECTOR} {_splat(1.0)}, {_VECTOR} {lower}")

    def _sign(self, expression: sympy.Expr) -> str:
        """Twice the step less one: zero at zero."""
        step = self._heaviside(expression)
        return self._binary("fsub", self._binary("fadd", step, step), _splat(1.0))

    _methods: Mapping[str, Callable[[_Body, sympy.Expr], str]] = {
        "Add": _add,
        "Mul": _mul,
        "Pow": _pow,
        "Max": _extremum,
        "Min": _extremum,
        "Heaviside": _heaviside,
        "sign": _sign,
        **dict.fromkeys(("sin", "cos", "exp", "log", "Abs"), _unary),
    }


def _is_negative(term: sympy.Expr) -> bool:
    return bool(term.as_coeff_Mul()[0].is_negative)
