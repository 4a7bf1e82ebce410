"""How far off orientations may be for unlabelled chains to find their curves: Lee's six-image block.

    python -m benchmarks.convergence_radius [--runs 7] [--jobs 2] [--figure docs/figures/convergence-radius.svg]

Control splines and approximate tie splines of the block, labels removed; positions and angles of all images off by
normal errors, whose sigma the settings state.  For every pair of sigma, without wrong chains and with a third of the
chains running elsewhere, so many runs (7: 504 in all): the share of images whose orientation lies within six of its own
standard deviations of the truth, of those that are called oriented and do not, and of points with a wrong label.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.contaminated import with_moved_orientations, with_wrong_chains
from benchmarks.matching_convergence import WRONG_CHAINS, Outcome, outcome
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import FloatArray
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import at_truth
from tests.unlabelled import without_labels

POSITIONS = (3.0, 10.0, 30.0, 60.0, 100.0, 150.0)  # m
ANGLES = (0.5, 2.0, 5.0, 10.0, 15.0, 20.0)  # degrees
HEADER = "                            runs oriented [%] misled [%] right [%] wrong [%] foreign [%]  s a run"


def six_image_run(seed: int, position_m: float, angle_deg: float, wrong_chains: float) -> Outcome:
    """The six-image block, labels removed, orientations off by normal errors."""
    simulated, truth = simulate_block("six-image", seed)
    start = replace(simulated, images=at_truth(simulated, truth).images)
    network, label = without_labels(start)
    generator = np.random.default_rng(10_000 + seed)
    if wrong_chains > 0.0:
        network, label = with_wrong_chains(network, label, wrong_chains, generator, 20.0)
    network = with_moved_orientations(network, generator, position_m, np.radians(angle_deg))
    settings = MatchSettings(position_sigma_m=position_m, angle_sigma_rad=float(np.radians(angle_deg)))
    return outcome(network, label, settings, truth.rotation, truth.eop[:, 3:])


@dataclass(frozen=True)
class Case:
    """One run."""

    position: float  # m
    angle: float  # degrees
    wrong_chains: float
    seed: int

    def run(self) -> Outcome:
        """Match one block and compare."""
        return six_image_run(self.seed, self.position, self.angle, self.wrong_chains)


def shares(found: Sequence[Outcome]) -> FloatArray:
    """Percent of images oriented and of images misled, of points right and wrong, of foreign points with a label."""
    every = [(f.converged, f.misled, f.right, f.wrong, f.foreign) for f in found]
    return 100.0 * np.mean(every, axis=0)


def _line(name: str, found: Sequence[Outcome]) -> str:
    oriented, misled, right, wrong, foreign = shares(found)
    seconds = np.mean([f.seconds for f in found])
    return (
        f"{name:26s} {len(found):5d} {oriented:12.1f} {misled:10.2f} {right:9.2f} {wrong:9.3f} {foreign:11.2f} "
        f"{seconds:8.1f}"
    )


def draw(tables: dict[str, FloatArray], path: Path) -> None:
    """Shares of oriented images over both sigma, (len(ANGLES), len(POSITIONS)) each, side by side."""
    import matplotlib as mpl

    mpl.use("svg" if path.suffix == ".svg" else "agg")
    mpl.rcParams["svg.hashsalt"] = "convergence-radius"
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(tables), figsize=(8.4, 3.9), sharey=True, layout="constrained")
    for axis, (name, table) in zip(np.atleast_1d(axes), tables.items(), strict=True):
        image = axis.imshow(table, origin="lower", vmin=0.0, vmax=100.0, cmap="cividis", aspect="auto")
        for row, column in product(range(len(ANGLES)), range(len(POSITIONS))):
            value = table[row, column]
            axis.text(
                column, row, f"{value:.0f}", ha="center", va="center", fontsize=9,
                color="black" if value > 55.0 else "white",
            )  # fmt: skip
        axis.set_xticks(range(len(POSITIONS)), [f"{p:g}" for p in POSITIONS])
        axis.set_yticks(range(len(ANGLES)), [f"{a:g}" for a in ANGLES])
        axis.set(title=name, xlabel="σ of positions [m]")
    np.atleast_1d(axes)[0].set_ylabel("σ of angles [°]")
    figure.colorbar(image, ax=axes, label="images oriented [%]")
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    plt.close(figure)


def study(runs: int, jobs: int) -> tuple[dict[str, FloatArray], list[Outcome]]:
    """Shares of oriented images of all pairs of sigma by the share of wrong chains, and all runs."""
    tables: dict[str, FloatArray] = {}
    every: list[Outcome] = []
    os.environ |= dict.fromkeys(
        ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1"
    )  # of the processes that begin
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for wrong in (0.0, WRONG_CHAINS):
            table = np.zeros((len(ANGLES), len(POSITIONS)))
            for (row, angle), (column, position) in product(enumerate(ANGLES), enumerate(POSITIONS)):
                cases = [Case(position, angle, wrong, seed) for seed in range(1, runs + 1)]
                found = list(pool.map(Case.run, cases))
                print(_line(f"{position:3.0f} m, {angle:4g} deg, {100 * wrong:3.0f} %", found), flush=True)
                table[row, column] = shares(found)[0]
                every += found
            tables[f"{100 * wrong:.0f} % of the chains wrong"] = table
    return tables, every


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=7, help="of every pair of sigma")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--figure", type=Path)
    chosen = parser.parse_args()
    print(HEADER)
    tables, every = study(chosen.runs, chosen.jobs)
    print(_line("all", every))
    if chosen.figure:
        draw(tables, chosen.figure)


if __name__ == "__main__":
    main()
