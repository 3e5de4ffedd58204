"""The distribution holds every source file exactly once, with and without the links; every doctest passes.

The stages stand at the top of the repository and are imported below ``chassym``. setuptools cannot discover
such packages, so pyproject.toml lists them by hand; these tests keep that list and the folders in step.
Nothing here needs the links ``chassym/{derivation,linear,nonlinear}``.
"""

import doctest
import importlib
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGE_FOLDERS: dict[str, str] = PROJECT["tool"]["setuptools"]["package-dir"]
TOP_FOLDERS = sorted({folder.split("/")[0] for folder in PACKAGE_FOLDERS.values()})
STAGES = sorted(set(TOP_FOLDERS) - {"chassym"})
LINKS = {f"chassym/{stage}" for stage in STAGES}


def source_files() -> list[str]:
    """List every file of the package folders, through the real folders only.

    A link is left out also where git wrote it as a small text file, as it does on systems without links.
    """
    paths = [path for folder in TOP_FOLDERS for path in (ROOT / folder).rglob("*") if path.is_file()]
    files = {path.relative_to(ROOT).as_posix() for path in paths if "__pycache__" not in path.parts}
    return sorted(files - LINKS)


def installed_name(file: str) -> str:
    """Give the place in the wheel of a file of the repository."""
    return file if file.startswith("chassym/") else f"chassym/{file}"


def module_names() -> list[str]:
    """List the importable modules of all packages, from the folders on disk."""
    files = [installed_name(file) for file in source_files() if file.endswith(".py")]
    paths = [file.removesuffix(".py").removesuffix("/__init__") for file in files]
    return sorted(path.replace("/", ".") for path in paths if not path.endswith("/__main__"))


def copy_of_the_tree(destination: Path, *, links: bool) -> Path:
    """Copy what the build reads, with the links to the stages or without them."""
    destination.mkdir()
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, destination / file)
    for file in source_files():
        (destination / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / file, destination / file)
    if links:
        for stage in STAGES:
            (destination / "chassym" / stage).symlink_to(Path("..") / stage)
    return destination


@pytest.fixture(scope="module", params=[True, False], ids=["with links", "without links"])
def distributions(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the sdist and the wheel built from a copy of the tree."""
    folder = tmp_path_factory.mktemp("distributions")
    tree = copy_of_the_tree(folder / "tree", links=request.param)
    build = "from setuptools import build_meta as b; b.build_sdist('dist'); b.build_wheel('dist')"
    run = subprocess.run([sys.executable, "-P", "-c", build], cwd=tree, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return tree / "dist"


def test_the_package_list_is_what_stands_on_disk() -> None:
    top = {init.parent.name for init in ROOT.glob("*/__init__.py")}
    assert top == set(TOP_FOLDERS)
    folders = {str(Path(file).parent) for file in source_files() if file.endswith(".py")}
    expected = {installed_name(folder + "/").strip("/").replace("/", "."): folder for folder in folders}
    assert expected == PACKAGE_FOLDERS
    assert sorted(PROJECT["tool"]["setuptools"]["packages"]) == sorted(expected)


@pytest.mark.parametrize("folder", PACKAGE_FOLDERS.values())
def test_every_package_is_a_regular_package(folder: str) -> None:
    assert (ROOT / folder / "__init__.py").is_file()


@pytest.mark.parametrize("stage", STAGES)
def test_a_link_if_present_leads_to_its_stage(stage: str) -> None:
    link = ROOT / "chassym" / stage
    assert not link.is_dir() or link.samefile(ROOT / stage)


def test_the_wheel_holds_every_file_once(distributions: Path) -> None:
    (wheel,) = distributions.glob("*.whl")
    names = [name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name]
    assert sorted(names) == sorted(map(installed_name, source_files()))


def test_the_sdist_holds_every_file_once(distributions: Path) -> None:
    (sdist,) = distributions.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        members = archive.getmembers()
    assert all(member.isfile() or member.isdir() for member in members)
    paths = [member.name.split("/", 1)[1] for member in members if member.isfile()]
    assert sorted(path for path in paths if path.split("/")[0] in TOP_FOLDERS) == source_files()


@pytest.mark.parametrize("name", module_names())
def test_doctests(name: str, pytestconfig: pytest.Config) -> None:
    flags = sum(doctest.OPTIONFLAGS_BY_NAME[flag] for flag in pytestconfig.getini("doctest_optionflags"))
    result = doctest.testmod(importlib.import_module(name), optionflags=flags)
    assert result.failed == 0, f"{result.failed} of {result.attempted} examples failed"


def test_no_source_file_is_imported_under_two_names() -> None:
    for name in module_names():
        importlib.import_module(name)
    names_of = defaultdict(set)
    for name, module in list(sys.modules.items()):
        file = getattr(module, "__file__", None)
        if file:
            names_of[Path(file).resolve()].add(name)
    inside = {path: names for path, names in names_of.items() if path.is_relative_to(ROOT) and len(names) > 1}
    assert not inside
