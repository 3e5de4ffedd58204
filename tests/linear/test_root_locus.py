"""Root loci hold the eigenvalues, in continuous branches with names and units."""

from collections.abc import Callable
from dataclasses import replace

import control
import numpy as np
import pytest

from chassym.derivation import Model, ParameterError
from chassym.linear import LinearisationError, LinearModel, damped_modes, linearise
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.modal.root_locus import parameter_root_locus, root_locus

TORSION = "body.front.torsional_stiffness", "body.rear.torsional_stiffness"


def oscillators(
    model: LinearModel, stiffness: Callable[[float], list[float]], damping: Callable[[float], list[float]]
) -> Callable[[float], LinearModel]:
    """Two uncoupled oscillators of unit mass in the place of a quarter car."""

    def at(value: float) -> LinearModel:
        matrices = {"damping": np.diag(damping(value)), "stiffness": np.diag(stiffness(value))}
        return replace(model, mass=np.eye(2), **matrices)

    return at


def assert_same_set(first: np.ndarray, second: np.ndarray, rtol: float) -> None:
    distances = np.abs(np.asarray(first)[:, None] - np.asarray(second))
    assert distances.min(axis=0).max() < rtol * np.abs(second).max()
    assert distances.min(axis=1).max() < rtol * np.abs(second).max()


def test_branches_pass_through_a_crossing(quarter_linear: LinearModel) -> None:
    values = np.linspace(1.0, 9.0, 18)  # eigenvalues +-i sqrt(k) and +-2i cross at k = 4
    at = oscillators(quarter_linear, lambda k: [k, 4.0], lambda k: [0.0, 0.0])
    locus = root_locus(at, values, "k", "N/m").to_numpy()
    expected = {(sign, which) for sign in (1, -1) for which in ("moves", "stays")}
    for branch in locus.T:
        sign = 1 if branch[0].imag > 0 else -1
        moves = abs(branch[0].imag) < 1.5
        frequency = np.sqrt(values) if moves else 2.0
        np.testing.assert_allclose(branch, 1j * sign * frequency, atol=1e-12)
        expected.remove((sign, "moves" if moves else "stays"))
    assert not expected


def test_overdamping(quarter_linear: LinearModel) -> None:
    """lambda = w (-zeta +- sqrt(zeta^2 - 1)): a circle of radius w, then two decays with product w^2."""
    ratios = np.linspace(0.1, 2.0, 39)
    at = oscillators(quarter_linear, lambda _: [9.0, 400.0], lambda ratio: [6 * ratio, 4.0])
    locus = root_locus(at, ratios, "damping ratio", "").to_numpy()
    pair = locus[:, np.abs(locus[0]) < 4]
    assert pair.shape == (39, 2)
    np.testing.assert_allclose(pair.prod(axis=1), 9.0, atol=1e-6)
    np.testing.assert_allclose(pair.sum(axis=1), -6 * ratios, atol=1e-6)
    np.testing.assert_allclose(np.abs(pair[ratios < 0.99]), 3.0)
    assert not pair[ratios > 1.01].imag.any()
    # On the real axis, too, a branch goes on as it began: one decays ever faster, the other ever more slowly.
    steps = np.diff(np.abs(pair[ratios > 1.05]), axis=0)
    assert (np.sign(steps) == np.sign(steps[0])).all() and steps[0].prod() < 0


def test_a_stiffness_is_a_gain(quarter_linear: LinearModel) -> None:
    """More tyre stiffness k is a feedback -k of the wheel's displacement to a force on the wheel."""
    wheel = np.array([0.0, 1.0])
    gains = np.linspace(0.0, 3e5, 7)
    locus = root_locus(
        lambda k: replace(quarter_linear, stiffness=quarter_linear.stiffness + k * np.outer(wheel, wheel)),
        gains,
        "added tyre stiffness",
        "N/m",
    )
    matrices = displacements_and_rates(quarter_linear)
    force = np.concatenate([np.zeros(2), np.linalg.solve(quarter_linear.mass, wheel)])[:, None]
    plant = control.ss(matrices.A, force, [[*wheel, 0, 0]], 0)
    for row, expected in zip(locus.to_numpy(), control.root_locus_map(plant, gains).loci, strict=True):
        assert_same_set(row, expected, 1e-8)


def test_against_a_parameter(quarter_car: Model) -> None:
    masses = [30.0, 40.0, 50.0]
    locus = parameter_root_locus(quarter_car, "unsprung.mass", masses)
    assert locus.dims == ("value", "branch")
    assert locus.attrs["units"] == "1/s"
    assert (locus.attrs["parameter"], locus.attrs["parameter_units"]) == ("unsprung.mass", "kg")
    assert locus.attrs["description"] == "quarter_car linearised at the design position"
    np.testing.assert_array_equal(locus["value"], masses)
    for mass in masses:
        linear = linearise(quarter_car.with_parameters({"unsprung.mass": mass}))
        for root in locus.sel(value=mass).to_numpy():
            dynamic = root**2 * linear.mass + root * linear.damping + linear.stiffness
            assert np.linalg.svd(dynamic, compute_uv=False)[-1] < 1e-9 * np.linalg.norm(dynamic)


def test_branches_are_named_by_the_modes_at_the_first_value(sedan: Model) -> None:
    locus = parameter_root_locus(sedan, "suspension.front.unsprung.mass", [40.0, 41.0])
    modes = damped_modes(linearise(sedan.with_parameters({"suspension.front.unsprung.mass": 40.0})))
    assert sorted(locus["mode"].to_numpy()) == sorted([mode.name for mode in modes] * 2)
    for mode in modes:
        roots = locus.isel(value=0).to_numpy()[locus["mode"].to_numpy() == mode.name]
        assert_same_set(roots, np.array([mode.eigenvalue, np.conj(mode.eigenvalue)]), 1e-9)


def test_branches_do_not_depend_on_the_steps(sedan: Model) -> None:
    def at(stiffness: float) -> LinearModel:
        return linearise(sedan.with_parameters(dict.fromkeys(TORSION, stiffness)))

    fine = np.geomspace(1e5, 1e7, 81)
    one = root_locus(at, fine[::2], "body torsional stiffness", "N*m/rad")
    other = root_locus(at, fine, "body torsional stiffness", "N*m/rad")
    np.testing.assert_allclose(one.to_numpy(), other.to_numpy()[::2], rtol=1e-8)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([], "shape"),
        ([[1.0]], "shape"),
        ([1.0, 1.0], "increase"),
        ([2.0, 1.0], "increase"),
        ([1.0, np.nan], "finite"),
    ],
)
def test_values_have_to_increase(quarter_linear: LinearModel, values: list, message: str) -> None:
    with pytest.raises(LinearisationError, match=message):
        root_locus(lambda _: quarter_linear, values, "k", "N/m")


def test_other_coordinates_are_refused(quarter_linear: LinearModel, half_linear: LinearModel) -> None:
    with pytest.raises(LinearisationError, match="4 eigenvalues at 0 and 8 at 1"):
        root_locus(lambda value: half_linear if value else quarter_linear, [0.0, 1.0], "k", "N/m")


def test_an_unknown_parameter_is_refused(quarter_car: Model) -> None:
    with pytest.raises(ParameterError, match=r"tyre\.stifness"):
        parameter_root_locus(quarter_car, "tyre.stifness", [1.0, 2.0])
