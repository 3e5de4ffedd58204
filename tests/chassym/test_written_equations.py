"""Equations as they are printed: read back and solved, they give the accelerations of the machine code."""

import json
import re

import numpy as np
import pytest

from chassym.cli import main
from chassym.derivation import Linear, Mechanism, TravelPort, derive, load_model, prismatic, revolute
from chassym.written_equations import SHORT, written_energies, written_equations

FUNCTIONS = {"cos": np.cos, "sin": np.sin, "Max": max}


def evaluated(text, values):
    """Evaluate an equation's side; the names of values may hold dots and brackets."""
    known = "|".join(re.escape(name) for name in sorted(values, key=len, reverse=True))
    code = re.sub(rf"(?<![\w.])({known})(?![\w.\[])", lambda match: f"values[{match[0]!r}]", text)
    return eval(code, {"__builtins__": {}}, FUNCTIONS | {"values": values})


SMALL = ("quarter_car", "half_car", "half_car_roll", "torsion_chain")


@pytest.mark.parametrize("vehicle", SMALL)
def test_printed_equations_give_the_accelerations(vehicle):
    model = load_model(vehicle)
    arguments = np.random.default_rng(1).uniform(-0.3, 0.3, model.argument_count)
    names = [symbol.name for symbol in model.equations.arguments]
    values = model.values | dict(zip(names, arguments.tolist(), strict=True))
    equations = dict(written_equations(model.equations))
    for name, text in reversed(equations.items()):  # forces and rates stand last and are mentioned first
        values[name] = evaluated(text, values)
    coordinates = [coordinate.name for coordinate in model.equations.coordinates]
    upper = np.array(
        [[values.get(f"M[{row}, {column}]", 0.0) for column in coordinates] for row in coordinates]
    )
    mass = np.triu(upper) + np.triu(upper, 1).T
    forces = np.array([values[f"f[{name}]"] for name in coordinates])
    compiled = model.accelerations(arguments[:, None])[:, 0]
    assert np.linalg.solve(mass, forces) == pytest.approx(compiled, rel=1e-10)


def test_every_name_is_explained():
    equations = dict(written_equations(load_model("half_car").equations))
    mentioned = {name for text in equations.values() for name in re.findall(r"\b[Fv]_\w+", text)}
    assert mentioned == {name for name in equations if not name.startswith(("M[", "f["))}


@pytest.mark.parametrize("vehicle", SMALL)
def test_printed_energies_are_short_and_those_of_the_equations(vehicle):
    model = load_model(vehicle)
    arguments = np.random.default_rng(2).uniform(-0.3, 0.3, model.argument_count)
    names = [symbol.name for symbol in model.equations.arguments]
    values = model.values | dict(zip(names, arguments.tolist(), strict=True))
    equations = model.equations
    energies = dict(
        zip("TVD", (equations.kinetic_energy, equations.potential_energy, equations.dissipation), strict=True)
    )
    for name, text in written_energies(equations):
        assert len(text) <= SHORT
        numbers = {symbol: values[symbol.name] for symbol in energies[name].free_symbols}
        assert evaluated(text, values) == pytest.approx(float(energies[name].xreplace(numbers)), rel=1e-9)


def test_rounding_errors_are_not_printed():
    """The mass centre has moments about the joint that cancel but for rounding."""
    mechanism = Mechanism("link", gravity=0)
    joint = prismatic("s", (0.6, 0, 0.8)).then(revolute("a", "y"))
    body = mechanism.add_body(
        "link",
        mechanism.ground,
        joint,
        (0, 0, 0),
        mass=1.5,
        mass_centre=(0.1, 0, 0.3),
        inertia=(0.1, 0.2, 0.1),
    )
    foot = mechanism.point("foot", body, (0.1, 0.1, 0.7))
    mechanism.add_force_element(
        "spring", TravelPort(foot, mechanism.ground, (0.8, 0, -0.6)), Linear(0.3, 0.7)
    )
    equations = derive(mechanism)
    texts = [text for _, text in (*written_equations(equations), *written_energies(equations))]
    texts += map(str, equations.lagrange_equations)
    assert not re.findall(r"e-1\d", " ".join(texts))


def test_energies_of_large_models_are_not_printed(sedan):
    assert list(written_energies(sedan.equations)) == []


def test_energies_stand_before_the_equations(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["equations", "torsion_chain"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "V = front_torsion**2*stiffness.front/2 + rear_torsion**2*stiffness.rear/2\n" in out
    assert out.index("T = ") < out.index("D = ") < out.index("M[")
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.parametrize("vehicle", ["quarter_car", "sedan"])
def test_an_article_is_written(vehicle, request, capsys, tmp_path):
    path = tmp_path / "equations.tex"
    path.write_text("something older")
    assert main(["equations", vehicle, "--latex", str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "equations.tex" in out
    article = path.read_text(encoding="utf-8")
    assert article.startswith(r"\documentclass{article}")
    entries = request.getfixturevalue(vehicle).glossary
    assert any(entry.latex in article and entry.description in article for entry in entries.values())
    assert [each.name for each in tmp_path.iterdir()] == ["equations.tex"]


def test_an_article_beside_json_changes_nothing_there(capsys, tmp_path):
    path = tmp_path / "equations.tex"
    assert main(["equations", "quarter_car", "--json", "--latex", str(path)]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer.keys() == {"degrees_of_freedom", "operations", "derivation_s"}
    assert path.exists()


def test_articles_that_cannot_be_written_are_refused(capsys, tmp_path):
    (tmp_path / "folder.tex").mkdir()
    (tmp_path / "file").touch()
    missing, below = tmp_path / "missing" / "a.tex", tmp_path / "file" / "a.tex"
    for path in ("equations.pdf", "", missing, below, tmp_path / "folder.tex"):
        assert main(["equations", "quarter_car", "--latex", str(path)]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert all(each in err for each in ("--latex", repr(str(path))))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.tex"]
