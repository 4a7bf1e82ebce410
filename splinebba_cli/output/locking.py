"""One run at a time writes a folder: a lock file beside it, which the kernel frees when the process dies."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from splinebba_cli.errors import OutputError


def lock_path(final: Path) -> Path:
    """Where the lock of a folder lies."""
    return final.parent / f".{final.name}.lock"


@contextmanager
def locked(final: Path, shown: Path) -> Iterator[None]:
    """Hold the lock of a folder.

    Parameters
    ----------
    final : Path
        The folder, resolved; the folder around it must exist.
    shown : Path
        The same as the user named it.

    Raises
    ------
    OutputError
        SBB606 if another run holds it.  A file that a dead process has left is no lock.
    """
    path = lock_path(final)
    descriptor = locked_descriptor(path)
    if descriptor is None:
        help = "wait for it, or give this run another folder with -o"
        raise OutputError("SBB606", f"another run is writing {shown}", help)
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)


def locked_descriptor(path: Path) -> int | None:
    """Open a file, made where it is not there, and lock it; None if someone else holds it."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            if not _try_lock(descriptor):
                os.close(descriptor)
                return None
            if path.exists() and os.path.samestat(os.fstat(descriptor), os.stat(path)):
                return descriptor
        except FileNotFoundError:
            pass
        os.close(descriptor)  # the holder before us removed the file between open and lock: again


def remove_unlocked(path: Path) -> None:
    """Remove a file that nobody holds; its holder has ended without removing it."""
    with suppress(OSError):
        descriptor = os.open(path, os.O_RDWR)
        try:
            if _try_lock(descriptor):
                path.unlink()
        finally:
            os.close(descriptor)


def _try_lock(descriptor: int) -> bool:
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno in (errno.ENOLCK, errno.ENOTSUP):  # a file system without locks: go on without
            return True
        raise
    return True
