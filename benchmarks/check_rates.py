"""How often the tests of check points and check splines reject what is right: the six-image block, new noise a run.

    python -m benchmarks.check_rates [RUNS]

The nominal rate is 5 % for every test (the lists of single tests and those of splines: at most 5 %); the interval is
the binomial one of 99 %.  `mean` is the mean of the statistic over its degrees of freedom; 1 where the dispersion is
right.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from scipy import stats

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.simulation.six_image_block import simulate_block

KINDS = ("single points", "points together", "mean of points", "single spline points", "spline together")


def rates(runs: int, *, scaled: bool = True, first: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Rejections and statistics over degrees of freedom, (runs, 5) each."""
    rejected, size = np.zeros((runs, len(KINDS)), dtype=bool), np.full((runs, len(KINDS)), np.nan)
    for run in range(runs):
        network, _ = simulate_block("six-image-mixed", first + run)
        network = replace(network, settings=replace(network.settings, scale_dispersion=scaled))
        checks = adjust(network).checks
        summary, (spline,) = checks.summary, checks.splines
        assert summary is not None
        assert summary.together is not None
        assert summary.shift is not None
        assert spline.together is not None
        tests = (summary.together, summary.shift, spline.together)
        rejected[run] = [
            summary.beyond > 0,
            not tests[0].passed,
            not tests[1].passed,
            spline.beyond > 0,
            not tests[2].passed,
        ]
        size[run, [1, 2, 4]] = [test.statistic / test.degrees for test in tests]
        size[run, 0] = np.mean([point.normalized**2 for point in checks.points])
        size[run, 3] = np.nanmean(spline.normalized**2)
    return rejected, size


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    for scaled in (True, False):
        rejected, size = rates(runs, scaled=scaled)
        lower, upper = stats.binom.ppf([0.005, 0.995], runs, 0.05) / runs
        print(f"{runs} runs, σ₀ {'estimated' if scaled else 'known'}: 5 % within {lower:.3f} … {upper:.3f}")
        for kind, rate, mean in zip(KINDS, rejected.mean(axis=0), size.mean(axis=0), strict=True):
            print(f"  {kind:22s} {rate:.3f}   mean {mean:.3f}")


if __name__ == "__main__":
    main()
