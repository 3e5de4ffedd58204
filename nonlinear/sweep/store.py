"""Finished points of a sweep on disk, each there as soon as it is computed, in an SQLite file.

One process writes; a transaction holds what was computed together. With SQLite's write-ahead log what has
been stored survives the death of the process at any instant, and a transaction costs a tenth of a millisecond
(https://www.sqlite.org/wal.html).
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np

_FORMAT = "chassym sweep 1"

_TABLES = """
CREATE TABLE IF NOT EXISTS about (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS points (
    number INTEGER PRIMARY KEY, numbers BLOB NOT NULL, patch TEXT NOT NULL, reason TEXT NOT NULL
);
"""


class StoreError(ValueError):
    """A store that cannot be used; the message names the file, the cause and the remedy."""


@dataclass(frozen=True)
class Row:
    """A finished point.

    Attributes
    ----------
    number
        Which one.
    numbers
        What was measured, in the order that the sweep keeps; not a number where it failed.
    patch
        The contact patch with the smallest force.
    reason
        Why the point failed; empty if it did not.
    """

    number: int
    numbers: tuple[float, ...]
    patch: str
    reason: str


class Store:
    """The finished points of one sweep.

    Parameters
    ----------
    path
        A file, made if it is not there; None keeps the points in memory.
    identity
        What makes the sweep the one it is, in parts, each a word by its name.

    Raises
    ------
    StoreError
        If the file belongs to another sweep, to another program, or to a run that goes on.
    """

    def __init__(self, path: Path | None, identity: Mapping[str, str]) -> None:
        self._path = path
        try:
            self._connection = sqlite3.connect(":memory:" if path is None else path, timeout=0.0)
        except sqlite3.Error as error:
            raise self._refusal(f"{error}; a file in a folder that can be written to is needed") from None
        try:
            self._open(identity)
        except BaseException:
            self._connection.close()
            raise

    def _open(self, identity: Mapping[str, str]) -> None:
        try:
            self._connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            tables = {name for (name,) in self._connection.execute("SELECT name FROM sqlite_master")}
            if tables and not {"about", "points"} <= tables:
                raise self._refusal("not the store of a sweep; choose another name")
            for setting in ("journal_mode = WAL", "synchronous = NORMAL"):
                self._connection.execute(f"PRAGMA {setting}")
            with self._connection:
                self._connection.executescript(_TABLES)
                known = dict(self._connection.execute("SELECT name, value FROM about"))
                about = {"format": _FORMAT} | dict(identity)
                if not known:
                    self._connection.executemany("INSERT INTO about VALUES (?, ?)", about.items())
        except sqlite3.OperationalError as error:
            raise self._refusal(f"{error}; another run may be using it, or it cannot be written") from None
        except sqlite3.DatabaseError as error:
            raise self._refusal(f"{error}; choose another name") from None
        others = [name for name in about if known and known.get(name) != about[name]]
        if others:
            raise self._refusal(
                f"belongs to a sweep with another {' and another '.join(others)}; "
                "choose another name, or remove it to start anew"
            )

    def _refusal(self, cause: str) -> StoreError:
        return StoreError(f"store {str(self._path)!r}: {cause}")

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.close()

    def add(self, rows: Iterable[Row]) -> None:
        """Keep points that were computed together: all of them or, if the process dies, none.

        Raises
        ------
        StoreError
            If they cannot be written.
        """
        fields = [(r.number, np.array(r.numbers, dtype="<f8").tobytes(), r.patch, r.reason) for r in rows]
        try:
            with self._connection:
                self._connection.executemany("INSERT OR REPLACE INTO points VALUES (?, ?, ?, ?)", fields)
        except sqlite3.Error as error:
            raise self._refusal(f"{error}; make room for it and start the sweep again to go on") from None

    def finished(self) -> set[int]:
        """Numbers of the points that are there."""
        return {number for (number,) in self._connection.execute("SELECT number FROM points")}

    def rows(self) -> Iterable[Row]:
        """The points that are there, by number."""
        chosen = "SELECT number, numbers, patch, reason FROM points ORDER BY number"
        for number, numbers, patch, reason in self._connection.execute(chosen):
            yield Row(number, tuple(np.frombuffer(numbers, dtype="<f8").tolist()), patch, reason)
