"""Files of what is stored in a folder, for other processes."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from .errors import CaseError

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


def check_page(path: str | os.PathLike[str]) -> None:
    """Requires the name of a page in a folder that is there."""
    if not os.fspath(path).lower().endswith((".html", ".htm")):
        raise CaseError(f"{os.fspath(path)}: a page is HTML; give a name that ends with .html")
    if not Path(path).absolute().parent.is_dir():
        raise CaseError(f"{os.fspath(path)}: there is no folder {Path(path).parent}; make it first")
