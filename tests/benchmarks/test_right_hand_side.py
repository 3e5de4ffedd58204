"""One evaluation of the reference car's right-hand side, with every force, beside MuJoCo's forward dynamics
of the same tree without any: from Python, in a compiled loop, in a batch; in one run.
"""

import ctypes
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from chassym.derivation import Model
from chassym.derivation.compilation.machine_code import compile_assembly, link
from chassym.nonlinear.excitation.excitation import Harmonic
from chassym.nonlinear.simulation.right_hand_side import RightHandSide

from ..consistency.test_mujoco import mjcf

pytestmark = pytest.mark.benchmark

LOOP = """
define void @again(ptr %function, ptr %a, ptr %b, ptr %c, i64 %count) {
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  call void %function(ptr %a, ptr %b, ptr %c)
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %count
  br i1 %more, label %loop, label %done
done:
  ret void
}
"""
"""Calls a function of three addresses, or of the first two of them, again and again."""


def microseconds(action: Callable[[], object], count: int, repeats: int = 25) -> float:
    """Shortest of several runs, for each of so many evaluations in a run."""
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        taken.append(time.perf_counter() - start)
    return 1e6 * min(taken) / count


def many_times(action: Callable[[], object], count: int) -> Callable[[], None]:
    def run() -> None:
        for _ in range(count):
            action()

    return run


def compiled_loop() -> Callable[..., None]:
    """A loop in machine code, as a function of addresses and a count."""
    linked = link(compile_assembly(LOOP), ["again"], "benchmark_loop")
    loop = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4, ctypes.c_int64)(linked.addresses["again"])
    loop.owners = linked
    return loop


def mj_forward_address() -> int:
    """Where MuJoCo's library, which is loaded already, has its forward dynamics."""
    (library,) = (p for p in Path(mujoco.__file__).parent.iterdir() if p.name.startswith("libmujoco"))
    address = ctypes.cast(ctypes.CDLL(str(library)).mj_forward, ctypes.c_void_p).value
    assert address is not None
    return address


def test_right_hand_side_beside_mujoco(sedan: Model, capsys: pytest.CaptureFixture[str]) -> None:
    engine = mujoco.MjModel.from_xml_string(mjcf(sedan))
    data = mujoco.MjData(engine)
    assert engine.nv == sedan.size
    state = np.random.default_rng(0).uniform(-0.05, 0.05, 2 * sedan.size)
    data.qpos[:], data.qvel[:] = np.split(state, 2)
    excitation = Harmonic(3.0, {motion.name: 0.005 for motion in sedan.system.inputs})
    rates = RightHandSide(sedan, excitation)
    function, jacobian = sedan.right_hand_side, sedan.right_hand_side_jacobian
    given = np.concatenate([state, np.full(2 * len(sedan.system.inputs), 0.005)])
    results, entries = np.empty(function.size), np.empty(jacobian.size)
    batch = np.random.default_rng(0).uniform(-0.05, 0.05, (sedan.argument_count, 4096))
    loop, count = compiled_loop(), 1000

    def ours_in_loop(code: int, constants: np.ndarray, into: np.ndarray) -> Callable[[], None]:
        return lambda: loop(code, given.ctypes.data, constants.ctypes.data, into.ctypes.data, count)

    in_place = function.between(given, results)
    evaluated = {
        "x' from Python, in place": many_times(in_place, count),
        "x' from Python, inputs and all": many_times(lambda: rates(0.1, state), count),
        "Jacobian from Python": many_times(lambda: rates.jacobian(0.1, state), count),
        "mj_forward from Python": many_times(lambda: mujoco.mj_forward(engine, data), count),
        "x' in a compiled loop": ours_in_loop(function.address, function.constants, results),
        "Jacobian in a compiled loop": ours_in_loop(jacobian.address, jacobian.constants, entries),
        "mj_forward in a compiled loop": lambda: loop(
            mj_forward_address(), engine._address, data._address, None, count
        ),
    }
    taken = {name: microseconds(action, count) for name, action in evaluated.items()}
    taken["accelerations in a batch"] = microseconds(lambda: sedan.accelerations(batch), 4096)
    python, compiled = taken["mj_forward from Python"], taken["mj_forward in a compiled loop"]
    with capsys.disabled():
        print(f"\nmj_forward of {engine.nv} joints: {python:.2f} us from Python, {compiled:.2f} us compiled")
        for name, each in taken.items():
            theirs = python if "Python" in name else compiled
            print(f"  {name}: {each:.2f} us; mj_forward takes {theirs / each:.2f} times as long")
    assert taken["x' from Python, in place"] < python
    assert taken["x' from Python, inputs and all"] < 2 * python
    assert taken["x' in a compiled loop"] < compiled
