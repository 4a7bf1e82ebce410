"""The runs of a campaign on the disk: one line of JSON a finished run, appended and flushed.

The first line says what the runs depend on.  A campaign continues only where that is the same; a line that a killed
program left half written is cut off.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from splinebba_cli.errors import OutputError, SimulationError
from splinebba_cli.output.atomic import make_folders, remove_empty
from splinebba_cli.output.locking import locked
from splinebba_cli.simulation.run_record import RunRecord, record_from
from splinebba_cli.write_errors import cannot_write

RUNS_FORMAT = "splinebba-campaign-runs/2"
RUNS_FILE = "runs.jsonl"
REPORT_FILE = "campaign.json"


class RunLog:
    """The finished runs of one campaign.

    Parameters
    ----------
    folder : made where it does not exist
    identity : what the runs depend on, JSON types only
    resume : whether runs that are there are continued

    Raises
    ------
    OutputError
        SBB603, if there are runs and `resume` is False; SBB601, if the file cannot be written.
    SimulationError
        SBB703, if the runs that are there are of another project or other options; names what differs.
    """

    def __init__(self, folder: Path, identity: Mapping[str, Any], *, resume: bool) -> None:
        self.path = folder / RUNS_FILE
        head = {"format": RUNS_FORMAT, **json.loads(json.dumps(identity))}
        self._lines: dict[int, str] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            content = self.path.read_bytes() if self.path.exists() else b""
            whole = content[: content.rfind(b"\n") + 1]
            if whole and not resume:
                help = "--resume continues it; --force begins anew; or choose another folder with -o"
                raise OutputError("SBB603", f"`{folder}` holds a campaign already", help)
            if whole:
                self._take(whole.decode("utf-8", "replace"), head)
                if len(whole) < len(content):
                    os.truncate(self.path, len(whole))
            else:
                text = json.dumps(head, ensure_ascii=False) + "\n"
                self.path.write_text(text, encoding="utf-8", newline="\n")
            self._stream = self.path.open("a", encoding="utf-8", newline="\n")
        except OSError as error:
            raise cannot_write(folder, error) from error

    def _take(self, text: str, head: dict[str, Any]) -> None:
        first, *lines = text.removesuffix("\n").split("\n")
        differing = _differences(_parsed(first, self.path), head)
        if differing:
            raise SimulationError(
                "SBB703",
                f"`{self.path}` is of another campaign: {', '.join(differing)} changed",
                "put back what changed, or choose another folder with -o, or --force to begin anew",
            )
        for number, line in enumerate(lines, 2):
            self._lines.setdefault(_run_of(line, number, self.path), line)

    @property
    def finished(self) -> frozenset[int]:
        """Numbers of the runs that are there."""
        return frozenset(self._lines)

    def append(self, record: RunRecord) -> None:
        """Write a finished run; it is on its way to the disk when this returns.

        Raises
        ------
        OutputError
            If there is no room for it: the runs before are kept.
        """
        line = record.line()
        try:
            self._stream.write(line + "\n")
            self._stream.flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error
        self._lines[record.run] = line

    def records(self, runs: int) -> list[RunRecord]:
        """The finished ones of the first `runs` runs, as they are on the disk, in order."""
        return [record_from(json.loads(self._lines[run])) for run in sorted(self._lines) if run < runs]

    def close(self) -> None:
        """Force what was written to the disk."""
        if not self._stream.closed:
            try:
                self._stream.flush()
                os.fsync(self._stream.fileno())
                self._stream.close()
            except OSError as error:
                with suppress(OSError):  # a second attempt to write what had no room
                    self._stream.close()
                raise cannot_write(self.path, error) from error


@contextmanager
def campaign_folder(folder: Path) -> Iterator[None]:
    """The folder of a campaign, for this run alone; made, and taken away again where nothing comes of it.

    Raises
    ------
    OutputError
        SBB606 if another run is at work there; SBB601, SBB604, SBB605, SBB607 if it cannot be written.
    """
    with ExitStack() as kept:
        try:
            kept.callback(remove_empty, make_folders(folder))
            kept.enter_context(locked(folder.resolve() / RUNS_FILE, folder))
        except OSError as error:
            raise cannot_write(folder, error) from error
        yield


def discard_runs(folder: Path) -> None:
    """Remove the runs of a folder and what was said of them, to begin anew."""
    for name in (REPORT_FILE, RUNS_FILE):
        (folder / name).unlink(missing_ok=True)


def _parsed(line: str, path: Path) -> dict[str, Any]:
    try:
        data = json.loads(line)
    except ValueError as error:
        raise SimulationError("SBB703", f"`{path}` holds a line that is no JSON: {error}") from error
    if not isinstance(data, dict):
        raise SimulationError("SBB703", f"`{path}` is not of format {RUNS_FORMAT}")
    return data


def _run_of(line: str, number: int, path: Path) -> int:
    """Number of the run of a line that holds a whole record."""
    data = _parsed(line, path)
    try:
        return int(record_from(data).run)
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        message = f"`{path}`: line {number} is no record of a run: {error!r}"
        raise SimulationError("SBB703", message, "remove the line: the run is made again") from error


def _differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """Names of what is not the same, files and options one by one."""
    names = []
    for key in sorted({*old, *new}):
        a, b = old.get(key), new.get(key)
        if a == b:
            continue
        if isinstance(a, dict) and isinstance(b, dict):
            names += [f"{key} `{name}`" for name in sorted({*a, *b}) if a.get(name) != b.get(name)]
        else:
            names.append(f"`{key}`")
    return names
