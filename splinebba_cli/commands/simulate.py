"""``splinebba simulate``: a synthetic project with its truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from splinebba_cli.commands.console import expected_errors
from splinebba_cli.errors import OutputError, UsageError


def simulate(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="Kind of block; `list` names them.", show_default=False)
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to write. Default: KIND in this folder.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the noise.")] = 0,
    noise_um: Annotated[float, typer.Option("--noise-um", min=0.0, help="σ of image coordinates, µm.")] = 5.0,
    force: Annotated[
        bool, typer.Option("--force", help="Replace the files of a project that is there.")
    ] = False,
) -> None:
    """Write a synthetic project with its truth."""
    with expected_errors():
        from splinebba_cli.project.diagnostics import listing, suggestion
        from splinebba_cli.simulation import catalogue

        if kind == "list":
            print("\n".join(f"{name:20}{about}" for name, about in catalogue.KINDS.items()))
            return
        if kind not in catalogue.KINDS:
            help = suggestion(kind, catalogue.KINDS) or f"known: {listing(catalogue.KINDS, 20)}"
            raise UsageError("SBB900", f"no kind of block `{kind}`", help)
        folder = output if output is not None else Path(kind)
        if (folder / "project.yaml").exists() and not force:
            raise OutputError(
                "SBB603", f"`{folder}` holds a project already", "choose another folder, or --force"
            )
        catalogue.write(kind, folder, seed, noise_um)
        print(folder / "project.yaml")
