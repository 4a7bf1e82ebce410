"""Reader of the synthetic multiview curve data: 39 analytic curves in 20 turntable views, x = K R (X - C).

Lines, circles, ellipses, helices and a saddle, 5117 points, seen in all views (hidden parts too), the camera about a
thousand units away: one unit is taken as a millimetre.  Source: Fabbri & Kimia, Multiview differential geometry of
curves, IJCV 117, 2016, CC-BY.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
)
from tests.reference_data import no_points, omega_phi_kappa, reference_dir

VIEWS = 20
SIZE = (500, 400)
PIXEL_MM = 0.005  # nominal; the scale of the photo frame, without influence on the object
UNIT_M = 1e-3
EVERY = 2  # points of a curve between two knots
SHORTEST = 15  # points of a curve that is used: marks of the axes are shorter


@dataclass(frozen=True)
class SyntheticCurves:
    """Curves with their exact projections; one row a point."""

    curve: IntArray  # (n,)
    xyz: FloatArray  # (n, 3) metres
    tangent: FloatArray  # (n, 3) unit
    pixel: FloatArray  # (views, n, 2) column, row; the centre of the first pixel is (0, 0)
    rotation: FloatArray  # (views, 3, 3) object from photo
    position: FloatArray  # (views, 3) metres
    camera: Camera


def synthetic_curves() -> SyntheticCurves:
    """The data as they are."""
    folder = reference_dir() / "synthcurves/turntable20"
    matrix = np.loadtxt(folder / "calib.intrinsic")
    poses = [_pose(folder / f"frame_{view:04d}.extrinsic") for view in range(VIEWS)]
    return SyntheticCurves(
        curve=np.loadtxt(folder / "crv-ids.txt").astype(np.int64),
        xyz=UNIT_M * np.loadtxt(folder / "crv-3D-pts.txt.gz"),
        tangent=np.loadtxt(folder / "crv-3D-tgts.txt.gz"),
        pixel=np.array([np.loadtxt(folder / f"frame_{view:04d}-pts-2D.txt.gz") for view in range(VIEWS)]),
        rotation=np.array([rotation for rotation, _ in poses]),
        position=np.array([position for _, position in poses]),
        camera=_camera(matrix),
    )


def _pose(path: Path) -> tuple[FloatArray, FloatArray]:
    """R (object from photo) and X0 of a view: rows of the file are camera axes, the camera looks along +z, y down."""
    table = np.loadtxt(path)
    return table[:3].T @ np.diag([1.0, -1.0, -1.0]), UNIT_M * table[3]


def _camera(matrix: FloatArray) -> Camera:
    width, height = SIZE
    fx, fy, cx, cy = matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]
    return Camera(
        id="turntable",
        principal_distance_mm=PIXEL_MM * fy,
        principal_point_mm=PIXEL_MM * np.array([cx - (width - 1) / 2, (height - 1) / 2 - cy]),
        radial=np.zeros(3),
        decentring=np.zeros(2),
        affinity=np.array([fy / fx - 1.0, 0.0]),
        pixel_size_mm=PIXEL_MM,
        format_mm=(PIXEL_MM * width, PIXEL_MM * height),
    )


def photo_xy(pixel: FloatArray) -> FloatArray:
    """Photo coordinates (..., 2) mm of pixels, about the centre of the format."""
    return np.asarray(PIXEL_MM * (pixel - (np.array(SIZE) - 1.0) / 2.0) * np.array([1.0, -1.0]))


def _cubics(xyz: FloatArray) -> Curve:
    """A control curve of cubic segments through every other point, without conditions at its ends."""
    knots = np.unique(np.append(np.arange(0, len(xyz), EVERY), len(xyz) - 1))
    place = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz[knots], axis=0), axis=1))])
    spline = CubicSpline(place, xyz[knots], bc_type="not-a-knot")
    length = np.diff(place)
    values = np.stack([spline.c[3 - k] * length[:, None] ** k for k in range(4)], axis=1).reshape(-1, 3)
    return Curve(
        id="", role="control", family="polynomial_3", values=values, sigma=np.zeros_like(values),
        knot_parameters=place,
    )  # fmt: skip


def synthetic_network(views: list[int], every: int = 1, sigma_px: float = 0.5) -> Network:
    """Views before control curves of known shape, with exact measurements and orientations.

    Parameters
    ----------
    every : which points of the curves are measured
    sigma_px : stated standard deviation
    """
    data = synthetic_curves()
    count = np.bincount(data.curve)
    numbers = np.flatnonzero(count >= SHORTEST)
    curves = tuple(
        replace(_cubics(data.xyz[data.curve == number]), id=f"curve-{number}") for number in numbers
    )
    index = np.full(len(count), -1)
    index[numbers] = np.arange(len(numbers))
    points = np.flatnonzero(index[data.curve] >= 0)[::every]
    total = len(points) * len(views)
    images = Images(
        ids=tuple(f"view-{view}" for view in views),
        camera=np.zeros(len(views), dtype=np.int64),
        rotation=data.rotation[views],
        position=data.position[views],
        sequence=omega_phi_kappa(len(views)),
        prior=np.full((len(views), 6), np.nan),
        prior_sigma=np.full((len(views), 6), np.inf),
    )
    observed = CurveObservations(
        image=np.repeat(np.arange(len(views)), len(points)),
        curve=np.tile(index[data.curve[points]], len(views)),
        photo_xy=photo_xy(data.pixel[views][:, points]).reshape(-1, 2),
        sigma=np.full((total, 2), sigma_px * PIXEL_MM),
        location=np.full(total, np.nan),
        segment=np.full(total, -1),
    )
    none, no_observations = no_points()
    return Network(np.zeros(3), (data.camera,), images, none, curves, no_observations, observed)
