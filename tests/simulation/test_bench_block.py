"""The benchmark's archive becomes a network with the same frames, parameters and weights."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from benchmarks.bench_block import network_from_npz
from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import FloatArray


def peer_projection(eop: FloatArray, xyz: FloatArray) -> FloatArray:
    """The benchmark's model, M = M_kappa M_phi M_omega, written down independently."""
    (so, sp, sk), (co, cp, ck) = np.sin(eop[:3]), np.cos(eop[:3])
    omega = np.array([[1, 0, 0], [0, co, so], [0, -so, co]])
    phi = np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])
    kappa = np.array([[ck, sk, 0], [-sk, ck, 0], [0, 0, 1]])
    p = (xyz - eop[3:]) @ (kappa @ phi @ omega).T
    return np.asarray(-153.0 * p[:, :2] / p[:, 2:])


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    """Two images, two splines of five knots (the second fixed), two tie points; no noise."""
    rng = np.random.default_rng(1)
    eop = np.array([[0.02, -0.03, 0.4, 0.0, 0.0, 1500.0], [-0.01, 0.05, 3.0, 600.0, 20.0, 1520.0]])
    knots = rng.uniform(0.0, 400.0, (2, 5, 3)) * [1.0, 1.0, 0.1]
    image, spline, segment = np.repeat([0, 1], 8), np.tile(np.repeat([0, 1], 4), 2), np.tile([0, 1, 2, 3], 4)
    t = rng.uniform(0.0, 1.0, 16)
    xyz = np.array(
        [
            CubicSpline(np.arange(5), knots[s], bc_type="natural")(u)
            for s, u in zip(spline, segment + t, strict=True)
        ]
    )
    ties = rng.uniform(0.0, 300.0, (2, 3))
    np.savez(
        tmp_path / "out.npz",
        f=153.0,
        sigma=0.005,
        eop0=eop,
        eop_prior=eop + 0.01,
        eop_sigma=np.array([1e-4] * 3 + [0.1] * 3),
        knots0=knots,
        knot_sigma=2.0,
        fixed=np.array([False, True]),
        img=image.astype(np.int32),
        spl=spline.astype(np.int32),
        seg=segment.astype(np.int32),
        xy=np.array([peer_projection(eop[i], x[None])[0] for i, x in zip(image, xyz, strict=True)]),
        t0=t,
        tie_img=np.array([0, 1, 0, 1], dtype=np.int32),
        tie_pt=np.array([0, 0, 1, 1], dtype=np.int32),
        tie_xy=np.vstack([peer_projection(eop[i], ties[p : p + 1]) for p in (0, 1) for i in (0, 1)]),
        tie0=ties,
    )
    return tmp_path / "out.npz"


def test_the_network_reproduces_the_measurements(archive: Path) -> None:
    network = network_from_npz(archive)
    seen, points, images = network.curve_observations, network.point_observations, network.images
    xyz = np.empty((len(seen), 3))
    for index, curve in enumerate(network.curves):
        basis, rows = basis_of(curve), seen.curve == index
        xyz[rows] = basis.evaluate(seen.location[rows], basis.coefficients_from_values(curve.values))
    image = np.concatenate([seen.image, points.image])
    xyz = np.vstack([xyz, network.points.xyz[points.point]])
    c = np.full(len(image), 153.0)
    computed = project(c, images.rotation[image], images.position[image], xyz)
    np.testing.assert_allclose(computed, np.vstack([seen.photo_xy, points.photo_xy]), atol=1e-10)


def test_weights_and_roles(archive: Path) -> None:
    network = network_from_npz(archive)
    assert [curve.role for curve in network.curves] == ["partial", "control"]
    assert (network.curves[0].sigma == 2.0).all() and (network.curves[1].sigma == 0.0).all()
    np.testing.assert_array_equal(network.images.prior_sigma[1], [1e-4] * 3 + [0.1] * 3)
    np.testing.assert_allclose(network.images.prior[0, 3:], [0.01, 0.01, 1500.01])
    assert (network.curve_observations.sigma == 0.005).all()
