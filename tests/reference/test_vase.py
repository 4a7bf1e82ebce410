"""Vase: 12 edge curves in 19 photographs with known cameras, against a structured-light scan.

Vase multiview 3D curve data set (Usumezbas, Fabbri, Kimia, ECCV 2016), traced curves and scan as in
reference/README.md.  The scan has a systematic offset of about 0.55 mm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import KnotPolicy
from splinebba_cli.core.result import AdjustmentResult
from tests.reference_data import reference_dir, vase_network, vase_scan

pytestmark = pytest.mark.skipif(
    not (reference_dir() / "vase").is_dir(), reason="reference data are not there"
)
WELL_DETERMINED_M = 0.0003


@pytest.fixture(scope="module")
def result() -> AdjustmentResult:
    network = vase_network()
    settings = replace(network.settings, knots=KnotPolicy(spacing_m=0.006, drop=True))
    return adjust(replace(network, settings=settings))


def test_residuals_across_the_curves(result: AdjustmentResult) -> None:
    pixel = result.network.cameras[0].pixel_size_mm
    assert pixel is not None
    assert np.sqrt(np.mean(result.curve_residuals.across**2)) / pixel <= 0.505


def test_distance_to_the_scan_where_depth_is_determined(result: AdjustmentResult) -> None:
    tree = cKDTree(vase_scan())
    for curve in result.curves:
        good = curve.sample_across[:, 0] < WELL_DETERMINED_M
        distance = tree.query(curve.sample_xyz[good])[0]
        assert 0.0003 < np.median(distance) < 0.0010
    everything = np.vstack([curve.sample_xyz for curve in result.curves])
    good = np.concatenate([curve.sample_across[:, 0] for curve in result.curves]) < WELL_DETERMINED_M
    assert 0.0004 <= np.median(tree.query(everything[good])[0]) <= 0.0009


def test_parts_without_depth_are_named(result: AdjustmentResult) -> None:
    """The cameras stand on one arc: curves that run along it have little depth; five are named, the others counted."""
    named = [problem for problem in result.problems if problem.code == "SBB533"]
    assert len({problem.subject for problem in named}) == 5
    (more,) = [problem.message for problem in named if "more)" in problem.message]
    assert int(more.split("(and ")[1].split(" ")[0]) >= 1
