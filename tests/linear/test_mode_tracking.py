"""Tracking of modes: closed forms through crossings, veerings and overdamping; the car's body stiffness."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from numpy.typing import ArrayLike
from scipy.linalg import block_diag, eigvals

from chassym.derivation import Model, load_model
from chassym.linear import LinearisationError, LinearModel, damped_modes, linearise
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.modal.mode_tracking import track_modes, without_damping
from chassym.linear.modal.pair_following import paired
from chassym.linear.modal.spectrum import spectrum

Build = Callable[..., LinearModel]


@pytest.fixture(scope="module")
def oscillators() -> Build:
    """Give a linear model of the given matrices; C and M by default 0 and 1."""
    some = linearise(load_model("quarter_car"))

    def build(
        stiffness: ArrayLike, damping: ArrayLike | None = None, mass: ArrayLike | None = None
    ) -> LinearModel:
        K = np.array(stiffness, dtype=float)
        n = len(K)
        return replace(
            some,
            mass=np.eye(n) if mass is None else np.array(mass, dtype=float),
            damping=np.zeros((n, n)) if damping is None else np.array(damping, dtype=float),
            stiffness=K,
            coordinates=tuple(f"mass_{i}" for i in range(n)),
            slopes={},
        )

    return build


def squares(found: xr.Dataset) -> np.ndarray:
    return (2 * np.pi * found["frequency_hz"].values) ** 2


def rotated(shape: tuple[int, int], seed: int) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=shape))[0]


@pytest.mark.parametrize("count", [2, 7, 8])
def test_uncoupled_oscillators_cross(oscillators: Build, count: int) -> None:
    """K = diag(1, v), seen from turned axes; with an odd count the crossing itself is among the values."""
    axes, values = rotated((2, 2), 1), np.geomspace(0.25, 4, count)
    found = track_modes(lambda v: oscillators(axes @ np.diag([1.0, v]) @ axes.T), values)
    np.testing.assert_allclose(squares(found), np.column_stack([values, np.ones(count)]), rtol=1e-9)
    for mode, axis in enumerate(axes.T[::-1]):
        overlap = np.abs(found["shape"].values[:, mode] @ axis)
        np.testing.assert_allclose(overlap, 1, rtol=1e-9)


@pytest.mark.parametrize("coupling", [0.1, 1e-3, 3e-5])
@pytest.mark.parametrize("count", [2, 3, 41])
def test_coupled_oscillators_veer(oscillators: Build, coupling: float, count: int) -> None:
    """K = [[1 + v, e], [e, 1 - v]]: w^2 = 1 -+ sqrt(v^2 + e^2), and the shapes turn by a quarter."""
    values = np.linspace(-0.5, 0.5, count)
    found = track_modes(lambda v: oscillators([[1 + v, coupling], [coupling, 1 - v]]), values)
    split = np.sqrt(values**2 + coupling**2)
    np.testing.assert_allclose(squares(found), np.column_stack([1 - split, 1 + split]), rtol=1e-9)
    turn = np.arctan2(coupling, values) / 2  # of the upper shape; the lower one is perpendicular to it
    upper, lower = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    for mode, expected in enumerate((lower, upper)):
        overlap = np.abs((found["shape"].values[:, mode] * expected.T).sum(axis=1))
        np.testing.assert_allclose(overlap, 1, rtol=1e-7)


def test_a_veering_narrower_than_the_stated_bound_is_a_crossing(oscillators: Build) -> None:
    found = track_modes(lambda v: oscillators([[1 + v, 1e-9], [1e-9, 1 - v]]), [-0.5, 0.5])
    np.testing.assert_allclose(squares(found), [[0.5, 1.5], [1.5, 0.5]], rtol=1e-9)


def test_steps_are_divided_only_where_it_takes_that(oscillators: Build) -> None:
    smooth = track_modes(lambda v: oscillators(np.diag([1.0, v])), np.linspace(2, 3, 5))
    assert smooth.attrs["evaluations"] == 5
    narrow = track_modes(lambda v: oscillators([[1 + v, 3e-5], [3e-5, 1 - v]]), [-0.5, 0.5])
    assert 10 < narrow.attrs["evaluations"] < 120


@pytest.mark.parametrize("values", [np.linspace(0, 2.5, 11), [0, 2.5], np.linspace(2.5, 0, 5)])
def test_proportional_damping_through_overdamping(oscillators: Build, values: np.ndarray) -> None:
    """C = b K: zeta = b w / 2, up to 5 here; decays of different modes cross, two are critical exactly."""
    frequencies = np.array([1.0, 1.6, 2.0, 4.0])
    axes = rotated((4, 4), 3)
    mass = axes.T @ np.diag([1.0, 2.0, 0.5, 3.0]) @ axes
    root = np.linalg.cholesky(mass)
    stiffness = root @ axes @ np.diag(frequencies**2) @ axes.T @ root.T
    found = track_modes(lambda b: oscillators(stiffness, b * stiffness, mass), values)
    np.testing.assert_allclose(2 * np.pi * found["frequency_hz"], np.tile(frequencies, (len(values), 1)))
    ratios = np.multiply.outer(values, frequencies) / 2
    np.testing.assert_allclose(found["damping_ratio"], ratios, rtol=1e-7, atol=1e-9)
    root_of = np.sqrt(ratios**2 - 1 + 0j)
    expected = frequencies * (-ratios + np.where(ratios >= 1, root_of, 1j * np.abs(root_of)))
    np.testing.assert_allclose(found["eigenvalue"].values[..., 0], expected, rtol=1e-6, atol=1e-6)
    assert {name.split()[0] for name in found["mode"].values} == {"mass"}


def test_one_oscillator_passes_critical_damping(oscillators: Build) -> None:
    """A loose coupling to another mass; through c = 2 the pair turns real and its shape has no jump."""

    def at(damping: float) -> LinearModel:
        return oscillators([[1.3, -0.3], [-0.3, 9.3]], [[damping, 0], [0, 0.1]])

    values = np.linspace(1, 4, 61)
    found = track_modes(at, values)
    slow = found.isel(mode=0)
    assert slow["damping_ratio"][0] < 0.5 and slow["damping_ratio"][-1] > 1.7
    assert np.abs(np.diff(slow["damping_ratio"], 2)).max() < 1e-3
    assert np.abs(np.diff(slow["shape"], axis=0)).max() < 0.05
    for value, pair in zip(values, found["eigenvalue"].values, strict=True):
        expected = eigvals(
            np.block([[np.zeros((2, 2)), np.eye(2)], [-at(value).stiffness, -at(value).damping]])
        )
        np.testing.assert_allclose(np.sort_complex(pair.ravel()), np.sort_complex(expected), atol=1e-9)


def test_decays_of_different_modes_that_merge_are_refused(oscillators: Build) -> None:
    """The fast decay of one oscillator meets the slow one, -1, of another; coupled, they oscillate."""

    def at(damping: float, coupling: float) -> LinearModel:
        return oscillators([[0.25, coupling], [coupling, 9.0]], [[damping, 0], [0, 10.0]])

    uncoupled = track_modes(lambda c: at(c, 0.0), [0.9, 1.5])
    np.testing.assert_allclose(uncoupled["eigenvalue"][-1, 1], [-1, -9], rtol=1e-9)
    with pytest.raises(LinearisationError, match="modes 'mass 0' and 'mass 1' .* near c = 1.2") as error:
        track_modes(lambda c: at(c, 0.05), [0.9, 1.5], parameter="c", unit="N s/m")
    assert "\n" not in str(error.value)


def test_flutter_is_refused_and_tracked_on_either_side(oscillators: Build) -> None:
    """K = [[1, p], [-p, 2]]: w^2 = 1.5 -+ sqrt(0.25 - p^2), which meet at p = 0.5 and turn complex."""

    def at(p: float) -> LinearModel:
        return oscillators([[1, p], [-p, 2]])

    values = np.linspace(0, 0.45, 4)
    before = track_modes(at, values)
    split = np.sqrt(0.25 - values**2)
    np.testing.assert_allclose(squares(before), np.column_stack([1.5 - split, 1.5 + split]), rtol=1e-9)
    with pytest.raises(LinearisationError, match="cannot be told apart near p = 0.5"):
        track_modes(at, [0.3, 0.7], parameter="p")
    after = track_modes(at, [0.7, 0.9])["eigenvalue"].values
    for p, pairs in zip((0.7, 0.9), after, strict=True):
        found = pairs.ravel() ** 2
        expected = -1.5 + 1j * np.sqrt(p**2 - 0.25) * np.array([-1, -1, 1, 1])
        np.testing.assert_allclose(found[found.imag.argsort()], expected, rtol=1e-9)


def test_a_start_among_mixed_decays_is_refused(oscillators: Build, quarter_linear: LinearModel) -> None:
    """Two quarter cars with dampers that lock: bounce and wheel hop have exchanged eigenvalues on the way."""
    M, C, K = quarter_linear.mass, quarter_linear.damping, quarter_linear.stiffness
    start = oscillators(block_diag(K, 4 * K), block_diag(8 * C, 16 * C), block_diag(M, M))
    with pytest.raises(LinearisationError, match="'mass 0' .* cannot be .* at v = 2: as damping .* at 0.2"):
        track_modes(lambda _: start, [2.0], parameter="v")
    assert [mode.partner for mode in damped_modes(start)] == [None] * 6


def test_two_modes_that_become_one(oscillators: Build) -> None:
    """At p = 0.5 the only eigenvalues are l^2 = -1.5, with the shape (1, 1): the limit of both modes."""
    found = track_modes(lambda p: oscillators([[1, p], [-p, 2]]), [0.3, 0.5]).isel(value=-1)
    np.testing.assert_allclose(found["eigenvalue"] ** 2, -1.5, rtol=1e-4)
    shapes = found["shape"].values
    np.testing.assert_allclose(shapes[:, 1] / shapes[:, 0], 1, rtol=1e-4)


def test_steps_between_positive_values_are_ratios(oscillators: Build) -> None:
    """A veering at 1e-3 in a step from 1e-5 to 1e5."""
    found = track_modes(lambda v: oscillators([[v, 1e-5], [1e-5, 1e-3]]), [1e-5, 1e5])
    np.testing.assert_allclose(squares(found)[-1], [1e-3, 1e5], rtol=1e-6)
    assert found.attrs["evaluations"] < 20


def test_equal_masses_that_are_overdamped_in_turned_directions(oscillators: Build) -> None:
    """K = 1, C with 3 and 5 on other axes: l^2 + 3 l + 1 and l^2 + 5 l + 1, all of them real."""
    pairs = paired(oscillators(np.eye(2), [[4.0, 1.0], [1.0, 4.0]]))
    np.testing.assert_allclose(np.sort(pairs.sums), [-5, -3], rtol=1e-9)
    np.testing.assert_allclose(pairs.products, 1, rtol=1e-9)


@pytest.mark.parametrize("damping", [0.0, 0.1, 2.0, 2.5])
@pytest.mark.parametrize("seed", [None, 1, 2, 3])
def test_spectral_projectors(oscillators: Build, damping: float, seed: int | None) -> None:
    """Idempotent, they commute with A and add up to 1: for free, equal and critically damped masses, too."""
    axes = np.eye(4) if seed is None else rotated((4, 4), seed)
    matrices = (
        axes @ np.diag(values) @ axes.T for values in ([1.0, 1, 0, 9], damping * np.array([1, 1, 0, 1]))
    )
    found = spectrum(oscillators(*matrices))
    total = np.zeros((8, 8))
    for eigenvalue in found.eigenvalues:
        projector = eigenvalue.right @ eigenvalue.left
        np.testing.assert_allclose(projector @ projector, projector, atol=1e-10)
        commuted = found.motion.matrix @ projector - projector @ found.motion.matrix
        np.testing.assert_allclose(commuted, 0, atol=1e-10)
        assert np.trace(projector) == pytest.approx(eigenvalue.right.shape[1], abs=1e-10)
        total += projector.real * (2 if eigenvalue.value.imag else 1)
    np.testing.assert_allclose(total, np.eye(8), atol=1e-10)
    assert sum(eigenvalue.dimensions for eigenvalue in found.eigenvalues) == 8
    assert [e.dimensions for e in found.eigenvalues if e.value == 0] == [2]


def test_twins_are_followed_in_their_common_subspace(oscillators: Build) -> None:
    """Two equal oscillators beside a third one that crosses them, seen from turned axes."""
    axes, values = rotated((3, 3), 7), np.linspace(0.5, 2, 6)
    found = track_modes(lambda v: oscillators(axes @ np.diag([1, 1, v]) @ axes.T, 0.1 * np.eye(3)), values)
    np.testing.assert_allclose(squares(found)[:, 1:], 1, rtol=1e-9)
    np.testing.assert_allclose(squares(found)[:, 0], values, rtol=1e-9)
    np.testing.assert_allclose(found["damping_ratio"], 0.05 / np.sqrt(squares(found)), rtol=1e-9)
    steps = np.einsum("vmc,vmc->vm", found["shape"].values[1:], found["shape"].values[:-1].conj())
    np.testing.assert_allclose(steps, 1, rtol=1e-6)


def test_modes_that_are_equal_at_the_first_value_only(oscillators: Build) -> None:
    """The damping singles out the shapes that go on; without a hint they are refused."""
    values = [1.0, 2.0]
    damped = track_modes(lambda v: oscillators([[v, 1 - v], [1 - v, v]], [[0.2, -0.1], [-0.1, 0.2]]), values)
    np.testing.assert_allclose(np.sort(squares(damped), axis=1), [[1, 1], [1, 3]], rtol=1e-9)
    with pytest.raises(LinearisationError, match="cannot be told apart near value = 1"):
        track_modes(lambda v: oscillators([[v, v - 1], [v - 1, v]]), values)


def test_a_position_that_becomes_unstable(oscillators: Build) -> None:
    """K = diag(v, 4) down to v = -1: w^2 = v passes zero, the pair becomes a growth and a decay."""
    values = np.array([1.0, 0.5, 0.0, -0.5, -1.0])
    for damping in (0.0, 0.2):
        found = track_modes(lambda v, c=damping: oscillators(np.diag([v, 4.0]), np.diag([c, 0.0])), values)
        loose = found.isel(mode=0)
        np.testing.assert_allclose(loose["eigenvalue"].prod("pair").real, values, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(loose["eigenvalue"].sum("pair").real, -damping, rtol=1e-9, atol=1e-12)
    assert loose["damping_ratio"][2] == np.inf and loose["frequency_hz"][2] == 0


def test_a_rigid_body_mode_stays_at_zero(torsion_chain: Model) -> None:
    """Two equal shafts on three equal inertias: 0, sqrt(k / I), sqrt(3 k / I)."""
    values = np.geomspace(1e4, 1e8, 5)

    def at(k: float) -> LinearModel:
        return linearise(torsion_chain.with_parameters({"stiffness.front": k, "stiffness.rear": k}))

    for found in (track_modes(at, values), track_modes(lambda k: without_damping(at(k)), values)):
        expected = np.sqrt(np.outer(values, [0, 1, 3]) / 126)
        np.testing.assert_allclose(2 * np.pi * found["frequency_hz"], expected, rtol=1e-9)
        assert list(found["mode"].values) == ["roll", "body torsion, opposite", "body torsion, in phase"]
        assert (found["damping_ratio"].sel(mode="roll") == 0).all()


def test_two_free_directions_with_and_without_drag(oscillators: Build) -> None:
    found = track_modes(lambda v: oscillators(np.diag([0, 0, v])), [1.0, 2.0])
    np.testing.assert_allclose(squares(found), [[0, 0, 1], [0, 0, 2]], rtol=1e-9)
    dragged = track_modes(lambda c: oscillators(np.diag([0, 0, 1.0]), np.diag([c, 2 * c, c])), [0.5, 1.0])
    np.testing.assert_allclose(np.sort(dragged["eigenvalue"][-1, :2, 1].real), [-2, -1], rtol=1e-9)
    np.testing.assert_allclose(dragged["eigenvalue"][:, :2, 0], 0, atol=1e-12)


@pytest.mark.parametrize(
    "seed", [0, 1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 40))]
)
def test_identity_depends_on_neither_steps_nor_direction_nor_coordinates(
    oscillators: Build, seed: int
) -> None:
    """Random damped systems of six masses: each step's eigenvalues, and the same curves from other grids."""
    random, n = np.random.default_rng(seed), 6
    first, last = (random.normal(size=(n, n)) for _ in range(2))
    losses = random.normal(size=(n, 2))
    base, change = first @ first.T + np.eye(n), last @ last.T
    turn = random.normal(size=(n, n))

    def at(value: float) -> LinearModel:
        return oscillators(base + value * change, 0.1 * losses @ losses.T)

    def turned(value: float) -> LinearModel:
        linear = at(value)
        mass, damping, stiffness = (
            turn.T @ matrix @ turn for matrix in (linear.mass, linear.damping, linear.stiffness)
        )
        return oscillators(stiffness, damping, mass)

    fine, coarse, other = (
        track_modes(function, np.linspace(0, 1, count))
        for function, count in ((at, 65), (at, 3), (turned, 9))
    )
    for found in (coarse, other):
        expected = fine["eigenvalue"].sel(value=found["value"])
        np.testing.assert_allclose(found["eigenvalue"].values, expected.values, rtol=1e-6)
    back = track_modes(at, np.linspace(1, 0, 3))["eigenvalue"].values
    order = [int(np.abs(back[0, :, 0] - value).argmin()) for value in coarse["eigenvalue"].values[-1, :, 0]]
    np.testing.assert_allclose(back[::-1, order], coarse["eigenvalue"].values, rtol=1e-6)
    zero = np.zeros((n, n))
    companion = np.block([[zero, np.eye(n)], [-at(0.5).stiffness, -at(0.5).damping]])
    found_there = np.sort_complex(coarse["eigenvalue"].sel(value=0.5).values.ravel())
    np.testing.assert_allclose(found_there, np.sort_complex(eigvals(companion)), rtol=1e-8)


def test_pairs_of_an_overdamped_quarter_car(quarter_linear: LinearModel) -> None:
    stiff = replace(quarter_linear, damping=8 * quarter_linear.damping)
    pairs = paired(stiff)
    expected = np.sort_complex(eigvals(displacements_and_rates(stiff).A))
    np.testing.assert_allclose(np.sort_complex(pairs.eigenvalues.ravel()), expected, rtol=1e-9)
    det_k, det_m = np.linalg.det(stiff.stiffness), np.linalg.det(stiff.mass)
    assert pairs.products.prod() == pytest.approx(det_k / det_m, rel=1e-9)
    assert -pairs.sums.sum() == pytest.approx(np.trace(np.linalg.solve(stiff.mass, stiff.damping)), rel=1e-9)


def body_stiffness(sedan: Model) -> Callable[[float], LinearModel]:
    """Give the car with both body joints of one stiffness; its damping is 0.001 s times that."""
    names = [f"body.{joint}.torsional_stiffness" for joint in ("front", "rear")]
    return lambda stiffness: linearise(sedan.with_parameters(dict.fromkeys(names, stiffness)))


@pytest.fixture(scope="module")
def soft_to_stiff(sedan: Model) -> xr.Dataset:
    """Give the car's modes over its body's stiffness, three values a decade."""
    values = np.geomspace(1e2, 1e9, 22)
    return track_modes(
        body_stiffness(sedan), values, parameter="body stiffness", unit="N*m/rad", named_at=5e6
    )


def test_twelve_modes_of_the_car_through_its_body_s_stiffness(
    sedan: Model, sedan_linear: LinearModel, soft_to_stiff: xr.Dataset
) -> None:
    """All eigenvalues at every value, no jumps, and the names of the nominal car."""
    at, found = body_stiffness(sedan), soft_to_stiff
    assert found.sizes == {"value": 22, "mode": 12, "pair": 2, "coordinate": 12}
    assert set(found["mode"].values) == {mode.name for mode in damped_modes(sedan_linear)}
    assert found.attrs["parameter"] == "body stiffness" and found["value"].attrs["units"] == "N*m/rad"
    for value in found["value"].values[[0, 10, 21]]:
        expected = np.sort_complex(eigvals(displacements_and_rates(at(value)).A))
        pairs = found["eigenvalue"].sel(value=value).values
        np.testing.assert_allclose(np.sort_complex(pairs.ravel()), expected, rtol=1e-7)
    shapes = found["shape"].values
    for before, after, value in zip(shapes, shapes[1:], found["value"].values[1:], strict=False):
        alike = np.einsum("mi,ij,mj->m", before.conj(), at(value).mass, after)
        assert alike.real.min() > 0.5


def test_body_torsion_becomes_overdamped(soft_to_stiff: xr.Dataset) -> None:
    """At the stiff end each has zeta = 0.0005 s w, above 1, and its two decays add up to -0.001 s w^2."""
    stiff = soft_to_stiff.isel(value=-1)
    for name, least in (("body torsion, opposite", 1.3), ("body torsion, in phase", 2.4)):
        mode = stiff.sel(mode=name)
        speed = 2 * np.pi * mode["frequency_hz"].item()
        assert mode["damping_ratio"].item() > least
        assert mode["damping_ratio"].item() == pytest.approx(0.0005 * speed, rel=5e-3)
        assert (mode["eigenvalue"].values.imag == 0).all()
        assert mode["eigenvalue"].values.real.sum() == pytest.approx(-0.001 * speed**2, rel=5e-3)


def test_the_stiff_end_converges_to_the_rigid_car(soft_to_stiff: xr.Dataset) -> None:
    """Ten modes differ from those of the rigid car by a part that falls with 1 / stiffness."""
    rigid = {mode.name: mode for mode in damped_modes(linearise(load_model("rigid_sedan")))}
    differences = {}
    for value in (1e7, 1e8, 1e9):
        there = soft_to_stiff.sel(value=value, method="nearest")
        pairs = [there["eigenvalue"].sel(mode=name).values[0] for name in rigid]
        expected = np.array([mode.eigenvalue for mode in rigid.values()])
        differences[value] = np.abs(np.array(pairs) / expected - 1).max()
    assert differences[1e9] < 5e-5
    assert differences[1e7] / differences[1e8] == pytest.approx(10, rel=0.05)
    assert differences[1e8] / differences[1e9] == pytest.approx(10, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("count", [8, 141])
def test_the_car_s_modes_do_not_depend_on_the_steps(
    sedan: Model, soft_to_stiff: xr.Dataset, count: int
) -> None:
    other = track_modes(body_stiffness(sedan), np.geomspace(1e2, 1e9, count), named_at=5e6)
    other = other.sel(mode=soft_to_stiff["mode"])
    for value in (1e2, 1e5, 1e9):
        pairs = [found["eigenvalue"].sel(value=value, method="nearest") for found in (soft_to_stiff, other)]
        np.testing.assert_allclose(pairs[0].values, pairs[1].values, rtol=1e-7)


@pytest.mark.slow
def test_the_soft_front_joint_alone(sedan: Model) -> None:
    """One joint from 1e2 to 1e9, the other nominal: there and back give the same curves."""

    def at(stiffness: float) -> LinearModel:
        return linearise(sedan.with_parameters({"body.front.torsional_stiffness": stiffness}))

    values = np.geomspace(1e2, 1e9, 36)
    there, back = (track_modes(at, v, named_at=5e6) for v in (values, values[::-1]))
    back = back.isel(value=slice(None, None, -1)).sel(mode=there["mode"])
    np.testing.assert_allclose(back["frequency_hz"], there["frequency_hz"], rtol=1e-7)


@pytest.mark.parametrize("values", [[], [1.0, np.inf], [[1.0]], 3.0])
def test_values_that_are_none_are_refused(oscillators: Build, values: ArrayLike) -> None:
    with pytest.raises(LinearisationError, match="values: received .* finite numbers"):
        track_modes(lambda v: oscillators(np.diag([v, 1])), values)


def test_other_coordinates_are_refused(oscillators: Build) -> None:
    with pytest.raises(
        LinearisationError, match="coordinates mass_0, mass_1, mass_2 at value = 3 and mass_0"
    ):
        track_modes(lambda v: oscillators(np.eye(int(v))), [2.0, 3.0])
