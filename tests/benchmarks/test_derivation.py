"""Ratios of run times of the derivation stage, each measured in one run: `pytest -m benchmark`."""

import subprocess
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import sympy
from sympy.core.cache import clear_cache
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from chassym.derivation import CompiledEquations, Mechanism, Model, derive, load_model, prismatic, revolute
from chassym.derivation.vehicles.full_car import full_car

from ..derivation.textbook import by_lagrange, lay_out

pytestmark = pytest.mark.benchmark


def seconds(work: Callable[[], object], repetitions: int = 5) -> float:
    """Shortest of several runs, each with sympy's cache empty."""
    taken = []
    for _ in range(repetitions):
        clear_cache()
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


def show(capsys: pytest.CaptureFixture[str], what: str, ratio: float) -> None:
    with capsys.disabled():
        print(f"\n{what}: {ratio:.3g}")


def arguments(model: Model, samples: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-0.1, 0.1, (model.argument_count, samples))


def pendulum(links: int) -> Mechanism:
    """Make a planar chain of equal pendulums on a cart."""
    mechanism = Mechanism("pendulum", sympy.Float(9.81))
    parent = mechanism.add_body("cart", mechanism.ground, prismatic("x", "x"), (0, 0, 0), mass=1)
    for i in range(links):
        hinge, centre = (0, 0, -i), (0, 0, -i - 1)
        parent = mechanism.add_body(
            f"link{i}", parent, revolute(f"angle{i}", "y"), hinge, mass=1, mass_centre=centre
        )
    return mechanism


def pendulum_by_textbook(links: int) -> LagrangesMethod:
    x, *angles = dynamicsymbols(" ".join(["x", *(f"angle{i}" for i in range(links))]))
    kinetic, potential = x.diff() ** 2 / 2, sympy.S.Zero
    across, up = x, sympy.S.Zero
    for i in range(links):
        total = sum(angles[: i + 1])
        across, up = across - sympy.sin(total), up - sympy.cos(total)
        kinetic += (across.diff(dynamicsymbols._t) ** 2 + up.diff(dynamicsymbols._t) ** 2) / 2
        potential += 9.81 * up
    method = LagrangesMethod(kinetic - potential, [x, *angles])
    method.form_lagranges_equations()
    return method


@pytest.mark.parametrize("links", [2, 3, 4])
def test_derivation_against_the_expanded_lagrangian(links: int, capsys: pytest.CaptureFixture[str]) -> None:
    mechanism = pendulum(links)
    derivation, textbook = seconds(lambda: derive(mechanism)), seconds(lambda: pendulum_by_textbook(links), 1)
    method = pendulum_by_textbook(links)
    equations = derive(mechanism)
    expanded = sympy.count_ops([*method.mass_matrix, *method.forcing])
    name = f"cart with {links} pendulums"
    show(capsys, f"{name}, time of LagrangesMethod over time of derive", textbook / derivation)
    show(
        capsys,
        f"{name}, operations expanded over operations",
        expanded / equations.operations["mass_matrix_and_bias"],
    )
    assert textbook > derivation


def test_reference_car_against_lagranges_method(sedan: Model, capsys: pytest.CaptureFixture[str]) -> None:
    """M and h by LagrangesMethod over M, h and all forces by `derive`, in one run; it takes minutes.

    LagrangesMethod gets the same car by frames, points and rigid bodies, without springs, dampers and tyres.
    """
    derivation = seconds(lambda: derive(sedan.system), 3)
    start = time.perf_counter()
    found = by_lagrange(lay_out(sedan.system, own_rates=False))
    textbook = time.perf_counter() - start
    own = derive(sedan.system).operations["mass_matrix_and_bias"]
    shared, results = sympy.cse([*found.mass_matrix, *found.forcing])
    common = sympy.count_ops([expression for _, expression in shared]) + sympy.count_ops(results)
    show(capsys, "sedan, M, h, forces, energies and outputs by derive (s)", derivation)
    show(capsys, "sedan, M and h by LagrangesMethod (s)", textbook)
    show(capsys, "sedan, time of LagrangesMethod over time of derive", textbook / derivation)
    show(capsys, "sedan, operations of M and h, LagrangesMethod with cse over derive", common / own)
    assert textbook > 300 * derivation
    assert common > own


SECTIONS = (3, 6, 12, 24, 48)


def exponent(sizes: Sequence[int], values: Sequence[float]) -> float:
    """Slope of a line through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def test_growth_with_the_body_sections(sedan: Model, capsys: pytest.CaptureFixture[str]) -> None:
    """Time and operations against degrees of freedom, from 12 to 57."""
    sizes, times, matrix, right = [], [], [], []
    for sections in SECTIONS:
        mechanism = full_car(sedan.parameters, sections=sections)
        sizes.append(len(mechanism.coordinates))
        times.append(seconds(lambda mechanism=mechanism: derive(mechanism), 2))
        operations = derive(mechanism).operations
        matrix.append(operations["mass_matrix_and_bias"])
        right.append(operations["right_hand_side"])
        show(capsys, f"{sections} sections, {sizes[-1]} degrees of freedom, time (s)", times[-1])
        show(capsys, f"{sections} sections, operations of M and h", matrix[-1])
        show(capsys, f"{sections} sections, operations of the right-hand side", right[-1])
    for name, values in (("time", times), ("operations of M and h", matrix), ("right-hand side", right)):
        show(capsys, f"exponent of {name} over degrees of freedom", exponent(sizes, values))
    assert max(exponent(sizes, matrix), exponent(sizes, right)) < 2.3


def test_growth_of_a_serial_chain(capsys: pytest.CaptureFixture[str]) -> None:
    """The other extreme: every coordinate is coupled to every other one."""
    sizes, times, matrix, right = [], [], [], []
    for links in (4, 8, 16, 32):
        mechanism = pendulum(links)
        sizes.append(links + 1)
        times.append(seconds(lambda mechanism=mechanism: derive(mechanism), 2))
        operations = derive(mechanism).operations
        matrix.append(operations["mass_matrix_and_bias"])
        right.append(operations["right_hand_side"])
    for name, values in (("time", times), ("operations of M and h", matrix), ("right-hand side", right)):
        show(capsys, f"cart with pendulums, exponent of {name}", exponent(sizes, values))
    assert exponent(sizes, matrix) < 2.3


LAGRANGES_METHOD = """
from chassym.derivation import load_model
from tests.derivation.textbook import by_lagrange, lay_out
by_lagrange(lay_out(load_model("{vehicle}").system, own_rates=False))
"""


def test_growth_of_lagranges_method(pytestconfig: pytest.Config, capsys: pytest.CaptureFixture[str]) -> None:
    """As far as it gets in five minutes, vehicle by vehicle, each in a process that can be stopped."""
    left, sizes, times = 300.0, [], []
    for vehicle in ("half_car", "ride_model", "rigid_sedan", "sedan"):
        degrees = len(load_model(vehicle).system.coordinates)
        name = f"LagrangesMethod, {vehicle}, {degrees} degrees of freedom"
        start = time.perf_counter()
        try:
            code = LAGRANGES_METHOD.format(vehicle=vehicle)
            subprocess.run([sys.executable, "-c", code], cwd=pytestconfig.rootpath, timeout=left, check=True)
        except subprocess.TimeoutExpired:
            show(capsys, f"{name}: not finished in (s)", left)
            break
        sizes.append(degrees)
        times.append(time.perf_counter() - start)
        left -= times[-1]
        show(capsys, f"{name}, time with imports (s)", times[-1])
    show(capsys, "LagrangesMethod, exponent of time over degrees of freedom", exponent(sizes, times))


def test_cache_against_building(
    capsys: pytest.CaptureFixture[str],
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CHASSYM_CACHE_DIR", str(tmp_path_factory.mktemp("empty")))
    build = seconds(lambda: load_model("sedan").accelerations, 1)
    fetch = seconds(lambda: load_model("sedan").accelerations)
    show(capsys, "sedan, building the accelerations over fetching them", build / fetch)
    assert fetch < build


def test_machine_code_against_numpy(
    sedan: Model, lambdified: Callable, capsys: pytest.CaptureFixture[str]
) -> None:
    equations = sedan.equations
    constants = {sympy.Symbol(name, real=True): value for name, value in sedan.values.items()}
    plain = lambdified(equations.program, [*constants, *equations.arguments], list(equations.accelerations))
    for samples in (1, 1000):
        given = arguments(sedan, samples)
        own = seconds(lambda given=given: sedan.accelerations(given))
        numpy = seconds(lambda given=given: plain(*constants.values(), *given))
        show(capsys, f"sedan, accelerations of {samples} samples, numpy over machine code", numpy / own)
        assert own < numpy


def test_a_batch_against_single_samples(sedan: Model, capsys: pytest.CaptureFixture[str]) -> None:
    given = arguments(sedan, 1000)
    one = sedan.accelerations.single()
    batch, single = (
        seconds(lambda: sedan.accelerations(given)),
        seconds(lambda: [one(sample) for sample in given.T]),
    )
    show(capsys, "sedan, 1000 samples one by one over one batch", single / batch)
    assert batch < single


def test_forward_dynamics_against_mujoco(sedan: Model, capsys: pytest.CaptureFixture[str]) -> None:
    """A tree of as many joints in MuJoCo, without force elements, over the whole car; both through Python."""
    mujoco = pytest.importorskip("mujoco")
    hinge, inertia = (
        '<joint type="hinge" axis="1 0 0"/>',
        '<inertial pos="0 0 0" mass="475" diaginertia="9 9 9"/>',
    )
    arm = f'<body pos="0 1 0">{hinge}<inertial pos="0 -2 0" mass="48" diaginertia="1 2 1"/></body>'
    axes = ("1 0 0", "0 1 0", "0 0 1")
    joints = "".join(f'<joint type="slide" axis="{a}"/>' for a in axes)
    joints += "".join(f'<joint type="hinge" axis="{a}"/>' for a in reversed(axes))
    ends = "".join(f'<body pos="{x} 0 0">{hinge}{inertia}{arm}{arm}</body>' for x in (-1, 1))
    tree = f"<mujoco><worldbody><body>{joints}{inertia}{ends}</body></worldbody></mujoco>"
    engine = mujoco.MjModel.from_xml_string(tree)
    data = mujoco.MjData(engine)
    assert engine.nv == sedan.size
    one, sample = sedan.accelerations.single(), arguments(sedan, 1)[:, 0]
    theirs = seconds(lambda: [mujoco.mj_forward(engine, data) for _ in range(1000)])
    own = seconds(lambda: [one(sample) for _ in range(1000)])
    show(
        capsys, "sedan, mj_forward over accelerations with all force elements, sample by sample", theirs / own
    )


def test_compilation_against_derivation(
    capsys: pytest.CaptureFixture[str],
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CHASSYM_CACHE_DIR", str(tmp_path_factory.mktemp("empty")))
    compiled = CompiledEquations(load_model("sedan").system)
    derivation = seconds(lambda: compiled.equations, 1)
    for function in ("accelerations", "outputs", "residual_jacobian", "linearisation"):
        taken = seconds(lambda function=function: getattr(compiled, function), 1)
        show(capsys, f"sedan, compiling {function} over deriving the equations", taken / derivation)
