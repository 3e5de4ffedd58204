"""The results of a sweep as labelled arrays with units, and as files."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from chassym.nonlinear.sweep.sampling import Points
from chassym.nonlinear.sweep.store import Row

if TYPE_CHECKING:
    import xarray

SUFFIXES = (".nc", ".zarr")
"""Of the names of files that results are written to: netCDF and Zarr."""


class ResultFileError(ValueError):
    """A file that results cannot be written to; the message tells what would be accepted."""


@dataclass(frozen=True)
class Column:
    """One of the numbers that are kept of every point."""

    name: str
    unit: str
    description: str


def to_dataset(
    points: Points, columns: Sequence[Column], rows: Sequence[Row], attributes: Mapping[str, str | float]
) -> xarray.Dataset:
    """The columns, ``patch`` and ``reason`` over the points' dimensions, each number with its unit.

    Parameters
    ----------
    rows
        One of every point, in order.
    """
    import xarray

    dimensions, sizes = tuple(points.shape), tuple(points.shape.values())
    numbers = np.array([row.numbers for row in rows]).reshape(*sizes, len(columns))
    variables = {
        column.name: (
            dimensions,
            np.ascontiguousarray(numbers[..., place]),
            {"units": column.unit, "long_name": column.description},
        )
        for place, column in enumerate(columns)
    }
    words = {
        "patch": ([row.patch for row in rows], "contact patch with the smallest force"),
        "reason": ([row.reason for row in rows], "why the point failed, empty if it did not"),
    }
    texts = {
        name: (dimensions, np.array(column, dtype=object).reshape(sizes), {"long_name": description})
        for name, (column, description) in words.items()
    }
    return xarray.Dataset(variables | texts, points.to_xarray().coords, dict(attributes))


def refuse_unwritable(path: Path) -> None:
    """Refuse a file that results cannot be written to.

    Raises
    ------
    ResultFileError
        If the suffix is not one of `SUFFIXES`, or Zarr is not installed.
    """
    if path.suffix not in SUFFIXES:
        raise ResultFileError(f"{str(path)!r}: a name that ends in {' or '.join(SUFFIXES)} is needed")
    if path.suffix == ".zarr" and find_spec("zarr") is None:
        raise ResultFileError(f"{path}: Zarr is not installed; install chassym[zarr], or write a .nc file")


def write_results(results: xarray.Dataset, path: str | Path) -> Path:
    """Write results as netCDF or Zarr, by the suffix of the name.

    They are written under another name first. A netCDF file then replaces what was there before at once. Zarr
    is a folder, which cannot be replaced so: what was there before is removed, then the new one is moved.

    Raises
    ------
    ResultFileError
        If the suffix is another one, or Zarr is not installed.
    OSError
        If the file cannot be written; a netCDF file that was there before stays as it was.
    """
    target = Path(path)
    refuse_unwritable(target)
    writers = dict(zip(SUFFIXES, (_write_netcdf, _write_zarr), strict=True))
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        writers[target.suffix](results, temporary)
        if temporary.is_dir():
            _remove(target)
        os.replace(temporary, target)
    finally:
        _remove(temporary)
    return target


def _write_netcdf(results: xarray.Dataset, path: Path) -> None:
    results.to_netcdf(path)


def _write_zarr(results: xarray.Dataset, path: Path) -> None:
    results.to_zarr(path, mode="w", zarr_format=2)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
