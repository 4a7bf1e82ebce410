"""How far off orientations may be for unlabelled points to find their curves; how precise they are then.

    python -m benchmarks.matching_convergence six-image [--runs 100] [--figure docs/figures/matching-convergence.svg]
    python -m benchmarks.matching_convergence synthetic [--runs 200]
    python -m benchmarks.matching_convergence strasbourg [--runs 20]

six-image: Lee's block with its control splines and approximate tie splines, labels removed, a third of the chains
wrong, orientations off by ever more; the settings say by how much.  synthetic, strasbourg: reference data (skipped
where they are not there); control curves of known shape, labels removed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.contaminated import with_moved_orientations, with_random_points, with_wrong_chains
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.quality.orientation_dispersion import eop_transform
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import at_truth
from tests.unlabelled import without_labels

WRONG_CHAINS = 0.3
OFFSETS = ((3.0, 0.5), (10.0, 2.0), (30.0, 5.0), (60.0, 10.0), (100.0, 15.0), (150.0, 20.0), (200.0, 30.0))
FAR_OFF = 6.0  # sigma: an orientation that is farther from the truth did not converge


@dataclass(frozen=True)
class Outcome:
    """One matching against the truth."""

    right: float  # share of points on curves with the right one
    wrong: float  # with another one
    foreign: float  # share of points on no curve that got one
    converged: float  # share of images oriented within 6 sigma of the truth
    seconds: float
    theta_error: FloatArray  # (m, 3) rad
    position_error: FloatArray  # (m, 3) m
    sigma: FloatArray  # (m, 6) predicted, of theta and X0; NaN where not oriented


def outcome(
    network: Network, label: IntArray, settings: MatchSettings, rotation: FloatArray, position: FloatArray
) -> Outcome:
    """Match a network and compare.

    Parameters
    ----------
    label : (n,) true curves, -1: none
    rotation, position : true orientations (m, 3, 3), (m, 3)
    """
    begin = time.perf_counter()
    result = match(network, settings)
    seconds = time.perf_counter() - begin
    curve, on_curve = result.matches.curve, label >= 0
    turn = np.einsum("mji,mjk->mik", rotation, result.network.images.rotation)
    theta = 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1
    )
    shift = result.network.images.position - position
    sigma = solver_sigma(result)
    off = np.abs(np.hstack([theta, shift])) / np.where(np.isfinite(sigma), sigma, 1e-12)
    return Outcome(
        right=float(np.mean(curve[on_curve] == label[on_curve])),
        wrong=float(np.mean((curve[on_curve] >= 0) & (curve[on_curve] != label[on_curve]))),
        foreign=float(np.mean(curve[~on_curve] >= 0)) if (~on_curve).any() else 0.0,
        converged=float(np.mean((off < FAR_OFF).all(axis=1))),
        seconds=seconds,
        theta_error=theta,
        position_error=shift,
        sigma=sigma,
    )


def solver_sigma(result: MatchResult) -> FloatArray:
    """Predicted standard deviations of theta and X0, (m, 6)."""
    inverse = np.linalg.inv(eop_transform(result.network.images, result.network.images.rotation))
    blocks = inverse @ result.eop_dispersion @ inverse.transpose(0, 2, 1)
    return np.sqrt(np.einsum("mii->mi", blocks))


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


def synthetic_run(seed: int, random_share: float, every: int = 10, views: Sequence[int] = (0,)) -> Outcome:
    """Views before the analytic curves, 0.5 px of noise, 1 degree and 10 mm off; chains are whole curves."""
    from tests.synthetic_curves import PIXEL_MM, UNIT_M, synthetic_network

    exact, generator = synthetic_network(list(views), every), np.random.default_rng(seed)
    observed = exact.curve_observations
    noise = generator.normal(0.0, 0.5 * PIXEL_MM, observed.photo_xy.shape)
    measured = replace(exact, curve_observations=replace(observed, photo_xy=observed.photo_xy + noise))
    network, label = without_labels(measured)
    if random_share > 0.0:
        network, label = with_random_points(network, label, random_share, generator)
    network = with_moved_orientations(network, generator, 10.0 * UNIT_M, float(np.radians(1.0)))
    settings = MatchSettings(position_sigma_m=10.0 * UNIT_M, angle_sigma_rad=float(np.radians(1.0)))
    return outcome(network, label, settings, exact.images.rotation, exact.images.position)


def strasbourg_run(seed: int, wrong_chains: float) -> Outcome:
    """Thirty traced curves in five images, orientations off by 5 m and 0.2 degrees, reference shapes held."""
    from tests.reference_data import strasbourg_curves_network

    traced = strasbourg_curves_network(points=False)
    curves = tuple(replace(c, role="control", sigma=np.zeros_like(c.values)) for c in traced.curves)
    exact, generator = replace(traced, curves=curves), np.random.default_rng(seed)
    network, label = without_labels(exact)
    if wrong_chains > 0.0:
        network, label = with_wrong_chains(network, label, wrong_chains, generator, 0.3)
    position, angle = 5.0 / np.sqrt(3.0), float(np.radians(0.2)) / np.sqrt(3.0)
    network = with_moved_orientations(network, generator, position, angle)
    settings = MatchSettings(position_sigma_m=position, angle_sigma_rad=angle)
    return outcome(network, label, settings, exact.images.rotation, exact.images.position)


def _summary(name: str, runs: Sequence[Outcome]) -> str:
    whole = np.mean([run.right for run in runs]), np.mean([run.wrong for run in runs])
    foreign, converged = np.mean([run.foreign for run in runs]), np.mean([run.converged for run in runs])
    return (
        f"{name:24s} {len(runs):5d} {100 * whole[0]:9.2f} {100 * whole[1]:9.3f} {100 * foreign:9.2f} "
        f"{100 * converged:12.1f} {np.mean([run.seconds for run in runs]):8.1f}"
    )


HEADER = f"{'':24s}  runs right [%] wrong [%]   foreign oriented [%]  s a run"


def _six_image(runs: int, figure: Path | None) -> None:
    shares: dict[str, list[tuple[float, float]]] = {}
    print(HEADER)
    for wrong in (0.0, WRONG_CHAINS):
        for position, angle in OFFSETS:
            found = [six_image_run(seed, position, angle, wrong) for seed in range(1, runs + 1)]
            name = f"{100 * wrong:.0f} % of chains wrong"
            print(_summary(f"{position:.0f} m, {angle:g} deg, {100 * wrong:.0f} %", found), flush=True)
            shares.setdefault(name, []).append((angle, 100.0 * float(np.mean([f.converged for f in found]))))
    if figure:
        _draw(shares, figure)


def _draw(shares: dict[str, list[tuple[float, float]]], path: Path) -> None:
    import matplotlib as mpl

    mpl.use("svg" if path.suffix == ".svg" else "agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
    for name, line in shares.items():
        axes.plot(*zip(*line, strict=True), "o-", label=name, markersize=4)
    axes.set(
        xlabel="σ of the errors of angles [°]; positions with them: "
        + ", ".join(f"{p:.0f}" for p, _ in OFFSETS)
        + " m",
        ylabel="images oriented [%]",
        ylim=(-3.0, 103.0),
    )
    axes.grid(visible=True, alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path)
    plt.close(figure)


def _precision(name: str, runs: Sequence[Outcome]) -> None:
    """Predicted standard deviations and the scatter of true errors of the first image."""
    theta = np.degrees([run.theta_error[0] for run in runs])
    position = 1e3 * np.array([run.position_error[0] for run in runs])
    predicted = np.mean([run.sigma[0] for run in runs], axis=0)
    scatter = [np.sqrt(np.mean(each**2, axis=0)) for each in (theta, position)]
    print(
        f"{name}, predicted   {np.degrees(predicted[:3]).round(4)} deg  {(1e3 * predicted[3:]).round(3)} mm"
    )
    print(f"{name}, true errors {scatter[0].round(4)} deg  {scatter[1].round(3)} mm", flush=True)


def _repeated(name: str, runs: int, one: Callable[[int], Outcome]) -> list[Outcome]:
    found = [one(seed) for seed in range(1, runs + 1)]
    print(_summary(name, found), flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("study", choices=("six-image", "synthetic", "strasbourg"))
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--figure", type=Path)
    chosen = parser.parse_args()
    if chosen.study == "six-image":
        _six_image(chosen.runs, chosen.figure)
        return
    print(HEADER)
    if chosen.study == "synthetic":
        half = list(range(0, 20, 2))
        _repeated("ten views, all points", 1, lambda seed: synthetic_run(seed, 0.0, 1, half))
        for share in (0.0, 0.3):
            name = f"view 0, {100 * share:.0f} % random"
            _precision(name, _repeated(name, chosen.runs, lambda seed, s=share: synthetic_run(seed, s)))  # type: ignore[misc]
        return
    for share in (0.0, WRONG_CHAINS):
        _repeated(
            f"{100 * share:.0f} % of chains wrong",
            chosen.runs,
            lambda seed, s=share: strasbourg_run(seed, s),  # type: ignore[misc]
        )


if __name__ == "__main__":
    main()
