"""MAT-files: what is written is what is read, whole or not at all."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io
from scipy.io import loadmat, whosmat

from chassym.linear import LinearisationError, LinearModel, write_mat
from chassym.linear.input_conventions import (
    InputConvention,
    accelerations,
    displacements,
    displacements_and_rates,
    rates,
)


def texts(cells: np.ndarray) -> tuple[str, ...]:
    assert cells.dtype == object and cells.shape == (len(cells), 1)
    return tuple(str(cell[0][0]) for cell in cells)


def test_plant_is_read_back(tmp_path: Path, sedan_linear: LinearModel) -> None:
    path = tmp_path / "plant.mat"
    write_mat(path, sedan_linear)
    assert whosmat(path) == [("plant", (1, 1), "struct")]
    plant, matrices = loadmat(path)["plant"][0, 0], displacements_and_rates(sedan_linear)
    for name in "ABCD":
        np.testing.assert_array_equal(plant[name], getattr(matrices, name))
    for signal in ("state", "input", "output"):
        assert texts(plant[f"{signal}_names"]) == getattr(matrices, f"{signal}_names")
        assert texts(plant[f"{signal}_units"]) == getattr(matrices, f"{signal}_units")
    assert plant["Ts"].item() == 0.0
    assert plant["name"].item() == "full_car"
    described = plant["description"].item()
    assert described == f"{sedan_linear.description}; inputs are displacements and rates"
    assert "mean_slope" in described


@pytest.mark.parametrize("convention", [rates, accelerations])
def test_the_convention_of_the_inputs_is_written_and_stated(
    tmp_path: Path, quarter_linear: LinearModel, convention: InputConvention
) -> None:
    path = tmp_path / "plant.mat"
    write_mat(path, quarter_linear, convention)
    plant, matrices = loadmat(path)["plant"][0, 0], convention(quarter_linear)
    for name in "ABCD":
        np.testing.assert_array_equal(plant[name], getattr(matrices, name))
    for signal in ("state", "input", "output"):
        assert texts(plant[f"{signal}_names"]) == getattr(matrices, f"{signal}_names")
        assert texts(plant[f"{signal}_units"]) == getattr(matrices, f"{signal}_units")
    assert plant["description"].item().endswith(f"; inputs are {convention.__name__}")


def test_an_impossible_convention_writes_nothing(tmp_path: Path, quarter_linear: LinearModel) -> None:
    with pytest.raises(LinearisationError, match="improper"):
        write_mat(tmp_path / "plant.mat", quarter_linear, displacements)
    assert not list(tmp_path.iterdir())


def test_system_without_inputs_is_written(tmp_path: Path, chain_linear: LinearModel) -> None:
    write_mat(tmp_path / "chain.mat", chain_linear)
    assert loadmat(tmp_path / "chain.mat")["plant"][0, 0]["A"].shape == (6, 6)


def test_a_file_is_replaced_and_nothing_is_left_beside_it(
    tmp_path: Path, quarter_linear: LinearModel
) -> None:
    path = tmp_path / "plant.mat"
    path.write_text("old")
    write_mat(str(path), quarter_linear)
    assert loadmat(path)["plant"][0, 0]["A"].shape == (4, 4)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("place", ["savemat", "replace"])
def test_a_failure_leaves_the_old_file(
    tmp_path: Path, quarter_linear: LinearModel, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError("disk full")

    path = tmp_path / "plant.mat"
    path.write_text("old")
    monkeypatch.setattr(*((scipy.io, "savemat") if place == "savemat" else ("os.replace",)), fail)
    with pytest.raises(OSError, match="disk full"):
        write_mat(path, quarter_linear)
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_missing_folder_is_refused(tmp_path: Path, quarter_linear: LinearModel) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere' does not exist; create it first") as error:
        write_mat(tmp_path / "nowhere" / "plant.mat", quarter_linear)
    assert "\n" not in str(error.value) and not list(tmp_path.iterdir())


def test_other_endings_are_refused(tmp_path: Path, quarter_linear: LinearModel) -> None:
    with pytest.raises(ValueError, match=r"does not end in '\.mat'"):
        write_mat(tmp_path / "plant.txt", quarter_linear)
