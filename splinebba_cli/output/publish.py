"""Several files that belong together, put into a folder of the user's: all of them, or none.

They are made in a hidden folder inside of the one that they go to, so that nothing else in it is touched, be it the
current folder or a mounted one.  At the end they take their places one after the other, the file that gives the others
their meaning last; its predecessor is taken away first.  A run that is killed in between leaves no such file, and so
nothing that could be taken for whole.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from splinebba_cli.interruption import uninterrupted
from splinebba_cli.output.atomic import make_folders, remove_empty, remove_tree, sync_directory, sync_tree
from splinebba_cli.output.locking import locked
from splinebba_cli.write_errors import cannot_write

_PREFIX = ".splinebba-new-"


@contextmanager
def published(folder: Path, last: str) -> Iterator[Path]:
    """A fresh folder to fill; its files go into `folder` when the block ends without an exception.

    Parameters
    ----------
    folder : Path
        Made where it is not there, and taken away again if nothing comes of it.  Other files in it stay.
    last : str
        The file that takes its place after all others.

    Raises
    ------
    OutputError
        SBB606 if another run writes there; SBB601, SBB604, SBB605, SBB607 if it cannot be written.
    """
    with ExitStack() as kept:
        try:
            kept.callback(remove_empty, make_folders(folder))
            kept.enter_context(locked(folder.resolve() / last, folder))
            for stale in folder.glob(f"{_PREFIX}*"):
                shutil.rmtree(stale, ignore_errors=True)
            fresh = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=folder))
            kept.callback(remove_tree, fresh)
            yield fresh
            sync_tree(fresh)
            with uninterrupted():
                _place(fresh, folder, last)
            sync_directory(folder)
        except OSError as error:
            raise cannot_write(folder, error) from error


def _place(fresh: Path, folder: Path, last: str) -> None:
    """Move the files; names sort the same on every run."""
    (folder / last).unlink(missing_ok=True)
    names = sorted(entry.name for entry in fresh.iterdir() if entry.name != last)
    for name in (*names, last):
        os.replace(fresh / name, folder / name)
