"""Files and folders that are either the old ones or the new ones, never a mixture.

A folder is built beside its target, forced to the disk, and takes the target's name in one step of the
kernel (Linux: ``renameat2`` with ``RENAME_EXCHANGE``).  Where the kernel or the file system has no such step,
the old folder is renamed away first; what a run leaves that is killed in between, the next one repairs.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from splinebba_cli.errors import OutputError

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2


def write_file_atomically(path: Path, content: bytes | str) -> None:
    """Write one file: the old content or the new one, whatever happens.

    Parameters
    ----------
    path : Path
        The file; its folder must exist.  A symbolic link is followed.
    content : bytes or str
        Text is written as UTF-8, its line ends as they are.

    Raises
    ------
    OutputError
        SBB601 if the file cannot be written.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    target = path.resolve()
    try:
        descriptor, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".new", dir=target.parent)
        try:
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            os.chmod(name, _file_mode(target))
            os.replace(name, target)
        except BaseException:
            with suppress(OSError):
                os.unlink(name)
            raise
        _sync_directory(target.parent)
    except OSError as error:
        raise _cannot_write(path, error) from error


@contextmanager
def replace_directory(target: Path, replaceable: Callable[[Path], bool]) -> Iterator[Path]:
    """A new folder to fill; it takes the place of `target` when the block ends without an exception.

    Parameters
    ----------
    target : Path
        The folder to write or to replace.  A symbolic link is followed.
    replaceable : callable
        Whether an existing, non-empty folder may be replaced: protects a mistyped ``-o ~``.

    Yields
    ------
    Path
        An empty folder on the same file system.

    Raises
    ------
    OutputError
        SBB602 if the target may not be replaced, SBB601 if it cannot be written or another run writes it.
    """
    final = target.resolve()
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        with _lock(final, target):
            _recover(final)
            _check_replaceable(final, target, replaceable)
            fresh = Path(tempfile.mkdtemp(prefix=_prefix(final, "new"), dir=final.parent))
            try:
                os.chmod(fresh, _directory_mode(final))
                yield fresh
                _sync_tree(fresh)
                _swap_in(fresh, final)
            finally:
                shutil.rmtree(fresh, ignore_errors=True)
    except OSError as error:
        raise _cannot_write(target, error) from error


def _prefix(final: Path, kind: str) -> str:
    return f".{final.name}.{kind}-"


def _cannot_write(path: Path, error: OSError) -> OutputError:
    reason = error.strerror or str(error)
    helps = {errno.ENOSPC: "free some space and run again", errno.EACCES: "choose another folder with -o"}
    return OutputError("SBB601", f"cannot write {path}: {reason}", helps.get(error.errno or 0, ""))


def _check_replaceable(final: Path, shown: Path, replaceable: Callable[[Path], bool]) -> None:
    if not final.exists():
        return
    if not final.is_dir():
        raise OutputError("SBB602", f"{shown} is a file, not a folder", "choose another folder with -o")
    if any(final.iterdir()) and not replaceable(final):
        raise OutputError(
            "SBB602",
            f"{shown} is not empty and not a folder of this program; it is left as it is",
            "choose another folder with -o, or empty this one",
        )


def _recover(final: Path) -> None:
    """Bring back an old folder that a killed run had renamed away; remove what killed runs left."""
    for stale in sorted(final.parent.glob(f"{_glob_escape(_prefix(final, 'old'))}*")):
        if final.exists():
            shutil.rmtree(stale, ignore_errors=True)
        else:
            os.rename(stale, final)
    for stale in final.parent.glob(f"{_glob_escape(_prefix(final, 'new'))}*"):
        shutil.rmtree(stale, ignore_errors=True)


def _glob_escape(text: str) -> str:
    return "".join(f"[{c}]" if c in "*?[" else c for c in text)


def _swap_in(fresh: Path, final: Path) -> None:
    """Give `fresh` the name `final`; whatever had it is in `fresh` or removed afterwards."""
    if not final.exists():
        os.rename(fresh, final)
    elif not _exchange(fresh, final):
        old = final.parent / f"{_prefix(final, 'old')}{os.getpid()}"
        os.rename(final, old)
        try:
            os.rename(fresh, final)
        except BaseException:
            os.rename(old, final)
            raise
        shutil.rmtree(old, ignore_errors=True)
    _sync_directory(final.parent)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two names in one step; False where the system cannot do that."""
    if not sys.platform.startswith("linux"):
        return False
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    renameat2.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint]
    renameat2.restype = ctypes.c_int
    done = renameat2(_AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE)
    if done == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        return False
    raise OSError(number, os.strerror(number), str(second))


@contextmanager
def _lock(final: Path, shown: Path) -> Iterator[None]:
    """Hold ``.<name>.lock`` beside the target; the kernel frees it when the process dies."""
    path = final.parent / f".{final.name}.lock"
    descriptor = _locked_descriptor(path)
    if descriptor is None:
        raise OutputError(
            "SBB601",
            f"another run is writing {shown}",
            "wait for it, or give this run another folder with -o",
        )
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)


def _locked_descriptor(path: Path) -> int | None:
    """Open and lock the lock file; None if someone else holds it."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            if not _try_lock(descriptor):
                os.close(descriptor)
                return None
            if path.exists() and os.path.samestat(os.fstat(descriptor), os.stat(path)):
                return descriptor
        except FileNotFoundError:
            pass
        os.close(descriptor)  # the holder before us removed the file between open and lock: again


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


def _sync_tree(folder: Path) -> None:
    for directory, _, files in os.walk(folder):
        for name in files:
            descriptor = os.open(os.path.join(directory, name), os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
        _sync_directory(Path(directory))


def _sync_directory(folder: Path) -> None:
    if sys.platform == "win32":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(descriptor)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _file_mode(target: Path) -> int:
    return target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask()


def _directory_mode(final: Path) -> int:
    return final.stat().st_mode & 0o777 if final.is_dir() else 0o777 & ~_umask()
