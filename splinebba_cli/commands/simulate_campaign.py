"""A Monte Carlo campaign of ``splinebba simulate``: runs in parallel, log, figures, summary."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from splinebba_cli.commands.console import Log, print_json, rich_console
from splinebba_cli.commands.streams import is_terminal, live_console
from splinebba_cli.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from splinebba_cli.output.run_log import RunLog
    from splinebba_cli.simulation.campaign import Campaign
    from splinebba_cli.simulation.targets import Target

TOLD = 10  # parts of a campaign that are told where no bar can be shown


@dataclass(frozen=True)
class CampaignRequest:
    """What the options ask for."""

    folder: Path
    runs: int
    seed: int
    study: tuple[float, ...]
    confidence: float
    jobs: int | None
    resume: bool
    force: bool
    figures: str  # "svg", "png", "none"


def run_campaign(target: Target, request: CampaignRequest, log: Log, as_json: bool) -> None:
    """Run what is not there yet, then report on all runs."""
    from splinebba_cli import __version__
    from splinebba_cli.output.campaign_json import CampaignInput, campaign_content
    from splinebba_cli.output.run_log import RunLog, campaign_folder, discard_runs
    from splinebba_cli.simulation.campaign import Campaign

    campaign = Campaign(target.design, target.noise, request.seed, request.study)
    _require_starts(campaign)
    identity = {
        "target": target.name,
        "inputs": target.inputs,
        "options": campaign.options(),
        "program": __version__,
    }
    with campaign_folder(request.folder):
        if request.force:
            discard_runs(request.folder)
        with closing(RunLog(request.folder, identity, resume=request.resume)) as runs:
            _run_missing(campaign, request, runs, log)
            records = runs.records(request.runs)
        asked = CampaignInput(target.design.network, target.noise, identity, request.runs, request.confidence)
        content = campaign_content(asked, records)
        _write(content, request)
    log.finished()
    _print(content, request.folder, as_json)
    if content["statistics"] is None:
        raise typer.Exit(ExitCode.NOT_SOLVABLE)


def _write(content: dict[str, Any], request: CampaignRequest) -> None:
    """The report on all runs and its figures, together."""
    from splinebba_cli.output.json_text import json_text
    from splinebba_cli.output.publish import published
    from splinebba_cli.output.run_log import REPORT_FILE

    with published(request.folder, REPORT_FILE) as folder:
        (folder / REPORT_FILE).write_text(json_text(content), encoding="utf-8", newline="\n")
        if request.figures != "none":
            from splinebba_cli.report.campaign_figures import write_campaign_figures

            write_campaign_figures(content, folder, request.figures)


def _require_starts(campaign: Campaign) -> None:
    noise = campaign.noise
    sizes = (noise.start_position_m, noise.start_angle_rad, noise.start_knots_m)
    if campaign.study and not any(sizes):
        help = "--start-position, --start-angle, --start-knots, or the same in the simulation section"
        raise UsageError("SBB900", "--study multiplies errors of the starts, but there are none", help)


def _run_missing(campaign: Campaign, request: CampaignRequest, runs: RunLog, log: Log) -> None:
    """Run what the log has not; every finished run is written at once."""
    from splinebba_cli.simulation.executors import available_processors, run_all

    missing = [run for run in range(request.runs) if run not in runs.finished]
    jobs = request.jobs or available_processors()
    begin = time.perf_counter()
    try:
        with (
            closing(run_all(campaign, missing, jobs)) as results,
            _progress(request.runs, request.runs - len(missing), log) as advance,
        ):
            for record in results:
                runs.append(record)
                advance()
    except KeyboardInterrupt:
        log.say(f"{len(runs.finished)} of {request.runs} runs are kept, --resume continues")
        raise
    if missing:
        log.detail(f"{len(missing)} runs in {time.perf_counter() - begin:.1f} s")


@contextmanager
def _progress(total: int, completed: int, log: Log) -> Iterator[Callable[[], None]]:
    """A bar on stderr, where that is a terminal, else some lines; gives what to call after every run."""
    if log.quiet or not is_terminal(sys.stderr):
        yield _told(total, completed, log)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=live_console(), transient=True) as bar:
        task = bar.add_task("runs", total=total, completed=completed)
        yield lambda: bar.advance(task)


def _told(total: int, completed: int, log: Log) -> Callable[[], None]:
    """A line whenever another tenth of the runs is finished."""
    done = completed

    def advance() -> None:
        nonlocal done
        done += 1
        if done == total or done * TOLD // total > (done - 1) * TOLD // total:
            log.say(f"{done} of {total} runs")

    return advance


def _print(content: dict[str, Any], folder: Path, as_json: bool) -> None:
    if as_json:
        print_json({"campaign": str(folder), **content})
        return
    from splinebba_cli.report.campaign_tables import CampaignSummary

    console = rich_console()
    console.print(CampaignSummary(content))
    console.print(f"Campaign: {folder}", markup=False, soft_wrap=True)
