"""``splinebba simulate``: a synthetic project with its truth, a Monte Carlo campaign, a pre-analysis."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from splinebba_cli.commands import simulation_options as option
from splinebba_cli.commands.console import Log, expected_errors, print_json, rich_console
from splinebba_cli.commands.options import FormatOption, OutputFormat, QuietOption, VerboseOption
from splinebba_cli.errors import OutputError, UsageError
from splinebba_cli.project.file_content import PROJECT_FILE

if TYPE_CHECKING:
    from splinebba_cli.simulation.targets import Target


def simulate(
    target: option.TargetArgument,
    output: option.FolderOption = None,
    seed: option.SeedOption = None,
    noise_um: option.NoiseOption = None,
    blunder_share: option.BlunderShareOption = None,
    blunder_size: option.BlunderSizeOption = None,
    missing_point_share: option.MissingPointsOption = None,
    missing_pair_share: option.MissingPairsOption = None,
    given_errors: option.GivenErrorsOption = None,
    start_position: option.StartPositionOption = None,
    start_angle: option.StartAngleOption = None,
    start_knots: option.StartKnotsOption = None,
    runs: option.RunsOption = None,
    jobs: option.JobsOption = None,
    resume: option.ResumeOption = False,
    confidence: option.ConfidenceOption = 0.95,
    study: option.StudyOption = None,
    figures: option.FiguresOption = option.FigureChoice.svg,
    predict: option.PredictOption = False,
    force: option.ForceOption = False,
    format: FormatOption = OutputFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Write a synthetic project with its truth; run a Monte Carlo campaign; predict precision."""
    log, as_json = Log(quiet, verbose), format is OutputFormat.json
    with expected_errors(as_json=as_json):
        _require_usage(runs, study, resume, predict)
        if target == "list":
            _print_kinds(as_json)
            return
        changes = option.changed_noise(
            noise_um, start_angle, blunder_share=blunder_share, blunder_size=blunder_size,
            missing_point_share=missing_point_share, missing_pair_share=missing_pair_share,
            given_values=given_errors, start_position_m=start_position, start_knots_m=start_knots,
        )  # fmt: skip
        chosen = _target(target, changes, log)
        seed = chosen.seed if seed is None else seed
        purpose = "prediction" if predict else "simulated" if runs is None else "campaign"
        folder = _folder(chosen, output, purpose)
        if predict:
            _predict(chosen, folder, log, as_json)
        elif runs is None:
            _write(chosen, SingleRequest(folder, seed, force), log, as_json)
        else:
            from splinebba_cli.commands.simulate_campaign import CampaignRequest, run_campaign

            factors, suffix = option.study_factors(study), figures.value
            request = CampaignRequest(folder, runs, seed, factors, confidence, jobs, resume, force, suffix)
            run_campaign(chosen, request, log, as_json)


@dataclass(frozen=True)
class SingleRequest:
    """Where one realization goes, and which."""

    folder: Path
    seed: int
    force: bool


def _require_usage(runs: int | None, study: str | None, resume: bool, predict: bool) -> None:
    if predict and runs is not None:
        raise UsageError("SBB900", "--predict and --runs are two different things", "give one of them")
    if runs is None and (study is not None or resume):
        raise UsageError("SBB900", "--study and --resume belong to a campaign", "give --runs as well")


def _print_kinds(as_json: bool) -> None:
    from splinebba_cli.simulation.six_image_block import KINDS

    if as_json:
        print_json(
            {"kinds": [{"name": name, "about": about} for name, about in KINDS.items()], "problems": []}
        )
        return
    print("\n".join(f"{name:20}{about}" for name, about in KINDS.items()))


def _target(target: str, changes: Mapping[str, Any], log: Log) -> Target:
    """The kind of block, or the project."""
    from splinebba_cli.project.diagnostics import listing, suggestion
    from splinebba_cli.project.loading import load_project
    from splinebba_cli.simulation.six_image_block import KINDS
    from splinebba_cli.simulation.targets import block_target, project_target

    if target in KINDS:
        return block_target(target, changes)
    if not os.path.exists(target):
        help = suggestion(target, KINDS) or f"known: {listing(KINDS, 20)}; or give a project"
        raise UsageError("SBB900", f"no kind of block and no project `{target}`", help)
    with log.working():
        loaded = load_project(target, "simulation")
    log.warnings(loaded.diagnostics)
    made = project_target(loaded, changes)
    for name in made.left_out:
        log.say(f"left out, seen by too few images: {name}")
    return made


def _folder(target: Target, output: Path | None, purpose: str) -> Path:
    if output is not None:
        return output
    if target.loaded is not None:
        return target.loaded.path.with_name(f"{target.loaded.path.stem}.{purpose}")
    return Path(target.name if purpose == "simulated" else f"{target.name}.{purpose}")


def _write(target: Target, request: SingleRequest, log: Log, as_json: bool) -> None:
    from splinebba_cli.output.publish import published
    from splinebba_cli.simulation.targets import write_target

    folder, project = request.folder, request.folder / PROJECT_FILE
    if os.path.exists(project) and not request.force:  # a name that is too long does not exist
        raise OutputError(
            "SBB603", f"`{folder}` holds a project already", "choose another folder, or --force"
        )
    with log.working(), published(folder, PROJECT_FILE) as fresh:
        log.stage(f"writing {folder}")
        write_target(target, fresh, request.seed)
    log.finished()
    if as_json:
        print_json({"project": str(project), "seed": request.seed, "problems": _warnings(target)})
    else:
        print(project)


def _warnings(target: Target) -> list[dict[str, Any]]:
    """What was found in the project that is simulated."""
    from splinebba_cli.project.diagnostics import as_json_data

    return [] if target.loaded is None else list(as_json_data(target.loaded.diagnostics))


def _predict(target: Target, folder: Path, log: Log, as_json: bool) -> None:
    from splinebba_cli import __version__
    from splinebba_cli.output.prediction_folder import prediction_content, write_prediction
    from splinebba_cli.report.prediction_tables import PredictionSummary
    from splinebba_cli.simulation.prediction import predict

    with log.working():
        log.stage("prediction")
        result = predict(target.design)
        identity = {"target": target.name, "inputs": target.inputs, "program": __version__}
        content = prediction_content(result, identity, target.left_out)
        log.stage(f"writing {folder}")
        write_prediction(folder, result, content)
    log.finished()
    if as_json:
        shown = {key: content[key] for key in ("target", "statistics", "redundancy_numbers", "left_out")}
        problems = [*_warnings(target), *content["problems"]]
        print_json({"prediction": str(folder), **shown, "problems": problems})
        return
    console = rich_console()
    console.print(PredictionSummary(content))
    console.print(f"Prediction: {folder}", markup=False, soft_wrap=True)
