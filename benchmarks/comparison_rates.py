"""What `compare` says about results that do not differ: six images, the same truth, new noise a run.

    python -m benchmarks.comparison_rates [RUNS] [--splines]

independent  two runs with other noise
nested       all image points, and seven of ten of them
free         two runs with other noise, no control, minimal constraints at other wrong starts: images after a similarity
model        the same image points; one model holds the (true) orientation of an image, the other estimates it

`mean` is the mean of d'C^-1 d over its degrees of freedom (1 where C is right), `rate` the share of runs with a
significant difference at 5 % (Sidak over all images, or all points, or all splines: at most 5 %).
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy import stats

from splinebba_cli.core.adjustment import adjust, points_only
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import Network, PointObservations
from splinebba_cli.output.comparison import Comparison, compare
from splinebba_cli.output.result_folder import reserve_result_folder, write_result_folder
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import Truth

CASES = ("independent", "nested", "model", "free")


@dataclass
class Loaded:
    """Stands in for a loaded project."""

    path: Path = Path("project.yaml")
    name: str = "block"
    source_hashes: dict[str, str] = field(default_factory=dict)


def pair(case: str, run: int, *, splines: bool = False) -> tuple[Network, Network]:
    """Two networks of a case; A is the more precise one where one is."""
    network, truth = block(2 * run + 1, splines=splines)
    if case == "independent":
        return network, block(2 * run + 2, splines=splines)[0]
    if case == "free":
        return without_control(network), without_control(block(2 * run + 2, splines=splines)[0])
    if case == "nested":
        return network, with_part(network, run)
    return with_held_image(network, truth), network


def block(seed: int, *, splines: bool) -> tuple[Network, Truth]:
    """The mixed six-image block, or its points alone."""
    network, truth = simulate_block("six-image-mixed", seed)
    return (network if splines else points_only(network)), truth


def with_part(network: Network, seed: int) -> Network:
    """The network with seven of ten image points of every point, two at least, and of every spline."""
    rng = np.random.default_rng(seed)
    seen, curves = network.point_observations, network.curve_observations
    order = rng.permutation(len(seen))
    rank = np.zeros(len(seen), dtype=int)
    counts: dict[int, int] = {}
    for row in order:
        rank[row] = counts.get(int(seen.point[row]), 0)
        counts[int(seen.point[row])] = rank[row] + 1
    kept = (rank < 2) | (rng.random(len(seen)) < 0.7)
    some = rng.random(len(curves)) < 0.7
    part = PointObservations(seen.image[kept], seen.point[kept], seen.photo_xy[kept], seen.sigma[kept])
    fewer = replace(
        curves,
        image=curves.image[some],
        curve=curves.curve[some],
        photo_xy=curves.photo_xy[some],
        sigma=curves.sigma[some],
        location=curves.location[some],
        segment=curves.segment[some],
        group=None if curves.group is None else curves.group[some],
    )
    return replace(network, point_observations=part, curve_observations=fewer)


def without_control(network: Network) -> Network:
    """The network with tie points alone and minimal constraints."""
    points, count = network.points, len(network.points.ids)
    free = replace(
        points,
        role=("tie",) * count,
        sigma=np.full((count, 3), np.inf),
        xyz=np.full((count, 3), np.nan),
        check_sigma=np.full((count, 3), np.nan),
    )
    return replace(network, points=free, settings=replace(network.settings, datum="minimal"))


def with_held_image(network: Network, truth: Truth) -> Network:
    """The network with the orientation of its first image held at the truth."""
    images = network.images
    rotation, position = images.rotation.copy(), images.position.copy()
    rotation[0] = rotation_object_from_photo(truth.eop[0, :3], images.sequence[0])
    position[0] = truth.eop[0, 3:]
    prior, sigma = images.prior.copy(), images.prior_sigma.copy()
    prior[0], sigma[0] = truth.eop[0], 0.0
    return replace(
        network, images=replace(images, rotation=rotation, position=position, prior=prior, prior_sigma=sigma)
    )


def comparisons(case: str, runs: int, *, splines: bool = False) -> Iterator[Comparison]:
    """Comparisons of so many runs."""
    with tempfile.TemporaryDirectory() as name:
        for run in range(runs):
            folders = [Path(name) / f"{run}-{side}" for side in "ab"]
            for folder, network in zip(folders, pair(case, run, splines=splines), strict=True):
                full = case == "free"
                with reserve_result_folder(folder) as place:
                    write_result_folder(
                        place,
                        adjust(network, full_dispersion=full),
                        loaded=Loaded(),
                        adjusted_files={},
                        dispersion="full" if full else "blocks",
                    )
            found = compare(*folders)
            _ = found.a.measured, found.b.measured
            yield found


def figures(case: str, runs: int, *, splines: bool = False) -> dict[str, tuple[float, float]]:
    """Mean of d'C^-1 d over its degrees of freedom and rate of significance, by kind."""
    rows: dict[str, list[tuple[float, float, bool]]] = {}
    for found in comparisons(case, runs, splines=splines):
        for kind, each in (("images", found.images), ("points", found.points)):
            size = float(np.nansum(each.statistic)), float(each.dimensions.sum())
            rows.setdefault(kind, []).append((*size, bool(each.significant.any())))
        for name, test in (("model test", found.model_test), ("variance test", found.variance_test)):
            if test is not None:
                rows.setdefault(name, []).append((test.statistic, 1.0, test.significant))
        if found.splines:
            largest = [spline.normalized for spline in found.splines]
            worst = any(spline.significant for spline in found.splines)
            rows.setdefault("splines (largest)", []).append((float(np.mean(largest)), 1.0, worst))
    out = {}
    for kind, values in rows.items():
        table = np.array(values, dtype=float)
        out[kind] = float(table[:, 0].sum() / max(table[:, 1].sum(), 1.0)), float(table[:, 2].mean())
    return out


def main() -> None:
    numbers = [int(text) for text in sys.argv[1:] if text.isdigit()]
    runs = numbers[0] if numbers else 300
    lower, upper = stats.binom.ppf([0.005, 0.995], runs, 0.05) / runs
    print(f"{runs} runs: 5 % within {lower:.3f} … {upper:.3f}")
    for case in CASES:
        for kind, (mean, rate) in figures(case, runs, splines="--splines" in sys.argv).items():
            print(f"  {case:12s} {kind:18s} mean {mean:.3f}   rate {rate:.3f}")


if __name__ == "__main__":
    main()
