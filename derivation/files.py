"""Files that are whole or absent: what is being written takes its place at once."""

from __future__ import annotations

import os
from pathlib import Path


def replace_file(target: Path, data: bytes) -> None:
    """Write a file under another name in the same folder, then put it in place at once.

    Raises
    ------
    OSError
        If the folder cannot be written to; a file that was there before stays as it was.
    """
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
