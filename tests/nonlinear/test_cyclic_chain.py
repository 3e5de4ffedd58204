"""Closed chains of linear maps, by their product and all together."""

import numpy as np
import pytest

from chassym.nonlinear.collocation.cyclic_chain import CyclicChain

Array = np.ndarray


def is_solution(maps: Array, gaps: Array, found: Array) -> bool:
    following = np.einsum("kij,kj->ki", maps, found) + gaps
    size = np.abs(maps).max() * np.abs(found).max() + np.abs(gaps).max()
    return bool(np.abs(following - np.roll(found, -1, axis=0)).max() < 1e-12 * size)


@pytest.mark.parametrize("growth", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("links", [1, 2, 40])
def test_deviations_follow_each_other_around(growth: float, links: int) -> None:
    """At a growth of 3 in 40 links the product of the maps knows nothing of the decaying ones any more."""
    generator = np.random.default_rng(0)
    turned, _ = np.linalg.qr(generator.normal(size=(links, 4, 4)))
    maps = turned * np.array([growth, 0.3, 0.2, 0.9])
    gaps = generator.normal(size=(links, 4))
    assert is_solution(maps, gaps, CyclicChain(maps).solution(gaps))


def test_growth_beyond_all_numbers() -> None:
    maps = np.full((700, 1, 1), 10.0)
    chain = CyclicChain(maps)
    assert not np.isfinite(chain.product).all()
    np.testing.assert_allclose(chain.solution(np.ones((700, 1))), -1 / 9, rtol=1e-14)


@pytest.mark.parametrize("growth", [1.0, 1e4])
def test_what_comes_back_unchanged_is_refused(growth: float) -> None:
    maps = np.array([[[growth]], [[1 / growth]]] * 2)
    with pytest.raises(np.linalg.LinAlgError):
        CyclicChain(maps).solution(np.ones((4, 1)))
