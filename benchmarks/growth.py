"""How time and memory of `splinebba adjust` grow with the block, from generator to result tables.

    python -m benchmarks.growth --sizes 100 1000 10000 50000 --folder DIR --json OUT.json --plot OUT.svg

Every size: block, project (both kept in DIR), then the whole command without HTML in a process of its own.  What a
size gave is kept in DIR as well, so that an interrupted study goes on where it ended (--again measures anew).
Prints exponents by least squares over the logarithms, from --from images on.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.blocks import Block, NotAvailableError, bench_folder, make_archive, make_project
from benchmarks.machine import machine
from benchmarks.measured_process import PYTHON, run_measured
from benchmarks.measurements import PLAIN, SPEED, SPEED_VARIABLE, Run, write_measurements
from benchmarks.power_law import exponent

console = Console(stderr=True)

# read by a process of its own: the table of a large block must not count as memory of the next measured process
READ_RESULT = """
import json, sys
with open(sys.argv[1], encoding="utf-8") as stream:
    result = json.load(stream)
timings = result["provenance"]["timestamps"]["timings_s"]
kept = {**result["status"], **result["statistics"], **timings}
print(json.dumps({name: value for name, value in kept.items() if isinstance(value, (int, float, str))}))
"""
QUANTITIES = {
    "wall time, s": lambda run: run.wall_s,
    "CPU time, s": lambda run: run.cpu_s,
    "peak memory, GiB": lambda run: run.peak_bytes / 2**30,
    "time per iteration, s": lambda run: run.figures["estimation_s"] / run.figures["iterations"],
    "quality, s": lambda run: run.figures["quality_s"],
}


def measured_size(block: Block, mode: str, threads: int, tables: str) -> Run:
    """The whole command on one block."""
    results = block.folder / f"r{block.images}"
    measured = run_measured(
        [PYTHON, "-m", "splinebba_cli", "adjust", block.project, "--no-html", "--quiet", "--tables", tables,
         "-o", results],
        threads=threads,
        extra={"SPLINEBBA_SPEED": SPEED_VARIABLE[mode], "NUMBA_CACHE_DIR": str(block.folder / "kernels")},
        accepted=(0, 1),
    )  # fmt: skip
    figures = json.loads(run_measured([PYTHON, "-c", READ_RESULT, results / "result.json"]).output)
    figures["result_bytes"] = sum(path.stat().st_size for path in results.iterdir())
    shutil.rmtree(results)
    return Run.of(measured, block.images, 0, "adjust", mode, figures)


def kept_or_measured(block: Block, mode: str, chosen: argparse.Namespace, generator: Path | None) -> Run:
    """What an earlier run left, or measured now."""
    kept = block.folder / f"growth-{mode}-{block.images}.json"
    if kept.exists() and not chosen.again:
        return Run(**json.loads(kept.read_text(encoding="utf-8")))
    if not (block.project / "project.yaml").exists():
        make_archive(block, generator or bench_folder(chosen.generator), text=False)
        make_project(block)
    run = measured_size(block, mode, chosen.threads, chosen.tables)
    kept.write_text(json.dumps(run.__dict__), encoding="utf-8")
    return run


def series(runs: list[Run], mode: str, first: int) -> dict[str, list[tuple[float, float]]]:
    """(images, value) of every quantity, from `first` images on."""
    chosen = sorted((run for run in runs if run.mode == mode), key=lambda run: run.size)
    return {
        name: [(run.size, value(run)) for run in chosen if run.size >= first]
        for name, value in QUANTITIES.items()
    }


def exponents(runs: list[Run], first: int) -> dict[str, dict[str, float | None]]:
    """The exponent of every quantity, by mode."""
    return {
        mode: {name: exponent(points) for name, points in series(runs, mode, first).items()}
        for mode in sorted({run.mode for run in runs})
    }


def print_growth(runs: list[Run], first: int) -> None:
    table = Table(title="splinebba adjust, whole process")
    for name in (
        "images",
        "mode",
        "wall s",
        "CPU s",
        "iterations",
        "s / iteration",
        "quality s",
        "GiB",
        "observations",
    ):
        table.add_column(name, justify="right")
    for run in runs:
        table.add_row(
            str(run.size), run.mode, f"{run.wall_s:.2f}", f"{run.cpu_s:.2f}",
            str(run.figures["iterations"]), f"{run.figures['estimation_s'] / run.figures['iterations']:.3f}",
            f"{run.figures['quality_s']:.2f}",
            f"{run.peak_bytes / 2**30:.2f}", str(run.figures["observations"]),
        )  # fmt: skip
    output = Console(width=None if sys.stdout.isatty() else 120)
    output.print(table)
    for mode, found in exponents(runs, first).items():
        for name, value in found.items():
            output.print(f"{mode}: exponent of {name}: {'–' if value is None else f'{value:.2f}'}")


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[100, 1000, 10000, 50000])
    parser.add_argument("--from", dest="first", type=int, default=1000, help="first size of the exponents")
    parser.add_argument("--modes", nargs="+", choices=[PLAIN, SPEED], default=[SPEED])
    parser.add_argument("--tables", choices=["csv", "parquet"], default="csv")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--folder", type=Path, required=True, help="keeps blocks, projects and figures")
    parser.add_argument("--generator", type=Path)
    parser.add_argument("--again", action="store_true", help="measure what was measured before, too")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path)
    return parser.parse_args()


def main() -> None:
    chosen = parsed()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    here: dict[str, Any] = machine()
    runs: list[Run] = []
    try:
        for images in sorted(chosen.sizes):
            for mode in chosen.modes:
                run = kept_or_measured(Block(images, chosen.folder.resolve()), mode, chosen, chosen.generator)
                runs.append(run)
                console.print(f"{images} {mode}: {run.wall_s:.1f} s, {run.peak_bytes / 2**30:.2f} GiB")
                if chosen.json:
                    found = exponents(runs, chosen.first)
                    write_measurements(chosen.json, "growth", here, runs, exponents=found, first=chosen.first)
    except NotAvailableError as reason:
        console.print(f"skipped: {reason}")
        return
    print_growth(runs, chosen.first)
    if chosen.plot:
        from benchmarks.plots import plot_growth

        panels = {
            name: {mode: series(runs, mode, 0)[name] for mode in chosen.modes}
            for name in ("wall time, s", "time per iteration, s", "peak memory, GiB")
        }
        plot_growth(panels, "images", chosen.plot)


if __name__ == "__main__":
    main()
