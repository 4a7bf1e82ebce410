"""How near the machine's limits the three steps of an iteration and of the dispersion come.

    python -m benchmarks.roofline BLOCK.npz --json OUT.json

For every step the work that it cannot do without is counted, and held against the measured peaks of memory bandwidth
and of dense products; `bound` is the time in which the machine could do it, max(operations / peak, bytes / peak).

    assembly    P (P + 1) operations a measured point, P = 19 columns (6 orientation, 12 curve, residual);
                its measurements read, its row written and read once, the normal matrix written
    factor      n^3/3 + n^2 r + n r^2 a front of n pivots and r rows; matrix read, factor written and read
    inverse     2 n^3/3 + n^2 r + 2 n r^2 + 2 n^2 r a front; factor read, inverse written
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.bench_block import network_from_npz
from benchmarks.machine import machine
from benchmarks.machine_peaks import best_seconds, memory_bandwidth, product_speed
from benchmarks.measurements import write_measurements
from benchmarks.solve_block import solved_block
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor
from splinebba_cli.core.estimation.gauss_markov import Solution
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import prepare

MEASUREMENT_BYTES = 8 * (2 + 1 + 1 + 1 + 4)  # xy, image, segment, location, whitening
COLUMNS = 6 + 12 + 1


@dataclass(frozen=True)
class Step:
    """One step with the work that it cannot do without."""

    name: str
    seconds: float
    operations: float
    bytes: float

    def bound(self, operations_per_s: float, bytes_per_s: float) -> float:
        """Seconds in which the machine could do it."""
        return max(self.operations / operations_per_s, self.bytes / bytes_per_s)


def inverse_operations(symbolic: SymbolicFactor) -> float:
    """Floating-point operations of the selected inverse."""
    n, r = symbolic.layout.pivots.astype(float), symbolic.layout.rows.astype(float)
    return float(np.sum(n * (2.0 * n * n / 3.0 + 3.0 * n * r + 2.0 * r * r)))


def measured_steps(assembler: Assembler, solution: Solution) -> list[Step]:
    """Times and counted work of assembly, factorisation and selected inverse at the solution."""
    prepared, state = assembler.prepared, solution.state
    held = held_locations(prepared, state.location)
    symbolic = assembler.symbolic(state)
    values = assembler.eliminate(solution.linearization, 0.0)[0]
    factor = symbolic.factorize(values)
    points = len(prepared.network.curve_observations)
    entries, stored = assembler.structure.n_entries, symbolic.factor_entries

    def assemble() -> object:
        return assembler.eliminate(assembler.linearize(state, held), 0.0)

    return [
        _step("assembly", assemble, points * COLUMNS * (COLUMNS + 1),
              points * (MEASUREMENT_BYTES + 2 * 8 * COLUMNS) + 8 * entries),
        _step("factorisation", lambda: symbolic.factorize(values), symbolic.flops, 8 * (entries + 2 * stored)),
        _step("selected inverse", factor.selected_inverse, inverse_operations(symbolic), 8 * 2 * stored),
    ]  # fmt: skip


def _step(name: str, work: Callable[[], object], operations: float, moved: float) -> Step:
    work()
    return Step(name, best_seconds(work), float(operations), float(moved))


def print_steps(steps: list[Step], peaks: dict[str, float]) -> None:
    output = Console(width=None if sys.stdout.isatty() else 120)
    for name, value in peaks.items():
        output.print(f"peak, {name}: {value / 1e9:.1f}")
    table = Table()
    for name in ("step", "ms", "GFLOP", "MB", "GFLOP/s", "GB/s", "bound ms", "bound / time"):
        table.add_column(name, justify="right")
    for step in steps:
        bound = step.bound(peaks["GFLOP/s, all threads"], peaks["GB/s, all threads"])
        table.add_row(
            step.name, f"{1e3 * step.seconds:.1f}", f"{step.operations / 1e9:.3f}", f"{step.bytes / 1e6:.1f}",
            f"{step.operations / step.seconds / 1e9:.2f}", f"{step.bytes / step.seconds / 1e9:.2f}",
            f"{1e3 * bound:.1f}", f"{bound / step.seconds:.1%}",
        )  # fmt: skip
    output.print(table)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("block")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    here = machine()
    peaks = {
        "GB/s, one thread": memory_bandwidth(1),
        "GB/s, all threads": memory_bandwidth(chosen.threads),
        "GFLOP/s, one thread": product_speed(1),
        "GFLOP/s, all threads": product_speed(chosen.threads),
    }
    prepared = prepare(network_from_npz(chosen.block))
    assembler, solution, _ = solved_block(prepared, starting_state(prepared)[0])
    steps = measured_steps(assembler, solution)
    print_steps(steps, peaks)
    if chosen.json:
        write_measurements(
            chosen.json, "roofline", here, [], peaks=peaks, steps=[asdict(step) for step in steps],
            images=len(prepared.network.images.ids), threads=chosen.threads,
        )  # fmt: skip


if __name__ == "__main__":
    main()
