"""The matching of one project, from its file to its folder: what ``match`` and a batch run."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from splinebba_cli.core.matching.matches import MatchResult, Reason
    from splinebba_cli.core.result import Iteration
    from splinebba_cli.project.diagnostics import Diagnostic
    from splinebba_cli.project.loading import LoadedProject

_log = logging.getLogger(__name__)
IMAGE_WITHOUT_MATCH = "SBB582"


@dataclass(frozen=True)
class MatchOptions:
    """What is wanted of a matching besides what its project says; None: as the project says.

    Attributes
    ----------
    output : Path, optional
        Folder; by default ``P.matched`` beside ``P.yaml``.
    new_curves : bool, optional
        Whether splines are built from chains that no spline explains.
    alpha : float, optional
        Share of right points that a gate may lose.
    rounds : int, optional
        Largest number of rounds.
    seed : int, optional
        Of all random choices.
    html : bool
        Whether ``match.html`` is written besides ``match.txt``.
    """

    output: Path | None = None
    new_curves: bool | None = None
    alpha: float | None = None
    rounds: int | None = None
    seed: int | None = None
    html: bool = True

    def told(self) -> dict[str, Any]:
        """What the results depend on besides the project and its files: part of their provenance."""
        return {**self.changes(), "html": self.html}

    def changes(self) -> dict[str, Any]:
        """Settings of the project that are overridden, by their keys."""
        return {
            "new_curves": self.new_curves,
            "alpha": self.alpha,
            "rounds": self.rounds,
            "seed": self.seed,
        }


@dataclass(frozen=True)
class MatchOutcome:
    """What a matching has written, and whether its project accepts it."""

    loaded: LoadedProject
    directory: Path
    content: dict[str, Any]  # of match.json
    accepted: bool
    seconds: dict[str, float]  # read, match, write


def default_match_output(project: Path) -> Path:
    """``P.matched`` beside ``P.yaml``."""
    return project.with_name(f"{project.stem}.matched")


def _nothing(_: Any) -> None:
    """Tells nobody."""


def run_match(
    project: Path,
    options: MatchOptions,
    *,
    warned: Callable[[Sequence[Diagnostic]], None] = _nothing,
    iterated: Callable[[Iteration], None] = _nothing,
) -> MatchOutcome:
    """Read, match, write.

    Parameters
    ----------
    project : Path
        Project file, or a folder that holds ``project.yaml``.
    options : MatchOptions
    warned : callable
        Gets the warnings of the project, before the matching.
    iterated : callable
        Gets every iteration of the adjustments inside.

    Returns
    -------
    MatchOutcome
        The folder is complete when this returns.

    Raises
    ------
    ProjectError
        If the project is invalid, or has no chains.
    NotSolvableError
        If nothing is matched (SBB599), or orientations are not determined.
    OutputError
        If the results cannot be written; an earlier folder is left as it was.
    """
    from splinebba_cli.core.matching.doubts import doubts
    from splinebba_cli.core.matching.match import match
    from splinebba_cli.output.match_folder import reserve_match_folder, write_match_folder
    from splinebba_cli.output.match_json import match_content
    from splinebba_cli.output.provenance import provenance
    from splinebba_cli.project.loading import load_project
    from splinebba_cli.project.matched import matched_project
    from splinebba_cli.project.overrides import with_matching
    from splinebba_cli.report.match_report import write_match_reports

    start = time.perf_counter()
    loaded = with_matching(load_project(project, "matching"), **options.changes())
    warned(loaded.diagnostics)
    read = time.perf_counter()
    directory = options.output if options.output is not None else default_match_output(loaded.path)
    with reserve_match_folder(directory) as place:
        result = match(loaded.network, loaded.match_settings, observer=iterated)
        result = replace(result, problems=(*doubts(result, loaded.match_settings), *result.problems))
        require_matches(result)
        matched = time.perf_counter()
        seconds = {"read": read - start, "match": matched - read}
        _log.info("writing %s", directory)
        origin = provenance(loaded, {**seconds, **result.timings}, options.told())
        smallest = loaded.model.matching.min_matched_share
        content = match_content(result, loaded.match_settings, origin, smallest)
        write_match_folder(
            place,
            result,
            content,
            matched_project(loaded, result, directory),
            lambda folder: write_match_reports(
                folder, result, content, ["text", "html"] if options.html else ["text"]
            ),
        )
    accepted = all(criterion["status"] == "passed" for criterion in content["acceptance"])
    seconds["write"] = time.perf_counter() - matched
    return MatchOutcome(loaded, directory, content, accepted, seconds)


def require_matches(result: MatchResult) -> None:
    """Refuse a result without any image point on a spline.

    Raises
    ------
    NotSolvableError
        SBB599, with the reasons of the points.
    """
    from splinebba_cli.core.result import Problem
    from splinebba_cli.errors import NotSolvableError
    from splinebba_cli.output.match_counts import MatchCounts
    from splinebba_cli.project.matched_tables import reason_word

    if len(result.network.curve_observations):
        return
    counts = MatchCounts(result).by_reason()
    why = ", ".join(f"{number} {reason_word(reason)}" for reason, number in counts.items())
    message = f"none of the {len(result.given.unlabelled)} image points was matched ({why})"
    problem = Problem("SBB599", "error", message, "matching", _cure(result, counts))
    others = (p for p in result.problems if p.severity != "info" and p.code != IMAGE_WITHOUT_MATCH)
    raise NotSolvableError([*others, problem])


def _cure(result: MatchResult, reasons: Mapping[Reason, int]) -> str:
    """What to look at where nothing was matched."""
    if not result.given.curves:
        return (
            "the project has no spline to match against: declare those that you know, or let splines be built "
            "(`--new-curves`)"
        )
    if reasons and max(reasons, key=lambda reason: reasons[reason]).name == "DIRECTION":
        return (
            "are the directions those of the edges, not of their normals, and is `angle_unit` theirs? Without the "
            "column, directions come from the chains"
        )
    return (
        "are the approximate orientations good enough (`matching: position_sigma_m, angle_sigma_deg` say how far they "
        "may be off), and do the chains show the splines of the project? `--new-curves` builds splines from chains"
    )
