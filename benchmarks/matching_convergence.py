"""Labels and orientations that unlabelled points of reference data find, and how precise these are.

    python -m benchmarks.matching_convergence synthetic [--runs 200]
    python -m benchmarks.matching_convergence strasbourg [--runs 20]

Reference data (beside the project): control curves of known shape, labels removed, orientations off by what the
settings say.  How far off they may be: convergence_radius.py.  "Apart": points further than 3 px from every other
curve (points_apart.py).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.contaminated import with_moved_orientations, with_random_points, with_wrong_chains
from benchmarks.points_apart import directions_along, points_apart
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.quality.orientation_dispersion import eop_transform
from tests.unlabelled import without_labels

WRONG_CHAINS = 0.3
APART_PX = 3.0  # from every other curve
EDGEL_RAD = 0.05  # of directions that an edge detector gives
FAR_OFF = 6.0  # sigma: an orientation that is farther from the truth did not converge


@dataclass(frozen=True)
class Outcome:
    """One matching against the truth."""

    right: float  # share of points on curves with the right one
    wrong: float  # with another one
    apart: float  # share of points on curves without another curve near; NaN where nobody looked
    right_apart: float  # share of these with the right one
    wrong_apart: float
    foreign: float  # share of points on no curve that got one
    converged: float  # share of images oriented within 6 sigma of the truth
    misled: float  # share of images called oriented that are not
    seconds: float
    theta_error: FloatArray  # (m, 3) rad
    position_error: FloatArray  # (m, 3) m
    sigma: FloatArray  # (m, 6) predicted, of theta and X0; NaN where not oriented


def outcome(
    network: Network, label: IntArray, settings: MatchSettings, rotation: FloatArray, position: FloatArray,
    apart: BoolArray | None = None,
) -> Outcome:  # fmt: skip
    """Match a network and compare.

    Parameters
    ----------
    label : (n,) true curves, -1: none
    rotation, position : true orientations (m, 3, 3), (m, 3)
    apart : (p,) which of the first points, those on curves, have no other curve near
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
    near = (off < FAR_OFF).all(axis=1)
    own, true = (curve[: len(apart)], label[: len(apart)]) if apart is not None else (curve[:0], label[:0])
    right, wrong = own == true, (own >= 0) & (own != true)
    return Outcome(
        right=float(np.mean(curve[on_curve] == label[on_curve])),
        wrong=float(np.mean((curve[on_curve] >= 0) & (curve[on_curve] != label[on_curve]))),
        apart=float(np.mean(apart)) if apart is not None else np.nan,
        right_apart=float(np.mean(right[apart])) if apart is not None else np.nan,
        wrong_apart=float(np.mean(wrong[apart])) if apart is not None else np.nan,
        foreign=float(np.mean(curve[~on_curve] >= 0)) if (~on_curve).any() else 0.0,
        converged=float(np.mean(near)),
        misled=float(np.mean(result.oriented & ~near)),
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


def synthetic_run(
    seed: int, random_share: float, every: int = 10, views: Sequence[int] = (0,), *, points: str = "chains"
) -> Outcome:
    """Views before the analytic curves, 0.5 px of noise, 1 degree and 10 mm off.

    Parameters
    ----------
    points : "chains": a curve is a chain in every view; "single": all points are; "edgels": single ones with the
        direction of their edge, to 0.05 rad
    """
    from tests.synthetic_curves import PIXEL_MM, UNIT_M, synthetic_network

    exact, generator = synthetic_network(list(views), every), np.random.default_rng(seed)
    observed = exact.curve_observations
    noise = generator.normal(0.0, 0.5 * PIXEL_MM, observed.photo_xy.shape)
    measured = replace(exact, curve_observations=replace(observed, photo_xy=observed.photo_xy + noise))
    network, label = without_labels(measured, chains=points == "chains")
    true = without_labels(exact, chains=points == "chains")[0]
    apart = points_apart(true, label, APART_PX * PIXEL_MM)
    if points == "edgels":
        along = directions_along(true, label, APART_PX * PIXEL_MM) + generator.normal(
            0.0, EDGEL_RAD, len(label)
        )
        network = replace(network, unlabelled=replace(network.unlabelled, direction=along))
    if random_share > 0.0:
        network, label = with_random_points(network, label, random_share, generator)
    network = with_moved_orientations(network, generator, 10.0 * UNIT_M, float(np.radians(1.0)))
    settings = MatchSettings(position_sigma_m=10.0 * UNIT_M, angle_sigma_rad=float(np.radians(1.0)))
    return outcome(network, label, settings, exact.images.rotation, exact.images.position, apart)


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
    def mean(share: str) -> float:
        return 100.0 * float(np.mean([getattr(run, share) for run in runs]))

    return (
        f"{name:32s} {len(runs):5d} {mean('right'):9.2f} {mean('wrong'):9.3f} {mean('apart'):9.1f} "
        f"{mean('right_apart'):9.2f} {mean('wrong_apart'):9.3f} {mean('foreign'):11.2f} "
        f"{mean('converged'):12.1f} {np.mean([run.seconds for run in runs]):8.1f}"
    )


HEADER = f"{'':32s}  runs right [%] wrong [%] apart [%] right [%] wrong [%] foreign [%] oriented [%]  s a run"


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


def _synthetic(runs: int) -> None:
    half = list(range(0, 20, 2))
    for share in (0.0, 0.3):
        name = f"ten views, {100 * share:.0f} % random"
        _repeated(name, 1, lambda seed, s=share: synthetic_run(seed, s, 1, half))  # type: ignore[misc]
    for points in ("chains", "edgels", "single"):
        for share in (0.0, 0.3):
            name = f"view 0, {points}, {100 * share:.0f} % random"
            found = _repeated(name, runs, lambda seed, s=share, p=points: synthetic_run(seed, s, points=p))  # type: ignore[misc]
            _precision(name, found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("study", choices=("synthetic", "strasbourg"))
    parser.add_argument("--runs", type=int, default=20)
    chosen = parser.parse_args()
    print(HEADER)
    if chosen.study == "synthetic":
        _synthetic(chosen.runs)
        return
    for share in (0.0, WRONG_CHAINS):
        _repeated(
            f"{100 * share:.0f} % of chains wrong",
            chosen.runs,
            lambda seed, s=share: strasbourg_run(seed, s),  # type: ignore[misc]
        )


if __name__ == "__main__":
    main()
