"""Made-up adjustment results of any size: plausible figures, not adjusted ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.evidence import Evidence
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    Images,
    Network,
    PointObservations,
    Points,
)
from splinebba_cli.core.prior_residuals import PriorResidual, PriorResiduals
from splinebba_cli.core.quality.reliability import local_tests_of, reliability
from splinebba_cli.core.result import (
    AdjustmentResult,
    CheckPoint,
    Checks,
    CheckSpline,
    CurveResult,
    DispersionBlocks,
    GlobalTest,
    ImageResult,
    Iteration,
    PointResult,
    Problem,
    ResidualTable,
    SegmentCoefficients,
    Statistics,
)
from splinebba_cli.output.dispersion_file import dispersion_arrays
from splinebba_cli.output.result_folder import Written, reserve_result_folder, write_result_folder
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.output.tables import all_tables
from splinebba_cli.report.build import write_reports
from splinebba_cli.report.result_data import ResultData

ORIGIN = np.array([572_000.0, 5_378_000.0, 100.0])
HEIGHT = 750.0


@dataclass
class Loaded:
    """Stands in for a loaded project."""

    path: Path = Path("block/project.yaml")
    name: str = "Six images & <two> splines"
    source_hashes: dict[str, str] = field(
        default_factory=lambda: {"block/project.yaml": "ab" * 32, "block/points.csv": "cd" * 32}
    )


def write_results(
    folder: Path,
    result: AdjustmentResult,
    *,
    loaded: Loaded | None = None,
    adjusted_files: Mapping[str, str] | None = None,
    html: bool = True,
    **options: Any,
) -> None:
    """Write a result folder with its reports, as the command `adjust` does."""
    with reserve_result_folder(folder) as place:
        write_result_folder(
            place,
            result,
            loaded=loaded or Loaded(),
            adjusted_files=adjusted_files or {},
            reports=lambda new, written: write_reports(
                new, ResultData.of(written), ["text", "html"] if html else ["text"]
            ),
            **options,
        )


def report_data(result: AdjustmentResult, *, full: bool = False) -> ResultData:
    """What a report is made from, without a folder."""
    arrays = dispersion_arrays(result, full=full)
    return ResultData.of(Written(result_to_dict(result), all_tables(result), arrays))


def _covariances(rng: np.random.Generator, sigma: np.ndarray, count: int) -> np.ndarray:
    """Random covariances (count, k, k) with about the given standard deviations."""
    k = len(sigma)
    factor = np.eye(k) + 0.35 * rng.standard_normal((count, k, k))
    return np.einsum("nij,nkj->nik", factor, factor) * np.outer(sigma, sigma)


def _images(rng: np.random.Generator, count: int) -> tuple[Images, ImageResult]:
    columns = max(1, int(np.ceil(np.sqrt(count))))
    grid = np.stack([np.arange(count) % columns, np.arange(count) // columns], axis=1) * 450.0
    position = np.column_stack([grid, np.full(count, HEIGHT)]) + rng.normal(0, 8, (count, 3)) + ORIGIN
    angles = rng.normal(0, 0.02, (count, 3))
    rotation = rotation_object_from_photo(angles)
    eop = np.column_stack([angles, position])
    dispersion = _covariances(rng, np.array([2e-5, 2e-5, 8e-6, 0.02, 0.02, 0.012]), count)
    if count > 1:  # one pair that cannot be told apart
        s = np.sqrt(np.diagonal(dispersion[1]))
        dispersion[1, 0, 4] = dispersion[1, 4, 0] = -0.983 * s[0] * s[4]
    ids = tuple(f"{762 + i}" for i in range(count))
    images = Images(
        ids=ids,
        camera=np.zeros(count, dtype=np.int64),
        rotation=rotation,
        position=position - ORIGIN,
        sequence=("omega-phi-kappa",) * count,
        prior=np.full((count, 6), np.nan),
        prior_sigma=np.full((count, 6), np.inf),
    )
    return images, ImageResult(eop, rotation, dispersion, np.ones((count, 6), dtype=bool))


def _curve(rng: np.random.Generator, number: int, extent: float, knots: int) -> tuple[Curve, CurveResult]:
    start = rng.uniform(0.05, 0.6, 2) * extent
    u = np.arange(knots, dtype=float)
    heading = rng.uniform(0, 2 * np.pi)
    along, wave = u * 0.35 * extent / knots, 0.03 * extent * np.sin(u * 1.1 + number)
    xyz = np.column_stack(
        [
            start[0] + along * np.cos(heading) - wave * np.sin(heading),
            start[1] + along * np.sin(heading) + wave * np.cos(heading),
            12 + 4 * np.sin(0.6 * u + number) + 0.5 * u,
        ]
    )
    spline = CubicSpline(u, xyz + ORIGIN, bc_type="natural")
    sample_u = np.linspace(0, knots - 1, 12 * (knots - 1) + 1)
    major = 0.012 + 0.01 * (1 + np.cos(2 * np.pi * sample_u / (knots - 1)))
    tangent = spline(sample_u, 1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    up = np.array([0.0, 0.0, 1.0]) - tangent * tangent[:, 2:]
    role = ("tie", "control", "partial", "check")[number % 4]
    values = xyz + ORIGIN
    curve = Curve(
        id=f"kerb-{number + 1}",
        role=role,
        family="natural_spline",
        values=xyz,
        sigma=np.full((knots, 3), np.inf),
    )
    covariance = _covariances(rng, np.array([0.03, 0.03, 0.02]), knots)
    segments = SegmentCoefficients(
        interval=np.column_stack([u[:-1], u[1:]]),
        coefficients=np.transpose(spline.c[::-1], (1, 0, 2)),
        sigma=np.full((knots - 1, 4, 3), 0.02),
    )
    return curve, CurveResult(
        values=values,
        values_dispersion=covariance,
        knots=values,
        knot_parameters=u,
        knot_sigma=np.sqrt(np.einsum("nii->ni", covariance)),
        reference=values,
        segments=segments,
        sample_u=sample_u,
        sample_xyz=spline(sample_u),
        sample_across=np.column_stack([major, 0.5 * major]),
        sample_across_direction=up / np.linalg.norm(up, axis=1)[:, None],
        sigma_across_max=float(major.max()),
        sigma_across_mean=float(major.mean()),
        rms_across_mm=0.006,
        n_observations=30,
        n_images=3,
        along_sigma=np.full(knots, 0.4),
    )


def _points(rng: np.random.Generator, count: int, extent: float) -> tuple[Points, PointResult]:
    xyz = np.column_stack([rng.uniform(0, extent, (count, 2)), rng.uniform(0, 20, count)])
    roles = tuple(("control", "tie", "tie", "check", "tie")[i % 5] for i in range(count))
    ids = tuple(f"P{i + 1}" for i in range(count))
    free, nan = np.full((count, 3), np.inf), np.full((count, 3), np.nan)
    points = Points(ids=ids, role=roles, xyz=xyz, sigma=free, check_sigma=nan)
    dispersion = _covariances(rng, np.array([0.015, 0.015, 0.03]), count)
    return points, PointResult(xyz + ORIGIN, dispersion, rng.integers(2, 7, count))


def _residuals(rng: np.random.Generator, count: int, *, on_curves: bool) -> ResidualTable:
    residual = rng.normal(0, 0.006, (count, 2))
    nan = np.full(count, np.nan)
    angle = rng.uniform(0, 2 * np.pi, count)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    across = np.sum(residual * normal, axis=1)
    if not on_curves:
        redundancy = rng.uniform(0.4, 0.9, (count, 2))
        return ResidualTable(
            residual,
            nan,
            redundancy,
            residual / (0.007 * np.sqrt(redundancy)),
            nan,
            np.full((count, 2), np.nan),
            nan,
            reliability(np.full((count, 2), 0.007), redundancy, 0.5 * (1.0 - redundancy), 4.13),
        )
    redundancy = np.column_stack([rng.uniform(0.5, 0.95, count), np.zeros(count)])
    standardized = np.column_stack([across / (0.007 * np.sqrt(redundancy[:, 0])), nan])
    if count:
        standardized[0, 0] = 4.7
    location, sigma = rng.uniform(0, 4, count), rng.uniform(1e-4, 1e-3, count)
    found = reliability(np.full((count, 2), 0.007), redundancy, 0.5 * (1.0 - redundancy), 4.13)
    return ResidualTable(residual, across, redundancy, standardized, location, normal, sigma, found)


def _observations(
    rng: np.random.Generator, sizes: tuple[int, int, int], images: int, points: int, curves: int
):
    n_point, n_curve, _ = sizes
    point_observations = PointObservations(
        image=rng.integers(0, images, n_point),
        point=rng.integers(0, max(points, 1), n_point),
        photo_xy=rng.uniform(-100, 100, (n_point, 2)),
        sigma=np.full((n_point, 2), 0.007),
    )
    curve_observations = CurveObservations(
        image=rng.integers(0, images, n_curve),
        curve=rng.integers(0, max(curves, 1), n_curve),
        photo_xy=rng.uniform(-100, 100, (n_curve, 2)),
        sigma=np.full((n_curve, 2), 0.007),
        location=np.full(n_curve, np.nan),
        segment=np.full(n_curve, -1),
    )
    return point_observations, curve_observations


def _priors() -> PriorResiduals:
    rows = (
        PriorResidual("control point", "P1", "x", 0.004, 0.01, 0.6),
        PriorResidual("control point", "P1", "y", -0.012, 0.01, 0.7),
        PriorResidual("control point", "P1", "z", 0.035, 0.01, 0.5),
        PriorResidual("eop prior", "762", "omega", 0.0001, 0.0005, 0.98),
        PriorResidual("eop prior", "762", "X0", 0.02, 0.1, 0.98),
        PriorResidual("control spline", "kerb-2", "knot 3 z", 0.003, 0.005, 0.4),
        PriorResidual("gauge", "kerb-1", "knot 0 along", 0.05, 0.8, 0.1),
        PriorResidual("gauge", "kerb-1", "knot 1 along", -0.02, 0.8, 0.1),
    )
    return PriorResiduals.of_rows(rows)


def _problems() -> tuple[Problem, ...]:
    return (
        Problem(
            "SBB520",
            "warning",
            "ω and Y0 are not separable (r = -0.983): the strip is narrow",
            "image `763`",
            "add control beside the strip, or a prior for the position",
        ),
        Problem("SBB521", "info", "2 image points lie beyond its ends", "spline `kerb-<1>`", "lengthen it"),
    )


def _statistics() -> Statistics:
    return Statistics(
        observations=420,
        unknowns=301,
        conditions=12,
        rank_defect=3,
        redundancy=131,
        sum_redundancy_numbers=130.9999999,
        condition_redundancy=1.7,
        condition_cost=0.9,
        vtpv=128.4,
        sigma0_prior=1.0,
        sigma0=float(np.sqrt(128.4 / 131)),
        global_test=GlobalTest(128.4, 101.2, 164.6, 0.05, True),
    )


def make_result(
    images: int = 3,
    splines: int = 2,
    points: int = 5,
    *,
    knots: int = 5,
    point_observations: int = 24,
    curve_observations: int = 60,
    seed: int = 1,
    **changes: object,
) -> AdjustmentResult:
    """A result with the given counts; `changes` replace fields of AdjustmentResult."""
    rng = np.random.default_rng(seed)
    extent = 450.0 * max(1, int(np.ceil(np.sqrt(images))) - 1) + 200.0
    image_part, image_result = _images(rng, images)
    curve_pairs = [_curve(rng, i, extent, knots) for i in range(splines)]
    point_part, point_result = _points(rng, points, extent)
    sizes = (point_observations if points else 0, curve_observations if splines else 0, 0)
    observed_points, observed_curves = _observations(rng, sizes, images, points, splines)
    camera = Camera(
        "RMK", 153.2, np.array([0.012, -0.003]), np.zeros(3), np.zeros(2), np.zeros(2), 0.012, (230.0, 230.0)
    )
    network = Network(
        origin=ORIGIN,
        cameras=(camera,),
        images=image_part,
        points=point_part,
        curves=tuple(curve for curve, _ in curve_pairs),
        point_observations=observed_points,
        curve_observations=observed_curves,
    )
    size = 6
    content: dict[str, object] = {
        "network": network,
        "converged": True,
        "termination": "step negligible",
        "iterations": tuple(
            Iteration(
                stage, i + 1, 128.4 + 9e4 * 10.0 ** (-2 * k), 90.0 * 10.0 ** (-1.5 * k), 10.0 ** (-3 - k)
            )
            for k, (stage, i) in enumerate(
                [("points", 0), ("points", 1), ("curves", 0), ("joint", 0), ("joint", 1)]
            )
        ),
        "statistics": _statistics(),
        "images": image_result,
        "curves": tuple(curve for _, curve in curve_pairs),
        "points": point_result,
        "point_residuals": _residuals(rng, sizes[0], on_curves=False),
        "curve_residuals": _residuals(rng, sizes[1], on_curves=True),
        "prior_residuals": _priors(),
        "checks": Checks(
            (CheckPoint("P4", np.array([0.01, -0.02, 0.04]), np.array([0.015, 0.015, 0.03]), 1.1),),
            (CheckSpline("kerb-9", np.array([0.0, 0.02, -0.05]), 0.031, 0.05, 0.02),),
        ),
        "problems": _problems(),
        "dispersion": DispersionBlocks(
            tuple(f"image 762 {name}" for name in ("omega", "phi", "kappa", "X0", "Y0", "Z0")),
            np.diag(np.arange(1.0, size + 1)),
        ),
        "timings": {"points": 0.1, "joint": 1.234567},
    }
    result = AdjustmentResult(**{**content, **changes})  # type: ignore[arg-type]
    return replace(result, evidence=Evidence(tests=local_tests_of(result)))
