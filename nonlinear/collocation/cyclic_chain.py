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
    maps, gaps
        A and g, shapes (links, size, size) and (links, size).
    """

    def __init__(self, maps: Array, gaps: Array) -> None:
        self._maps, self._gaps = maps, gaps
        size = maps.shape[1]
        along = np.eye(size, size + 1)
        self._along = [along]
        with np.errstate(over="ignore", invalid="ignore"):  # what grows so much is solved another way
            for each, gap in zip(maps, gaps, strict=True):
                along = each @ along
                along[:, -1] += gap
                self._along.append(along)

    @property
    def product(self) -> Array:
        """The map once around; not finite if it is too large for numbers, shape (size, size)."""
        return self._along[-1][:, :-1]

    def solution(self) -> Array:
        """Every d, shape (links, size).

        By way of d[0], whose equation holds the product of all maps; where deviations grow on the way, as
        about an unstable orbit, the equations of all are solved together.

        Raises
        ------
        numpy.linalg.LinAlgError
            If there is none, or more than one, to within rounding.
        """
        along = np.stack(self._along[:-1])
        if not np.abs(along).max() < _GROWTH:
            return self._together()
        whole = self._along[-1]
        first = np.linalg.solve(np.eye(len(whole)) - whole[:, :-1], whole[:, -1])
        if np.abs(first).max() > _UNBOUNDED * np.abs(whole[:, -1]).max():
            raise np.linalg.LinAlgError("what is missing after one turn makes deviations without bounds")
        return np.asarray(along @ np.append(first, 1.0))

    def _together(self) -> Array:
        links, size = self._gaps.shape
        unit = np.broadcast_to(np.eye(size), self._maps.shape)
        order = np.arange(links)
        blocks = np.stack([-self._maps, unit], axis=1).reshape(-1, size, size)
        columns = np.stack([order, (order + 1) % links], axis=1).ravel()
        matrix = bsr_array((blocks, columns, 2 * np.arange(links + 1)), shape=(links * size,) * 2)
        try:
            return np.asarray(splu(matrix.tocsc()).solve(self._gaps.ravel()).reshape(links, size))
        except RuntimeError as error:  # SuperLU's word for an exactly singular matrix
            raise np.linalg.LinAlgError(str(error)) from None
