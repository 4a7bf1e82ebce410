"""Growth of the sparse factorisation with the size of the block, and its rate against that of dense products.

    python -m benchmarks.factorisation [--images 100 1000 10000 50000] [--repeats 3] [--clock wall]
                                       [--fronts-only]

Patterns of aerial blocks (60 % forward overlap, three curves of 15 unknowns per image, each seen by two to six
neighbouring images) with diagonally dominant values; each size in a process of its own.  Prints the least of the
repeated times (s; with --clock cpu of the processor, all threads together, for machines that others use as well):

    analyse    ordering and pattern of the factor, once for an adjustment
    places     where the values go, once
    factor     one factorisation, and its GFLOP/s
    solve      one right-hand side
    EOPs       selected inverse of the images and their 6 x 6 blocks
    curves     the rest of the selected inverse

the exponents of their growth from the second size to the last one, predicted and measured memory, and the rate of
single fronts (potrf, trsm, syrk; n pivots and n rows) against dgemm of 1000 x 1000.  SPLINEBBA_SPEED and
SPLINEBBA_THREADS choose the way of computing.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import blas, lapack

from splinebba_cli.core import speed
from splinebba_cli.core.estimation.blas_threads import one_thread
from splinebba_cli.core.estimation.block_cholesky import analyse
from splinebba_cli.core.estimation.block_matrix import BlockStructure, FloatArray
from splinebba_cli.core.estimation.compiled_fronts import factor_kernels
from splinebba_cli.core.estimation.factor_memory import NUMBER, factor_memory
from splinebba_cli.core.estimation.fronts import front_operations

TIMES = ("analyse", "places", "factor", "solve", "EOPs", "curves")
CURVES_PER_IMAGE = 3
CLOCKS = {"wall": time.perf_counter, "cpu": time.process_time}
CLOCK = "FACTORISATION_CLOCK"
FRONTS = (20, 50, 100, 300, 1000)


def block_pattern(n_images: int) -> tuple[BlockStructure, FloatArray]:
    """Pattern and positions of a block of about so many images, strips twice as far apart as images."""
    rng = np.random.default_rng(20080101)
    n_strips = max(2, round(np.sqrt(n_images / 2.0)))
    length = max(4, round(n_images / n_strips))
    n = n_strips * length
    strip, along = np.divmod(np.arange(n), length)
    n_curves = CURVES_PER_IMAGE * n
    first, of_strip = rng.integers(0, length - 2, n_curves), rng.integers(0, n_strips - 1, n_curves)
    in_strip, strips = rng.integers(2, 4, n_curves), rng.integers(1, 3, n_curves)
    pairs = [
        np.stack([(of_strip + s) * length + first + a, n + np.arange(n_curves)])[
            :, (a < in_strip) & (s < strips)
        ]
        for s in range(2)
        for a in range(3)
    ]
    images = np.stack([along, 2.0 * strip, np.full(n, 4.0)], axis=1)
    curves = np.stack(
        [first + 0.5 * (in_strip - 1), 2.0 * of_strip + (strips - 1), np.zeros(n_curves)], axis=1
    )
    sizes = np.concatenate([np.full(n, 6), np.full(n_curves, 15)])
    return BlockStructure.from_pairs(sizes, *np.concatenate(pairs, axis=1)), np.concatenate([images, curves])


def dominant_values(structure: BlockStructure) -> FloatArray:
    """Random values, the diagonal above the sum of the others of its row."""
    rng = np.random.default_rng(1)
    values = rng.uniform(-1.0, 1.0, structure.n_entries)
    others = np.bincount(structure.rows, structure.sizes[structure.cols], structure.n_nodes)
    others += np.bincount(structure.cols, structure.sizes[structure.rows], structure.n_nodes)
    diagonal = np.flatnonzero(structure.rows == structure.cols)
    for size in np.unique(structure.sizes):
        nodes = np.flatnonzero(structure.sizes == size)
        place = structure.offsets[diagonal[nodes]][:, None] + np.arange(size * size)
        block = values[place].reshape(-1, size, size)
        block = 0.5 * (block + block.transpose(0, 2, 1)) + others[nodes][:, None, None] * np.eye(size)
        values[place] = block.reshape(-1, size * size)
    return values


def least_time(work: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    times, result = [], None
    for _ in range(repeats):
        result = None  # a second factor beside the first would spoil the peak of the memory
        start = CLOCKS[os.environ.get(CLOCK, "wall")]()
        result = work()
        times.append(CLOCKS[os.environ.get(CLOCK, "wall")]() - start)
    return min(times), result


def held_memory(name: str) -> int:
    """Bytes that this process holds (VmRSS), or has held at most since `forget_peak` (VmHWM)."""
    line = next(x for x in Path("/proc/self/status").read_text().splitlines() if x.startswith(name))
    return 1024 * int(line.split()[1])


def forget_peak() -> None:
    """The peak starts anew at what is held now (proc(5), clear_refs)."""
    Path("/proc/self/clear_refs").write_text("5")


def measure(n_images: int, repeats: int) -> dict[str, float]:
    """Times and memory of one size, in this process."""
    structure, positions = block_pattern(n_images)
    values = dominant_values(structure)
    if factor_kernels(structure.n_unknowns) is not None:
        os.environ[speed.VARIABLE] = "always"
    small, place = block_pattern(40)
    warm = analyse(small, place).factorize(dominant_values(small))  # loads what is loaded once
    warm.solve(np.ones(small.n_unknowns))
    warm.selected_inverse().panel.sum()
    forget_peak()
    before = held_memory("VmRSS")
    out: dict[str, float] = {}
    out["analyse"], symbolic = least_time(lambda: analyse(structure, positions), repeats)
    predicted = factor_memory(symbolic)
    out["places"], factor = least_time(lambda: symbolic.factorize(values), 1)
    del factor
    out["factor"], factor = least_time(lambda: symbolic.factorize(values), repeats)
    out["places"] -= out["factor"]
    out["solve"], _ = least_time(lambda: factor.solve(np.ones(structure.n_unknowns)), repeats)
    images = np.flatnonzero(structure.sizes == 6)
    out["EOPs"], selected = least_time(lambda: _inverse_of(factor, images), repeats)
    out["curves"], _ = least_time(lambda: selected.panel, 1)
    out |= {
        "images": len(images), "unknowns": structure.n_unknowns, "fronts": len(symbolic.fronts),
        "GFLOP": symbolic.flops / 1e9, "entries": symbolic.factor_entries,
        "predicted": predicted.peak - predicted.assembly + NUMBER * structure.n_entries,
        "measured": held_memory("VmHWM") - before + NUMBER * structure.n_entries,
    }  # fmt: skip
    return out


def _inverse_of(factor: Any, images: Any) -> Any:
    selected = factor.selected_inverse()
    selected.blocks(images, images)
    return selected


def print_growth(rows: list[dict[str, float]]) -> None:
    print(f"{'images':>7} {'unknowns':>9} {'fronts':>7} {'GFLOP':>8}", *(f"{t:>9}" for t in TIMES), end="")
    print(f" {'GFLOP/s':>8} {'predicted MB':>13} {'measured MB':>12}")
    for row in rows:
        print(
            f"{row['images']:7.0f} {row['unknowns']:9.0f} {row['fronts']:7.0f} {row['GFLOP']:8.3f}", end=" "
        )
        print(*(f"{row[t]:9.4f}" for t in TIMES), f"{row['GFLOP'] / row['factor']:8.1f}", end=" ")
        print(f"{row['predicted'] / 1e6:13.1f} {row['measured'] / 1e6:12.1f}")
    if len(rows) > 2:
        first, last = rows[1], rows[-1]
        spread = np.log(last["images"] / first["images"])
        exponents = [np.log(last[t] / first[t]) / spread for t in (*TIMES, "measured")]
        print(f"exponents from {first['images']:.0f} to {last['images']:.0f} images:", end=" ")
        print(*(f"{t} {e:.2f}" for t, e in zip((*TIMES, "memory"), exponents, strict=True)))


def print_fronts() -> None:
    """Rates of single fronts in one thread."""
    with one_thread():
        square = np.asfortranarray(np.random.default_rng(1).normal(size=(1000, 1000)))
        peak = 2e-9 * 1000**3 / least_time(lambda: blas.dgemm(1.0, square, square), 5)[0]
        print(f"dgemm 1000 x 1000: {peak:.1f} GFLOP/s in one thread; fronts of n pivots and n rows:")
        for n in FRONTS:
            top = np.asfortranarray(np.eye(n) * 2.0 * n + 0.1)
            below = np.asfortranarray(np.ones((n, n)))
            count = max(1, int(2e8 / front_operations(float(n), float(n))))
            seconds, _ = least_time(lambda: [_front(top, below) for _ in range(count)], 5)  # noqa: B023
            rate = 1e-9 * count * front_operations(float(n), float(n)) / seconds
            print(f"  n = {n:5d}: {rate:6.1f} GFLOP/s, {100 * rate / peak:5.1f} % of dgemm")


def _front(top: FloatArray, below: FloatArray) -> FloatArray:
    lower, _ = lapack.dpotrf(top, lower=1, clean=0)
    divided = blas.dtrsm(1.0, lower, below, side=1, lower=1, trans_a=1)
    return np.asarray(blas.dsyrk(-1.0, divided, lower=1))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--images", type=int, nargs="+", default=[100, 1000, 10_000, 50_000])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--fronts-only", action="store_true")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--clock", choices=list(CLOCKS), default=os.environ.get(CLOCK, "wall"))
    options = parser.parse_args()
    os.environ[CLOCK] = options.clock
    if options.one:
        print(json.dumps(measure(options.one, options.repeats)))
        return
    print_fronts()
    if options.fronts_only:
        return
    rows = []
    for n_images in options.images:
        command = [sys.executable, "-m", "benchmarks.factorisation", "--one", str(n_images)]
        command += ["--repeats", str(options.repeats)]
        run = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True)
        rows.append(json.loads(run.stdout))
    print_growth(rows)


if __name__ == "__main__":
    main()
