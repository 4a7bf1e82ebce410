"""A coastline of many knots as one spline: seconds and memory against its length.

    python -m benchmarks.coastline --knots 500 1000 2000 5000 --json OUT.json --plot OUT.svg [--profile]

Every length is adjusted by the core (`adjust(network)`) in a process of its own.  A strip of images follows the
coast, so that all costs should be proportional to the number of knots; exponents by least squares over the logarithms.
With --profile the functions that take most time, at every length, and how their times grow.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import pstats
import sys
import time
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.machine import machine
from benchmarks.measured_process import PYTHON, FailedProcessError, run_measured
from benchmarks.measurements import PLAIN, SPEED, SPEED_VARIABLE, Run, write_measurements
from benchmarks.power_law import exponent

TIMES = ("approximation_s", "estimation_s", "quality_s", "total_s", "total_cpu_s")
LISTED = 60  # functions of a profile that are kept
SHOWN = 16

console = Console(stderr=True)


def adjusted_here(knots: int, role: str, overlap: float, profiled: bool) -> dict[str, Any]:
    """Generate and adjust in this process; figures, and own seconds of functions where profiled."""
    from benchmarks.coastline_block import Coastline, coastline_network
    from splinebba_cli.core.adjustment import adjust

    coast = Coastline(knots, overlap=overlap, role="tie" if role == "tie" else "partial")
    network = coastline_network(coast)
    profile = cProfile.Profile(time.process_time)  # of a loaded machine, too
    begin = time.perf_counter(), time.process_time()
    if profiled:
        profile.enable()
    result = adjust(network)
    profile.disable()
    total = time.perf_counter() - begin[0]
    return {
        "images": coast.images,
        "points": len(network.curve_observations),
        "iterations": len(result.iterations),
        "sigma0": result.statistics.sigma0,
        "total_s": total,
        "total_cpu_s": time.process_time() - begin[1],
        **result.timings,
        "functions": _functions(profile) if profiled else {},
    }


def _functions(profile: cProfile.Profile) -> dict[str, float]:
    """Own processor seconds of the functions that take most."""
    table: dict[Any, Any] = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    own = {f"{Path(file).name}:{name}": row[2] for (file, _, name), row in table.items()}
    return dict(sorted(own.items(), key=lambda item: -item[1])[:LISTED])


def measured_coast(knots: int, mode: str, chosen: argparse.Namespace) -> Run:
    """One length in a process of its own."""
    command = [PYTHON, "-m", "benchmarks.coastline", "--one", str(knots), "--role", chosen.role,
               "--overlap", str(chosen.overlap)]  # fmt: skip
    measured = run_measured(
        [*command, "--profile"] if chosen.profile else command,
        threads=chosen.threads,
        extra={"SPLINEBBA_SPEED": SPEED_VARIABLE[mode]},
    )
    figures = json.loads(measured.output.splitlines()[-1])
    return Run.of(measured, knots, 0, "coastline", mode, figures)


def exponents(runs: list[Run]) -> dict[str, dict[str, float | None]]:
    """Exponent over the number of knots, by mode."""
    found: dict[str, dict[str, float | None]] = {}
    for mode in sorted({run.mode for run in runs}):
        chosen = [run for run in runs if run.mode == mode]
        values = {name: [(run.size, run.figures[name]) for run in chosen] for name in TIMES}
        values["estimation_s an iteration"] = [
            (run.size, run.figures["estimation_s"] / run.figures["iterations"]) for run in chosen
        ]
        values["peak_bytes"] = [(run.size, run.peak_bytes) for run in chosen]
        found[mode] = {name: exponent(points) for name, points in values.items()}
    return found


def print_coasts(runs: list[Run]) -> None:
    table = Table(title="one spline, adjusted by the core")
    for name in ("knots", "images", "points", "mode", "iterations", "approximation s", "estimation s", "quality s",
                 "ms / knot", "peak GiB", "KiB / knot"):  # fmt: skip
        table.add_column(name, justify="right")
    for run in runs:
        f = run.figures
        table.add_row(
            str(run.size), str(f["images"]), str(f["points"]), run.mode, str(f["iterations"]),
            *(f"{f[name]:.2f}" for name in TIMES[:3]), f"{1e3 * f['total_s'] / run.size:.2f}",
            f"{run.peak_bytes / 2**30:.2f}", f"{run.peak_bytes / 2**10 / run.size:.0f}",
        )  # fmt: skip
    output = Console(width=None if sys.stdout.isatty() else 130)
    output.print(table)
    for mode, found in exponents(runs).items():
        shown = ", ".join(f"{name} {value:.2f}" for name, value in found.items() if value is not None)
        output.print(f"{mode}: exponents: {shown}")
    print_functions(runs, output)


def print_functions(runs: list[Run], output: Console) -> None:
    """Own time of functions at the longest coast, and how it grows."""
    longest = max(runs, key=lambda run: run.size)
    of_mode = [run for run in runs if run.mode == longest.mode]
    for name, seconds in list(longest.figures["functions"].items())[:SHOWN]:
        points = [(run.size, run.figures["functions"].get(name, 0.0)) for run in of_mode]
        growth = exponent(points)
        grows = "" if growth is None else f"exponent {growth:.2f}"
        output.print(f"{seconds:9.2f} s  {name:55s} {grows}", highlight=False)


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--knots", type=int, nargs="+", default=[500, 1000, 2000, 5000])
    parser.add_argument("--role", choices=["partial", "tie"], default="partial")
    parser.add_argument("--overlap", type=float, default=0.75, help="of consecutive images, in knots")
    parser.add_argument("--modes", nargs="+", choices=[PLAIN, SPEED], default=[PLAIN])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--profile", action="store_true")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> None:
    chosen = parsed()
    if chosen.one:
        print(json.dumps(adjusted_here(chosen.one, chosen.role, chosen.overlap, chosen.profile)))
        return
    here, runs = machine(), []
    for knots in sorted(chosen.knots):
        for mode in chosen.modes:
            try:
                runs.append(measured_coast(knots, mode, chosen))
            except FailedProcessError as error:
                console.print(f"{knots} knots: {error}")
                continue
            console.print(f"{knots} {mode}: {runs[-1].figures['total_s']:.1f} s")
            if chosen.json:
                write_measurements(
                    chosen.json, "coastline", here, runs, exponents=exponents(runs), role=chosen.role
                )
    if not runs:
        return
    print_coasts(runs)
    if chosen.plot:
        from benchmarks.plots import plot_growth

        of = {mode: [run for run in runs if run.mode == mode] for mode in chosen.modes}
        panels = {
            "time, s": {f"{name[:-2]}, {mode}": [(run.size, run.figures[name]) for run in chosen_runs]
                        for mode, chosen_runs in of.items() for name in TIMES},
            "peak memory, GiB": {mode: [(run.size, run.peak_bytes / 2**30) for run in chosen_runs]
                                 for mode, chosen_runs in of.items()},
        }  # fmt: skip
        plot_growth(panels, "knots", chosen.plot)


if __name__ == "__main__":
    main()
