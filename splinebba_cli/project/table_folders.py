"""Where the side tables of a project may lie: in its folder, and in those that it declares.

A name that leads elsewhere (``../``, an absolute path, a symbolic link) reads another project's table without anybody
seeing it, or a file that is no table at all.  `project.table_folders` says so in the head of the file.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path


def lies_within(file: Path, folder: Path, further: Sequence[str]) -> bool:
    """Whether a file, all symbolic links followed, lies in a folder or in one of further ones named from there."""
    real = os.path.realpath(file)
    roots = [os.path.realpath(folder), *(os.path.realpath(folder / name) for name in further)]
    return any(os.path.commonpath([real, root]) == root for root in roots if _comparable(real, root))


def _comparable(one: str, other: str) -> bool:
    """Whether two paths are on one drive."""
    return os.path.splitdrive(one)[0] == os.path.splitdrive(other)[0]


def folders_seen_from(directory: Path | None, folder: Path, further: Sequence[str]) -> list[str]:
    """A project's folders as another folder names them; absolute where `directory` is None."""
    real = [os.path.realpath(folder), *(os.path.realpath(folder / name) for name in further)]
    return [seen_from(directory, path) for path in real]


def seen_from(directory: Path | None, path: str) -> str:
    """A path (links followed) as a folder names it; absolute where `directory` is None."""
    if directory is None:
        return path
    try:
        return Path(os.path.relpath(path, os.path.realpath(directory))).as_posix()
    except ValueError:  # another drive
        return path
