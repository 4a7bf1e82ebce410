"""What the system says when something cannot be written, in the user's words."""

from __future__ import annotations

import errno
from pathlib import Path

from splinebba_cli.errors import OutputError

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FORBIDDEN = {errno.EACCES, errno.EPERM, errno.EROFS}
_NAMES = {errno.ENAMETOOLONG, errno.ENOTDIR, errno.EISDIR, errno.ELOOP, errno.EINVAL, errno.EILSEQ}
_FIXED = {errno.EBUSY, errno.EXDEV}


def cannot_write(path: Path | str, error: OSError) -> OutputError:
    """The error for the user.

    Parameters
    ----------
    path : Path or str
        What was to be written, as the user named it.
    error : OSError

    Returns
    -------
    OutputError
        SBB604 the disk is full, SBB605 not allowed, SBB607 the name will not do, else SBB601.
    """
    reason = error.strerror or str(error)
    message = f"cannot write {path}: {reason}"
    number = error.errno
    if number in _FULL:
        return OutputError("SBB604", message, "free some space, or write elsewhere with -o, and run again")
    if number in _FORBIDDEN:
        return OutputError("SBB605", message, "choose a folder with -o in which you may write")
    if number in _NAMES:
        return OutputError("SBB607", message, "choose another name with -o")
    if number in _FIXED:
        return OutputError(
            "SBB601", message, "a folder of its own is needed: choose one inside of it with -o"
        )
    if number == errno.ENOENT:
        return OutputError("SBB601", message, "the folder around it is not there, or was removed meanwhile")
    return OutputError("SBB601", message, "look after the disk, or choose another folder with -o")


def is_full(error: OSError) -> bool:
    """Whether there was no room."""
    return error.errno in _FULL
