"""Splinebba and Ceres Solver on the same blocks, in turn, each in a process of its own with two threads.

    python -m benchmarks.against_ceres --sizes 100 1000 5000 --repeats 5 --json OUT.json --plot OUT.svg

In every repetition: the peer's `vp`, the core's solution in plain numpy and with compiled kernels (extra `speed`),
the whole `splinebba adjust --no-html` both ways (up to --adjust images); once per size up to --once images the
peer's `knots` and its dispersion.  Prints ratios (least, median, most) beside those that are wanted.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.blocks import Block, NotAvailableError, bench_folder, make_archive, make_project
from benchmarks.comparisons import ratios_of
from benchmarks.machine import machine
from benchmarks.measured_process import PYTHON, Measured, run_measured
from benchmarks.measurements import PLAIN, SPEED, SPEED_VARIABLE, Run, write_measurements
from benchmarks.peer import find_peer, run_peer

console = Console(stderr=True)


@dataclass(frozen=True)
class Session:
    """What is run, and where its files are."""

    folder: Path
    peer: Path | None  # None: not available
    modes: tuple[str, ...]
    solves: int
    adjust: int  # largest block for the whole command
    once: int  # largest block for what the peer does once
    threads: int = 2

    def extra(self, mode: str) -> dict[str, str]:
        """Environment of a mode; compiled kernels are kept in the folder of the session."""
        return {"SPLINEBBA_SPEED": SPEED_VARIABLE[mode], "NUMBA_CACHE_DIR": str(self.folder / "kernels")}

    def solve(self, block: Block, mode: str) -> tuple[Measured, dict[str, Any]]:
        """The core's solution, in a process of its own."""
        measured = run_measured(
            [PYTHON, "-m", "benchmarks.solve_block", block.archive, "--solves", str(self.solves),
             "--estimates", self.estimates(block)],
            threads=self.threads, extra=self.extra(mode),
        )  # fmt: skip
        return measured, json.loads(measured.output.splitlines()[-1])

    def adjust_project(self, block: Block, mode: str) -> Measured:
        """The whole command, as a user runs it, without HTML."""
        return run_measured(
            [PYTHON, "-m", "splinebba_cli", "adjust", block.project, "--no-html", "--quiet",
             "-o", self.folder / f"r{block.images}"],
            threads=self.threads, extra=self.extra(mode),
            accepted=(0, 1),
        )  # fmt: skip

    def estimates(self, block: Block) -> Path:
        """Where the last solution leaves its orientations."""
        return self.folder / f"e{block.images}.npz"

    def dump(self, block: Block) -> Path:
        """Where the peer leaves its orientations."""
        return self.folder / f"d{block.images}.txt"


def one_time_runs(session: Session, block: Block) -> Iterator[Run]:
    """The peer's dispersion and its formulation `knots`."""
    if session.peer is None or block.images > session.once:
        return
    measured, figures = run_peer(session.peer, block, "vp", dispersion=True, threads=session.threads)
    yield Run.of(measured, block.images, 0, "ceres_cov", "", figures)
    measured, figures = run_peer(session.peer, block, "knots", threads=session.threads)
    yield Run.of(measured, block.images, 0, "ceres_knots", "", figures)


def repeated_runs(session: Session, block: Block, repetition: int) -> Iterator[Run]:
    """All that is compared, once."""
    if session.peer is not None:
        measured, figures = run_peer(
            session.peer, block, "vp", dump=session.dump(block), threads=session.threads
        )
        yield Run.of(measured, block.images, repetition, "ceres_vp", "", figures)
    for mode in session.modes:
        measured, figures = session.solve(block, mode)
        yield Run.of(measured, block.images, repetition, "solve", mode, figures)
    if block.images <= session.adjust:
        for mode in session.modes:
            measured = session.adjust_project(block, mode)
            yield Run.of(measured, block.images, repetition, "adjust", mode, {})


def compiling_run(session: Session, block: Block) -> Iterator[Run]:
    """The first use of compiled kernels, with an empty cache."""
    if SPEED in session.modes and not (session.folder / "kernels").exists():
        measured, figures = session.solve(block, SPEED)
        yield Run.of(measured, block.images, 0, "first_use", SPEED, figures)


def measure(session: Session, blocks: list[Block], repeats: int) -> Iterator[Run]:
    """All runs; blocks in turn within each repetition."""
    yield from compiling_run(session, blocks[0])
    for block in blocks:
        yield from one_time_runs(session, block)
    for repetition in range(repeats):
        for block in blocks:
            yield from repeated_runs(session, block, repetition)


def agreements(session: Session, blocks: list[Block], runs: list[Run]) -> dict[str, Any]:
    """Agreement with the peer, by size; imports numpy, hence after all that is measured."""
    from benchmarks.agreement import agreement

    found: dict[str, Any] = {}
    for block in blocks:
        of_block = [run for run in runs if run.size == block.images]
        ours = [run.figures for run in of_block if run.task == "solve"]
        peer = {key: value for run in of_block if run.task in ("ceres_vp", "ceres_cov")
                for key, value in run.figures.items()}  # fmt: skip
        if ours and peer:
            found[str(block.images)] = agreement(
                ours[-1], session.estimates(block), peer, session.dump(block)
            )
    return found


def print_ratios(runs: list[Run], found: dict[str, Any]) -> None:
    """The table that a person reads."""
    table = Table(title="seconds (median) and ratios to the peer")
    for name in ("images", "what", "mode", "s", "against", "s", "least", "median", "most", "wanted", ""):
        table.add_column(name, justify="left" if name in ("what", "mode", "against") else "right")
    for ratio in ratios_of(runs):
        mark = {None: "", True: "yes", False: "NO"}[ratio.reached]
        table.add_row(
            str(ratio.images), ratio.comparison.name, ratio.comparison.mode, f"{ratio.seconds:.3f}",
            ratio.comparison.other_name, f"{ratio.other_seconds:.3f}",
            *(f"{value:.3g}" for value in (ratio.least, ratio.median, ratio.most)),
            "" if ratio.wanted is None else f"{ratio.wanted:.3g}", mark,
        )  # fmt: skip
    output = Console(width=None if sys.stdout.isatty() else 150)
    output.print(table)
    for run in runs:
        if run.task == "first_use":
            figures = run.figures
            output.print(
                f"compiled kernels: first use {run.wall_s:.1f} s, of it first solution "
                f"{figures['warm_up_s']:.1f} s and import {figures['import_s']:.2f} s"
            )
    for images, values in found.items():
        sigma = "" if values["sigma_x"] is None else (
            f", σX {values['sigma_x']:+.1e}, σZ {values['sigma_z']:+.1e}"
        )  # fmt: skip
        output.print(
            f"{images} images: v'Pv differs by {values['cost']:+.1e} of itself ({values['cost_peer_rule']:+.1e} "
            "with the peer's rule at joints), orientations by at most "
            f"{values['largest_difference']:.1e} σ (RMS {values['rms_difference']:.1e} σ){sigma}"
        )


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[100, 1000, 5000])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--solves", type=int, default=3, help="solutions of the core in one process")
    parser.add_argument("--adjust", type=int, default=1000, help="largest block for `splinebba adjust`")
    parser.add_argument("--once", type=int, default=1000, help="largest block for Ceres knots and --cov")
    parser.add_argument("--modes", nargs="+", choices=[PLAIN, SPEED], default=[PLAIN, SPEED])
    parser.add_argument("--generator", type=Path, help="folder of gen_block.py and of the peer's source")
    parser.add_argument("--peer", type=Path, help="the peer's program; default: compiled")
    parser.add_argument("--folder", type=Path, help="keeps blocks, projects and the peer; default: temporary")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path)
    return parser.parse_args()


def run(chosen: argparse.Namespace, folder: Path) -> None:
    """Prepare, measure, report."""
    generator = bench_folder(chosen.generator)
    peer = None
    try:
        peer = find_peer(chosen.peer, generator, folder)
    except NotAvailableError as reason:
        console.print(f"without the peer: {reason}")
    modes = [mode for mode in chosen.modes if mode == PLAIN or find_spec("numba")]
    if modes != chosen.modes:
        console.print("without compiled kernels: numba is not installed (extra `speed`)")
    session = Session(folder, peer, tuple(modes), chosen.solves, chosen.adjust, chosen.once)
    blocks = [Block(images, folder) for images in sorted(chosen.sizes)]
    for block in blocks:
        console.print(f"block of {block.images} images")
        make_archive(block, generator, text=peer is not None)
        if block.images <= chosen.adjust:
            make_project(block)
    here, runs = machine(), []
    for each in measure(session, blocks, chosen.repeats):
        runs.append(each)
        console.print(
            f"{each.repetition + 1}: {each.task} {each.mode} {each.size}: {each.wall_s:.2f} s wall, "
            f"{each.cpu_s:.2f} s CPU, {each.peak_bytes / 2**20:.0f} MiB"
        )
        if chosen.json:
            write_measurements(chosen.json, "against_ceres", here, runs)
    found = agreements(session, blocks, runs)
    if chosen.json:
        write_measurements(chosen.json, "against_ceres", here, runs, agreement=found)
    print_ratios(runs, found)
    if chosen.plot:
        from benchmarks.plots import plot_against_peer

        plot_against_peer(runs, chosen.plot)


def main() -> None:
    chosen = parsed()
    try:
        if chosen.folder:
            chosen.folder.mkdir(parents=True, exist_ok=True)
            run(chosen, chosen.folder.resolve())
        else:
            with tempfile.TemporaryDirectory(prefix="splinebba-bench-") as folder:
                run(chosen, Path(folder))
    except NotAvailableError as reason:
        console.print(f"skipped: {reason}")


if __name__ == "__main__":
    main()
