"""The cache of compiled functions: whatever stands on the disk, the right function comes back."""

import dataclasses
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    CompiledEquations,
    DamperTable,
    JointPort,
    Linear,
    Mechanism,
    Model,
    PointDisplacement,
    TravelPort,
    load_model,
    prismatic,
    revolute,
)
from chassym.derivation.characteristic import Characteristic
from chassym.derivation.compilation import cache, machine_code, numeric
from chassym.derivation.program import Program

SOURCE = cache.Source(("x",), ("m", "k"), 2, (0, 1), (0, 0), cache.pack("define void @kernel()"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give the cache's folder, which does not exist yet."""
    place = tmp_path / "deep" / "cache"
    monkeypatch.setenv("CHASSYM_CACHE_DIR", str(place))
    return place


def never() -> NoReturn:
    raise AssertionError("built again")


def is_generated(name: str = "entry") -> bool:
    """Tell whether a source has to be generated; it is right either way."""
    built = []

    def build() -> cache.Source:
        built.append(True)
        return SOURCE

    assert cache.fetch_source(name, build) == SOURCE
    return bool(built)


def is_compiled() -> bool:
    """Tell whether object code has to be made; it is right either way."""
    built = []

    def build() -> bytes:
        built.append(True)
        return bytes(range(256))

    assert cache.fetch_object_code(SOURCE, "processor", build) == bytes(range(256))
    return bool(built)


LEVELS = pytest.mark.parametrize("is_built", [is_generated, is_compiled])
Level = Callable[[], bool]


# Entries on the disk


def test_a_source_comes_back_as_it_was(folder: Path) -> None:
    assert is_generated()
    found = cache.fetch_source("entry", never)
    assert found == SOURCE
    assert found.assembly == "define void @kernel()"
    assert [path.name for path in folder.iterdir()] == ["entry.source.json"]


def test_object_code_comes_back_as_it_was(folder: Path) -> None:
    assert is_compiled()
    assert cache.fetch_object_code(SOURCE, "processor", never) == bytes(range(256))
    (path,) = folder.iterdir()
    assert path.name.endswith(".code.json")


def test_names_are_kept_apart(folder: Path) -> None:
    other = dataclasses.replace(SOURCE, constants=7)
    cache.fetch_source("one", lambda: SOURCE)
    cache.fetch_source("two", lambda: other)
    assert cache.fetch_source("one", never) == SOURCE
    assert cache.fetch_source("two", never) == other


def test_object_code_is_kept_by_source_and_processor(folder: Path) -> None:
    other = dataclasses.replace(SOURCE, packed=cache.pack("define void @other()"))
    cases = [(SOURCE, "one"), (SOURCE, "two"), (other, "one"), (other, "two")]
    for number, case in enumerate(cases):
        cache.fetch_object_code(*case, lambda number=number: bytes([number]))
    assert [cache.fetch_object_code(*case, never) for case in cases] == [bytes([n]) for n in range(4)]


def test_a_source_under_the_name_of_another_is_refused(folder: Path) -> None:
    other = dataclasses.replace(SOURCE, constants=9)
    cache.fetch_source("one", lambda: SOURCE)
    (folder / "two.source.json").write_bytes((folder / "one.source.json").read_bytes())
    assert cache.fetch_source("two", lambda: other) == other
    assert cache.fetch_source("two", never) == other


def test_object_code_under_the_name_of_another_is_refused(folder: Path) -> None:
    cache.fetch_object_code(SOURCE, "one", lambda: b"one")
    (first,) = folder.iterdir()
    cache.fetch_object_code(SOURCE, "two", lambda: b"two")
    (second,) = set(folder.iterdir()) - {first}
    second.write_bytes(first.read_bytes())
    assert cache.fetch_object_code(SOURCE, "two", lambda: b"again") == b"again"
    assert cache.fetch_object_code(SOURCE, "two", never) == b"again"


def changed_entry(data: bytes, **changes: object) -> bytes:
    """Change fields and leave the checksum as it was."""
    envelope = json.loads(data)
    fields = json.loads(envelope["entry"]) | changes
    return json.dumps(envelope | {"entry": json.dumps(fields)}).encode()


def flipped(data: bytes, place: int) -> bytes:
    return data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :]


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda data: b"",
    "cut in half": lambda data: data[: len(data) // 2],
    "cut by one byte": lambda data: data[:-1],
    "zeros": lambda data: bytes(len(data)),
    "not text": lambda data: b"\xff\xfe\x00" + data,
    "another file": lambda data: b"<html></html>",
    "a number": lambda data: b"42",
    "null": lambda data: b"null",
    "a list": lambda data: b"[]",
    "an empty object": lambda data: b"{}",
    "numbers for text": lambda data: b'{"checksum": 1, "entry": 2}',
    "null for text": lambda data: b'{"checksum": null, "entry": null}',
    "wrong checksum": lambda data: data.replace(b'"checksum": "', b'"checksum": "0'),
    "changed code": lambda data: changed_entry(data, object_code="AAAA", packed="AAAA"),
    "changed constants": lambda data: changed_entry(data, constants=3),
    "changed rows": lambda data: changed_entry(data, rows=[1, 0]),
    "twice": lambda data: data + data,
    **{f"bit flipped at {n}/10": lambda data, n=n: flipped(data, n * len(data) // 10) for n in range(10)},
}


@LEVELS
@pytest.mark.parametrize("kind", DAMAGE)
def test_damage_is_noticed_and_mended(folder: Path, kind: str, is_built: Level) -> None:
    assert is_built()
    (path,) = folder.iterdir()
    path.write_bytes(DAMAGE[kind](path.read_bytes()))
    assert is_built()
    assert not is_built()


@LEVELS
def test_a_folder_in_the_place_of_the_file(folder: Path, is_built: Level) -> None:
    assert is_built()
    (path,) = folder.iterdir()
    path.unlink()
    path.mkdir()
    assert is_built()
    assert list(folder.iterdir()) == [path]


@LEVELS
def test_a_file_in_the_place_of_the_folder(folder: Path, is_built: Level) -> None:
    folder.parent.mkdir(parents=True)
    folder.write_text("in the way")
    assert is_built()
    assert folder.read_text() == "in the way"


@LEVELS
@pytest.mark.parametrize("operation", ["mkstemp", "fdopen", "replace"])
def test_a_disk_that_cannot_be_written_to(
    folder: Path, monkeypatch: pytest.MonkeyPatch, operation: str, is_built: Level
) -> None:
    """Read-only, full or failing: the function is built, and no half-written file stays behind."""

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "read-only file system")

    folder.mkdir(parents=True)
    with monkeypatch.context() as patch:
        patch.setattr(cache.tempfile if operation == "mkstemp" else cache.os, operation, refuse)
        assert is_built()
    assert not list(folder.iterdir())


@LEVELS
@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="permissions do not bind this user")
def test_a_folder_without_permissions(folder: Path, is_built: Level) -> None:
    folder.mkdir(parents=True)
    folder.chmod(0o500)
    try:
        assert is_built()
    finally:
        folder.chmod(0o700)


def test_a_failing_build_leaves_nothing_behind(folder: Path) -> None:
    def fail() -> NoReturn:
        raise ArithmeticError("no such function")

    with pytest.raises(ArithmeticError, match="no such function"):
        cache.fetch_source("entry", fail)
    with pytest.raises(ArithmeticError, match="no such function"):
        cache.fetch_object_code(SOURCE, "processor", fail)
    assert not folder.exists()


@LEVELS
def test_a_user_without_a_home(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, is_built: Level) -> None:
    """It costs the caching and nothing else."""

    def refuse() -> NoReturn:
        raise RuntimeError("Could not determine home directory.")

    for name in ("CHASSYM_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(cache.Path, "home", refuse)
    assert is_built()
    assert is_built()


@LEVELS
def test_threads_at_once(folder: Path, is_built: Level) -> None:
    """All of them get the right entry, and one whole file is left."""
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda _: is_built(), range(64)))
    assert not is_built()
    assert len(list(folder.iterdir())) == 1


def test_the_folder_is_the_one_given_or_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CHASSYM_CACHE_DIR", str(tmp_path / "given"))
    assert cache.directory() == tmp_path / "given"
    monkeypatch.setenv("CHASSYM_CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache.directory() == tmp_path / "xdg" / "chassym"


# Functions that come from it


def accelerations(arguments: np.ndarray) -> np.ndarray:
    """Evaluate the quarter car from a model that knows nothing of earlier ones."""
    return load_model("quarter_car").accelerations(arguments)


@pytest.fixture
def arguments(quarter_car: Model) -> np.ndarray:
    return np.random.default_rng(8).uniform(-1, 1, (quarter_car.argument_count, 5))


def test_the_second_use_neither_derives_nor_compiles(
    folder: Path, arguments: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = accelerations(arguments)

    def refuse(*_: object) -> None:
        raise AssertionError("built again")

    for name in ("_generate", "derive"):
        monkeypatch.setattr(numeric, name, refuse)
    monkeypatch.setattr(machine_code, "compile_assembly", refuse)
    assert np.array_equal(accelerations(arguments), first)


def test_derivatives_by_name_come_from_disk_as_well(
    folder: Path, arguments: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    def derivatives() -> np.ndarray:
        car = load_model("quarter_car")
        return car.compiled.jacobian(["sprung.mass", "road"]).bind(car.values)(arguments)

    first = derivatives()
    monkeypatch.setattr(numeric, "_generate", never)
    monkeypatch.setattr(machine_code, "compile_assembly", never)
    assert np.array_equal(derivatives(), first)


def test_on_another_processor_it_is_compiled_and_not_derived(
    folder: Path, arguments: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = accelerations(arguments)
    compiled = []
    compile_assembly = machine_code.compile_assembly
    monkeypatch.setattr(machine_code, "processor", lambda: "another processor")
    monkeypatch.setattr(
        machine_code, "compile_assembly", lambda text: compiled.append(text) or compile_assembly(text)
    )
    with monkeypatch.context() as patch:
        patch.setattr(numeric, "derive", never)
        assert np.array_equal(accelerations(arguments), first)
        assert compiled
        count = len(compiled)
        assert np.array_equal(accelerations(arguments), first)
    assert len(compiled) == count


# Functions that travel


def pickled(car: Model) -> bytes:
    return pickle.dumps((car, car.compiled.residual))


def test_a_pickled_model_neither_derives_nor_compiles(
    quarter_car: Model, arguments: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The whole graph at once: shared parts stay shared."""
    expected = quarter_car.accelerations(arguments)
    data = pickled(quarter_car)
    for name in ("_generate", "derive"):
        monkeypatch.setattr(numeric, name, never)
    monkeypatch.setattr(machine_code, "compile_assembly", never)
    monkeypatch.setattr(cache, "directory", never)
    car, residual = pickle.loads(data)
    assert np.array_equal(car.accelerations(arguments), expected)
    assert car.accelerations.function is car.compiled.accelerations
    assert residual is car.compiled.residual
    assert car.values == quarter_car.values


def test_bodies_keep_their_identity_when_pickled(half_car: Model) -> None:
    """Bodies are told apart by identity, the ground as well."""
    system = pickle.loads(pickle.dumps(half_car)).system
    body = system.bodies[0]
    assert body.parent is system.ground
    assert all(each.parent in (system.ground, *system.bodies) for each in system.bodies)
    assert {output.point.body for output in system.outputs if hasattr(output, "point")} <= set(system.bodies)


def test_a_pickled_model_can_derive_again(quarter_car: Model, arguments: np.ndarray) -> None:
    """What was not there is derived on arrival from the mechanism that came along."""
    car = pickle.loads(pickle.dumps(load_model("quarter_car")))
    assert np.array_equal(car.outputs(arguments), quarter_car.outputs(arguments))
    assert car.compiled._identity == quarter_car.compiled._identity
    assert car.equations.operations == quarter_car.equations.operations


def test_a_pickled_model_in_another_process(
    quarter_car: Model, arguments: np.ndarray, tmp_path: Path
) -> None:
    quarter_car.accelerations(arguments)
    (tmp_path / "model").write_bytes(pickle.dumps((quarter_car, arguments)))
    program = """
import pickle, sys
car, arguments = pickle.loads(open(sys.argv[1], "rb").read())
print(car.accelerations(arguments).tobytes().hex())
"""
    command = [sys.executable, "-c", program, str(tmp_path / "model")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == quarter_car.accelerations(arguments).tobytes().hex()


def test_a_pickled_function_on_another_processor_is_compiled_from_its_source(
    folder: Path, quarter_car: Model, arguments: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = quarter_car.accelerations(arguments)
    function = quarter_car.compiled.accelerations
    foreign = dataclasses.replace(
        function.entry, processor="elsewhere", object_code=b"no code of this machine"
    )
    data = pickle.dumps(dataclasses.replace(function, entry=foreign))
    monkeypatch.setattr(numeric, "derive", never)
    arrived = pickle.loads(data)
    assert np.array_equal(arrived.bind(quarter_car.values)(arguments), expected)
    assert [path.name.partition(".")[2] for path in folder.iterdir()] == ["code.json"]
    monkeypatch.setattr(machine_code, "compile_assembly", never)
    assert np.array_equal(pickle.loads(data).bind(quarter_car.values)(arguments), expected)


# Files


@pytest.mark.parametrize("kind", ["empty", "cut in half", "wrong checksum", "changed code"])
def test_a_damaged_file_gives_the_right_function(
    folder: Path, arguments: np.ndarray, quarter_car: Model, kind: str
) -> None:
    expected = quarter_car.accelerations(arguments)
    assert np.array_equal(accelerations(arguments), expected)
    for path in folder.iterdir():
        path.write_bytes(DAMAGE[kind](path.read_bytes()))
    assert np.array_equal(accelerations(arguments), expected)


def test_two_processes_at_once(folder: Path, arguments: np.ndarray, quarter_car: Model) -> None:
    """Both start on an empty cache and stop at the same line before they build."""
    program = """
import sys, numpy
from chassym.derivation import load_model
car = load_model("quarter_car")
print("ready", flush=True)
sys.stdin.readline()
arguments = numpy.random.default_rng(8).uniform(-1, 1, (car.argument_count, 5))
for function in (car.accelerations, car.outputs):
    print(function(arguments).tobytes().hex(), flush=True)
"""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    processes = [subprocess.Popen([sys.executable, "-c", program], **pipes) for _ in range(2)]  # type: ignore[call-overload]
    assert [process.stdout.readline() for process in processes] == ["ready\n"] * 2
    for process in processes:
        process.stdin.write("go\n")
        process.stdin.flush()
    expected = [f(arguments).tobytes().hex() for f in (quarter_car.accelerations, quarter_car.outputs)]
    for process in processes:
        assert process.communicate(timeout=60)[0].split() == expected
        assert process.returncode == 0
    names = [path.name for path in folder.iterdir()]
    assert {name.partition(".")[2] for name in names} == {"source.json", "code.json"}
    assert all(cache._read(name) for name in names)


# What an entry's name depends on


@dataclasses.dataclass(frozen=True)
class Cubic(Characteristic):
    """A force law that the package does not have."""

    factor: sympy.Expr

    def force(
        self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
    ) -> sympy.Expr:
        return self.factor * deflection**3


def identity(
    *,
    axis: str = "z",
    joint: Callable = prismatic,
    mass: sympy.Expr | float = 1.0,
    centre: tuple[float, float, float] = (0, 0, 0.5),
    place: float = 0.2,
    law: Characteristic | None = None,
    gravity: float = 9.81,
    preloaded: bool = False,
    moved: bool = False,
    output: str = "x",
) -> str | None:
    """Describe a one-body mechanism, all but one of its features as usual."""
    mechanism = Mechanism("bench", sympy.sympify(gravity))
    body = mechanism.add_body(
        "body",
        mechanism.ground,
        joint("q", axis),
        (0, 0, 0),
        mass=mass,
        mass_centre=centre,
        inertia=(1, 1, 1),
    )
    point = mechanism.point("p", body, (place, 0, 0))
    pad = mechanism.add_input("pad", "m")
    travel = TravelPort(point, mechanism.ground, "z")
    port = travel.less(pad) if moved else travel
    mechanism.add_force_element("spring", port, law or Linear(sympy.Integer(5)), preloaded=preloaded)
    mechanism.add_output(PointDisplacement("reading", point, output, mechanism.ground))
    return CompiledEquations(mechanism)._identity


K, V, F = sympy.Symbol("k", real=True), sympy.symbols("v:3", real=True), sympy.symbols("f:3", real=True)
VARIANTS: dict[str, dict] = {
    "axis": {"axis": "x"},
    "kind of joint": {"joint": revolute},
    "mass": {"mass": 1.5},
    "mass as a parameter": {"mass": sympy.Symbol("m", real=True)},
    "mass centre": {"centre": (0, 0, 0.6)},
    "place of a point": {"place": 0.3},
    "stiffness": {"law": Linear(sympy.Integer(6))},
    "damping": {"law": Linear(sympy.Integer(5), sympy.Integer(1))},
    "force law": {"law": Cubic(sympy.Integer(5))},
    "factor of a force law": {"law": Cubic(K)},
    "table": {"law": DamperTable(V, F)},
    "shorter table": {"law": DamperTable(V[:2], F[:2])},
    "factor of a table": {"law": DamperTable(V, F, K)},
    "gravity": {"gravity": 1.62},
    "preload": {"preloaded": True},
    "input": {"moved": True},
    "output": {"output": "y"},
}


def test_every_feature_of_a_mechanism_gives_another_name() -> None:
    names = [identity(), *(identity(**change) for change in VARIANTS.values())]
    assert len(set(names)) == len(names)


def test_the_same_mechanism_has_the_same_name() -> None:
    for change in VARIANTS.values():
        assert identity(**change) == identity(**change)


def test_values_of_parameters_do_not_matter(quarter_car: Model) -> None:
    assert (
        load_model("quarter_car", {"sprung.mass": 500.0}).compiled._identity == quarter_car.compiled._identity
    )


def test_the_length_of_a_table_does(quarter_car: Model) -> None:
    shorter = load_model("quarter_car", {"damper.velocity": [-1.0, 1.0], "damper.force": [-900.0, 900.0]})
    assert shorter.compiled._identity != quarter_car.compiled._identity


class Stiff(Linear):
    """A force law with something that its fields do not tell."""

    def __init__(self, stiffness: float, factor: float) -> None:
        super().__init__(stiffness)
        object.__setattr__(self, "hidden", factor)


def local_law(factor: float) -> Characteristic:
    """Make a force law of a class of its own for every factor, all of one source."""

    @dataclasses.dataclass(frozen=True)
    class Law(Characteristic):
        def force(
            self, program: Program, deflection: sympy.Expr, rate: sympy.Expr, preload: sympy.Expr
        ) -> sympy.Expr:
            return factor * deflection

    return Law()


@pytest.mark.parametrize("law", [Stiff(1, 2), local_law(3)], ids=["hidden attribute", "local class"])
def test_what_fields_do_not_tell_is_not_kept(law: Characteristic) -> None:
    assert identity(law=law) is None


def test_arrays_are_told_by_their_entries() -> None:
    tables = [DamperTable(np.array([0.0, 1.0]), np.array([0.0, force])) for force in (1.0, 2.0)]
    one, other = (identity(law=table) for table in tables)
    assert one is not None and one != other


def test_a_part_added_later_does_not_change_what_is_kept(folder: Path) -> None:
    """Code of a mechanism as it was is not found under the name of what it has become."""
    mechanism = Mechanism("bench", gravity=0)
    mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=1)
    port = JointPort(mechanism.coordinate("z"))
    mechanism.add_force_element("first", port, Linear(1))
    early = CompiledEquations(mechanism)
    _ = early.equations
    mechanism.add_force_element("second", port, Linear(1))
    state = np.array([[1.0], [0.0], [0.0]])
    assert early.residual.bind({})(state) == pytest.approx(1)
    assert CompiledEquations(mechanism).residual.bind({})(state) == pytest.approx(2)
