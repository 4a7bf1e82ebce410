"""Real and synthetic views of which nothing is known, oriented from chains among which 30 % are wrong.

Curves: Fabbri & Kimia, IJCV 2016 (CC-BY); 30 edges in aerial images of Strasbourg (reference/README.md).  All images
and more runs: ``python -m benchmarks.free_orientation``.
"""

from __future__ import annotations

import pytest

from benchmarks.free_orientation import outcomes, strasbourg
from benchmarks.free_orientation_scenes import synthetic_curves
from tests.reference_data import reference_dir


@pytest.mark.parametrize("image", [0, 4])
def test_strasbourg(image: int) -> None:
    """Within three standard deviations of the given orientation: 0.03 degrees across the view, 1 m of 1.8 km."""
    (found,) = outcomes(strasbourg(1, wrong_share=0.3), 1770.0, 1, [image])
    assert found.code == ""
    assert found.angle_deg < 0.09
    assert found.position_share < 0.0017


def test_synthetic_curves() -> None:
    """Frame 1, half a pixel of noise; standard deviations are 0.009 degrees and 0.3 mm of 1.13 m."""
    folder = reference_dir() / "synthcurves/turntable20"
    (found,) = outcomes(synthetic_curves(folder, 1), 1.13, 1, [1])
    assert found.code == ""
    assert found.angle_deg < 0.05
    assert found.position_share < 0.001
