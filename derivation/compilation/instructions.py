"""LLVM instructions on vectors of samples, written out as text.

Every instruction works on `LANES` samples at once, so that a batch of samples runs on the processor's vector
units.
"""

from __future__ import annotations

import struct

LANES = 8
"""Samples that one pass of a kernel evaluates together, but in kernels of one sample."""


def vector_type(lanes: int) -> str:
    """Type of a quantity: its value in every sample of a pass."""
    return f"<{lanes} x double>"


def vector_bytes(lanes: int) -> int:
    """Size of a quantity, to whose multiples scratch memory is aligned."""
    return 8 * lanes


def _bits(number: float) -> int:
    return int(struct.unpack("<Q", struct.pack("<d", number))[0])


def lane_by_lane(name: str, count: int, lanes: int) -> str:
    """A function of vectors that calls a function of C's mathematical library for each lane."""
    inputs, vector = "abc"[:count], vector_type(lanes)
    lines = [
        f"declare double @{name}({', '.join(['double'] * count)}) nounwind willreturn readnone",
        f"define internal {vector} @lanes_{name}({', '.join(f'{vector} %{i}' for i in inputs)}) {{",
    ]
    previous = "poison"
    for lane in range(lanes):
        lines += [f"  %{i}{lane} = extractelement {vector} %{i}, i64 {lane}" for i in inputs]
        listed = ", ".join(f"double %{i}{lane}" for i in inputs)
        lines.append(f"  %called{lane} = call double @{name}({listed})")
        lines.append(f"  %v{lane} = insertelement {vector} {previous}, double %called{lane}, i64 {lane}")
        previous = f"%v{lane}"
    return "\n".join([*lines, f"  ret {vector} {previous}", "}"])


class Instructions:
    """Instructions in the making; every method writes one operation and gives the name of its result.

    Addresses are those of a kernel: %x inputs and %y results, in rows that are %stride apart, and %i the
    first sample of the pass; %c the constants of the pass, lane beside lane; %s is scratch memory, in which
    parts of a kernel leave values for later ones.

    Examples
    --------
    >>> code = Instructions()
    >>> code.binary("fadd", "%a", "%b")
    '%v0'
    >>> code.lines
    ['  %v0 = fadd contract <8 x double> %a, %b']
    """

    def __init__(self, lanes: int = LANES) -> None:
        self.lines: list[str] = []
        self.lanes = lanes
        self.vector = vector_type(lanes)
        self._boolean = f"<{lanes} x i1>"
        self._count = 0

    def splat(self, number: float) -> str:
        """A constant in every lane, written bit by bit so that no digit is lost."""
        bits = f"double 0x{_bits(number):016X}"
        return "<" + ", ".join([bits] * self.lanes) + ">"

    def splat_truth(self, truth: bool) -> str:
        """A truth value in every lane."""
        return "<" + ", ".join([f"i1 {str(truth).lower()}"] * self.lanes) + ">"

    def new(self, instruction: str) -> str:
        """Write any instruction."""
        name = f"%v{self._count}"
        self._count += 1
        self.lines.append(f"  {name} = {instruction}")
        return name

    def load(self, row: int) -> str:
        """A row of the inputs."""
        offset = self.new(f"mul i64 %stride, {row}")
        place = self.new(f"add i64 {offset}, %i")
        address = self.new(f"getelementptr double, ptr %x, i64 {place}")
        return self.new(f"load {self.vector}, ptr {address}, align 8")

    def load_constant(self, row: int) -> str:
        """A constant, of every lane's own parameter set."""
        address = self.new(f"getelementptr {self.vector}, ptr %c, i64 {row}")
        return self.new(f"load {self.vector}, ptr {address}, align 8")

    def store(self, row: int, value: str) -> None:
        """Put a value into a row of the results."""
        offset = self.new(f"mul i64 %stride, {row}")
        place = self.new(f"add i64 {offset}, %i")
        address = self.new(f"getelementptr double, ptr %y, i64 {place}")
        self.lines.append(f"  store {self.vector} {value}, ptr {address}, align 8")

    def store_by_pass(self, row: int, rows: int, value: str) -> None:
        """Put a value into the results of the pass, of which there are so many rows."""
        first = self.new(f"mul i64 %i, {rows}")
        place = self.new(f"add i64 {first}, {row * self.lanes}")
        address = self.new(f"getelementptr double, ptr %y, i64 {place}")
        self.lines.append(f"  store {self.vector} {value}, ptr {address}, align 8")

    def keep(self, place: int, value: str) -> None:
        """Put a value into scratch memory."""
        address = self.new(f"getelementptr {self.vector}, ptr %s, i64 {place}")
        self.lines.append(f"  store {self.vector} {value}, ptr {address}, align {vector_bytes(self.lanes)}")

    def recall(self, place: int) -> str:
        """A value from scratch memory."""
        address = self.new(f"getelementptr {self.vector}, ptr %s, i64 {place}")
        return self.new(f"load {self.vector}, ptr {address}, align {vector_bytes(self.lanes)}")

    def binary(self, operation: str, left: str, right: str) -> str:
        """Arithmetic on two operands."""
        return self.new(f"{operation} contract {self.vector} {left}, {right}")

    def compare(self, predicate: str, left: str, right: str) -> str:
        """The truth of a comparison."""
        return self.new(f"fcmp {predicate} {self.vector} {left}, {right}")

    def select(self, condition: str, one: str, other: str) -> str:
        """One operand where a condition holds, the other where it does not."""
        return self.new(f"select {self._boolean} {condition}, {self.vector} {one}, {self.vector} {other}")

    def select_truth(self, condition: str, one: str, other: str) -> str:
        """One truth value where a condition holds, the other where it does not."""
        return self.new(f"select {self._boolean} {condition}, {self._boolean} {one}, {self._boolean} {other}")

    def logic(self, operation: str, left: str, right: str) -> str:
        """Logic of two truth values."""
        return self.new(f"{operation} {self._boolean} {left}, {right}")
