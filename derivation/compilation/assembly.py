"""Straight-line programs as LLVM assembly: functions with loops over the samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from chassym.derivation.compilation.expressions import LIBRARY, Body
from chassym.derivation.compilation.instructions import (
    LANES,
    lane_by_lane,
    vector_bytes,
    vector_type,
)
from chassym.derivation.compilation.parts import Kernel, Statement, divide, in_order_of_need, scratch_places


def assembly(kernels: Sequence[Kernel], lanes: int = LANES) -> str:
    """LLVM assembly of several kernels, as one module.

    Every function takes the addresses of its inputs, constants and results, the number of samples (a multiple
    of the lanes), the distance between rows of the inputs and results in numbers of float64, and how many
    constants to go on by from pass to pass: zero if all samples have the same ones. Of one lane, there are
    also functions ``.._of_one``, which takes the three addresses only, and ``.._of_block``, which takes the
    address where these stand one after the other.

    Raises
    ------
    UnsupportedExpressionError
        If an expression contains a function or a number without machine code.
    """
    functions = "\n".join(_function(kernel, lanes) for kernel in kernels)
    if lanes == 1:
        functions += "\n".join(_of_one(kernel.name) for kernel in kernels)
    library = [lane_by_lane(*item, lanes) for item in LIBRARY.items() if f"@lanes_{item[0]}(" in functions]
    return "\n".join([*_declarations(lanes), *library, functions])


_PARAMETERS = "ptr noalias %x, ptr noalias %constants, ptr noalias %y, i64 %count, i64 %stride, i64 %step"
_PART_PARAMETERS = "ptr noalias %x, ptr noalias %c, ptr noalias %y, ptr noalias %s, i64 %i, i64 %stride"
_PART_ARGUMENTS = "ptr %x, ptr %c, ptr %y, ptr %s, i64 %i, i64 %stride"
_INTRINSICS = {"sin": 1, "cos": 1, "exp": 1, "log": 1, "sqrt": 1, "fabs": 1, "pow": 2}


def _declarations(lanes: int) -> list[str]:
    vector = vector_type(lanes)
    return [
        f"declare {vector} @llvm.{name}.v{lanes}f64({', '.join([vector] * count)})"
        for name, count in _INTRINSICS.items()
    ]


def _function(kernel: Kernel, lanes: int) -> str:
    """A loop over the samples that calls the kernel's parts, and the parts."""
    parts = divide(in_order_of_need(kernel))
    places = scratch_places(parts)
    names = [f"{kernel.name}_part{number}" for number in range(len(parts))]
    return "\n".join(
        [
            *(_part(name, kernel, part, places, lanes) for name, part in zip(names, parts, strict=True)),
            f"define void @{kernel.name}({_PARAMETERS}) {{",
            "entry:",
            f"  %s = alloca [{max(places.values(), default=0) + 1} x {vector_type(lanes)}], "
            f"align {vector_bytes(lanes)}",
            "  br label %loop",
            "loop:",
            "  %i = phi i64 [ 0, %entry ], [ %next, %loop ]",
            "  %passed = mul i64 %i, %step",
            "  %c = getelementptr double, ptr %constants, i64 %passed",
            *(f"  call void @{name}({_PART_ARGUMENTS})" for name in names),
            f"  %next = add i64 %i, {lanes}",
            "  %more = icmp slt i64 %next, %count",
            "  br i1 %more, label %loop, label %done",
            "done:",
            "  ret void",
            "}",
            "",
        ]
    )


def _of_one(name: str) -> str:
    """A kernel's functions of one sample."""
    return "\n".join(
        [
            f"define void @{name}_of_one(ptr noalias %x, ptr noalias %constants, ptr noalias %y) {{",
            f"  call void @{name}(ptr %x, ptr %constants, ptr %y, i64 1, i64 1, i64 0)",
            "  ret void",
            "}",
            f"define void @{name}_of_block(ptr %block) {{",
            "  %x = load ptr, ptr %block",
            "  %second = getelementptr ptr, ptr %block, i64 1",
            "  %constants = load ptr, ptr %second",
            "  %third = getelementptr ptr, ptr %block, i64 2",
            "  %y = load ptr, ptr %third",
            f"  call void @{name}_of_one(ptr %x, ptr %constants, ptr %y)",
            "  ret void",
            "}",
            "",
        ]
    )


def _part(
    name: str,
    kernel: Kernel,
    statements: Sequence[Statement],
    places: Mapping[sympy.Symbol, int],
    lanes: int,
) -> str:
    body = Body(kernel, places, lanes)
    for statement in statements:
        body.add(statement)
    first = f"define internal void @{name}({_PART_PARAMETERS}) nounwind {{"
    return "\n".join([first, *body.code.lines, "  ret void", "}"])
