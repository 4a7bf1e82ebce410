"""The log of a batch: JSON lines, the first about the batch, then one for every project as soon as it is finished."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from splinebba_cli import __version__
from splinebba_cli.batch.outcome import Outcome
from splinebba_cli.write_errors import cannot_write

LOG_FORMAT = "splinebba-batch-log/1"


class BatchLog:
    """A log file, written anew; every line is on its way to the disk when its method returns.

    Parameters
    ----------
    path : Path
    about : mapping
        Options and number of projects, JSON types only.

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB607, if the file cannot be written.
    """

    def __init__(self, path: Path, about: Mapping[str, Any]) -> None:
        self._path = path
        try:
            # a name that is no Unicode: its escape is one of JSON, too
            self._stream = path.open("w", encoding="utf-8", errors="backslashreplace", newline="\n")
        except OSError as error:
            raise cannot_write(path, error) from error
        self._write({"format": LOG_FORMAT, "program": __version__, "begun": _now(), **about})

    def add(self, outcome: Outcome) -> None:
        """What became of a project."""
        self._write({"finished": _now(), **outcome.data()})

    def close(self, about: Mapping[str, Any]) -> None:
        """The last line: counts."""
        self._write({"ended": _now(), **about})
        self._stream.close()

    def _write(self, data: Mapping[str, Any]) -> None:
        try:
            self._stream.write(json.dumps(data, ensure_ascii=False) + "\n")
            self._stream.flush()
        except OSError as error:
            raise cannot_write(self._path, error) from error


def _now() -> str:
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
