"""Which times are held against which times of the peer, and the ratio that is wanted.

Ratios are taken repetition by repetition: both were measured side by side, so that what loads the machine hits both.
What the peer did only once (its dispersion) is held against every repetition.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from benchmarks.measurements import PLAIN, SPEED, Run, select

Seconds = Callable[[Run], float]


@dataclass(frozen=True)
class Comparison:
    """One time of this program against one of another."""

    name: str
    task: str
    mode: str
    seconds: Seconds
    other_name: str
    other_task: str
    other_mode: str
    other_seconds: Seconds
    wanted: dict[int, float]  # highest ratio, by the number of images


@dataclass(frozen=True)
class Ratio:
    """Measured ratios of one comparison at one size."""

    comparison: Comparison
    images: int
    seconds: float  # median
    other_seconds: float  # median
    ratios: tuple[float, ...]

    @property
    def least(self) -> float:
        """The best of the repetitions."""
        return min(self.ratios)

    @property
    def median(self) -> float:
        """The middle of the repetitions."""
        return statistics.median(self.ratios)

    @property
    def most(self) -> float:
        """The worst of the repetitions."""
        return max(self.ratios)

    @property
    def wanted(self) -> float | None:
        """The highest wanted ratio; None where none is."""
        return self.comparison.wanted.get(self.images)

    @property
    def reached(self) -> bool | None:
        """Whether the median is what is wanted."""
        return None if self.wanted is None else self.median <= self.wanted


def _median_of(name: str) -> Seconds:
    return lambda run: statistics.median(run.figures[name])


def _printed(name: str) -> Seconds:
    return lambda run: float(run.figures[name])


def _wall(run: Run) -> float:
    return run.wall_s


def _processor(run: Run) -> float:
    return run.cpu_s


SOLVE = {PLAIN: {100: 1.0, 1000: 0.7, 5000: 0.6}, SPEED: {100: 0.5, 1000: 0.4, 5000: 0.35}}
DISPERSION = {100: 1.0 / 30.0, 1000: 1.0 / 250.0}
ONE_ITERATION = {5000: 1.0}
WHOLE = {1000: 3.0}


def _of_mode(mode: str) -> tuple[Comparison, ...]:
    iteration = _median_of("iteration_s")
    dispersion = _median_of("dispersion_s")
    return (
        Comparison(
            "solution", "solve", mode, _median_of("solve_s"),
            "Ceres vp", "ceres_vp", "", _printed("solve_s"), SOLVE[mode],
        ),
        Comparison(
            "dispersion of all orientations", "solve", mode, dispersion,
            "ceres::Covariance", "ceres_cov", "", _printed("cov_s"), DISPERSION,
        ),
        Comparison(
            "dispersion of all orientations", "solve", mode, dispersion,
            "one own iteration", "solve", mode, iteration, ONE_ITERATION,
        ),
        Comparison(
            "splinebba adjust, whole process", "adjust", mode, _wall,
            "Ceres vp, whole process", "ceres_vp", "", _wall, WHOLE,
        ),
        Comparison(
            "splinebba adjust, processor time", "adjust", mode, _processor,
            "Ceres vp, processor time", "ceres_vp", "", _processor, {},
        ),
    )  # fmt: skip


COMPARISONS = (
    *_of_mode(PLAIN),
    *_of_mode(SPEED),
    Comparison(
        "Ceres vp", "ceres_vp", "", _printed("solve_s"), "Ceres knots", "ceres_knots", "",
        _printed("solve_s"), {},
    ),
)  # fmt: skip


def ratios_of(runs: Sequence[Run]) -> list[Ratio]:
    """All comparisons that were measured, by size."""
    found = []
    for images in sorted({run.size for run in runs}):
        for comparison in COMPARISONS:
            ours = select(runs, images, comparison.task, comparison.mode)
            theirs = select(runs, images, comparison.other_task, comparison.other_mode)
            if ours and theirs:
                found.append(_ratio(comparison, images, ours, theirs))
    return found


def _ratio(comparison: Comparison, images: int, ours: Sequence[Run], theirs: Sequence[Run]) -> Ratio:
    mine = [comparison.seconds(run) for run in ours]
    other = {run.repetition: comparison.other_seconds(run) for run in theirs}
    middle = statistics.median(other.values())
    ratios = tuple(
        taken / max(other.get(run.repetition, middle) if len(other) > 1 else middle, 1e-9)
        for run, taken in zip(ours, mine, strict=True)
    )
    return Ratio(comparison, images, statistics.median(mine), middle, ratios)
