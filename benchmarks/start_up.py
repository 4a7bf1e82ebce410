"""Start-up and a small project against importing what they need.

    python -m benchmarks.start_up --repeats 7 --json OUT.json

In turn, each in a process of its own: `splinebba --help` against `import typer, rich` (wanted: at most 1.5 times),
and the six-image sample from start to result tables, without HTML, against importing the libraries (at most 3 times).
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.machine import machine
from benchmarks.measured_process import PYTHON, REPOSITORY, run_measured
from benchmarks.measurements import Run, select, write_measurements

SAMPLE = REPOSITORY / "sample_projects" / "six_image_block"
IMPORTS = "import numpy, scipy.linalg, pydantic, typer, rich.console, yaml"


@dataclass(frozen=True)
class Pair:
    """A command, and the imports that it is held against."""

    name: str
    command: tuple[str, ...]  # {results} stands for a folder
    imports: str
    wanted: float


PAIRS = (
    Pair("--help", ("--help",), "import typer, rich", 1.5),
    Pair("sample", ("adjust", str(SAMPLE), "--no-html", "--quiet", "-o", "{results}"), IMPORTS, 3.0),
)


def measured_pairs(repeats: int, folder: Path) -> list[Run]:
    """Both commands and their imports, in turn; the first repetition (cold caches) is left out."""
    runs = []
    for repetition in range(-1, repeats):
        for pair in PAIRS:
            words = [word.format(results=folder / "results") for word in pair.command]
            for mode, command in (
                ("command", ["-m", "splinebba_cli", *words]),
                ("imports", ["-c", pair.imports]),
            ):
                measured = run_measured([PYTHON, *command], accepted=(0, 1))
                if repetition >= 0:
                    runs.append(Run.of(measured, 0, repetition, pair.name, mode, {}))
    return runs


@dataclass(frozen=True)
class StartUp:
    """One command against its imports."""

    pair: Pair
    command_s: float  # median
    imports_s: float
    ratios: tuple[float, ...]


def ratios_of(runs: list[Run]) -> list[StartUp]:
    """Ratios by repetition."""
    found = []
    for pair in PAIRS:
        ours = [run.wall_s for run in select(runs, 0, pair.name, "command")]
        other = [run.wall_s for run in select(runs, 0, pair.name, "imports")]
        ratios = tuple(a / b for a, b in zip(ours, other, strict=True))
        found.append(StartUp(pair, statistics.median(ours), statistics.median(other), ratios))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    here = machine()
    with tempfile.TemporaryDirectory() as folder:
        runs = measured_pairs(chosen.repeats, Path(folder))
    if chosen.json:
        write_measurements(chosen.json, "start_up", here, runs)
    table = Table()
    for name in ("command", "s", "imports s", "least", "median", "most", "wanted"):
        table.add_column(name, justify="right")
    for row in ratios_of(runs):
        figures = min(row.ratios), statistics.median(row.ratios), max(row.ratios), row.pair.wanted
        table.add_row(
            row.pair.name, f"{row.command_s:.3f}", f"{row.imports_s:.3f}", *(f"{f:.2f}" for f in figures)
        )
    Console(width=None if sys.stdout.isatty() else 100).print(table)


if __name__ == "__main__":
    main()
