"""``splinebba chains``: a table of chains from the files of tracing tools."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING

from splinebba_cli.commands import chains_options as option
from splinebba_cli.commands.console import Log, expected_errors, print_json, rich_console
from splinebba_cli.commands.digitised_options import column_names
from splinebba_cli.commands.options import FormatOption, OutputFormat, QuietOption, VerboseOption
from splinebba_cli.commands.places import require_place
from splinebba_cli.errors import OutputError, UsageError

if TYPE_CHECKING:
    from splinebba_cli.exchange.chain_conversion import ConvertedChains

STDOUT = Path("-")


def chains(
    files: option.FilesArgument,
    output: option.FileOption = Path("chains.csv"),
    spacing: option.SpacingOption = None,
    min_points: option.MinPointsOption = 2,
    columns: option.ColumnsOption = None,
    image_suffix: option.ImageSuffixOption = "",
    y_up: option.YUpOption = None,
    renumber: option.RenumberOption = False,
    format: FormatOption = OutputFormat.text,
    force: option.ForceOption = False,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Make a table of chains for a project from files of tracing tools: GeoJSON, labelme, points, segments."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is OutputFormat.json):
        from splinebba_cli.exchange.chain_conversion import ConversionOptions, converted_chains
        from splinebba_cli.exchange.traced_chains import TracingOptions
        from splinebba_cli.output.atomic import write_file_atomically

        _check_place(output, force)
        _check_numbers(spacing, y_up)
        tracing = TracingOptions(_columns(columns), image_suffix)
        options = ConversionOptions(tracing, spacing, min_points, y_up, renumber)
        with log.working():
            log.stage(f"reading {len(files)} file{'s' if len(files) != 1 else ''}")
            converted = converted_chains(files, options)
        if output != STDOUT:
            write_file_atomically(output, converted.csv_text())
        _print(converted, output, format, log)
        log.finished()


def _check_place(output: Path, force: bool) -> None:
    if output == STDOUT:
        return
    require_place(output)
    if os.path.exists(output) and not force:
        raise OutputError("SBB603", f"`{output}` is there already", "choose another name, or --force")


def _check_numbers(spacing: float | None, y_up: float | None) -> None:
    if spacing is not None and not (spacing > 0.0 and math.isfinite(spacing)):
        raise UsageError("SBB900", f"a spacing of {spacing:g} pixels makes no sense", "--spacing 5")
    if y_up is not None and not math.isfinite(y_up):
        raise UsageError(
            "SBB900", f"`--y-up {y_up:g}` is no value of y", "0, or the height of the image in pixels"
        )


def _columns(text: str | None) -> tuple[str, ...] | None:
    """Names of columns.

    Raises
    ------
    UsageError
        If one of them is not known.
    """
    from splinebba_cli.exchange.chains_table import NAMES, OTHER_NAMES, known_column
    from splinebba_cli.project.diagnostics import listing

    names = column_names(text)
    for name in names or ():
        if name != "-" and not known_column(name):
            known = listing((*NAMES, *OTHER_NAMES, "-"), 20)
            raise UsageError("SBB900", f"`{name}` is no column of chains", f"columns are {known}")
    return names


def _print(converted: ConvertedChains, output: Path, format: OutputFormat, log: Log) -> None:
    from splinebba_cli.report.chains_summary import chains_data, chains_table, next_step
    from splinebba_cli.report.console import rich_table

    to_stdout = output == STDOUT
    if format is OutputFormat.json:
        from splinebba_cli.project.diagnostics import as_json_data

        name = None if to_stdout else str(output)
        data = {"output": name, **chains_data(converted), "problems": as_json_data(converted.warnings)}
        print_json(data)
        return
    log.warnings(converted.warnings)
    if to_stdout:
        print(converted.csv_text(), end="")
    if to_stdout and log.quiet:
        return
    console = rich_console(to_stdout=not to_stdout)
    for line in rich_table(chains_table(converted), console.width):
        console.print(line)
    if not to_stdout:
        console.print(f"Chains: {output}", markup=False, soft_wrap=True)
        console.print(next_step(output.name), style="dim", markup=False, soft_wrap=True)
