"""Linear equations solved to the last digits of small unknowns beside large ones."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def refined_solve(matrix: Array, right: Array) -> tuple[Array, Array]:
    """Solve matrix @ x = right with one step of iterative refinement.

    The residual is taken in the precision of the arguments, `numpy.longdouble` or `numpy.clongdouble`, the
    factorisation in double precision. What is small in x because large terms cancel, as the response of one
    wheel to another far above all resonances, thereby keeps its digits. Where the platform has no longer
    floating-point numbers than double ones, this is an ordinary solution. Higham, Accuracy and Stability of
    Numerical Algorithms, 2nd ed., section 12.1.

    Parameters
    ----------
    matrix, right
        Shapes (..., n, n) and (..., n, columns), in extended precision.

    Returns
    -------
    x
        Shape (..., n, columns), in extended precision.
    correction
        The largest correction relative to the largest unknown, of all columns, shape (...): about the
        condition number times 1e-16. The digits of x are not determined where it is near one.

    Raises
    ------
    numpy.linalg.LinAlgError
        If a matrix is exactly singular.

    Examples
    --------
    >>> matrix = np.array([[3.0, 1.0], [1.0, 2.0]], dtype=np.longdouble)
    >>> x, correction = refined_solve(matrix, np.array([[5.0], [5.0]], dtype=np.longdouble))
    >>> x.astype(float).ravel().round(12).tolist(), bool(correction < 1e-12)
    ([1.0, 2.0], True)
    """
    double = complex if np.iscomplexobj(right) else float
    rounded = matrix.astype(double)
    first = np.linalg.solve(rounded, right.astype(double))
    step = np.linalg.solve(rounded, (right - matrix @ first).astype(double))
    size = np.abs(first).max(axis=(-2, -1), initial=0.0)
    correction = np.abs(step).max(axis=(-2, -1), initial=0.0) / np.where(size > 0, size, 1.0)
    return first.astype(right.dtype) + step, correction
