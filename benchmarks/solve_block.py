"""Solve a block with the core in this process and print what it took, as JSON.

    python -m benchmarks.solve_block BLOCK.npz [--solves 3] [--estimates OUT.npz]

`solve`: from the prepared network and its starting state: layout, structure, ordering, all iterations.  The first
solution of the process is the warm-up (it imports numba and loads or compiles kernels) and is reported by itself.
`dispersion`: selected inverse and 6 x 6 blocks of all images, from the last factor.
"""

from __future__ import annotations

import argparse
import json
import time
from typing import Any

BEGIN = time.perf_counter()

import numpy as np  # noqa: E402

from benchmarks.bench_block import network_from_npz  # noqa: E402
from benchmarks.peer_rule import cost_difference  # noqa: E402
from splinebba_cli.core.approximation.starting_values import starting_state  # noqa: E402
from splinebba_cli.core.camera.rotation import angles_from_rotation  # noqa: E402
from splinebba_cli.core.estimation.datum import datum_layout  # noqa: E402
from splinebba_cli.core.estimation.gauss_markov import Solution, solve  # noqa: E402
from splinebba_cli.core.estimation.normal_equations import Assembler  # noqa: E402
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows  # noqa: E402
from splinebba_cli.core.observations.shape_conditions import control_rows  # noqa: E402
from splinebba_cli.core.quality.cofactors import Cofactors  # noqa: E402
from splinebba_cli.core.result import Iteration  # noqa: E402
from splinebba_cli.core.state import Prepared, State, prepare  # noqa: E402


class Stopwatch:
    """Wall and processor time since the last reading."""

    def __init__(self) -> None:
        self.read()

    def read(self) -> tuple[float, float]:
        """Seconds of wall and of processor time since the last call."""
        now = time.perf_counter(), time.process_time()
        taken = (now[0] - self._last[0], now[1] - self._last[1]) if hasattr(self, "_last") else (0.0, 0.0)
        self._last = now
        return taken


def assembler_of(prepared: Prepared, state: State) -> Assembler:
    """The normal equations of a block: control splines held, no gauge conditions beyond the default ones."""
    layout = datum_layout(prepared, state)
    rows = [
        control_rows(prepared, layout.coefficient_mask),
        gauge_rows(prepared, layout.coefficient_mask, None),
    ]
    return Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))


def solved_block(prepared: Prepared, state: State) -> tuple[Assembler, Solution, list[float]]:
    """Assembler, solution and seconds of every iteration."""
    assembler = assembler_of(prepared, state)
    watch, seconds = Stopwatch(), []

    def observe(_: Iteration) -> None:
        seconds.append(watch.read()[0])

    solution = solve(assembler, state, max_iterations=30, stage="joint", damping=0.0, observer=observe)
    assert solution.converged, solution.termination
    return assembler, solution, seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("block")
    parser.add_argument("--solves", type=int, default=3, help="solutions after the warm-up")
    parser.add_argument("--estimates", help="write orientations and their dispersion to this archive")
    chosen = parser.parse_args()
    figures: dict[str, Any] = {"import_s": time.perf_counter() - BEGIN}
    watch = Stopwatch()
    network = network_from_npz(chosen.block)
    figures["load_s"] = watch.read()[0]
    prepared = prepare(network)
    figures["prepare_s"] = watch.read()[0]
    state, _ = starting_state(prepared)
    figures["start_s"] = watch.read()[0]
    assembler, solution, iterations = solved_block(prepared, state)
    figures["warm_up_s"] = watch.read()[0]
    figures |= {
        "solve_s": [],
        "solve_cpu_s": [],
        "iteration_s": [],
        "dispersion_s": [],
        "dispersion_cpu_s": [],
    }
    for _ in range(chosen.solves):
        watch.read()
        assembler, solution, iterations = solved_block(prepared, state)
        taken = watch.read()
        figures["solve_s"].append(taken[0])
        figures["solve_cpu_s"].append(taken[1])
        figures["iteration_s"].append(float(np.median(iterations)))
        blocks = Cofactors(assembler, solution).images
        taken = watch.read()
        figures["dispersion_s"].append(taken[0])
        figures["dispersion_cpu_s"].append(taken[1])
    with np.load(chosen.block) as archive:
        own_segments = cost_difference(prepared, solution.state, archive["seg"].astype(np.int64))
    sigma = np.sqrt(np.diagonal(blocks, axis1=1, axis2=2))
    middle = len(sigma) // 2
    figures |= {
        "images": len(sigma),
        "points": len(network.curve_observations),
        "iterations": len(solution.iterations),
        "cost": solution.linearization.cost / 2.0,
        "cost_peer_rule": (solution.linearization.cost + own_segments) / 2.0,
        "sigma_x": float(sigma[middle, 3]),
        "sigma_z": float(sigma[middle, 5]),
    }
    if chosen.estimates:
        angles = angles_from_rotation(solution.state.rotation)
        eop = np.column_stack([angles, solution.state.position])
        np.savez(chosen.estimates, eop=eop, sigma=sigma)
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
