"""``splinebba init``: a project to start from."""

from __future__ import annotations

import shlex
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from splinebba_cli.commands.console import Log, expected_errors, print_json
from splinebba_cli.commands.digitised_options import (
    CartesianOption,
    ColumnsOption,
    HeightOption,
    ThresholdOption,
    column_names,
)
from splinebba_cli.commands.options import FormatOption, OutputFormat, QuietOption
from splinebba_cli.errors import UsageError
from splinebba_cli.starters.catalogue import DEFAULT, OF_POLYLINES, TEMPLATES, Polyline

if TYPE_CHECKING:
    from collections.abc import Sequence


class TemplateChoice(StrEnum):
    """Kind of project; the keys of :data:`.starters.catalogue.TEMPLATES`."""

    aerial = "aerial"
    close_range = "close-range"
    control_splines = "control-splines"


def init(
    folder: Annotated[
        Path | None,
        typer.Argument(metavar="FOLDER", help="Folder to make. Default: the name of the template."),
    ] = None,
    template: Annotated[
        TemplateChoice | None,
        typer.Option(
            "--template", "-t", help=f"Kind of project. Default: {DEFAULT}; with --polyline {OF_POLYLINES}."
        ),
    ] = None,
    polyline: Annotated[
        Path | None,
        typer.Option(
            "--polyline", metavar="FILE", help="Digitised lines, CSV or GeoJSON, metres: the control splines."
        ),
    ] = None,
    threshold_m: ThresholdOption = 0.05,
    columns: ColumnsOption = None,
    z: HeightOption = None,
    cartesian: CartesianOption = False,
    list_templates: Annotated[bool, typer.Option("--list", help="Tell the templates.")] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace files of the same names in a folder that is not empty.")
    ] = False,
    format: FormatOption = OutputFormat.text,
    quiet: QuietOption = False,
) -> None:
    """Write a project to start from: it adjusts at once, and says what to replace by own data."""
    with expected_errors(as_json=format is OutputFormat.json):
        if list_templates:
            _print_templates(format)
            return
        name = _template(template, polyline)
        target = folder if folder is not None else Path(name)
        from splinebba_cli.starters.catalogue import build
        from splinebba_cli.starters.folder import require_free, write_starter

        require_free(target, force)
        lines = None
        if polyline is not None:
            lines = Polyline(polyline, column_names(columns), z, cartesian, threshold_m)
        made = build(name, lines)
        Log(quiet or format is OutputFormat.json).warnings(made.warnings)
        project = write_starter(target, made.files)
        _print(name, target, project, sorted(made.files), format)


def _template(template: TemplateChoice | None, polyline: Path | None) -> str:
    if template is None:
        return DEFAULT if polyline is None else OF_POLYLINES
    if polyline is not None and template.value != OF_POLYLINES:
        help = f"leave --template out, or say --template {OF_POLYLINES}"
        raise UsageError("SBB900", f"--polyline does not belong to the template `{template.value}`", help)
    return template.value


def _print_templates(format: OutputFormat) -> None:
    if format is OutputFormat.json:
        print_json({"templates": [{"name": name, "about": about} for name, about in TEMPLATES.items()]})
        return
    width = max(map(len, TEMPLATES)) + 2
    print("\n".join(f"{name:{width}}{about}" for name, about in TEMPLATES.items()))


def _print(name: str, folder: Path, project: Path, files: Sequence[str], format: OutputFormat) -> None:
    shown = shlex.quote(str(folder))
    commands = [f"splinebba check {shown}", f"splinebba adjust {shown}"]
    if format is OutputFormat.json:
        data = {"template": name, "folder": str(folder), "project": str(project), "files": files}
        print_json({**data, "next": commands})
        return
    print(f"Project: {project}\n")
    print("Next:")
    print("\n".join(f"  {command}" for command in commands))
    print(f"\n{folder / 'README.md'} says what is what, and how to put in your own data.")
