"""Readers of the reference data that tests are held against; the data themselves are not part of the project.

They are looked for under ``$SPLINEBBA_REFERENCE_DATA`` and at ``../shared/reference`` beside the repository;
:func:`reference_dir` skips the test where neither exists.

Sources: Strasbourg points from DBAT 0.9.2 (Börlin & Grussenmeyer), curves traced in the same images; vase
from the Vase multiview 3D curve data set (Usumezbas, Fabbri & Kimia, ECCV 2016; images: DTU robot data set
40).
"""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from splinebba_cli.core.approximation.intersection import intersect_points
from splinebba_cli.core.camera.distortion import corrected_photo_xy
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_object_from_photo
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    Network,
    PointObservations,
    Points,
    Role,
    RotationSequence,
)

STRASBOURG_ORIGIN = np.array([1_000_000.0, 112_000.0, 0.0])
STRASBOURG_PIXEL_MM = 0.006
STRASBOURG_SIZE = (8858, 12996)
STRASBOURG_CHECKS = ("351", "410")
VASE_PIXEL_MM = 0.00465  # nominal; the scale of the photo frame, without influence on the object
VASE_SIZE = (1600, 1200)


def reference_dir() -> Path:
    """The folder of the reference data; skips the calling test where it is absent."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "reference"
    folder = Path(os.environ.get("SPLINEBBA_REFERENCE_DATA", beside))
    if not folder.is_dir():
        pytest.skip(
            f"reference data not found at {folder} (set SPLINEBBA_REFERENCE_DATA)", allow_module_level=True
        )
    return folder


def _dbat_table(path: Path) -> list[list[str]]:
    """Rows of a DBAT text table: comma separated, comments begin with #."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return [[cell.strip() for cell in line.split(",")] for line in lines if line.strip() and line[0] != "#"]


def _csv_table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@dataclass(frozen=True)
class StrasbourgReport:
    """The adjusted values that DBAT printed; angles in degrees, positions in metres of the user's frame."""

    ids: tuple[str, ...]
    eop: FloatArray  # (5, 6) omega, phi, kappa (deg), X0, Y0, Z0 (m)
    sigma: FloatArray  # (5, 6) already scaled by sigma0
    sigma0: float
    redundancy: int
    observations: int
    unknowns: int


def strasbourg_report() -> StrasbourgReport:
    """What DBAT 0.9.2 found on the points of Strasbourg (result/report.txt)."""
    text = (reference_dir() / "strasbourg_aerial/points/result/report.txt").read_text(encoding="utf-8")

    def number(pattern: str) -> float:
        found = re.search(pattern, text)
        assert found is not None, pattern
        return float(found.group(1))

    stations = text.split("Photograph Standard Deviations:")[1].split("\n   Quality")[0]
    values = [float(v) for v in re.findall(r"Value:\s+(\S+)", stations)]
    sigmas = [float(v) for v in re.findall(r"Deviation:\s+(\S+)", stations)]
    return StrasbourgReport(
        ids=tuple(re.findall(r"Photo \d+: (\d+)\.jpg", stations)),
        eop=np.array(values).reshape(5, 6),
        sigma=np.array(sigmas).reshape(5, 6),
        sigma0=number(r"Sigma0:\s+(\S+)"),
        redundancy=int(number(r"Redundancy\s+(\d+)")),
        observations=int(number(r"Number of observations: (\d+)")),
        unknowns=int(number(r"Number of params:\s+(\d+)")),
    )


def strasbourg_photo_xy(pixel: FloatArray, first: float = 1.0) -> FloatArray:
    """Photo coordinates (mm, origin at the centre of the format) of pixel coordinates.

    Parameters
    ----------
    pixel : (n, 2) float, column and row
    first : coordinate of the centre of the first pixel: 1 for DBAT's point tables, see also
        :data:`STRASBOURG_CURVE_FIRST_PIXEL`
    """
    width, height = STRASBOURG_SIZE
    x = STRASBOURG_PIXEL_MM * (pixel[:, 0] - first - (width - 1) / 2)
    y = STRASBOURG_PIXEL_MM * ((height - 1) / 2 - (pixel[:, 1] - first))
    return np.column_stack([x, y])


def _strasbourg_camera() -> Camera:
    width, height = STRASBOURG_SIZE
    centre = STRASBOURG_PIXEL_MM * (np.array(STRASBOURG_SIZE) + 1) / 2  # DBAT's frame, pixel (1, 1) first
    return Camera(
        id="aerial",
        principal_distance_mm=123.9392,
        principal_point_mm=np.array([26.5770 - centre[0], centre[1] - 38.8110]),
        radial=np.zeros(3),
        decentring=np.zeros(2),
        affinity=np.zeros(2),
        pixel_size_mm=STRASBOURG_PIXEL_MM,
        format_mm=(width * STRASBOURG_PIXEL_MM, height * STRASBOURG_PIXEL_MM),
    )


def _strasbourg_points(folder: Path, ids: list[str]) -> Points:
    given = {row[0]: row for row in _dbat_table(folder / "reference/sxb-control.txt")}
    xyz = np.full((len(ids), 3), np.nan)
    sigma = np.full((len(ids), 3), np.inf)
    check_sigma = np.full((len(ids), 3), np.nan)
    roles: list[Role] = []
    for i, id in enumerate(ids):
        if id not in given:
            roles.append("tie")
            continue
        xyz[i] = np.array(given[id][2:5], dtype=float) - STRASBOURG_ORIGIN
        target = check_sigma if id in STRASBOURG_CHECKS else sigma
        target[i] = np.array(given[id][5:8], dtype=float)
        roles.append("check" if id in STRASBOURG_CHECKS else "control")
    return Points(tuple(ids), tuple(roles), xyz, sigma, check_sigma)


def omega_phi_kappa(count: int) -> tuple[RotationSequence, ...]:
    """The rotation sequence of `count` images."""
    one: RotationSequence = "omega-phi-kappa"
    return (one,) * count


def _free_images(ids: tuple[str, ...], camera: list[int]) -> Images:
    count = len(ids)
    return Images(
        ids=ids,
        camera=np.array(camera, dtype=np.int64),
        rotation=np.full((count, 3, 3), np.nan),
        position=np.full((count, 3), np.nan),
        sequence=omega_phi_kappa(count),
        prior=np.full((count, 6), np.nan),
        prior_sigma=np.full((count, 6), np.inf),
    )


def no_curve_observations() -> CurveObservations:
    """An empty group."""
    whole = np.zeros(0, dtype=np.int64)
    return CurveObservations(whole, whole, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), whole)


def no_points() -> tuple[Points, PointObservations]:
    """No points, and no observations of them."""
    whole, three = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    return Points((), (), three, three, three), PointObservations(
        whole, whole, np.zeros((0, 2)), np.zeros((0, 2))
    )


def strasbourg_points_network(approximate: bool) -> Network:
    """381 points in five images (1196 image points); check points 351 and 410; origin (1000000, 112000, 0).

    Parameters
    ----------
    approximate : whether to give approximate values: the exterior orientations of DBAT's report, and tie
        points intersected from them.  Without, they are NaN.
    """
    folder = reference_dir() / "strasbourg_aerial/points"
    images = [(row[0], Path(row[1]).stem) for row in _dbat_table(folder / "images/images.txt")]
    image_index = {row[0]: i for i, row in enumerate(images)}
    rows = [(row, 0.5) for row in _dbat_table(folder / "measurements/markpts.txt")]
    rows += [(row, 1.0) for row in _dbat_table(folder / "measurements/smartpts.txt")]
    ids = sorted({row[0] for row, _ in rows}, key=int)
    index = {id: i for i, id in enumerate(ids)}
    pixel = np.array([[float(row[2]), float(row[3])] for row, _ in rows])
    sigma_mm = STRASBOURG_PIXEL_MM * np.array([sigma for _, sigma in rows])
    network = Network(
        origin=STRASBOURG_ORIGIN,
        cameras=(_strasbourg_camera(),),
        images=_free_images(tuple(id for _, id in images), [0] * len(images)),
        points=_strasbourg_points(folder, ids),
        curves=(),
        point_observations=PointObservations(
            image=np.array([image_index[row[1]] for row, _ in rows], dtype=np.int64),
            point=np.array([index[row[0]] for row, _ in rows], dtype=np.int64),
            photo_xy=strasbourg_photo_xy(pixel),
            sigma=np.column_stack([sigma_mm, sigma_mm]),
        ),
        curve_observations=no_curve_observations(),
    )
    if not approximate:
        return network
    return _with_tie_points(with_orientation(network, *strasbourg_orientation(strasbourg_report().eop)))


def strasbourg_orientation(eop_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotations (m, 3, 3) and local positions (m, 3) of omega, phi, kappa (deg), X0, Y0, Z0 (user frame)."""
    return rotation_object_from_photo(np.radians(eop_deg[:, :3])), eop_deg[:, 3:] - STRASBOURG_ORIGIN


def with_orientation(network: Network, rotation: FloatArray, position: FloatArray) -> Network:
    """The network with other approximate exterior orientations."""
    return replace(network, images=replace(network.images, rotation=rotation, position=position))


def _with_tie_points(network: Network) -> Network:
    seen, images = network.point_observations, network.images
    found = intersect_points(
        seen.point,
        len(network.points.ids),
        np.array([camera.principal_distance_mm for camera in network.cameras])[images.camera[seen.image]],
        corrected_photo_xy(network.cameras[0], seen.photo_xy)[0],
        images.rotation[seen.image],
        images.position[seen.image],
    )
    xyz = np.where(np.isfinite(network.points.xyz), network.points.xyz, found.xyz)
    return replace(network, points=replace(network.points, xyz=xyz))


# Centre of the first pixel in curve_obs.csv.  Not documented: with (1, 1) the reference curves seen with
# eo.csv leave 0.669 px RMS and a mean shift of (0.07, -0.12) px, with (0, 0) 1.133 px and (1.07, -1.11) px.
STRASBOURG_CURVE_FIRST_PIXEL = 1.0

Parameters = Literal["given", "chord_length"]


def strasbourg_curves_network(
    approximate: bool = True,
    points: bool = True,
    sigma_px: float = 0.7,
    fixed_images: bool = False,
    parameters: Parameters = "given",
) -> Network:
    """The 30 traced curves (5 727 edge points) as tie splines, with or without the points.

    Parameters
    ----------
    approximate : whether exterior orientations (curves/eo.csv: those of DBAT's report) are given
    points : whether the 381 points take part
    sigma_px : standard deviation of an edge point in x and in y
    fixed_images : whether the exterior orientations are held fixed
    parameters : "given": the column s_m, with which the reference splines were fitted (0.67 px RMS across);
        "chord_length": other curves through the same knots (3.1 px RMS, the knots are spaced unevenly)
    """
    folder = reference_dir() / "strasbourg_aerial/curves"
    network = strasbourg_points_network(approximate)
    rows = _csv_table(folder / "curve_obs.csv")
    pixel = np.array([[float(row["x_px"]), float(row["y_px"])] for row in rows])
    curves, observations = _curves(
        rows,
        _csv_table(folder / "curves_ref.csv"),
        ("X", "Y", "Z"),
        STRASBOURG_ORIGIN,
        network.images.ids,
        strasbourg_photo_xy(pixel, STRASBOURG_CURVE_FIRST_PIXEL),
        sigma_px * STRASBOURG_PIXEL_MM,
        parameters,
    )
    network = replace(network, curves=curves, curve_observations=observations)
    if approximate:
        eo = {row["image"]: row for row in _csv_table(folder / "eo.csv")}
        names = ("omega_deg", "phi_deg", "kappa_deg", "Xc", "Yc", "Zc")
        eop = np.array([[float(eo[id][name]) for name in names] for id in network.images.ids])
        network = with_orientation(network, *strasbourg_orientation(eop))
        if fixed_images:
            network = with_fixed_images(network)
    if not points:
        empty, none = no_points()
        network = replace(network, points=empty, point_observations=none)
    return network


def with_fixed_images(network: Network) -> Network:
    """The network with its exterior orientations held fixed at their approximate values."""
    images = network.images
    prior = np.column_stack([angles_from_rotation(images.rotation), images.position])
    return replace(network, images=replace(images, prior=prior, prior_sigma=np.zeros_like(prior)))


def _curves(
    rows: list[dict[str, str]],
    reference: list[dict[str, str]],
    columns: tuple[str, str, str],
    origin: FloatArray,
    image_ids: tuple[str, ...],
    photo_xy: FloatArray,
    sigma_mm: float,
    parameters: Parameters,
) -> tuple[tuple[Curve, ...], CurveObservations]:
    """Tie splines through the reference knots, and the measured edge points."""
    knots: dict[str, list[list[float]]] = {}
    for row in reference:
        knots.setdefault(row["curve"], []).append([float(row[name]) for name in ("s_m", *columns)])
    ids = list(knots)
    curves = []
    for id in ids:
        table = np.array(knots[id])
        given = table[:, 0] if parameters == "given" else None
        free = np.full((len(table), 3), np.inf)
        curves.append(Curve(id, "tie", "natural_cubic", table[:, 1:] - origin, free, knot_parameters=given))
    image = np.array([image_ids.index(row["image"]) for row in rows], dtype=np.int64)
    observations = CurveObservations(
        image=image,
        curve=np.array([ids.index(row["curve"]) for row in rows], dtype=np.int64),
        photo_xy=photo_xy,
        sigma=np.full((len(rows), 2), sigma_mm),
        location=np.full(len(rows), np.nan),
        segment=np.full(len(rows), -1, dtype=np.int64),
    )
    return tuple(curves), observations


def vase_network(parameters: Parameters = "given") -> Network:
    """12 tie splines in 19 close-range images with known, fixed cameras; metres; sigma 0.5 px.

    Computer-vision frame (looking along +z, y down) to ours: p = diag(1, -1, -1) R_cv (X - C).  With
    c = pixel f_y, the scale of x becomes the affinity b1 = f_y / f_x - 1 (corrected = measured + b1 x).  The
    reference curves leave 0.495 px RMS with their own parameters s_m, 0.549 px with chord lengths.
    """
    folder = reference_dir() / "vase"
    rows = _csv_table(folder / "cameras.csv")
    cameras = tuple(_vase_camera(row) for row in rows)
    ids = tuple(row["image"] for row in rows)
    axes = np.array([[[float(row[f"r{i}{j}"]) for j in (1, 2, 3)] for i in (1, 2, 3)] for row in rows])
    rotation = np.swapaxes(axes, 1, 2) @ np.diag([1.0, -1.0, -1.0])
    position = np.array([[float(row[name]) for name in ("Cx_m", "Cy_m", "Cz_m")] for row in rows])
    observed = _csv_table(folder / "obs.csv")
    pixel = np.array([[float(row["x_px"]), float(row["y_px"])] for row in observed])
    half = (np.array(VASE_SIZE) - 1.0) / 2.0
    curves, observations = _curves(
        observed,
        _csv_table(folder / "curves_ref.csv"),
        ("X_m", "Y_m", "Z_m"),
        np.zeros(3),
        ids,
        VASE_PIXEL_MM * (pixel - half) * np.array([1.0, -1.0]),
        0.5 * VASE_PIXEL_MM,
        parameters,
    )
    points, none = no_points()
    images = replace(_free_images(ids, list(range(len(ids)))), rotation=rotation, position=position)
    network = Network(np.zeros(3), cameras, images, points, curves, none, observations)
    return with_fixed_images(network)


def _vase_camera(row: dict[str, str]) -> Camera:
    fx, fy, cx, cy = (float(row[name]) for name in ("fx", "fy", "cx", "cy"))
    width, height = VASE_SIZE
    centre = np.array([cx - (width - 1) / 2, (height - 1) / 2 - cy])
    return Camera(
        id=row["image"],
        principal_distance_mm=VASE_PIXEL_MM * fy,
        principal_point_mm=VASE_PIXEL_MM * centre,
        radial=np.zeros(3),
        decentring=np.zeros(2),
        affinity=np.array([fy / fx - 1.0, 0.0]),
        pixel_size_mm=VASE_PIXEL_MM,
        format_mm=(VASE_PIXEL_MM * width, VASE_PIXEL_MM * height),
    )


def vase_scan() -> FloatArray:
    """Structured-light scan of the edges of the vase, (n, 3) metres (systematic offset about 0.55 mm)."""
    return np.atleast_2d(np.loadtxt(reference_dir() / "vase/vase-edge-gt3-017.txt.gz"))
