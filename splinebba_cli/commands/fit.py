"""``splinebba fit``: splines with few knots from digitised points."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from splinebba_cli.commands import fit_options as option
from splinebba_cli.commands.console import Log, expected_errors, print_json, rich_console
from splinebba_cli.commands.digitised_options import (
    CartesianOption,
    ColumnsOption,
    HeightOption,
    ThresholdOption,
    column_names,
)
from splinebba_cli.commands.fit_options import ParameterizationChoice, RoleChoice
from splinebba_cli.commands.options import FormatOption, OutputFormat, QuietOption, VerboseOption
from splinebba_cli.errors import FitError, OutputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from splinebba_cli.exchange.digitised_lines import DigitisedLine
    from splinebba_cli.project.diagnostics import Diagnostic
    from splinebba_cli.report.fit_summary import Fitted


def fit(
    points: option.PointsArgument,
    output: option.FileOption = None,
    threshold_m: ThresholdOption = 0.05,
    closed: option.ClosedOption = False,
    parameterization: option.ParameterizationOption = ParameterizationChoice.chord_length,
    id: option.IdOption = None,
    role: option.RoleOption = RoleChoice.tie,
    sigma: option.SigmaOption = None,
    corner_angle: option.CornerAngleOption = None,
    figure: option.FigureOption = None,
    columns: ColumnsOption = None,
    z: HeightOption = None,
    cartesian: CartesianOption = False,
    format: FormatOption = OutputFormat.text,
    force: option.ForceOption = False,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Fit natural cubic splines with few knots to digitised points, for a project file."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is OutputFormat.json):
        from splinebba_cli.exchange.digitised_lines import ReadingOptions, read_digitised_lines
        from splinebba_cli.report.fit_summary import fit_warnings, splines_yaml

        sigma_m = _sigma_m(role, sigma)
        target = output if output is not None else points.with_name(f"{points.stem}.splines.yaml")
        _check_targets([path for path in (target, figure) if path is not None and str(path) != "-"], force)
        image = None if figure is None else _figure_format(figure)
        lines, found = read_digitised_lines(points, ReadingOptions(column_names(columns), z, cartesian))
        ids = _ids(lines, id, points.stem)
        with log.working():
            fits = []
            for name, line in zip(ids, lines, strict=True):
                log.stage(f"fitting {name} to {len(line.points)} points")
                fits.append(_fitted(name, line, threshold_m, closed, parameterization.value, corner_angle))
        warnings = [*found, *fit_warnings(fits, str(points))]
        if figure is not None and image is not None:
            from splinebba_cli.output.atomic import write_file_atomically
            from splinebba_cli.report.fit_figure import fit_figure

            write_file_atomically(figure, fit_figure([(f.id, f.spline) for f in fits], image))
        text = splines_yaml(fits, role.value, sigma_m, points.name, threshold_m)
        _print(fits, warnings, text, target, figure, format, log)
        log.finished()


def _sigma_m(role: RoleChoice, sigma: str | None) -> float | None:
    from splinebba_cli.project.scalars import parse_sigma

    known = role in (RoleChoice.control, RoleChoice.partial)
    if sigma is None:
        if known:
            help = "--sigma 0.02 (metres), or --sigma fixed"
            raise UsageError("SBB900", f"splines of role {role.value} need the σ of their knots", help)
        return None
    if not known:
        help = "--role control or --role partial"
        raise UsageError("SBB900", f"splines of role {role.value} have no σ: they are unknown", help)
    try:
        return parse_sigma(sigma)
    except ValueError as error:
        raise UsageError("SBB900", str(error)) from None


def _check_targets(targets: list[Path], force: bool) -> None:
    for target in targets:
        if os.path.exists(target) and not force:  # a name that is too long does not exist
            raise OutputError("SBB603", f"`{target}` is there already", "choose another name, or --force")


def _figure_format(figure: Path) -> str:
    from splinebba_cli.report.fit_figure import FORMATS

    kind = figure.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        help = f"end the name in {', '.join('.' + name for name in FORMATS)}"
        raise UsageError("SBB900", f"`{figure}` is no figure that can be drawn", help)
    return kind


def _ids(lines: Sequence[DigitisedLine], id: str | None, stem: str) -> list[str]:
    """Ids of the option, else of the file, else of its name."""
    base = id if id is not None else stem
    several = len(lines) > 1
    ids = [
        (line.id if id is None else "") or (f"{base}-{number}" if several else base)
        for number, line in enumerate(lines, start=1)
    ]
    twice = next((name for name in ids if ids.count(name) > 1), None)
    if twice is not None:
        raise FitError("SBB302", f"two lines have the id `{twice}`", "`--id NAME` numbers the lines anew")
    return ids


def _fitted(
    id: str,
    line: DigitisedLine,
    threshold_m: float,
    closed: bool,
    parameterization: Any,
    corner_angle: float | None,
) -> Fitted:
    from splinebba_cli.core.curves.fitting import fit_spline
    from splinebba_cli.report.fit_summary import Fitted

    start = time.perf_counter()
    try:
        spline = fit_spline(
            line.points,
            threshold_m,
            closed=closed or line.closed,
            parameterization=parameterization,
            corner_angle_deg=corner_angle,
        )
    except FitError as error:
        raise FitError(error.code, f"line `{id}`: {error.message}", error.help) from None
    return Fitted(id, spline, time.perf_counter() - start)


def _print(
    fits: Sequence[Fitted],
    warnings: Sequence[Diagnostic],
    text: str,
    target: Path,
    figure: Path | None,
    format: OutputFormat,
    log: Log,
) -> None:
    """Write the YAML; say what came out."""
    to_stdout = str(target) == "-"
    if not to_stdout:
        from splinebba_cli.output.atomic import write_file_atomically

        write_file_atomically(target, text)
    if format is OutputFormat.json:
        from splinebba_cli.project.diagnostics import as_json_data
        from splinebba_cli.report.fit_summary import fit_data

        print_json(
            {
                "output": None if to_stdout else str(target),
                "figure": None if figure is None else str(figure),
                "splines": [fit_data(fitted) for fitted in fits],
                "problems": as_json_data(warnings),
            }
        )
        return
    from splinebba_cli.report.fit_summary import fit_table

    log.warnings(warnings)
    if to_stdout:
        print(text, end="")
    if not to_stdout or not log.quiet:
        rich_console(to_stdout=not to_stdout).print(fit_table(fits))
    if not to_stdout:
        rich_console().print(f"Splines: {target}", markup=False, soft_wrap=True)
    if figure is not None:
        rich_console(to_stdout=not to_stdout).print(f"Figure: {figure}", markup=False, soft_wrap=True)
