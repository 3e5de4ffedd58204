"""A cache of compiled functions on disk: one file for each, complete or absent, rebuilt when damaged."""

from __future__ import annotations

import base64
import binascii
import contextlib
import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Entry:
    """What is kept of one compiled function.

    Attributes
    ----------
    parameters
        Names of the parameters that its constants are computed from, in order.
    constants
        Number of constants.
    rows, columns
        Where every result stands in the array that the function returns.
    object_code
        Machine code.
    """

    parameters: tuple[str, ...]
    constants: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]
    object_code: bytes


def directory() -> Path:
    """Where entries are kept: CHASSYM_CACHE_DIR, or the user's cache directory.

    Raises
    ------
    RuntimeError
        If the user has no home directory.
    """
    given = os.environ.get("CHASSYM_CACHE_DIR")
    if given:
        return Path(given)
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    return Path(base) / "chassym"


def key(parts: Sequence[str]) -> str:
    """A file name for everything that an entry depends on."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:40]


def fetch(name: str, build: Callable[[], Entry]) -> Entry:
    """The entry of a name, from the disk if it is whole there, otherwise built and if possible stored."""
    with contextlib.suppress(OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError):
        return _decode((directory() / f"{name}.json").read_bytes())
    entry = build()
    with contextlib.suppress(OSError, RuntimeError):
        _store(directory() / f"{name}.json", _encode(entry))
    return entry


def _encode(entry: Entry) -> bytes:
    fields = {
        "parameters": entry.parameters,
        "constants": entry.constants,
        "rows": entry.rows,
        "columns": entry.columns,
        "object_code": base64.b64encode(entry.object_code).decode(),
    }
    text = json.dumps(fields)
    return json.dumps({"checksum": hashlib.sha256(text.encode()).hexdigest(), "entry": text}).encode()


def _decode(data: bytes) -> Entry:
    """Read an entry.

    Raises
    ------
    ValueError, KeyError, TypeError, AttributeError
        If it is not whole.
    """
    envelope = json.loads(data)
    text = envelope["entry"]
    if hashlib.sha256(text.encode()).hexdigest() != envelope["checksum"]:
        raise ValueError("damaged entry")
    fields = json.loads(text)
    try:
        object_code = base64.b64decode(fields["object_code"], validate=True)
    except binascii.Error as error:
        raise ValueError("damaged entry") from error
    return Entry(
        tuple(fields["parameters"]),
        fields["constants"],
        tuple(fields["rows"]),
        tuple(fields["columns"]),
        object_code,
    )


def _store(path: Path, data: bytes) -> None:
    """Write a file so that another process sees all of it or nothing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.replace(temporary, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise
