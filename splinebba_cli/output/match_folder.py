"""The folder of a matching: match.json, the matched project, tables of points and chains, replaced in one step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.output.atomic import ReservedDirectory, reserve_directory
from splinebba_cli.output.columns import write_table
from splinebba_cli.output.folder_files import begins_with_format, keep_foreign_files, write_inside
from splinebba_cli.output.json_text import json_text
from splinebba_cli.output.match_counts import MatchCounts, chains_table
from splinebba_cli.output.match_json import MATCH_FILE, MATCH_FORMAT

_OWN = (MATCH_FILE, "matched.yaml", "match_drawings.json", "match_report.json", "chains.csv")
_OWN_BEGINNINGS = ("matched_", "unmatched_points")
_REPORTS = (
    "match.txt",
    "match.html",
    "match.md",
    "match.pdf",
)  # of former results where they are not made anew


@contextmanager
def reserve_match_folder(directory: Path) -> Iterator[ReservedDirectory]:
    """Keep a folder for this run, before anything is computed.

    Raises
    ------
    OutputError
        SBB602 not a folder of matching, SBB606 another run writes it, SBB601, SBB604, SBB605, SBB607 cannot be written.
    """
    with reserve_directory(directory, is_match_folder) as place:
        yield place


def write_match_folder(
    place: ReservedDirectory,
    result: MatchResult,
    content: dict[str, Any],
    matched_files: Mapping[str, str],
    reports: Callable[[Path], object],
) -> None:
    """Write everything that `match` promises; the folder is the old one or the new one, never a mixture.

    Parameters
    ----------
    content : dict
        Of match.json.
    matched_files : mapping
        File name to text: ``matched.yaml``, its tables, and the unmatched points.
    reports : callable
        Writes the reports into the new folder.

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB607: cannot be written.
    """
    with place.replaced() as folder:
        write_inside(folder, MATCH_FILE, json_text(content))
        for name, text in matched_files.items():
            write_inside(folder, name, text)
        if result.given.unlabelled.chain_ids:
            write_table(folder, chains_table(MatchCounts(result)), "csv")
        reports(folder)
        keep_foreign_files(place.final, folder, _is_own)


def is_match_folder(folder: Path) -> bool:
    """Whether a folder was written by `match`."""
    return begins_with_format(folder / MATCH_FILE, MATCH_FORMAT)


def _is_own(name: str) -> bool:
    return name in (*_OWN, *_REPORTS) or name.startswith(_OWN_BEGINNINGS)
