"""A cache of generated and compiled functions on disk: files complete or absent, rebuilt when damaged.

What is generated depends on the equations alone and is kept apart from the machine code made of it, which
depends on the processor too: on another processor equations are compiled, not derived again.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import json
import os
import tempfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from chassym.derivation.compilation.instructions import LANES


@dataclass(frozen=True)
class Source:
    """What is generated of one function, the same for every processor.

    Attributes
    ----------
    arguments
        Names of its arguments, in order.
    parameters
        Names of the parameters that its constants are computed from, in order.
    constants
        Number of constants.
    rows, columns
        Where every result stands in the array that the function returns.
    packed
        Assembly text, compressed: it is read only where there is no object code yet.
    lanes
        Samples of one pass.
    """

    arguments: tuple[str, ...]
    parameters: tuple[str, ...]
    constants: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]
    packed: bytes = field(repr=False)
    lanes: int = LANES

    @property
    def assembly(self) -> str:
        """Assembly text."""
        return zlib.decompress(self.packed).decode()


@dataclass(frozen=True)
class Entry:
    """One compiled function.

    Attributes
    ----------
    source
        What it was compiled from.
    processor
        What the object code depends on besides its source.
    object_code
        Machine code.
    """

    source: Source
    processor: str
    object_code: bytes = field(repr=False)


def pack(assembly: str) -> bytes:
    """Compress assembly text."""
    return zlib.compress(assembly.encode())


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
    """A name for everything that an entry depends on."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:40]


def fetch_source(name: str, build: Callable[[], Source]) -> Source:
    """The generated source of a name, from the disk if it is whole there, otherwise built and kept."""
    path = f"{name}.source.json"
    with contextlib.suppress(*_NOT_WHOLE):
        return _source(_read(path))
    source = build()
    _keep(path, asdict(source) | {"packed": _text(source.packed)})
    return source


def fetch_object_code(source: Source, processor: str, build: Callable[[], bytes]) -> bytes:
    """The object code of a source for a processor, from the disk or built, as `fetch_source` does."""
    path = f"{key([hashlib.sha256(source.packed).hexdigest(), processor])}.code.json"
    with contextlib.suppress(*_NOT_WHOLE):
        return _bytes(_read(path)["object_code"])
    object_code = build()
    _keep(path, {"object_code": _text(object_code)})
    return object_code


_NOT_WHOLE = (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError)
"""What reading raises from a file that is absent, damaged or another's, or where there is no folder."""


def _source(fields: dict[str, Any]) -> Source:
    return Source(
        tuple(fields["arguments"]),
        tuple(fields["parameters"]),
        fields["constants"],
        tuple(fields["rows"]),
        tuple(fields["columns"]),
        _bytes(fields["packed"]),
        fields["lanes"],
    )


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _bytes(text: str) -> bytes:
    return base64.b64decode(text, validate=True)


def _checksum(name: str, text: str) -> str:
    """A sum of an entry and of its own name: a file copied to another name is not whole there."""
    return hashlib.sha256(f"{name}\0{text}".encode()).hexdigest()


def _read(name: str) -> dict[str, Any]:
    """The fields of a file.

    Raises
    ------
    OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError
        If it is not whole.
    """
    envelope = json.loads((directory() / name).read_bytes())
    text = envelope["entry"]
    if _checksum(name, text) != envelope["checksum"]:
        raise ValueError("damaged entry")
    fields: dict[str, Any] = json.loads(text)
    return fields


def _keep(name: str, fields: dict[str, Any]) -> None:
    """Write a file so that another process sees all of it or nothing; without a disk, do nothing."""
    text = json.dumps(fields)
    data = json.dumps({"checksum": _checksum(name, text), "entry": text}).encode()
    with contextlib.suppress(OSError, RuntimeError):
        _replace(directory() / name, data)


def _replace(path: Path, data: bytes) -> None:
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
