"""Coverage of 95 % intervals over many seeded runs: ``python -m benchmarks.coverage [--runs 500] [--only NAME]``.

One line a kind of estimates and case: share of the runs in which the interval holds the truth, pooled over the
elements, with the interval in which a correct program finds the share of one element with 99 % probability (binomial);
the least and the largest share of a single element, and of how many elements it is outside; empirical over predicted
σ, smallest and largest, with limits that all of the line keep together with 99 % probability.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.conic_errors import MeasuredRun, measured_run
from benchmarks.coverage_cases import CASES, Case, case
from splinebba_cli.core.network import Network
from splinebba_cli.output.json_text import finite
from splinebba_cli.simulation.campaign_statistics import (
    ElementStatistics,
    SplineStatistics,
    all_elements,
    all_locations,
    all_splines,
    element_statistics,
    kind_statistics,
    largest_bias,
)
from splinebba_cli.simulation.executors import run_all
from splinebba_cli.simulation.intervals import Figure
from splinebba_cli.simulation.monte_carlo import MonteCarloResult, summarize

CONFIDENCE = 0.95
SEED = 1
HEAD = (
    f"{'Case':13s} {'Estimates':28s} {'number':>6s} {'coverage':>8s} {'from':>6s} {'to':>6s} {'':7s} "
    f"{'single: least':>13s} {'most':>6s} {'outside':>7s}   {'ratio: least':>12s} {'most':>6s} {'from':>6s} {'to':>6s} "
    f"{'bias':>5s} {'limit':>5s}"
)


@dataclass(frozen=True)
class Line:
    """All estimates of a kind in one case."""

    case: str
    estimates: str
    elements: int
    coverage: Figure
    least: float  # coverage of a single element
    most: float
    outside: int  # elements whose coverage is outside of the interval: one in a hundred by chance
    smallest_ratio: float
    largest_ratio: float
    ratio_limits: tuple[float, float]
    bias: float  # the largest one, in its own σ
    bias_limit: float

    def text(self) -> str:
        """The line of the table."""
        c, (low, high) = self.coverage, self.ratio_limits
        return (
            f"{self.case:13s} {self.estimates:28s} {self.elements:6d} {c.value:8.4f} {c.lower:6.3f} {c.upper:6.3f} "
            f"{'inside' if c.inside else 'OUTSIDE':7s} {self.least:13.3f} {self.most:6.3f} {self.outside:7d}   "
            f"{self.smallest_ratio:12.3f} {self.largest_ratio:6.3f} {low:6.3f} {high:6.3f} "
            f"{self.bias:5.2f} {self.bias_limit:5.2f}"
        )


def lines_of(chosen: Case, network: Network, runs: Sequence[MeasuredRun]) -> list[Line]:
    """All lines of one case."""
    settings = network.settings
    result = summarize([run.record for run in runs], settings.alpha, settings.scale_dispersion)
    eop, points = (
        [each for item in all_elements(result, kind, CONFIDENCE) for each in item]
        for kind in ("eop", "points")
    )
    groups: list[tuple[str, Sequence[ElementStatistics | SplineStatistics | None]]] = [
        ("orientations", eop),
        ("points", points),
        ("locations along", all_locations(result, CONFIDENCE)),
    ]
    splines = all_splines(result, CONFIDENCE)
    if chosen.curve_by_curve:
        groups += [
            (f"across {curve.id}", [each]) for curve, each in zip(network.curves, splines, strict=True)
        ]
        groups += conic_groups(runs, result)
    else:
        groups.append(("splines across", splines))
    found = [line_of(chosen.name, name, items, result) for name, items in groups]
    return [line for line in found if line is not None]


def conic_groups(
    runs: Sequence[MeasuredRun], result: MonteCarloResult
) -> list[tuple[str, list[ElementStatistics | None]]]:
    """Elements of all conics."""
    solved = sorted((run for run in runs if run.conics), key=lambda run: run.record.run)
    groups = []
    for key in solved[0].conics if solved else ():
        errors, sigma = (np.array([run.conics[key][i] for run in solved]) for i in (0, 1))
        normalized = errors / sigma
        covered = result.covered(normalized**2, 1.0, CONFIDENCE)
        items = [
            element_statistics(errors[:, j], normalized[:, j], covered[:, j], CONFIDENCE)
            for j in range(errors.shape[1])
        ]
        groups.append((f"{key[0]}: {key[1]}", items))
    return groups


def line_of(
    name: str,
    estimates: str,
    items: Sequence[ElementStatistics | SplineStatistics | None],
    result: MonteCarloResult,
) -> Line | None:
    """One line; None where nothing is estimated."""
    kind = kind_statistics(items, result, CONFIDENCE)
    if kind is None:
        return None
    known = [item for item in items if item is not None]
    single = [item.coverage for item in known]
    elements = [item for item in known if isinstance(item, ElementStatistics)]
    splines = [item for item in known if isinstance(item, SplineStatistics)]
    bias, limit = largest_bias(elements)
    if splines:
        bias = max(item.largest_bias for item in splines)
        limit = max(item.largest_bias_limit for item in splines)
    limits = kind.ratio_limits
    if len(splines) == 1:
        limits = (splines[0].ratio.lower, splines[0].ratio.upper)
    return Line(
        name, estimates, kind.elements, kind.coverage,
        min(each.value for each in single), max(each.value for each in single),
        sum(not each.inside for each in single), kind.smallest_ratio, kind.largest_ratio, limits, bias, limit,
    )  # fmt: skip


def measure(chosen: Case, runs: int, jobs: int) -> tuple[list[Line], dict[str, int]]:
    """Run a case; its lines, and how many runs were solved or not, by reason."""
    campaign = chosen.make(SEED)
    found = list(run_all(partial(measured_run, campaign), range(runs), jobs))
    reasons: dict[str, int] = {"solved": sum(run.record.failure is None for run in found)}
    for run in found:
        if run.record.failure is not None:
            reasons[run.record.failure.code] = reasons.get(run.record.failure.code, 0) + 1
    return lines_of(chosen, campaign.design.network, found), reasons


def main() -> None:
    parser = argparse.ArgumentParser(description="coverage of 95 % intervals")
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--only", choices=[each.name for each in CASES], action="append")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, default=Path("coverage.results"))
    options = parser.parse_args()
    chosen = [case(name) for name in options.only] if options.only else CASES
    options.output.mkdir(parents=True, exist_ok=True)
    print(HEAD)
    for each in chosen:
        begin = time.perf_counter()
        lines, reasons = measure(each, options.runs, options.jobs)
        for line in lines:
            print(line.text(), flush=True)
        print(f"# {each.name}: {each.title}; {reasons}, {time.perf_counter() - begin:.0f} s", flush=True)
        content = {
            "case": each.name,
            "title": each.title,
            "seed": SEED,
            "runs": options.runs,
            "confidence": CONFIDENCE,
            "reasons": reasons,
            "lines": [{**asdict(line), "inside": line.coverage.inside} for line in lines],
        }
        text = json.dumps(finite(content), indent=1, ensure_ascii=False)
        (options.output / f"{each.name}.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
