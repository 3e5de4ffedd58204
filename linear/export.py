"""The state space as a MAT-file for MATLAB, Octave and Simulink."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np

from chassym.derivation.files import replace_file
from chassym.linear.input_conventions import InputConvention, displacements_and_rates
from chassym.linear.linear_model import LinearModel

Array = np.ndarray


def write_mat(
    path: str | Path, linear: LinearModel, inputs: InputConvention = displacements_and_rates
) -> None:
    """Write one struct ``plant`` to a MAT-file (level 5): all of it or, where that fails, nothing.

    Its fields are the matrices A, B, C, D; the cell columns state_names, input_names, output_names and
    state_units, input_units, output_units; Ts = 0 for continuous time; the name of the model; and a
    description that states the slope of every table and what the inputs are. In MATLAB or Octave::

        load plant.mat
        ss(plant.A, plant.B, plant.C, plant.D, 'StateName', plant.state_names, ...
           'InputName', plant.input_names, 'OutputName', plant.output_names)

    Parameters
    ----------
    path
        File to write or replace; its folder must exist and its name end in ``.mat``, as MATLAB expects.
    linear
        The linear model.
    inputs
        What the inputs are; see `chassym.linear.input_conventions`.

    Raises
    ------
    FileNotFoundError
        If the folder does not exist.
    ValueError
        If the name does not end in ``.mat``.
    LinearisationError
        If the mass matrix is singular, or the convention impossible.
    """
    target = Path(path)
    if target.suffix != ".mat":
        raise ValueError(f"path {str(path)!r} does not end in '.mat'; MATLAB would read it as text")
    if not target.parent.is_dir():
        raise FileNotFoundError(
            f"path {str(path)!r}: folder {str(target.parent)!r} does not exist; create it first"
        )
    replace_file(target, _encoded(_fields(linear, inputs)))


def _fields(linear: LinearModel, inputs: InputConvention) -> dict[str, object]:
    matrices = inputs(linear)
    return {
        "A": matrices.A,
        "B": matrices.B,
        "C": matrices.C,
        "D": matrices.D,
        "state_names": _cells(matrices.state_names),
        "input_names": _cells(matrices.input_names),
        "output_names": _cells(matrices.output_names),
        "state_units": _cells(matrices.state_units),
        "input_units": _cells(matrices.input_units),
        "output_units": _cells(matrices.output_units),
        "Ts": 0.0,
        "name": linear.name,
        "description": f"{linear.description}; inputs are {_words(inputs)}",
    }


def _words(inputs: InputConvention) -> str:
    """What a convention, be it a function or an object, is called."""
    return str(getattr(inputs, "__name__", type(inputs).__name__)).replace("_", " ")


def _cells(texts: Sequence[str]) -> Array:
    """A column of cells."""
    column = np.empty((len(texts), 1), dtype=object)
    column[:, 0] = texts
    return column


def _encoded(plant: dict[str, object]) -> bytes:
    from scipy.io import savemat  # it brings in much: only for those who ask for it

    buffer = BytesIO()
    savemat(buffer, {"plant": plant}, do_compression=True)
    return buffer.getvalue()
