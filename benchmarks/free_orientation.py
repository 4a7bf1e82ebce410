"""Orientation of images of which nothing is known.

``python -m benchmarks.free_orientation synthetic|six-image|strasbourg``.  *oriented*: one was given; *right*: it is
within 0.5 degrees and 5 % of the distance of the truth.  Curves are control with their true shape, chains carry noise
and no labels, wrong ones run along no curve.  Times are of the process (seconds of one core), an image.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.free_orientation_scenes import (
    FreeScene,
    free_scene,
    orientation_errors,
    synthetic_curves,
    wrong_chains,
)
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.matching.free_orientation.orient_freely import orient_freely
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import FloatArray, Network, select_rows
from splinebba_cli.simulation.six_image_block import simulate_block

RIGHT_DEG, RIGHT_SHARE = 0.5, 0.05


@dataclass(frozen=True)
class Outcome:
    """Of one image."""

    image: int
    code: str  # of the problem, "" where it is oriented
    angle_deg: float
    position_share: float  # error over the distance of the object
    seconds: float

    @property
    def right(self) -> bool:
        """Whether it is oriented as it was taken."""
        return not self.code and self.angle_deg < RIGHT_DEG and self.position_share < RIGHT_SHARE


def outcomes(
    scene: FreeScene, distance: float, seed: int, images: list[int] | None = None
) -> Iterator[Outcome]:
    """Every image of a scene by itself."""
    for image in images if images is not None else range(len(scene.rotation)):
        begin = time.process_time()
        found = orient_freely(only_image(scene.network, image), MatchSettings(seed=seed))
        seconds = time.process_time() - begin
        best = found.from_chains.get(0)
        if best is None:
            yield Outcome(image, found.problems[0].code, np.nan, np.nan, seconds)
            continue
        angle, away = orientation_errors(scene, image, best.rotation, best.position)
        yield Outcome(image, "", angle, away / distance, seconds)


def only_image(network: Network, image: int) -> Network:
    """The network with one of its images."""
    images = network.images
    one = replace(
        images,
        ids=images.ids[image : image + 1],
        camera=images.camera[[image]],
        rotation=images.rotation[[image]],
        position=images.position[[image]],
        sequence=images.sequence[image : image + 1],
        prior=images.prior[[image]],
        prior_sigma=images.prior_sigma[[image]],
    )
    points = select_rows(network.unlabelled, np.flatnonzero(network.unlabelled.image == image))
    return replace(network, images=one, unlabelled=replace(points, image=np.zeros_like(points.image)))


def six_images(seed: int, wrong_share: float = 0.0) -> FreeScene:
    """Lee's six images: two control splines; ties, the partial spline and wrong chains are chains of no known curve."""
    network, truth = simulate_block("six-image", seed)
    observed = network.curve_observations
    rotation = rotation_object_from_photo(truth.eop[:, :3])
    rng = np.random.default_rng(seed)
    chains: list[tuple[int, int, FloatArray]] = []
    for image in range(len(truth.eop)):
        of_image = []
        for curve in range(len(network.curves)):
            rows = np.flatnonzero((observed.image == image) & (observed.curve == curve))
            if len(rows) > 2:
                of_image.append((image, curve if network.curves[curve].role == "control" else -1,
                                 observed.photo_xy[rows[np.argsort(truth.locations[rows])]]))  # fmt: skip
        wrong = wrong_chains(rng, [xy for *_, xy in of_image], wrong_share)
        chains += of_image + [(image, -1, xy) for xy in wrong]
    control = tuple(curve for curve in network.curves if curve.role == "control")
    return free_scene(
        rng, network.cameras[0], control, rotation, truth.eop[:, 3:], chains, 0.005, noise=False
    )


def strasbourg(seed: int, wrong_share: float = 0.0, cut: bool = False) -> FreeScene:
    """30 curves in five aerial images as control; chains end where they were traced (reference/README.md)."""
    from tests.reference_data import strasbourg_curves_network

    network = strasbourg_curves_network(approximate=True, points=False)
    observed = network.curve_observations
    rng = np.random.default_rng(seed)
    chains: list[tuple[int, int, FloatArray]] = []
    for image in range(5):
        rows_of = [np.flatnonzero((observed.image == image) & (observed.curve == k)) for k in range(30)]
        of_image = [(image, k, observed.photo_xy[rows]) for k, rows in enumerate(rows_of) if len(rows) > 2]
        chains += of_image + [
            (image, -1, xy) for xy in wrong_chains(rng, [xy for *_, xy in of_image], wrong_share)
        ]
    control = tuple(replace(c, role="control", sigma=np.zeros_like(c.sigma)) for c in network.curves)
    images = network.images
    sigma = float(observed.sigma.mean())
    return free_scene(
        rng, network.cameras[0], control, images.rotation, images.position, chains, sigma, cut, noise=False
    )


def report(title: str, found: list[Outcome]) -> None:
    """One line of figures."""
    given = [each for each in found if not each.code]
    right = [each for each in found if each.right]
    codes = {
        code: sum(each.code == code for each in found) for code in sorted({e.code for e in found} - {""})
    }
    angle = [each.angle_deg for each in right] or [np.nan]
    share = [100.0 * each.position_share for each in right] or [np.nan]
    seconds = [each.seconds for each in found]
    print(
        f"{title:34s} {len(found):4d} {len(given):8d} {len(right):5d} {len(given) - len(right):5d} "
        f"{np.median(angle):9.4f} {np.max(angle):9.4f} {np.median(share):8.4f} "
        f"{np.median(seconds):6.1f} {np.max(seconds):6.1f}  {codes or ''}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="orientation without any approximation")
    parser.add_argument("what", choices=("synthetic", "six-image", "strasbourg"))
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--first", type=int, default=1, help="seed of the first run")
    parser.add_argument("--reference", type=Path, default=Path("../shared/reference"))
    parser.add_argument("--only", help="one of the cases: words of its name")
    options = parser.parse_args()
    print(f"{'':34s} {'imgs':>4s} {'oriented':>8s} {'right':>5s} {'wrong':>5s} {'deg 50%':>9s} {'deg max':>9s} "
          f"{'X0 50% %':>8s} {'s 50%':>6s} {'s max':>6s}")  # fmt: skip
    folder = options.reference / "synthcurves/turntable20"
    cases: dict[str, dict[str, tuple[Callable[[int], FreeScene], float]]] = {
        "synthetic": {
            "whole chains": (lambda seed: synthetic_curves(folder, seed, wrong_share=0.0), 1.13),
            "30 % wrong": (lambda seed: synthetic_curves(folder, seed), 1.13),
            "30 % wrong, chains cut": (lambda seed: synthetic_curves(folder, seed, cut=True), 1.13),
        },
        "six-image": {
            "as simulated": (six_images, 480.0),
            "30 % wrong": (lambda s: six_images(s, 0.3), 480.0),
        },
        "strasbourg": {
            "as traced": (strasbourg, 1770.0),
            "30 % wrong": (lambda seed: strasbourg(seed, 0.3), 1770.0),
            "30 % wrong, chains cut": (lambda seed: strasbourg(seed, 0.3, cut=True), 1770.0),
        },
    }
    for title, (make, distance) in cases[options.what].items():
        if options.only is not None and options.only != title:
            continue
        seeds = range(options.first, options.first + options.runs)
        report(title, [each for seed in seeds for each in outcomes(make(seed), distance, seed)])


if __name__ == "__main__":
    main()
