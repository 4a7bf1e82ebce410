"""A block of the benchmark written as a project loads to the network that the archive itself gives."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

from benchmarks.bench_block import network_from_npz
from benchmarks.bench_project import write_project
from splinebba_cli.core.network import Network
from splinebba_cli.project.loading import load_project

IMAGES, SPLINES, KNOTS, POINTS = 100, 300, 5, 40


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Arrays of the generator's names and shapes; every feature in several images, every twentieth spline fixed."""
    rng = np.random.default_rng(7)
    eop = np.column_stack([rng.normal(0, 0.02, (IMAGES, 3)), rng.uniform(0, 2e4, (IMAGES, 3))])
    seen = np.column_stack([np.tile(np.arange(SPLINES), 20), rng.integers(0, IMAGES, 20 * SPLINES)])
    ties = np.column_stack([np.repeat(np.arange(POINTS), 5), np.tile(np.arange(IMAGES), 2)])
    path = tmp_path_factory.mktemp("block") / "block.npz"
    np.savez(
        path,
        f=153.0,
        sigma=0.005,
        eop0=eop,
        eop_prior=eop + rng.normal(0, 1e-4, eop.shape),
        eop_sigma=np.array([1e-4] * 3 + [0.1] * 3),
        knots0=rng.uniform(0, 2e4, (SPLINES, KNOTS, 3)),
        knot_sigma=2.0,
        fixed=np.arange(SPLINES) % 20 == 3,
        img=seen[:, 1].astype(np.int32),
        spl=seen[:, 0].astype(np.int32),
        seg=rng.integers(0, KNOTS - 1, len(seen)).astype(np.int32),
        t0=rng.uniform(0, 1, len(seen)),
        xy=rng.uniform(-115, 115, (len(seen), 2)),
        tie_img=ties[:, 1].astype(np.int32),
        tie_pt=ties[:, 0].astype(np.int32),
        tie_xy=rng.uniform(-115, 115, (len(ties), 2)),
        tie0=rng.uniform(0, 2e4, (POINTS, 3)),
    )
    return path


@pytest.mark.parametrize("fmt", ["csv", "parquet"])
def test_it_is_the_same_network(archive: Path, fmt: Literal["csv", "parquet"], tmp_path: Path) -> None:
    expected = network_from_npz(archive)
    found = load_project(write_project(archive, tmp_path, fmt)).network
    assert (found.origin == 0.0).all()
    _same(found.images, expected.images, "ids", "camera", "rotation", "position", "prior", "prior_sigma")
    _same(found.points, expected.points, "ids", "role", "xyz", "sigma")
    _same(found.point_observations, expected.point_observations, "image", "point", "photo_xy", "sigma")
    _same(found.curve_observations, expected.curve_observations, "image", "photo_xy", "sigma", "location")
    _same_curves(found, expected)


def _same_curves(found: Network, expected: Network) -> None:
    """The same splines, the fixed ones first."""
    place = {curve.id: number for number, curve in enumerate(found.curves)}
    assert len(place) == len(expected.curves)
    assert [c.role for c in found.curves] == ["control"] * 15 + ["partial"] * 285
    for curve in expected.curves:
        _same(found.curves[place[curve.id]], curve, "role", "family", "values", "sigma", "parameterization")
    order = np.array([place[curve.id] for curve in expected.curves])
    np.testing.assert_array_equal(found.curve_observations.curve, order[expected.curve_observations.curve])


def _same(found: Any, expected: Any, *names: str) -> None:
    for name in names:
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), err_msg=name)
