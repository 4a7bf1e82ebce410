"""The folder of a starter: its files come together or not at all, whatever else the folder holds."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from splinebba_cli.errors import OutputError
from splinebba_cli.output.publish import published
from splinebba_cli.project.file_content import PROJECT_FILE


def require_free(folder: Path, force: bool) -> None:
    """Nothing of anybody is in the way.

    Raises
    ------
    OutputError
        SBB603, if the folder is a file, or not empty while `force` is not given.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError("SBB603", f"`{folder}` is a file", "choose another folder")
    if folder.is_dir() and any(folder.iterdir()) and not force:
        help = "choose another folder; --force replaces the files of the same names and leaves the others"
        raise OutputError("SBB603", f"`{folder}` is not empty", help)


def write_starter(folder: Path, files: Mapping[str, str]) -> Path:
    """Write the files, all of them or none; those of other names stay.

    Returns
    -------
    Path of the project file

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB606, SBB607, if something cannot be written.
    """
    with published(folder, PROJECT_FILE) as fresh:
        for name, text in files.items():
            (fresh / name).write_text(text, encoding="utf-8", newline="\n")
    return folder / PROJECT_FILE
