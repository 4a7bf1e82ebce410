"""The peer: Ceres Solver on the same block, as a program that is compiled from the folder of the generator.

It prints one line of JSON for the solution and one for the dispersion; with the environment variable DUMP it writes
the adjusted exterior orientations (omega phi kappa X0 Y0 Z0; radians, metres), one image a line.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any, Literal

from benchmarks.blocks import Block, NotAvailableError
from benchmarks.measured_process import FailedProcessError, Measured, run_measured

Mode = Literal["vp", "knots"]
SOURCES = ("ba_spline.cc", "Makefile")
PROGRAM = "ba_spline"
HEADER = Path("/usr/include/ceres/ceres.h")


def find_peer(given: Path | None, generator: Path, folder: Path) -> Path:
    """The peer's program: the given one, or compiled in `folder` (kept there).

    Raises
    ------
    NotAvailableError
        Where it is not given and cannot be compiled.
    """
    if given is not None:
        if not os.access(given, os.X_OK):
            raise NotAvailableError(f"not a program: {given}")
        return given.resolve()
    program = folder / PROGRAM
    if program.exists():
        return program
    if not HEADER.exists():
        raise NotAvailableError("Ceres Solver is not installed: apt-get install g++ make libceres-dev")
    with tempfile.TemporaryDirectory() as work:
        for name in SOURCES:
            shutil.copy(generator / name, work)
        try:
            run_measured(["make", PROGRAM], folder=Path(work))
        except (OSError, FailedProcessError) as error:
            raise NotAvailableError(f"the peer does not compile: {error}") from error
        shutil.copy(Path(work) / PROGRAM, program)
    return program


def run_peer(
    program: Path,
    block: Block,
    mode: Mode,
    *,
    dispersion: bool = False,
    dump: Path | None = None,
    threads: int = 2,
) -> tuple[Measured, dict[str, Any]]:
    """One run of the peer, and the figures that it printed (those of the dispersion with it)."""
    command = [program, block.text, "--mode", mode, "--threads", str(threads)]
    extra = {"DUMP": str(dump)} if dump is not None else {}
    measured = run_measured([*command, "--cov"] if dispersion else command, threads=threads, extra=extra)
    figures: dict[str, Any] = {}
    for line in measured.output.splitlines():
        if line.startswith("{"):
            figures |= json.loads(line)
    return measured, figures
