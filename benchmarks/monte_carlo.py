"""Do the errors follow the reported dispersion?  Adjust a simulated block with many seeds and print the figures.

python -m benchmarks.monte_carlo [KIND] [RUNS]
"""

from __future__ import annotations

import sys
from functools import partial

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.simulation.monte_carlo import Figure, run_monte_carlo
from splinebba_cli.simulation.six_image_block import simulate_block


def line(name: str, figure: Figure) -> str:
    """A figure with its interval."""
    verdict = "inside" if figure.inside else "OUTSIDE"
    return f"{name:46s}{figure.value:8.4f}   {figure.lower:.4f} … {figure.upper:.4f}   {verdict}"


def main(kind: str = "six-image", runs: str = "200") -> None:
    """Print acceptance, mean squared normalised error, and empirical over predicted σ."""
    result = run_monte_carlo(partial(simulate_block, kind), adjust, int(runs))
    ratio, interval = result.sigma_ratio, result.sigma_ratio_interval()
    print(f"{kind}, {result.runs} runs, {result.failures} without a solution; intervals of 99 %")
    print(line("share of accepted global tests", result.acceptance))
    print(line("mean squared normalised error, all elements", result.mean_square))
    print(line("empirical / predicted σ, smallest of all", Figure(float(ratio.min()), *interval)))
    print(line("empirical / predicted σ, largest of all", Figure(float(ratio.max()), *interval)))


if __name__ == "__main__":
    main(*sys.argv[1:])
