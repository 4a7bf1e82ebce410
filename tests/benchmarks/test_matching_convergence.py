"""One run of the study of convergence: Lee's block, 30 % wrong chains, orientations off by 10 m and 2 degrees."""

from __future__ import annotations

from benchmarks.convergence_radius import six_image_run


def test_six_images_come_back_from_far_off() -> None:
    run = six_image_run(1, 10.0, 2.0, 0.3)
    assert run.converged == 1.0
    assert run.right > 0.99
    assert run.wrong < 0.002
    assert run.foreign < 0.05
