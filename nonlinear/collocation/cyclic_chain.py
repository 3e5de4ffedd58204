"""Chains of linear maps that close: d[k + 1] = A[k] d[k] + g[k], and d[0] after the last."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array
from scipy.sparse.linalg import splu

Array = np.ndarray

_GROWTH = 1e6
"""Growth of deviations along the chain up to which their product loses no more than half of all digits."""


_UNBOUNDED = 1e8
"""How much larger than what is missing after one turn deviations may be at most."""


class CyclicChain:
    """A closed chain.

    Parameters
    ----------
    maps
        A, shape (links, size, size).
    """

    def __init__(self, maps: Array) -> None:
        self._maps = maps
        along = np.eye(maps.shape[1])
        products = [along]
        with np.errstate(over="ignore", invalid="ignore"):  # what grows so much is solved another way
            for each in maps:
                along = each @ along
                products.append(along)
        self._products = np.stack(products)

    @property
    def product(self) -> Array:
        """The map once around; not finite if it is too large for numbers, shape (size, size)."""
        return np.asarray(self._products[-1])

    def solution(self, gaps: Array) -> Array:
        """Every d for some g, shape (links, size) as theirs.

        By way of d[0], whose equation holds the product of all maps; where deviations grow on the way, as
        about an unstable orbit, the equations of all are solved together.

        Raises
        ------
        numpy.linalg.LinAlgError
            If there is none, or more than one, to within rounding.
        """
        if not np.abs(self._products[:-1]).max() < _GROWTH:
            return self._together(gaps)
        gathered = [np.zeros(gaps.shape[1])]
        for each, gap in zip(self._maps, gaps, strict=True):
            gathered.append(each @ gathered[-1] + gap)
        missing = gathered.pop()
        first = np.linalg.solve(np.eye(len(missing)) - self.product, missing)
        if np.abs(first).max() > _UNBOUNDED * np.abs(missing).max():
            raise np.linalg.LinAlgError("what is missing after one turn makes deviations without bounds")
        return np.asarray(self._products[:-1] @ first + gathered)

    def _together(self, gaps: Array) -> Array:
        links, size = gaps.shape
        unit = np.broadcast_to(np.eye(size), self._maps.shape)
        order = np.arange(links)
        blocks = np.stack([-self._maps, unit], axis=1).reshape(-1, size, size)
        columns = np.stack([order, (order + 1) % links], axis=1).ravel()
        matrix = bsr_array((blocks, columns, 2 * np.arange(links + 1)), shape=(links * size,) * 2)
        try:
            return np.asarray(splu(matrix.tocsc()).solve(gaps.ravel()).reshape(links, size))
        except RuntimeError as error:  # SuperLU's word for an exactly singular matrix
            raise np.linalg.LinAlgError(str(error)) from None
