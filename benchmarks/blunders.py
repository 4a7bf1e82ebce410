"""Outliers found, gross errors survived, false rejections: ``python -m benchmarks.blunders [--runs 200] [--only a]``.

(a) one error of 6 σ: how often the first rejection is the planted one, against the probability of its design
(b) 10 to 40 % errors of 20 to 200 σ in points on curves, high-breakdown start and snooping: orientations against
    those of the same measurements without errors
(c) no errors: share of the tests beyond the critical value, and rejections of snooping
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np

from benchmarks.blunder_cases import (
    across,
    clean_block,
    contaminated,
    first_probability,
    geometry,
    in_coordinate,
    largest_shift,
    with_policy,
    without_planted,
)
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.critical_values import critical_w, power_of_w
from splinebba_cli.core.settings import OutlierMethod, OutlierPolicy
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.simulation.intervals import binomial_interval

ALPHA = 0.001
SIZE = 6.0
SHARES = (0.1, 0.2, 0.3, 0.4)


@dataclass(frozen=True)
class FirstRejections:
    """How often the planted error was rejected first."""

    runs: int
    observed: int
    predicted: float  # mean probability, by samples of all correlated w
    power: float  # mean probability that w of the planted one is beyond the critical value
    interval: tuple[float, float]  # of the share, 99 %


def first_rejections(runs: int, seed: int = 1) -> FirstRejections:
    """One error of 6 σ a run, every other one in a coordinate of a point, the others across a curve."""
    made, rng, critical = geometry(), np.random.default_rng(seed), critical_w(ALPHA)
    observed, probability, power = 0, [], []
    for run in range(runs):
        clean = clean_block(seed + run)
        network = clean.network
        points = len(network.point_observations)
        sign = float(rng.choice([-1.0, 1.0]))
        if run % 2:
            entry, axis = int(rng.integers(points)), int(rng.integers(2))
            planted, kind, own = in_coordinate(network, entry, axis, sign * SIZE), "point", entry
        else:
            own, axis = int(rng.integers(len(network.curve_observations))), 0
            normal = clean.result.curve_residuals.normal
            planted = across(network, normal, np.array([own]), np.array([sign * SIZE]))
            entry, kind = points + own, "spline"
        row = made.row_of(entry, axis)
        probability.append(first_probability(made, entry, row, SIZE, critical, rng))
        power.append(power_of_w(SIZE * float(np.sqrt(made.redundancy[row])), critical))
        log = adjust(with_policy(planted, OutlierPolicy("snooping"))).revision.rejections
        observed += bool(log) and (log[0].kind, log[0].row) == (kind, own)
    mean = float(np.mean(probability))
    return FirstRejections(runs, observed, mean, float(np.mean(power)), binomial_interval(runs, mean, 0.99))


@dataclass(frozen=True)
class Shifts:
    """Largest shift of an orientation element in every run, in σ of the clean solution; inf where unsolved."""

    found: FloatArray  # (runs,)
    knowing: FloatArray  # (runs,) of the adjustment that knows the errors: what the lost points cost

    @property
    def within(self) -> float:
        """Share of the runs within 3 σ."""
        return float(np.mean(self.found <= 3.0))


def shifts(share: float, runs: int, kind: str, method: OutlierMethod = "snooping", seed: int = 1) -> Shifts:
    """Orientations with a share of errors against those without any."""
    found, knowing = [], []
    policy = OutlierPolicy(method, "high_breakdown", max_share=0.5)
    for run in range(runs):
        clean = clean_block(seed + run, kind)
        network = with_policy(contaminated(clean, share, seed + run), policy)
        try:
            found.append(largest_shift(clean.result, adjust(network)))
        except NotSolvableError:
            found.append(float("inf"))
        try:
            knowing.append(largest_shift(clean.result, without_planted(clean, share, seed + run)))
        except NotSolvableError:
            knowing.append(float("inf"))
    return Shifts(np.array(found), np.array(knowing))


@dataclass(frozen=True)
class FalseRejections:
    """Tests beyond the critical value where there are no errors."""

    tests: int
    beyond: int
    rejections: int  # of snooping, way back included
    interval: tuple[float, float]  # of the share beyond, 99 %


def false_rejections(runs: int, seed: int = 1) -> FalseRejections:
    """All tests of many runs without errors."""
    tests = beyond = rejections = 0
    for run in range(runs):
        clean = clean_block(seed + run)
        result = clean.result
        w = np.concatenate(
            [result.point_residuals.standardized.ravel(), result.curve_residuals.standardized[:, 0]]
        )
        r = np.concatenate(
            [result.point_residuals.redundancy.ravel(), result.curve_residuals.redundancy[:, 0]]
        )
        tested = w[r > 0.01]
        tests += len(tested)
        beyond += int((np.abs(tested) > critical_w(ALPHA)).sum())
        rejections += adjust(with_policy(clean.network, OutlierPolicy("snooping"))).revision.rejected
    return FalseRejections(tests, beyond, rejections, binomial_interval(tests, ALPHA, 0.99))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--only", nargs="*", default=["a", "b", "c"])
    parser.add_argument("--shares", nargs="*", type=float, default=SHARES, help="shares of errors of (b)")
    parser.add_argument("--kinds", nargs="*", default=["six-image-mixed", "six-image"], help="blocks of (b)")
    options = parser.parse_args()
    begin = time.perf_counter()
    if "a" in options.only:
        first = first_rejections(options.runs)
        low, high = first.interval
        print(
            f"(a) planted error of {SIZE:g} σ rejected first: {first.observed} of {first.runs} "
            f"({first.observed / first.runs:.3f}), predicted {first.predicted:.3f} (99 %: {low:.3f} to {high:.3f}); "
            f"power of its own test {first.power:.3f}"
        )
    if "b" in options.only:
        for kind in options.kinds:
            for share in options.shares:
                both = shifts(share, options.runs, kind)
                print(
                    f"(b) {kind}, {100 * share:.0f} % errors: within 3 σ in {both.within:.3f} of {options.runs} runs "
                    f"({np.isinf(both.found).sum()} unsolved); largest shift: median {np.median(both.found):.2f} σ, "
                    f"worst {both.found.max():.2f} σ; with the errors known: {np.mean(both.knowing <= 3.0):.3f}, "
                    f"{np.median(both.knowing):.2f} σ, {both.knowing.max():.2f} σ",
                    flush=True,
                )
    if "c" in options.only:
        false = false_rejections(options.runs)
        low, high = false.interval
        print(
            f"(c) {false.beyond} of {false.tests} tests beyond {critical_w(ALPHA):.2f}: "
            f"{false.beyond / false.tests:.5f} "
            f"(99 %: {low:.5f} to {high:.5f}); {false.rejections} rejections in {options.runs} runs"
        )
    print(f"{time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
