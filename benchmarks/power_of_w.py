"""Empirical power of the w-test: biases of one minimal detectable bias, in points and across curves.

    python -m benchmarks.power_of_w [--blocks 50] [--each 10] [--alpha 0.001] [--power 0.8]

Every block of six images is simulated and adjusted, then adjusted again with one biased measurement at a time.  Prints
how many biases the test finds, with the 99 % binomial interval about the nominal power, and how often it finds
something at the same observations without a bias.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binom

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.settings import LocalTesting
from splinebba_cli.simulation.six_image_block import simulate_block

LEAST_REDUNDANCY = 0.05


@dataclass
class Count:
    """Outcomes of one kind of observation."""

    tested: int = 0
    found: int = 0
    false: int = 0

    def interval(self, rate: float) -> tuple[int, int]:
        """99 % binomial interval of the found ones."""
        low, high = binom.interval(0.99, self.tested, rate)
        return int(low), int(high)


def study(blocks: int, each: int, alpha: float, power: float) -> dict[str, Count]:
    """Outcomes of points and curves."""
    counts = {"points": Count(), "splines, across": Count()}
    for seed in range(blocks):
        generator = np.random.default_rng([17, seed])
        network, _ = simulate_block(
            "six-image-mixed", 1000 + seed, start_position_m=0.5, start_angle_deg=0.1, start_knots_m=0.3
        )
        settings = replace(network.settings, testing=LocalTesting(alpha=alpha, power=power))
        network = replace(network, settings=settings)
        result = adjust(network)
        _points(network, result, each, generator, counts["points"])
        _curves(network, result, each, generator, counts["splines, across"])
    return counts


def restarted(network: Network, result: AdjustmentResult) -> Network:
    """The network with adjusted values as approximate ones, solved in one stage."""
    images = replace(
        network.images,
        position=result.images.eop[:, 3:] - network.origin,
        rotation=result.images.rotation,
    )
    curves = tuple(
        replace(
            curve,
            values=np.where(np.isinf(curve.sigma), found.values - network.origin, curve.values),
            reference=curve.reference if curve.reference is not None else curve.values,
        )
        for curve, found in zip(network.curves, result.curves, strict=True)
    )
    xyz = np.where(np.isinf(network.points.sigma), result.points.xyz - network.origin, network.points.xyz)
    check = np.array([role == "check" for role in network.points.role])[:, None]
    return replace(
        network,
        images=images,
        curves=curves,
        points=replace(network.points, xyz=np.where(check, network.points.xyz, xyz)),
        settings=replace(network.settings, staged=False),
    )


def _critical(result: AdjustmentResult) -> float:
    assert result.evidence.tests is not None
    return result.evidence.tests.critical


def _points(
    network: Network, result: AdjustmentResult, each: int, generator: np.random.Generator, count: Count
) -> None:
    table, start = result.point_residuals, restarted(network, result)
    usable = np.argwhere(table.redundancy > LEAST_REDUNDANCY)
    for row, axis in usable[generator.permutation(len(usable))[:each]]:
        xy: FloatArray = start.point_observations.photo_xy.copy()
        sign = generator.choice([-1.0, 1.0])
        xy[row, axis] += sign * table.reliability.minimal_detectable_bias[row, axis]
        biased = adjust(replace(start, point_observations=replace(start.point_observations, photo_xy=xy)))
        count.tested += 1
        count.found += abs(biased.point_residuals.standardized[row, axis]) > _critical(result)
        count.false += abs(table.standardized[row, axis]) > _critical(result)


def _curves(
    network: Network, result: AdjustmentResult, each: int, generator: np.random.Generator, count: Count
) -> None:
    table, start = result.curve_residuals, restarted(network, result)
    usable = np.flatnonzero(table.redundancy[:, 0] > LEAST_REDUNDANCY)
    for row in usable[generator.permutation(len(usable))[:each]]:
        xy: FloatArray = start.curve_observations.photo_xy.copy()
        bias = table.reliability.minimal_detectable_bias[row, 0] * generator.choice([-1.0, 1.0])
        xy[row] += bias * table.normal[row]
        biased = adjust(replace(start, curve_observations=replace(start.curve_observations, photo_xy=xy)))
        count.tested += 1
        count.found += abs(biased.curve_residuals.standardized[row, 0]) > _critical(result)
        count.false += abs(table.standardized[row, 0]) > _critical(result)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--blocks", type=int, default=50)
    parser.add_argument("--each", type=int, default=10)
    parser.add_argument("--alpha", type=float, default=0.001)
    parser.add_argument("--power", type=float, default=0.8)
    chosen = parser.parse_args()
    for name, count in study(chosen.blocks, chosen.each, chosen.alpha, chosen.power).items():
        low, high = count.interval(chosen.power)
        print(
            f"{name}: {count.found} of {count.tested} found ({count.found / count.tested:.3f}), "
            f"99 % interval {low} to {high}; without bias {count.false}"
        )


if __name__ == "__main__":
    main()
