"""From how far away Lee's experiments come back: ``python -m benchmarks.convergence [--runs 50] [--only NAME]``.

Starts of locations and of coefficients are true values + factor · (Lee's starts − true values); factor 1 is what the
dissertation starts from.  *same*: every location on a known segment and every place across the segment is within 0.01 σ
of the solution that starts at the truth.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.coverage_cases import LEE_EXPERIMENTS
from splinebba_cli.core.network import FloatArray
from splinebba_cli.simulation.campaign import SAME_SOLUTION, at_truth_with_control, attempt
from splinebba_cli.simulation.campaign_statistics import study_statistics
from splinebba_cli.simulation.dissertation import design_of, experiment
from splinebba_cli.simulation.executors import run_all
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.run_errors import largest, reference_of_result, run_errors
from splinebba_cli.simulation.run_record import RunRecord, StudyPoint

FACTORS = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0)
SEED = 1


def with_starts(design: Design, factor: float) -> Design:
    """The design with the errors of its own starts multiplied by a factor."""
    network, truth = design.network, design.truth

    def scaled(start: FloatArray, true: FloatArray) -> FloatArray:
        return np.asarray(true + factor * (start - true))

    observed = network.curve_observations
    curves = tuple(
        replace(curve, values=scaled(curve.values, true))
        for curve, true in zip(network.curves, truth.curves, strict=True)
    )
    observed = replace(observed, location=scaled(observed.location, truth.locations))
    return replace(design, network=replace(network, curves=curves, curve_observations=observed))


def outcomes(name: str, run: int) -> RunRecord:
    """Where the starts of every factor led in one run."""
    design = design_of(experiment(name))
    made = realize(design, Noise(), SEED + run)
    best, failure = attempt(at_truth_with_control(made))
    points = []
    for factor in FACTORS if best is not None else ():
        network = realize(with_starts(design, factor), Noise(), SEED + run).network
        result, reason = attempt(network)
        if result is None or best is None:
            points.append(StudyPoint(factor, "failed", float("nan"), 0, reason))
            continue
        deviation = largest(run_errors(result, reference_of_result(best)))
        same = deviation <= SAME_SOLUTION
        points.append(
            StudyPoint(factor, "same" if same else "other minimum", deviation, len(result.iterations))
        )
    return RunRecord(run, failure, None, float("nan"), 0, None, 0, tuple(points))


def main() -> None:
    parser = argparse.ArgumentParser(description="convergence of Lee's experiments")
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--only", choices=LEE_EXPERIMENTS, action="append")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    print(f"{'Experiment':11s} {'factor':>6s} {'location':>8s} {'runs':>4s} {'same [%]':>8s} {'from':>6s} {'to':>6s} "
          f"{'other minimum':>13s} {'failed':>6s} {'iterations':>10s}")  # fmt: skip
    for name in options.only or LEE_EXPERIMENTS:
        design = design_of(experiment(name))
        error = design.network.curve_observations.location - design.truth.locations
        records = list(run_all(partial(outcomes, name), range(options.runs), options.jobs))
        for each in study_statistics(records):
            size = each.factor * float(np.abs(error).max())
            same = [100.0 * share for share in (each.same.value, each.same.lower, each.same.upper)]
            print(
                f"{name:11s} {each.factor:6.1f} {size:8.3f} {each.runs:4d} "
                f"{same[0]:8.1f} {same[1]:6.1f} {same[2]:6.1f} "
                f"{each.other_minimum:13d} {each.failed:6d} {each.iterations:10.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
