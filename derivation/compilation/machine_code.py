"""Machine code: LLVM assembly compiled for this machine's processor and linked into this process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import llvmlite.binding as llvm

_CODE_GENERATION_LEVEL = 1


def compile_assembly(text: str) -> bytes:
    """Object code of an LLVM module for the processor of this machine.

    No passes improve the assembly first: in statements that share every subexpression already they find
    nothing that shortens the run time. The same is true of code generation's higher levels.
    """
    return bytes(_target_machine().emit_object(llvm.parse_assembly(text)))


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
    cpu = llvm.get_host_cpu_name()
    return target.create_target_machine(cpu=cpu, features=features, opt=_CODE_GENERATION_LEVEL, jit=True)


@cache
def processor() -> str:
    """What object code depends on besides its source: LLVM, its level, the processor, its features."""
    features = llvm.get_host_cpu_features().flatten()
    version, triple = llvm.llvm_version_info, llvm.get_process_triple()
    return f"{version} {_CODE_GENERATION_LEVEL} {triple} {llvm.get_host_cpu_name()} {features}"
