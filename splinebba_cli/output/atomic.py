"""Files and folders that are either the old ones or the new ones, never a mixture.

A folder is built beside its target, forced to the disk, and takes the target's name in one step of the
kernel (Linux: ``renameat2`` with ``RENAME_EXCHANGE``).  Where the kernel or the file system has no such step,
the old folder is renamed away first; what a run leaves that is killed in between, the next one repairs.
"""

from __future__ import annotations

import errno
import os
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from splinebba_cli.errors import OutputError
from splinebba_cli.interruption import uninterrupted
from splinebba_cli.output.exchange_names import exchange
from splinebba_cli.output.locking import locked, locked_descriptor, remove_unlocked
from splinebba_cli.write_errors import cannot_write


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
        SBB601, SBB604, SBB605, SBB607 if the file cannot be written.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        target = _resolved(path)
        fresh, descriptor = _fresh_file(target)
        try:
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            os.chmod(fresh, _file_mode(target))
            os.replace(fresh, target)
        except BaseException:
            with suppress(OSError):
                os.unlink(fresh)
            raise
        sync_directory(target.parent)
    except OSError as error:
        raise cannot_write(path, error) from error


def _resolved(path: Path) -> Path:
    """The path without links."""
    try:
        return path.resolve()
    except RuntimeError as error:  # Python before 3.13
        raise OSError(errno.ELOOP, "too many symbolic links") from error


def _fresh_file(target: Path) -> tuple[Path, int]:
    """An empty file beside the target, open and locked; those that killed runs have left are removed."""
    prefix = f".{target.name}.new-"
    for stale in target.parent.glob(f"{_glob_escape(prefix)}*"):
        remove_unlocked(stale)
    fresh = target.parent / f"{prefix}{os.getpid()}-{threading.get_ident()}"
    descriptor = locked_descriptor(fresh)
    if descriptor is None:
        raise OSError(errno.EBUSY, "another run is writing it")
    return fresh, descriptor


@dataclass(frozen=True)
class ReservedDirectory:
    """A folder that only this run writes.

    Attributes
    ----------
    final : Path
        Where it lies, links followed.
    shown : Path
        As the user named it.
    """

    final: Path
    shown: Path

    @contextmanager
    def replaced(self) -> Iterator[Path]:
        """An empty folder on the same file system, which takes the place when the block ends without an exception."""
        try:
            fresh = Path(tempfile.mkdtemp(prefix=_prefix(self.final, "new"), dir=self.final.parent))
            try:
                os.chmod(fresh, _directory_mode(self.final))
                yield fresh
                sync_tree(fresh)
                with uninterrupted():
                    _swap_in(fresh, self.final)
                    remove_tree(fresh)  # the old folder
            finally:
                remove_tree(fresh)
        except OSError as error:
            raise cannot_write(self.shown, error) from error


@contextmanager
def reserve_directory(target: Path, replaceable: Callable[[Path], bool]) -> Iterator[ReservedDirectory]:
    """Find out whether a folder can be written before long work begins, and keep other runs away from it.

    Parameters
    ----------
    target : Path
        The folder to write or to replace.  A symbolic link is followed.
    replaceable : callable
        Whether an existing, non-empty folder may be replaced: protects a mistyped ``-o ~``.

    Raises
    ------
    OutputError
        SBB602 if the target may not be replaced, SBB606 if another run writes it, SBB601, SBB604, SBB605, SBB607 if it
        cannot be written.
    """
    with ExitStack() as kept:
        try:
            final = _resolved(target)
            kept.callback(remove_empty, make_folders(final.parent))
            kept.enter_context(locked(final, target))
            _recover(final)
            _check_replaceable(final, target, replaceable)
        except OSError as error:
            raise cannot_write(target, error) from error
        yield ReservedDirectory(final, target)


@contextmanager
def replace_directory(target: Path, replaceable: Callable[[Path], bool]) -> Iterator[Path]:
    """A new folder to fill; it takes the place of `target` when the block ends without an exception.

    Parameters and errors as of :func:`reserve_directory`.

    Yields
    ------
    Path
        An empty folder on the same file system.
    """
    with reserve_directory(target, replaceable) as place, place.replaced() as fresh:
        yield fresh


def make_folders(folder: Path) -> list[Path]:
    """Make a folder and those around it; the ones that were made, innermost first."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


def remove_tree(folder: Path) -> None:
    """Remove a folder with all that is in it, as far as that is possible; a signal waits until that is done."""
    with uninterrupted():
        shutil.rmtree(folder, ignore_errors=True)


def remove_empty(folders: list[Path]) -> None:
    """Remove folders in which nothing has come to lie."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()


def _prefix(final: Path, kind: str) -> str:
    return f".{final.name}.{kind}-"


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
    elif not exchange(fresh, final):
        old = final.parent / f"{_prefix(final, 'old')}{os.getpid()}"
        os.rename(final, old)
        try:
            os.rename(fresh, final)
        except BaseException:
            os.rename(old, final)
            raise
        shutil.rmtree(old, ignore_errors=True)
    sync_directory(final.parent)


def sync_tree(folder: Path) -> None:
    """Force all files of a folder to the disk."""
    for directory, _, files in os.walk(folder):
        for name in files:
            descriptor = os.open(os.path.join(directory, name), os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
        sync_directory(Path(directory))


def sync_directory(folder: Path) -> None:
    """Force the names of a folder to the disk, where the system can do that."""
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
