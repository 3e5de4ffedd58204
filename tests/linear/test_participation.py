"""Participation against left eigenvectors, and residues against the frequency response."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eig

from chassym.linear import LinearisationError, LinearModel, damped_modes, frequency_response, undamped_modes
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.modal.participation import input_output_participation, participation, participation_table

VEHICLES = ["sedan_linear", "quarter_linear", "half_linear", "circulatory"]


@pytest.fixture
def circulatory(half_linear: LinearModel) -> LinearModel:
    """Give the half car with a force that follows the pitch angle, and a gyroscopic moment."""
    stiffness, damping = half_linear.stiffness.copy(), half_linear.damping.copy()
    stiffness[0, 1] += 4e3
    damping[0, 1] += 500
    damping[1, 0] -= 500
    return replace(half_linear, stiffness=stiffness, damping=damping)


@pytest.mark.parametrize("name", VEHICLES)
def test_participation_is_that_of_the_first_order_system(name: str, request: pytest.FixtureRequest) -> None:
    """w_ki v_ki with the left eigenvectors from the inverse of the matrix of right ones."""
    linear = request.getfixturevalue(name)
    n, modes = len(linear.coordinates), damped_modes(linear)
    values, right = eig(displacements_and_rates(linear).A)
    factors = (right * np.linalg.inv(right).T).reshape(2, n, 2 * n).sum(axis=0)
    found = participation(linear, modes)
    for mode, column in zip(modes, found.values.T, strict=True):
        expected = factors[:, np.abs(values - mode.eigenvalue).argmin()]
        np.testing.assert_allclose(column, expected, atol=1e-9)
    np.testing.assert_allclose(found.sum("coordinate"), 1, rtol=1e-12)


@pytest.mark.parametrize("name", ["sedan_linear", "circulatory"])
def test_it_is_how_far_feedback_of_a_coordinate_moves_the_eigenvalue(
    name: str, request: pytest.FixtureRequest
) -> None:
    """A + e 1_kk in both states of coordinate k changes the eigenvalue by e p_k."""
    linear = request.getfixturevalue(name)
    n, modes, step = len(linear.coordinates), damped_modes(linear), 1e-4
    found = participation(linear, modes).values
    for k in (0, n - 1):
        change = np.zeros((2 * n, 2 * n))
        change[k, k] = change[n + k, n + k] = step
        ends = [np.linalg.eigvals(displacements_and_rates(linear).A + sign * change) for sign in (1, -1)]
        for mode, expected in zip(modes, found[k], strict=True):
            after, before = (end[np.abs(end - mode.eigenvalue).argmin()] for end in ends)
            assert (after - before) / (2 * step) == pytest.approx(expected, abs=1e-5)


def test_without_damping_it_is_the_share_of_the_kinetic_energy(half_linear: LinearModel) -> None:
    undamped = replace(half_linear, damping=np.zeros((4, 4)))
    for modes in (damped_modes(undamped), undamped_modes(half_linear).modes):
        shapes = np.array([mode.shape for mode in modes]).T
        found = participation(undamped, modes)
        np.testing.assert_allclose(found, shapes * (undamped.mass @ shapes), atol=1e-10)


def test_a_rigid_body_mode_and_equal_modes(chain_linear: LinearModel, quarter_linear: LinearModel) -> None:
    rigid = participation(chain_linear, damped_modes(chain_linear)).sel(mode="roll")
    np.testing.assert_allclose(rigid, [1, 0, 0], atol=1e-12)
    twins = replace(quarter_linear, mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2))
    found = participation(twins, damped_modes(twins))
    np.testing.assert_allclose(found.sum("coordinate"), 1, rtol=1e-12)
    np.testing.assert_allclose(found.sum("mode"), 1, rtol=1e-12)
    dragged = replace(twins, stiffness=np.diag([0.0, 4.0]))
    at_rest = participation(dragged, damped_modes(dragged)).isel(mode=0)
    np.testing.assert_allclose(at_rest, [1, 0], atol=1e-12)


@pytest.mark.parametrize("name", VEHICLES)
def test_residues_add_up_to_the_frequency_response(name: str, request: pytest.FixtureRequest) -> None:
    """G = sum of residue / (s - l) over all eigenvalues + D + C B' + s D'; B, D belong to u, B', D' to u'."""
    linear = request.getfixturevalue(name)
    modes, p = damped_modes(linear), len(linear.inputs)
    frequencies = np.array([0.3, 4.0, 50.0])
    s = 2j * np.pi * frequencies
    matrices = displacements_and_rates(linear)
    through, by_rate = matrices.D[:, :p] + matrices.C @ matrices.B[:, p:], matrices.D[:, p:]
    expected = through[..., None] + by_rate[..., None] * s
    residues = input_output_participation(linear, modes)["residue"].values
    for mode, residue in zip(modes, np.moveaxis(residues, -1, 0), strict=True):
        expected = expected + residue[..., None] / (s - mode.eigenvalue)
        if mode.eigenvalue.imag:
            expected = expected + residue.conj()[..., None] / (s - mode.eigenvalue.conjugate())
    found = frequency_response(linear, frequencies).response
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(found).max())


def test_excitation_and_observation_of_the_quarter_car(quarter_linear: LinearModel) -> None:
    found = input_output_participation(quarter_linear, damped_modes(quarter_linear))
    assert set(found.data_vars) == {"excitation", "observation", "residue"}
    assert found["input_unit"].sel(input="road") == "m"
    both = found["observation"] * found["excitation"]
    np.testing.assert_allclose(found["residue"], both.transpose("output", "input", "mode"))
    road = np.abs(found["excitation"].sel(input="road"))
    assert road.sel(mode="wheel hop") > road.sel(mode="bounce")


def test_free_flight_has_no_residue(sedan_linear: LinearModel) -> None:
    flying = replace(sedan_linear, stiffness=0 * sedan_linear.stiffness, damping=0 * sedan_linear.damping)
    with pytest.raises(LinearisationError, match="is in free flight.*leave it out"):
        input_output_participation(flying, damped_modes(flying))


def test_critical_damping_is_refused(quarter_linear: LinearModel) -> None:
    critical = replace(
        quarter_linear, mass=np.eye(2), damping=np.diag([2.0, 0.1]), stiffness=np.diag([1.0, 9])
    )
    with pytest.raises(LinearisationError, match="critically damped") as error:
        participation(critical, damped_modes(critical))
    assert "\n" not in str(error.value)


def test_table_by_what_moves(sedan_linear: LinearModel) -> None:
    modes = damped_modes(sedan_linear)
    table = participation_table(sedan_linear, modes)
    assert table.dims == ("mode", "motion") and list(table["mode"].values) == [mode.name for mode in modes]
    factors = participation(sedan_linear, modes)
    arms = factors.sel(coordinate=["front_left_arm_angle", "front_right_arm_angle"]).sum("coordinate")
    np.testing.assert_allclose(table.sel(motion="front wheel hop"), np.abs(arms), rtol=1e-12)
    assert table.to_pandas().shape == (12, 9)
    assert (table.idxmax("motion").sel(mode=["yaw", "longitudinal"]) == ["yaw", "longitudinal"]).all()
