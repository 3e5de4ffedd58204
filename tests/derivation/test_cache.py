"""The cache of compiled functions: whatever stands on the disk, the right function comes back."""

import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    CompiledEquations,
    DamperTable,
    Linear,
    Mechanism,
    Model,
    PointDisplacement,
    TravelPort,
    cache,
    load_model,
    numeric,
    prismatic,
    revolute,
)
from chassym.derivation.characteristic import Characteristic
from chassym.derivation.program import Program

ENTRY = cache.Entry(("m", "k"), 2, (0, 1), (0, 0), bytes(range(256)))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give the cache's folder, which does not exist yet."""
    place = tmp_path / "deep" / "cache"
    monkeypatch.setenv("CHASSYM_CACHE_DIR", str(place))
    return place


def never() -> cache.Entry:
    raise AssertionError("built again")


def is_built(name: str = "entry") -> bool:
    """Tell whether an entry has to be built; it is right either way."""
    built = []

    def build() -> cache.Entry:
        built.append(True)
        return ENTRY

    assert cache.fetch(name, build) == ENTRY
    return bool(built)


# Entries on the disk


def test_an_entry_comes_back_as_it_was(folder: Path) -> None:
    assert is_built()
    assert cache.fetch("entry", never) == ENTRY
    assert [path.name for path in folder.iterdir()] == ["entry.json"]


def test_names_are_kept_apart(folder: Path) -> None:
    other = dataclasses.replace(ENTRY, object_code=b"other")
    cache.fetch("one", lambda: ENTRY)
    cache.fetch("two", lambda: other)
    assert cache.fetch("one", never) == ENTRY
    assert cache.fetch("two", never) == other


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
    "changed code": lambda data: changed_entry(data, object_code="AAAA"),
    "changed constants": lambda data: changed_entry(data, constants=3),
    "changed rows": lambda data: changed_entry(data, rows=[1, 0]),
    "twice": lambda data: data + data,
    **{f"bit flipped at {n}/10": lambda data, n=n: flipped(data, n * len(data) // 10) for n in range(10)},
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damage_is_noticed_and_mended(folder: Path, kind: str) -> None:
    assert is_built()
    path = folder / "entry.json"
    path.write_bytes(DAMAGE[kind](path.read_bytes()))
    assert is_built()
    assert not is_built()


def test_a_folder_in_the_place_of_the_file(folder: Path) -> None:
    (folder / "entry.json").mkdir(parents=True)
    assert is_built()
    assert [path.name for path in folder.iterdir()] == ["entry.json"]


def test_a_file_in_the_place_of_the_folder(folder: Path) -> None:
    folder.parent.mkdir(parents=True)
    folder.write_text("in the way")
    assert is_built()
    assert folder.read_text() == "in the way"


@pytest.mark.parametrize("operation", ["mkstemp", "fdopen", "replace"])
def test_a_disk_that_cannot_be_written_to(
    folder: Path, monkeypatch: pytest.MonkeyPatch, operation: str
) -> None:
    """Read-only, full or failing: the function is built, and no half-written file stays behind."""

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "read-only file system")

    folder.mkdir(parents=True)
    with monkeypatch.context() as patch:
        patch.setattr(cache.tempfile if operation == "mkstemp" else cache.os, operation, refuse)
        assert is_built()
    assert not list(folder.iterdir())


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="permissions do not bind this user")
def test_a_folder_without_permissions(folder: Path) -> None:
    folder.mkdir(parents=True)
    folder.chmod(0o500)
    try:
        assert is_built()
    finally:
        folder.chmod(0o700)


def test_a_failing_build_leaves_nothing_behind(folder: Path) -> None:
    def fail() -> cache.Entry:
        raise ArithmeticError("no such function")

    with pytest.raises(ArithmeticError, match="no such function"):
        cache.fetch("entry", fail)
    assert not folder.exists()


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

    for name in ("_build", "derive"):
        monkeypatch.setattr(numeric, name, refuse)
    monkeypatch.setattr(numeric.machine_code, "compile_assembly", refuse)
    assert np.array_equal(accelerations(arguments), first)


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
    names = sorted(path.suffix for path in folder.iterdir())
    assert set(names) == {".json"}
    assert all(cache._decode(path.read_bytes()) for path in folder.iterdir())


# What an entry's name depends on


@dataclasses.dataclass(frozen=True)
class Cubic(Characteristic):
    """A force law that the package does not have."""

    factor: sympy.Expr

    def force(self, program: Program, deflection: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
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
) -> str:
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
    port = TravelPort(point, mechanism.ground, "z", pad if moved else None)
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
