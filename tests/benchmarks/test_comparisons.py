"""Ratios are taken repetition by repetition, and against the wanted figures of their size."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.comparisons import Ratio, ratios_of
from benchmarks.measurements import Run


def run(task: str, repetition: int, mode: str = "", images: int = 1000, **figures: Any) -> Run:
    return Run(images, repetition, task, mode, figures.pop("wall_s", 1.0), 1.0, 2**20, figures)


def solved(repetition: int, seconds: float, images: int = 1000) -> Run:
    return run(
        "solve",
        repetition,
        "plain",
        images,
        solve_s=[9.0, seconds, 0.1],
        dispersion_s=[0.02],
        iteration_s=[0.1],
    )


def only(ratios: list[Ratio], name: str, other: str) -> Ratio:
    (found,) = (r for r in ratios if (r.comparison.name, r.comparison.other_name) == (name, other))
    return found


def test_both_of_one_repetition_are_compared() -> None:
    """A load that slows both down in one repetition leaves the ratios alone."""
    runs = [solved(1, 2.0), run("ceres_vp", 0, solve_s=2.0), solved(0, 1.0), run("ceres_vp", 1, solve_s=4.0)]
    ratio = only(ratios_of(runs), "solution", "Ceres vp")
    assert ratio.ratios == (0.5, 0.5)
    assert (ratio.seconds, ratio.other_seconds) == (1.5, 3.0)
    assert (ratio.wanted, ratio.reached) == (0.7, True)


def test_what_the_peer_did_once_is_compared_with_every_repetition() -> None:
    runs = [solved(0, 1.0), solved(1, 1.0), solved(2, 1.0), run("ceres_cov", 0, cov_s=4.0)]
    ratio = only(ratios_of(runs), "dispersion of all orientations", "ceres::Covariance")
    assert ratio.ratios == pytest.approx((0.005,) * 3)
    assert (ratio.wanted, ratio.reached) == (1.0 / 250.0, False)


def test_sizes_are_apart_and_have_their_own_aim() -> None:
    runs = [
        solved(0, 3.0, images=5000), run("ceres_vp", 0, images=5000, solve_s=4.0),
        solved(0, 1.0, images=100), run("ceres_vp", 0, images=100, solve_s=1.0),
        solved(0, 1.0, images=20), run("ceres_vp", 0, images=20, solve_s=1.0),
    ]  # fmt: skip
    found = {r.images: r for r in ratios_of(runs) if r.comparison.name == "solution"}
    assert {images: (r.median, r.wanted, r.reached) for images, r in found.items()} == {
        20: (1.0, None, None), 100: (1.0, 1.0, True), 5000: (0.75, 0.6, False),
    }  # fmt: skip


def test_the_whole_command_against_the_whole_process() -> None:
    runs = [run("adjust", 0, "plain", wall_s=4.5), run("ceres_vp", 0, wall_s=1.6, solve_s=1.3)]
    ratio = only(ratios_of(runs), "splinebba adjust, whole process", "Ceres vp, whole process")
    assert ratio.median == pytest.approx(4.5 / 1.6)
    assert ratio.reached
