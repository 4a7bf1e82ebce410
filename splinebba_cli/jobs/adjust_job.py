"""The adjustment of one project, from its file to its result folder: what ``adjust`` and a batch run."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from splinebba_cli.core.evidence import Criterion
    from splinebba_cli.core.result import Iteration, Problem
    from splinebba_cli.core.settings import OutlierMethod
    from splinebba_cli.output.columns import TableFormat
    from splinebba_cli.output.result_folder import DispersionChoice
    from splinebba_cli.project.diagnostics import Diagnostic
    from splinebba_cli.project.loading import LoadedProject

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class AdjustOptions:
    """What is wanted of an adjustment besides what its project says.

    Attributes
    ----------
    output : Path, optional
        Result folder; by default ``P.results`` beside ``P.yaml``.
    dispersion : {"full", "blocks", "none"}
        How much of the dispersion matrix is kept.
    tables : {"csv", "parquet"}
        Format of the result tables.
    outliers : str, optional
        What is done with gross errors; by default as the project says.
    html : bool
        Whether ``report.html`` is written besides ``report.txt``.
    match : bool
        Whether chains of the project are matched first (:mod:`.matched_adjust_job`).
    """

    output: Path | None = None
    dispersion: DispersionChoice = "blocks"
    tables: TableFormat = "csv"
    outliers: OutlierMethod | None = None
    html: bool = True
    match: bool = False

    def told(self) -> dict[str, Any]:
        """What the results depend on besides the project and its files: part of their provenance."""
        return {
            "dispersion": self.dispersion,
            "tables": self.tables,
            "outliers": self.outliers,
            "html": self.html,
            **({"match": True} if self.match else {}),
        }


@dataclass(frozen=True)
class AdjustOutcome:
    """What an adjustment has written, and whether its project accepts it."""

    loaded: LoadedProject
    directory: Path
    content: dict[str, Any]  # of result.json
    criteria: Sequence[Criterion]
    problems: Sequence[Problem]
    accepted: bool
    seconds: dict[str, float]  # read, approximation, estimation, quality, write


def default_output(project: Path) -> Path:
    """``P.results`` beside ``P.yaml``."""
    return project.with_name(f"{project.stem}.results")


def _nothing(_: Any) -> None:
    """Tells nobody."""


def run_adjustment(
    project: Path,
    options: AdjustOptions,
    *,
    warned: Callable[[Sequence[Diagnostic]], None] = _nothing,
    iterated: Callable[[Iteration], None] = _nothing,
) -> AdjustOutcome:
    """Read, adjust, assess, write.

    Parameters
    ----------
    project : Path
        Project file, or a folder that holds ``project.yaml``.
    options : AdjustOptions
    warned : callable
        Gets the warnings of the project, before the adjustment.
    iterated : callable
        Gets every iteration.

    Returns
    -------
    AdjustOutcome
        The result folder is complete when this returns.

    Raises
    ------
    ProjectError
        If the project is invalid.
    NotSolvableError
        If the network is singular, does not converge or does not fit into memory.
    OutputError
        If the results cannot be written; an earlier result folder is left as it was.
    """
    from splinebba_cli.core.adjustment import adjust as adjust_network
    from splinebba_cli.output.result_folder import reserve_result_folder, write_result_folder
    from splinebba_cli.project.acceptance import assess, violations
    from splinebba_cli.project.adjusted import adjusted_project
    from splinebba_cli.project.loading import load_project
    from splinebba_cli.project.overrides import with_outliers
    from splinebba_cli.report.build import write_reports
    from splinebba_cli.report.result_data import ResultData

    start = time.perf_counter()
    loaded = load_project(project)
    if options.outliers is not None:
        loaded = with_outliers(loaded, options.outliers)
    warned(loaded.diagnostics)
    read = time.perf_counter()
    full = options.dispersion == "full"
    directory = options.output if options.output is not None else default_output(loaded.path)
    with reserve_result_folder(directory) as place:
        result = adjust_network(loaded.network, observer=iterated, full_dispersion=full)
        criteria = assess(loaded.model.acceptance, result)
        failed = violations(criteria)
        result = replace(result, acceptance=criteria, problems=(*failed, *result.problems))
        adjusted = time.perf_counter()
        seconds = {"read": read - start, "adjust": adjusted - read}
        _log.info("writing %s", directory)
        written = write_result_folder(
            place,
            result,
            loaded=loaded,
            adjusted_files=adjusted_project(loaded, result, directory),
            dispersion=options.dispersion,
            tables=options.tables,
            reports=lambda folder, new: write_reports(
                folder, ResultData.of(new), ["text", "html"] if options.html else ["text"]
            ),
            timings={**seconds, **result.timings},
            options=options.told(),
        )
    stages = {key.removesuffix("_s"): value for key, value in result.timings.items()}
    seconds = {"read": read - start, **stages, "write": time.perf_counter() - adjusted}
    return AdjustOutcome(loaded, directory, written.content, criteria, result.problems, not failed, seconds)
