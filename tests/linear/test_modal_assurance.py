"""The modal assurance criterion: its properties, closed forms, and the flexible car against the rigid one."""

from dataclasses import replace

import numpy as np
import pytest

from chassym.derivation import Model, load_model
from chassym.linear import LinearisationError, LinearModel, linearise, undamped_modes
from chassym.linear.modal.modal_assurance import common_coordinates, compare_modes, modal_assurance


@pytest.fixture(scope="module")
def rigid_linear() -> LinearModel:
    return linearise(load_model("rigid_sedan"))


def complex_shapes(seed: int, count: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    return random.normal(size=(5, count)) + 1j * random.normal(size=(5, count))


def test_it_is_the_squared_cosine_of_an_angle() -> None:
    angle = np.linspace(0, np.pi, 7)
    found = modal_assurance([[1], [0]], [np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(found, [np.cos(angle) ** 2], atol=1e-15)


def test_factors_do_not_matter_and_conjugates_do() -> None:
    first, second = complex_shapes(1, 3), complex_shapes(2, 4)
    found = modal_assurance(first, second)
    assert found.shape == (3, 4) and (found > 0).all() and (found < 1).all()
    np.testing.assert_allclose(modal_assurance(first * [2j, -1, 1 + 1j], second), found, rtol=1e-13)
    np.testing.assert_allclose(modal_assurance(second, first), found.T, rtol=1e-13)
    assert modal_assurance(first[:, :1], first[:, :1].conj())[0, 0] < 0.9


def test_a_weight_is_another_choice_of_coordinates() -> None:
    """W = L L^T: the same as without a weight for L^T a."""
    first, second = complex_shapes(3, 3), complex_shapes(4, 2)
    lower = np.tril(np.random.default_rng(5).normal(size=(5, 5))) + 3 * np.eye(5)
    expected = modal_assurance(lower.T @ first, lower.T @ second)
    np.testing.assert_allclose(modal_assurance(first, second, lower @ lower.T), expected, rtol=1e-12)


def test_undamped_modes_are_orthogonal_in_the_mass(sedan_linear: LinearModel) -> None:
    shapes = undamped_modes(sedan_linear).shapes
    np.testing.assert_allclose(modal_assurance(shapes, shapes, sedan_linear.mass), np.eye(12), atol=1e-20)


def test_the_flexible_car_against_the_rigid_one(sedan: Model, rigid_linear: LinearModel) -> None:
    """A mode without its twist is that of the rigid car, up to a part that falls with 1 / stiffness^2."""
    lacks = []
    for stiffness in (5e6, 5e7):
        names = [f"body.{joint}.torsional_stiffness" for joint in ("front", "rear")]
        found = compare_modes(linearise(sedan.with_parameters(dict.fromkeys(names, stiffness))), rigid_linear)
        assert found.shape == (12, 10)
        same = found.sel(first_mode=found["second_mode"].values)
        assert (same.argmax("first_mode") == np.arange(10)).all()
        lacks.append(1 - np.diag(same).min())
    assert lacks[0] < 2e-3
    assert lacks[0] / lacks[1] == pytest.approx(100, rel=0.2)


def test_labels(sedan_linear: LinearModel, rigid_linear: LinearModel) -> None:
    found = compare_modes(sedan_linear, rigid_linear, modes_of=lambda linear: undamped_modes(linear).modes)
    assert found.dims == ("first_mode", "second_mode")
    assert tuple(found["first_mode"].values) == undamped_modes(sedan_linear).names
    np.testing.assert_allclose(found["second_frequency_hz"], undamped_modes(rigid_linear).frequencies_hz)
    plain = compare_modes(sedan_linear, rigid_linear, weight=np.eye(10))
    assert plain.sel(first_mode="yaw", second_mode="yaw") > 0.9


def test_the_weight_is_the_mass_of_the_smaller_model(quarter_linear: LinearModel) -> None:
    small = replace(quarter_linear, mass=np.array([[3.0, 0.5], [0.5, 1.0]]), damping=np.zeros((2, 2)))
    large = replace(
        small,
        mass=np.diag([4.0, 1.0, 7.0]),
        stiffness=np.array([[3.0, -1, 0], [-1, 4, -2], [0, -2, 5]]),
        damping=np.zeros((3, 3)),
        coordinates=("wheel_bounce", "seat", "body_bounce"),
    )
    shapes = undamped_modes(large).shapes[[2, 0]], undamped_modes(small).shapes
    expected = modal_assurance(*shapes, small.mass)
    np.testing.assert_allclose(compare_modes(large, small), expected, atol=1e-9)
    np.testing.assert_allclose(compare_modes(small, large), expected.T, atol=1e-9)


def test_common_coordinates(sedan_linear: LinearModel, rigid_linear: LinearModel) -> None:
    assert common_coordinates(sedan_linear, rigid_linear) == rigid_linear.coordinates
    assert common_coordinates(rigid_linear, sedan_linear) == rigid_linear.coordinates


def test_nothing_in_common_is_refused(sedan_linear: LinearModel, quarter_linear: LinearModel) -> None:
    with pytest.raises(LinearisationError, match="body_bounce, wheel_bounce have none in common"):
        compare_modes(sedan_linear, quarter_linear)


def test_a_mode_beside_the_common_coordinates_is_refused(quarter_linear: LinearModel) -> None:
    split = replace(quarter_linear, mass=np.eye(2), stiffness=np.diag([1.0, 4.0]), damping=np.zeros((2, 2)))
    other = replace(split, coordinates=("body_bounce", "seat"))
    with pytest.raises(LinearisationError, match="'wheel hop' .* moves none of .* body_bounce"):
        compare_modes(split, other)


@pytest.mark.parametrize(
    ("first", "second", "weight", "message"),
    [
        (np.ones((2, 1)), np.ones((3, 1)), None, r"\(2, 1\) and \(3, 1\) .* do not fit"),
        (np.ones((2, 1)), np.ones((2, 1)), np.eye(3), r"weight \(3, 3\) do not fit"),
        (np.zeros((2, 1)), np.ones((2, 1)), None, "squared size of zero"),
        (np.ones((2, 1)), np.ones((2, 1)), -np.eye(2), "positive definite"),
    ],
)
def test_what_does_not_fit_is_refused(
    first: np.ndarray, second: np.ndarray, weight: np.ndarray | None, message: str
) -> None:
    with pytest.raises(LinearisationError, match=message) as error:
        modal_assurance(first, second, weight)
    assert "\n" not in str(error.value)
