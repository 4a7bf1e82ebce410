"""Tie curves from chains: labels and shapes of Strasbourg and of the vase taken away and found again.

``python -m benchmarks.tie_curves`` prints, for both data sets, how many links of the fragments are right, what they
cover, how far they are from the labelled solution, and what wrong chains do.  ``--size COLUMNS ROWS CHAINS`` builds a
block of images with so many chains each instead.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from benchmarks.chain_block import chain_block
from benchmarks.fragment_figures import FragmentFigures, agreement, figures
from benchmarks.spline_figures import (
    adjusted_splines,
    distance_to,
    false_curves,
    spline_figures,
    splines_of,
)
from benchmarks.wrong_chains import with_wrong_chains
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.matching.fragments.build import build_fragments
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.network import IntArray, KnotPolicy, Network
from splinebba_cli.core.result import AdjustmentResult
from tests.reference_data import strasbourg_curves_network, vase_network, vase_scan
from tests.unlabelled import without_labels

SHARES = (0.0, 0.3, 0.5)
SEEDS = (1, 2, 3)
WELL_DETERMINED_M = 0.0003


def data_sets() -> dict[str, tuple[Network, float]]:
    """Labelled networks, and the distance of their knots."""
    return {"Strasbourg": (strasbourg_curves_network(), 3.0), "vase": (vase_network(), 0.006)}


def labelled_solution(network: Network, spacing_m: float) -> AdjustmentResult:
    """The adjustment with labels."""
    knots = KnotPolicy(spacing_m=spacing_m, drop=True)
    return adjust(replace(network, settings=replace(network.settings, knots=knots)))


def built(network: Network) -> tuple[list[Fragment], float]:
    """Fragments of a network with its given orientations, and seconds."""
    start = perf_counter()
    found = build_fragments(network, network.images.rotation, network.images.position)
    return found, perf_counter() - start


def print_data_set(name: str, network: Network, spacing_m: float) -> None:
    """All figures of one data set."""
    labelled = labelled_solution(network, spacing_m)
    curves = [curve.sample_xyz - network.origin for curve in labelled.curves]
    bare, truth = without_labels(replace(network, curves=()))
    print(f"{name}: {len(truth)} points, {len(bare.unlabelled.chain_ids)} chains, {len(curves)} curves")
    for share in SHARES:
        for seed in SEEDS if share else SEEDS[:1]:
            mixed, wrong = with_wrong_chains(bare, share, seed)
            labels = np.concatenate([truth, np.full(len(wrong), -1)])
            found, seconds = built(mixed)
            print(
                f"  {share:4.0%} wrong chains: {_line(figures(mixed, found, labels, curves))}, {seconds:.1f} s"
            )
            if not share:
                three, two_sigma, ellipse = agreement(found, labels, curves)
                print(
                    f"    places: {three:.1%} in three images; of these {two_sigma:.1%} within 2 sigma across,"
                    f" {ellipse:.1%} within the 95 % ellipse of the labelled curves"
                )
                print_splines(mixed, found, labels, labelled, spacing_m)
            elif seed == SEEDS[0]:
                new = splines_of(mixed, found)
                print(f"    splines: {len(new.curves)}, {false_curves(new, labels)} of them false")


def print_splines(
    network: Network, fragments: list[Fragment], truth: IntArray, labelled: AdjustmentResult, spacing_m: float
) -> None:
    """Figures of the tie splines, adjusted with the same knot distance as the labelled ones."""
    start = perf_counter()
    new = splines_of(network, fragments)
    seconds = perf_counter() - start
    result = adjusted_splines(network, new, spacing_m)
    of = spline_figures(new, result, labelled, truth, spacing_m)
    print(
        f"    splines: {of.curves} in {seconds:.0f} s; {of.linked:.1%} of the points linked, {of.right:.2%} right;"
        f" adjusted: {of.rms_px:.3f} px across; {of.rebuilt:.1%} of the labelled curves rebuilt, of these"
        f" {of.two_sigma:.1%} within 2 sigma (median {of.median_sigma:.2f} sigma)"
    )
    if spacing_m < 0.1:  # the vase
        print(
            f"    distance to the scan: {1000.0 * distance_to(vase_scan(), result, WELL_DETERMINED_M):.2f} mm,"
            f" labelled {1000.0 * distance_to(vase_scan(), labelled, WELL_DETERMINED_M):.2f} mm"
        )


def _line(found: FragmentFigures) -> str:
    return (
        f"{found.fragments} fragments ({found.false_fragments} false) of {found.curves} curves,"
        f" {found.links} links, {found.right_share:.2%} right, {found.covered:.1%} of the points covered"
    )


def print_size(columns: int, rows: int, chains: int) -> None:
    """Figures of a block."""
    block = chain_block(columns, rows, chains)
    points = block.network.unlabelled
    print(f"{columns * rows} images, {len(points.chain_ids)} chains, {len(points)} points")
    cpu = process_time()
    found, seconds = built(block.network)
    cpu = process_time() - cpu
    covered = np.zeros(len(points), dtype=bool)
    links = wrong = 0
    for fragment in found:
        label = block.curve[fragment.link_row]
        links, wrong = links + len(label), wrong + int((label != np.bincount(label).argmax()).sum())
        covered[fragment.link_row] = True
    key = block.curve * block.curves.shape[1] + np.rint(block.place).astype(np.int64)
    images = np.zeros(int(key.max()) + 1, dtype=np.int64)
    for k in range(columns * rows):
        images[np.unique(key[points.image == k])] += 1
    three = images[key] >= 3
    print(
        f"{seconds:.0f} s ({cpu:.0f} s of processor time), {len(found)} fragments, {1 - wrong / links:.2%} of the links"
        f" right, {covered[three].mean():.1%} of the points in three images covered"
    )


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", choices=["Strasbourg", "vase"])
    parser.add_argument("--size", nargs=3, type=int, metavar=("COLUMNS", "ROWS", "CHAINS"))
    options = parser.parse_args()
    if options.size:
        print_size(*options.size)
        return
    beside = Path(__file__).resolve().parents[2] / "shared" / "reference"
    if not Path(os.environ.get("SPLINEBBA_REFERENCE_DATA", beside)).is_dir():
        print("the reference data are not there (set SPLINEBBA_REFERENCE_DATA)")
        return
    for name, (network, spacing) in data_sets().items():
        if options.only in (None, name):
            print_data_set(name, network, spacing)


if __name__ == "__main__":
    main()
