"""Equations as they are printed: read back and solved, they give the accelerations of the machine code."""

import re

import numpy as np
import pytest

from chassym.derivation import load_model
from chassym.written_equations import written_equations

FUNCTIONS = {"cos": np.cos, "sin": np.sin, "Max": max}


def evaluated(text, values):
    """Evaluate an equation's side; the names of values may hold dots and brackets."""
    known = "|".join(re.escape(name) for name in sorted(values, key=len, reverse=True))
    code = re.sub(rf"(?<![\w.])({known})(?![\w.\[])", lambda match: f"values[{match[0]!r}]", text)
    return eval(code, {"__builtins__": {}}, FUNCTIONS | {"values": values})


@pytest.mark.parametrize("vehicle", ["quarter_car", "half_car", "torsion_chain"])
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
