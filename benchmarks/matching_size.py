"""Seconds and memory of matching by size: a million points against ten thousand curves in a hundred images.

    python -m benchmarks.matching_size [--images 100] [--curves 10000] [--points 1000000] [--gate 5] [--whole]

Synthetic block with the truth (matching_block.py): 30 % of the points belong to no curve, orientations are slightly
off.  Prints wall and processor seconds of

    prepare       curve tables, corrected image points
    candidates    all places of all curves within the gate of every point, the least of the repeats
    match         the whole matching, with --whole: labels and orientations, whose sigma are given

then how many points have the right curve as nearest candidate (as their label), and how many candidates a point has.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from benchmarks.machine import machine
from benchmarks.matching_block import PIXEL_MM, SHIFT_M, TURN_RAD, MatchingBlock, matching_block
from splinebba_cli.core.matching.candidates.search import Candidates, find_candidates
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import IntArray, Network
from splinebba_cli.core.state import State, initial_coefficients, prepare

Done = TypeVar("Done")


@dataclass(frozen=True)
class Seconds:
    """Of one piece of work."""

    wall: float
    processor: float


def timed(work: Callable[[], Done]) -> tuple[Done, Seconds]:
    begin = time.perf_counter(), time.process_time()
    done = work()
    return done, Seconds(time.perf_counter() - begin[0], time.process_time() - begin[1])


def scene_of(network: Network) -> Scene:
    """Given curves before given orientations."""
    prepared, images = prepare(network), network.images
    state = State(
        images.rotation, images.position, initial_coefficients(prepared), np.zeros((0, 3)), np.zeros(0)
    )
    return Scene.of(network, state, prepared)


def labels(count: int, found: Candidates) -> IntArray:
    """The curve of the nearest candidate of every point, -1: none."""
    out = np.full(count, -1)
    point, first = np.unique(found.point, return_index=True)
    out[point] = found.curve[first]
    return out


def shares(block: MatchingBlock, label: IntArray) -> dict[str, float]:
    """Of points on curves: right, without a curve; of random points: with a curve."""
    on_curve = block.curve >= 0
    return {
        "right": float(np.mean(label[on_curve] == block.curve[on_curve])),
        "unmatched": float(np.mean(label[on_curve] < 0)),
        "random_matched": float(np.mean(label[~on_curve] >= 0)),
    }


def measure(block: MatchingBlock, gate_px: float, repeats: int, whole: bool) -> dict[str, Any]:
    """All figures."""
    network, count = block.network, len(block.curve)
    radius = np.full(count, gate_px * PIXEL_MM)
    scene, preparation = timed(lambda: scene_of(network))
    runs = [timed(lambda: find_candidates(scene, radius)) for _ in range(repeats)]
    found = runs[0][0]
    figures: dict[str, Any] = {
        "prepare": preparation.__dict__,
        "candidates": {
            "wall": min(taken.wall for _, taken in runs),
            "processor": min(taken.processor for _, taken in runs),
        },
        "count": len(found),
        "most_of_a_point": int(np.bincount(found.point).max(initial=0)),
        "nearest": shares(block, labels(count, found)),
    }
    if whole:
        settings = MatchSettings(position_sigma_m=SHIFT_M, angle_sigma_rad=TURN_RAD)
        result, taken = timed(lambda: match(network, settings))
        figures |= {
            "match": taken.__dict__,
            "rounds": len(result.history),
            "matched": shares(block, result.matches.curve),
        }
    figures["peak_gib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--images", type=int, default=100)
    parser.add_argument("--curves", type=int, default=10_000)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--gate", type=float, default=5.0, help="pixels")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--whole", action="store_true", help="the whole matching, too")
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    on = machine()
    block = matching_block(chosen.images, chosen.curves, chosen.points)
    figures = measure(block, chosen.gate, chosen.repeats, chosen.whole)
    print(f"{len(block.network.images.ids)} images, {chosen.curves} curves, {chosen.points} points")
    for name in ("prepare", "candidates", "match"):
        if name in figures:
            print(f"{name:12s} {figures[name]['wall']:8.2f} s, processor {figures[name]['processor']:8.2f} s")
    if chosen.whole:
        print(f"rounds of matching and adjustment: {figures['rounds']}")
    print(f"{figures['count']} candidates, at most {figures['most_of_a_point']} of a point")
    for name in ("nearest", "matched"):
        if name in figures:
            own = figures[name]
            print(
                f"{name:12s} right {own['right']:.4f}, without a curve {own['unmatched']:.4f}, "
                f"random points with a curve {own['random_matched']:.4f}"
            )
    print(f"memory at most {figures['peak_gib']:.2f} GiB; load at the start {on['load_average'][0]:.1f}")
    if chosen.json:
        chosen.json.write_text(json.dumps({"machine": on, **figures}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
