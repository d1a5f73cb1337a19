"""Files of what is stored in a folder, for other processes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

T = TypeVar("T")


def stored(save: Callable[[str], None]) -> dict[str, bytes]:
    """Files that `save` writes into a folder, by their names."""
    with TemporaryDirectory() as folder:
        save(folder)
        found = filter(Path.is_file, Path(folder).rglob("*"))
        return {str(file.relative_to(folder)): file.read_bytes() for file in found}


def restored(files: dict[str, bytes], load: Callable[[str], T]) -> T:
    """What `load` makes of a folder with files."""
    with TemporaryDirectory() as folder:
        for name, content in files.items():
            file = Path(folder, name)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        return load(folder)
