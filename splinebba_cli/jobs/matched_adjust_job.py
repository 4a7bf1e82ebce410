"""A project whose chains are matched before it is adjusted: what a batch runs with ``--match``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from splinebba_cli.jobs.adjust_job import AdjustOptions, AdjustOutcome, run_adjustment
from splinebba_cli.jobs.match_job import MatchOptions, MatchOutcome, run_match

if TYPE_CHECKING:
    from splinebba_cli.project.diagnostics import Diagnostic


def match_folder(results: Path) -> Path:
    """``P.matched`` beside ``P.results``."""
    return results.with_name(f"{results.name.removesuffix('.results')}.matched")


def run_matched_adjustment(
    project: Path,
    options: AdjustOptions,
    *,
    results: Path,
    warned: Callable[[Sequence[Diagnostic]], None],
) -> MatchOutcome | AdjustOutcome:
    """Match the chains of a project, if it has any, and adjust what comes of it.

    Parameters
    ----------
    project : Path
        Project file.
    options : AdjustOptions
    results : Path
        Result folder of the adjustment; that of the matching lies beside it.
    warned : callable
        Gets the warnings of the project.

    Returns
    -------
    AdjustOutcome or MatchOutcome
        The latter where too little was matched: nothing is adjusted then.

    Raises
    ------
    ProjectError, NotSolvableError, OutputError
        As :func:`.match_job.run_match` and :func:`.adjust_job.run_adjustment`.
    """
    from splinebba_cli.project.loading import has_chains
    from splinebba_cli.project.matched import MATCHED_FILE

    adjusting = replace(options, output=results)
    if not has_chains(project):
        return run_adjustment(project, adjusting, warned=warned)
    matching = MatchOptions(output=match_folder(results), html=options.html)
    matched = run_match(project, matching, warned=warned)
    if not matched.accepted:
        return matched
    return run_adjustment(matched.directory / MATCHED_FILE, adjusting, warned=warned)
