"""Files that a command writes at its end: whether they can be written is said before it begins."""

from __future__ import annotations

import os
from pathlib import Path

from splinebba_cli.errors import OutputError


def require_place(place: Path | None) -> None:
    """Refuse a file whose folder is not there, or takes no files.

    Raises
    ------
    OutputError
        SBB601 there is no folder, SBB605 nothing may be written there, SBB607 the place is a folder.
    """
    if place is None:
        return
    folder = place.parent
    if not os.path.isdir(folder):  # unlike is_dir, no error where a name is too long
        help = "make the folder first, or choose another one"
        raise OutputError("SBB601", f"cannot write {place}: there is no folder `{folder}`", help)
    if os.path.isdir(place):
        raise OutputError("SBB607", f"cannot write {place}: it is a folder", "choose the name of a file")
    if not os.access(place if os.path.exists(place) else folder, os.W_OK):
        raise OutputError(
            "SBB605", f"cannot write {place}: not allowed", "choose a place in which you may write"
        )
