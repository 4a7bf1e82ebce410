"""The content of a file that a user names: of a regular one that fits into the memory, or a reason why not.

A pipe without a writer never answers, a device without an end never stops: neither is opened.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

PROJECT_FILE = "project.yaml"  # of a folder that is named in place of its project
LARGEST_PROJECT_FILE = 256 * 2**20  # bytes: what stands in it is read scalar by scalar
_UNKNOWN_MEMORY = 2**40


class NoContentError(Exception):
    """Why a file has no content to read."""


class TooLargeError(NoContentError):
    """The file is larger than what is read."""


def file_content(path: Path, largest: int | None = None, *, may_be_pipe: bool = False) -> bytes:
    """All bytes of a regular file.

    Parameters
    ----------
    path : Path
    largest : int, optional
        Number of bytes that are read at most; by default the memory of the machine.
    may_be_pipe : bool
        Of a file that the command line names: `<(command)` is a pipe that ends.

    Raises
    ------
    NoContentError
        If there is none, with the reason in words; TooLargeError for its size.
    """
    try:
        status = path.stat()
        if not (may_be_pipe and stat.S_ISFIFO(status.st_mode)):
            _check_kind(status.st_mode)
        check_size(status.st_size, largest)
        content = path.read_bytes()
    except OSError as error:
        raise NoContentError(error.strerror or str(error)) from error
    except ValueError as error:  # NUL or surrogates in the name
        raise NoContentError(str(error)) from error
    except MemoryError:
        raise TooLargeError("it does not fit into the memory") from None
    return content


def check_size(size: int, largest: int | None = None) -> None:
    """TooLargeError for more bytes than are read; by default, than the machine has."""
    limit = memory_bytes() if largest is None else largest
    if size > limit:
        raise TooLargeError(f"it has {in_words(size)}, more than {in_words(limit)}")


def _check_kind(mode: int) -> None:
    kinds = (
        (stat.S_ISDIR, "it is a folder"),
        (stat.S_ISFIFO, "it is a pipe, not a file"),
        (stat.S_ISCHR, "it is a device, not a file"),
        (stat.S_ISBLK, "it is a device, not a file"),
        (stat.S_ISSOCK, "it is a socket, not a file"),
    )
    for is_kind, reason in kinds:
        if is_kind(mode):
            raise NoContentError(reason)


def memory_bytes() -> int:
    """Bytes of memory that the machine has."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # no POSIX system
        return _UNKNOWN_MEMORY


def in_words(size: int) -> str:
    """A number of bytes with its unit."""
    for unit, factor in (("GiB", 2**30), ("MiB", 2**20), ("KiB", 2**10)):
        if size >= factor:
            return f"{size / factor:,.4g} {unit}"
    return f"{size} bytes"


def names_in(folder: Path) -> list[str]:
    """Names of what is in a folder; none of one that cannot be looked into."""
    try:
        return [item.name for item in folder.iterdir()]
    except OSError:
        return []
