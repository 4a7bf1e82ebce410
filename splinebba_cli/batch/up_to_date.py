"""Whether the results of a project are those that a new adjustment would give.

They are where result.json tells the same program version, the same options and the same sha256 of all files that were
read.  The project file names the tables, so that with the same project file the files are the same ones.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from splinebba_cli import __version__
from splinebba_cli.batch.adjusting import outcome_of_result
from splinebba_cli.batch.outcome import Outcome
from splinebba_cli.batch.plan import Task
from splinebba_cli.core.threads import in_threads
from splinebba_cli.errors import OutputError
from splinebba_cli.jobs.match_job import MatchOptions
from splinebba_cli.output.damaged_results import complete_results
from splinebba_cli.output.match_json import load_match_json
from splinebba_cli.output.result_json import load_result_json
from splinebba_cli.project.loading import has_chains
from splinebba_cli.project.matched import MATCHED_FILE


def kept_outcomes(tasks: Sequence[Task]) -> list[Outcome | None]:
    """The outcome of every task whose results are up to date; None of the others."""
    return in_threads(kept_outcome, tasks)


def kept_outcome(task: Task) -> Outcome | None:
    """The outcome that up-to-date results tell; None where they are not, or there are none."""
    try:
        with complete_results(task.result_folder):
            content = load_result_json(task.result_folder)
            source = _source(task)
            if source is None or not _same_origin(source, task.options.told(), content["provenance"]):
                return None
            return replace(outcome_of_result(task, content), up_to_date=True)
    except OutputError:
        return None


def _source(task: Task) -> Path | None:
    """The project file that is adjusted: the user's, or the matched one; None where that is not up to date."""
    if not (task.options.match and has_chains(task.project_file)):
        return task.project_file
    matching = MatchOptions(html=task.options.html).told()
    content = load_match_json(task.matched_folder)
    same = _same_origin(task.project_file, matching, content["provenance"])
    return task.matched_folder / MATCHED_FILE if same else None


def _same_origin(source: Path, options: dict[str, Any], provenance: dict[str, Any]) -> bool:
    """Whether results come from a project file as it is now, with the same options and this program."""
    inputs = {item["file"]: item["sha256"] for item in provenance.get("inputs", [])}
    return (
        provenance.get("program", {}).get("version") == __version__
        and provenance.get("options") == options
        and source.name in inputs
        and all(_sha256(source.parent / file) == digest for file, digest in inputs.items())
    )


def _sha256(file: Path) -> str | None:
    """None where the file cannot be read, or is a pipe or a device."""
    try:
        if not file.is_file():
            return None
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return None
