"""Files of a folder that the program replaces as a whole: its own, and those that people have put there."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path

_HEAD = 200  # characters in which the format of a file stands


def begins_with_format(file: Path, format: str) -> bool:
    """Whether a JSON file begins with a format of this program."""
    try:
        with file.open(encoding="utf-8") as stream:
            head = stream.read(_HEAD)
    except (OSError, UnicodeDecodeError):
        return False
    return re.match(rf'\{{\s*"format":\s*"{re.escape(format)}"', head) is not None


def write_inside(folder: Path, name: str, text: str) -> None:
    """Write a text; its name may hold subfolders, but must not lead out of the folder."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{name!r} is outside of the folder")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")


def keep_foreign_files(old: Path, new: Path, is_own: Callable[[str], bool]) -> None:
    """Take over what people have put into the old folder: notes, plots.

    Parameters
    ----------
    is_own : callable
        Whether a name in the old folder is one of the program's; what stands in the new one already is.
    """
    if not old.is_dir():
        return
    written = {entry.name for entry in new.iterdir()}
    for entry in old.iterdir():
        if entry.name in written or is_own(entry.name):
            continue
        if entry.is_dir() and not entry.is_symlink():
            shutil.copytree(entry, new / entry.name, symlinks=True, copy_function=_link_or_copy)
        else:
            _link_or_copy(str(entry), str(new / entry.name))


def _link_or_copy(source: str, target: str) -> str:
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)
    return target
