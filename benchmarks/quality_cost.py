"""What redundancy numbers, w, tau and minimal detectable biases cost against one iteration of the adjustment.

    python -m benchmarks.quality_cost OUT.npz [--repeats 5]

The block of the benchmark generator is brought to its solution; then, in turn and in the same run,

    iteration    equations and normal equations, factor, solution, refined foot points at the new state
    quality      selected inverse, redundancy numbers of all observations, w, tau, MDB, external reliability

Prints medians of the times and the ratio; then everything that follows from a solution (`evaluate`), part by part, the
least times of the repeats, and the memory that it takes.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np

from benchmarks.bench_block import network_from_npz
from benchmarks.quality_parts import Times, memory_gib, times_of_parts
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.datum import datum_layout
from splinebba_cli.core.estimation.gauss_markov import TRIAL_STEPS, Solution, apply_step, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.locations import held_locations, refine_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.evaluation import Adjusted
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.redundancy import redundancy_numbers
from splinebba_cli.core.quality.reliability import delta0_of
from splinebba_cli.core.quality.residual_tables import curve_table, point_table
from splinebba_cli.core.state import prepare


def iteration(assembler: Assembler, solution: Solution) -> None:
    """One undamped iteration from the solution."""
    prepared, state = assembler.prepared, solution.state
    at = assembler.linearize(state, held_locations(prepared, state.location))
    values, side, _ = assembler.eliminate(at, 0.0)
    factor = assembler.symbolic(state).factorize(values)
    reduced = factor.solve(side) * assembler.mask
    moved = apply_step(assembler, state, reduced, np.zeros_like(state.xyz))
    refine_locations(prepared, moved, TRIAL_STEPS)


def quality(solved: ConditionedSolution) -> float:
    """All figures of all image points; returns the sum of redundancy numbers."""
    prepared = solved.assembler.prepared
    cofactors = Cofactors(solved.assembler, solved.solution)
    numbers = redundancy_numbers(cofactors, linked_cofactors(cofactors))
    count = len(prepared.network.curve_observations)
    conditions = np.zeros(len(solved.assembler.coefficient_rows), dtype=bool)
    delta0 = delta0_of(prepared.network.settings.testing, numbers.tested(conditions))
    table = curve_table(prepared, solved, numbers, np.zeros(count), delta0)
    point_table(prepared, solved, numbers, delta0)
    sigma0 = np.sqrt(solved.solution.linearization.cost / numbers.total)
    _ = table.standardized / sigma0
    return numbers.total


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("block")
    parser.add_argument("--repeats", type=int, default=5)
    chosen = parser.parse_args()
    prepared = prepare(network_from_npz(chosen.block))
    state, _ = starting_state(prepared)
    layout = datum_layout(prepared, state)
    rows = [
        control_rows(prepared, layout.coefficient_mask),
        gauge_rows(prepared, layout.coefficient_mask, None),
    ]
    assembler = Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))
    solution = solve(assembler, state, max_iterations=30, stage="joint", damping=1e-3)
    assert solution.converged, solution.termination
    solved = ConditionedSolution(assembler, solution, np.arange(0))
    iteration(assembler, solution)
    quality(solved)
    times: dict[str, list[float]] = {"iteration": [], "quality": []}
    for _ in range(chosen.repeats):
        for name, run in (
            ("iteration", lambda: iteration(assembler, solution)),
            ("quality", lambda: quality(solved)),
        ):
            begin = time.perf_counter()
            run()
            times[name].append(time.perf_counter() - begin)
    adjusted = Adjusted(prepared, solved, (), ())
    memory = memory_gib(adjusted)
    parts = [times_of_parts(adjusted) for _ in range(chosen.repeats)]
    middle = {name: statistics.median(taken) for name, taken in times.items()}
    ratios = [q / i for q, i in zip(times["quality"], times["iteration"], strict=True)]
    print(
        f"images {len(prepared.network.images.ids)}, curve points {len(prepared.network.curve_observations)}"
    )
    print(f"iteration {middle['iteration']:.2f} s, quality {middle['quality']:.2f} s")
    print(
        f"ratio {min(ratios):.2f} / {statistics.median(ratios):.2f} / {max(ratios):.2f} (least, median, most)"
    )
    _print_parts(parts)
    if memory is not None:
        print(f"resident memory {memory[0]:.2f} GiB before, {memory[1]:.2f} GiB at most")


def _print_parts(parts: list[Times]) -> None:
    print("\nevaluate, part by part (some lie inside others)      wall s   processor s")
    for label in parts[0]:
        wall, cpu = (min(times[label][k] for times in parts) for k in range(2))
        print(f"{label:48s} {wall:10.3f} {cpu:13.3f}")


if __name__ == "__main__":
    main()
