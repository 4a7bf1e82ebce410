"""Variance components, tests of groups and of systematic effects, measured on the six-image block.

python -m benchmarks.variance_components factors  [runs]    two groups of curve points, σ wrong by 0.5 and 3
python -m benchmarks.variance_components alarms   [runs]    false alarms of every test on clean blocks
python -m benchmarks.variance_components effects  [runs]    planted effects: how often they are named, by what
python -m benchmarks.variance_components strasbourg         two classes of image points of a real block
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import VarianceComponent
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.settings import WeightPolicy
from splinebba_cli.simulation.intervals import binomial_interval, mean_square_interval
from splinebba_cli.simulation.six_image_block import simulate_block

KIND = "six-image-mixed"
TRUE_FACTORS = (0.5, 3.0)  # true over given σ of both groups of curve points


def block(seed: int) -> Network:
    """A clean block from starts that are nearly right."""
    return simulate_block(KIND, seed, start_position_m=0.5, start_angle_deg=0.05, start_knots_m=0.5)[0]


def two_groups(seed: int, factors: tuple[float, float] = TRUE_FACTORS) -> Network:
    """Curve points in turn in groups `fine` and `coarse`; their given σ are the true ones over the factors."""
    network = block(seed)
    seen = network.curve_observations
    group = np.arange(len(seen)) % 2
    sigma = seen.sigma / np.array(factors)[group][:, None]
    grouped = replace(seen, sigma=sigma, group=group, group_names=("fine", "coarse"))
    settings = replace(network.settings, weights=WeightPolicy(variance_components=True))
    return replace(network, curve_observations=grouped, settings=settings)


def truth_of(component: VarianceComponent) -> float:
    """True over given σ of a group of `two_groups`."""
    return dict(zip(("fine", "coarse"), TRUE_FACTORS, strict=True)).get(component.group, 1.0)


def normalized_errors(result: AdjustmentResult) -> dict[str, float]:
    """(estimated − true variance) over its σ of all estimated groups; the σ is relative, at the true value."""
    found = {}
    for each in result.evidence.variance_components:
        if each.estimated:
            ratio = (each.factor * each.sigma0 / truth_of(each)) ** 2
            found[each.group] = float((ratio - 1.0) / (2.0 * each.sigma0_sigma / each.sigma0))
    return found


def factor_errors(runs: int, first: int = 1) -> dict[str, FloatArray]:
    """Normalised errors of every group over all runs."""
    found: dict[str, list[float]] = {}
    for seed in range(first, first + runs):
        for group, error in normalized_errors(adjust(two_groups(seed))).items():
            found.setdefault(group, []).append(error)
    return {group: np.array(values) for group, values in found.items()}


def factors(runs: int = 200) -> None:
    """Are the factors recovered within their stated σ?"""
    low, high = binomial_interval(runs, 0.95)
    print(f"{runs} runs; 99 % intervals of a correct program: |mean| < {2.576 / np.sqrt(runs):.3f},")
    square = mean_square_interval(runs)
    print(f"rms {np.sqrt(square[0]):.3f} … {np.sqrt(square[1]):.3f}, coverage of 95 % {low:.3f} … {high:.3f}")
    for group, e in factor_errors(runs).items():
        covered = float(np.mean(np.abs(e) < 1.96))
        print(
            f"{group:16s} n {len(e):4d}  mean {e.mean():+.3f}  rms {np.sqrt(np.mean(e**2)):.3f}  covered {covered:.3f}"
        )


def alarms_of(result: AdjustmentResult) -> frozenset[str]:
    """Families in which at least one test is beyond its critical value."""
    evidence = result.evidence
    found = {effect.kind for effect in evidence.systematic if effect.significant}
    if any(not test.passed for test in evidence.groups):
        found.add("groups")
    if any(problem.code == "SBB545" for problem in result.problems):
        found.add("variance component")
    if any(not each.passed for each in evidence.variance_components):
        found.add("χ² of a group")
    return frozenset(found)


FAMILIES = (
    "χ² of a group", "variance component", "groups", "image mean", "radial trend", "tangential trend", "grid",
    "run along curve", "drift",
)  # fmt: skip


def shares(networks: Iterator[Network]) -> tuple[int, Counter[str]]:
    """Number of networks, and in how many each family found something."""
    count, found = 0, Counter[str]()
    for network in networks:
        found.update(alarms_of(adjust(network)))
        count += 1
    return count, found


def alarms(runs: int = 400) -> None:
    """False alarms: at most α = 0.05 of the clean blocks for each family (radial and tangential share theirs)."""
    print(f"{runs} clean blocks {KIND}; nominal 0.05, 99 % interval {binomial_interval(runs, 0.05)}")
    count, found = shares(block(seed) for seed in range(1, runs + 1))
    for family in FAMILIES:
        print(f"{family:20s} {found[family] / count:.4f}")


def radial(network: Network, edge_um: float) -> Network:
    """Measured with a third-order radial distortion of `edge_um` at r = 160 mm that the camera lacks."""
    moved = {}
    for name in ("point_observations", "curve_observations"):
        table = getattr(network, name)
        square = np.sum(table.photo_xy**2, axis=1)[:, None] / 160.0**2
        moved[name] = replace(table, photo_xy=table.photo_xy * (1.0 + 1e-3 * edge_um / 160.0 * square))
    return replace(network, **moved)


def shifted_chain(network: Network, shift_um: float, image: int = 4, curve: int = 1) -> Network:
    """One chain of an open spline moved in x, which is nearly across it."""
    seen = network.curve_observations
    own = (seen.image == image) & (seen.curve == curve)
    xy = seen.photo_xy + np.where(own[:, None], [1e-3 * shift_um, 0.0], 0.0)
    return replace(network, curve_observations=replace(seen, photo_xy=xy))


def correlated(network: Network, rho: float) -> Network:
    """Noise of 5 µm added that neighbours on a curve share: a first-order autoregressive process of each chain."""
    seen = network.curve_observations
    generator = np.random.default_rng(int(1e6 * abs(float(seen.photo_xy[0, 0]))) % 2**31)
    noise = generator.standard_normal(seen.photo_xy.shape)
    key = seen.image * 100 + seen.curve
    for i in range(1, len(seen)):
        if key[i] == key[i - 1]:
            noise[i] = rho * noise[i - 1] + np.sqrt(1.0 - rho**2) * noise[i]
    return replace(network, curve_observations=replace(seen, photo_xy=seen.photo_xy + 0.005 * noise))


def moved_control(network: Network, shift_m: float) -> Network:
    """The fifth control point given wrong in height."""
    xyz = network.points.xyz.copy()
    xyz[4, 2] += shift_m
    return replace(network, points=replace(network.points, xyz=xyz))


PLANTED: dict[str, Callable[[Network], Network]] = {
    "radial distortion of 40 µm at 160 mm": lambda n: radial(n, 40.0),
    "radial distortion of 80 µm at 160 mm": lambda n: radial(n, 80.0),
    "chain of `tie-1` in image 5 by 10 µm": lambda n: shifted_chain(n, 10.0),
    "chain of `tie-1` in image 5 by 20 µm": lambda n: shifted_chain(n, 20.0),
    "control point 5 higher by 0.15 m": lambda n: moved_control(n, 0.15),
    "correlated noise of curve points, 0.8": lambda n: correlated(n, 0.8),
}


def effects(runs: int = 100) -> None:
    """How often planted effects are found, and by which family."""
    for name, plant in PLANTED.items():
        count, found = shares(plant(block(seed)) for seed in range(1, runs + 1))
        line = ", ".join(f"{family} {found[family] / count:.2f}" for family in FAMILIES if found[family])
        print(f"{name} ({count} runs): {line}")


def strasbourg_groups() -> Network:
    """Points of the Strasbourg block: manual points with σ 0.5 px, automatic ones with 1 px, as two groups."""
    from tests.reference_data import STRASBOURG_PIXEL_MM, strasbourg_points_network

    network = strasbourg_points_network(True)
    seen = network.point_observations
    group = (seen.sigma[:, 0] > 0.75 * STRASBOURG_PIXEL_MM).astype(np.int64)
    named = replace(seen, group=group, group_names=("manual, 0.5 px", "automatic, 1 px"))
    return replace(network, point_observations=named)


def strasbourg() -> None:
    """What tests and variance components say of both groups, with the given and with estimated σ."""
    network = strasbourg_groups()
    for estimate in (False, True):
        weights = WeightPolicy(variance_components=estimate)
        result = adjust(replace(network, settings=replace(network.settings, weights=weights)))
        _print_strasbourg(result, estimate)


def _print_strasbourg(result: AdjustmentResult, estimated: bool) -> None:
    print(
        f"--- variance components {'estimated' if estimated else 'as given'}: σ̂0 {result.statistics.sigma0:.4f}"
    )
    for each in result.evidence.variance_components:
        print(
            f"{each.group:18s} r {each.redundancy:7.1f} factor {each.factor:.3f} "
            f"σ̂ {each.sigma0:.3f} ± {each.sigma0_sigma:.3f} passed {each.passed}"
        )
    for effect in result.evidence.systematic:
        print(
            f"{effect.kind:18s} {effect.subject:18s} {effect.statistic:8.2f} / {effect.critical:.2f}  {effect.detail}"
        )
    network, w = result.network, np.nan_to_num(np.abs(result.point_residuals.standardized))
    observed = network.point_observations
    print(f"|w| > 3.29: {int((w > 3.29).sum())} of {w.size} (expected {0.001 * w.size:.1f})")
    for k in np.argsort(-w.max(axis=1))[:8]:
        names = network.images.ids[observed.image[k]], network.points.ids[observed.point[k]]
        print(f"  image {names[0]} point {names[1]} w {w[k].max():.2f}")
    for problem in result.problems:
        print(f"  {problem.code} {problem.severity}: {problem.message}")


if __name__ == "__main__":
    part, *rest = sys.argv[1:] or ["alarms"]
    numbers = [int(text) for text in rest]
    {"factors": factors, "alarms": alarms, "effects": effects, "strasbourg": strasbourg}[part](*numbers)
