"""From the models of a project to the network of the core: units, frames, local origin, ids to indices.

Every step reports what it finds and goes on, so that all errors come out in one go.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import (
    ArcLengths,
    BoolArray,
    FloatArray,
    IntArray,
    Network,
    Points,
    Tangents,
)
from splinebba_cli.project.build_cameras import build_cameras
from splinebba_cli.project.build_chains import as_unlabelled_points, read_chains
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_curves import CurveRows, position_rows, read_curves, shifted
from splinebba_cli.project.build_distances import read_distances
from splinebba_cli.project.build_images import ImageRows, build_images, check_images, read_images
from splinebba_cli.project.build_linked import Marks, read_arc_lengths, read_tangents
from splinebba_cli.project.build_observations import (
    ObservationRows,
    as_curve_observations,
    as_point_observations,
    kept_rows,
    read_observations,
)
from splinebba_cli.project.build_points import PointRows, read_points
from splinebba_cli.project.build_settings import settings_of
from splinebba_cli.project.plausibility import check_knot_spacing
from splinebba_cli.project.semantic_checks import (
    check_chains,
    check_datum_features,
    check_extent,
    check_features_seen,
    check_images_seen,
    check_images_to_match,
    check_resection,
    check_segments,
    images_per_feature,
    images_per_feature_of_all,
)

ORIGIN_STEP_M = 1000.0
SMALL_COORDINATES_M = 10_000.0


def build_network(building: Building) -> Network | None:
    """The network of a project; None (and errors in the collector) where it is invalid."""
    cameras, frames = build_cameras(building)
    images = read_images(building)
    check_images(images, building)
    points = read_points(building)
    curves = read_curves(building)
    on_points = read_observations("point", building, images, points.declared(), frames)
    on_curves = read_observations("spline", building, images, _declared_splines(building, curves), frames)
    chains = read_chains(building, images, frames)
    measured = bool(on_points.groups or on_curves.groups or chains.groups)
    if building.collector.has_errors and not (images.ids and measured):
        return None
    if not check_chains(building, chains, bool(on_points.groups or on_curves.groups)) or _incomplete(
        building
    ):
        return None
    check_extent(building, images, points, curves)
    check_knot_spacing(curves, building)
    if building.purpose == "matching":
        check_images_to_match(building, images, (on_points, on_curves), chains)
    kept_points, kept_curves = _features_taking_part(building, images, points, curves, on_points, on_curves)
    origin = local_origin(building, images, points, curves)
    built_images = build_images(images, origin, building)
    arc_lengths, tangents = ArcLengths.none(), Tangents.none()
    if _links(building):
        marks = Marks.of(on_curves, curves, building)
        numbers = kept_rows(on_curves, _renumbered(kept_curves))
        arc_lengths = read_arc_lengths(building, images, marks, frames, numbers)
        tangents = read_tangents(building, images, marks, frames, numbers)
    distances = read_distances(building, images, points, _renumbered(kept_points))
    check_datum_features(building, images.ids, points.ids, [curve.id for curve in curves.curves])
    if building.collector.has_errors:
        return None
    return Network(
        origin=origin,
        cameras=tuple(cameras),
        images=built_images,
        points=_points(points, kept_points, origin),
        curves=tuple(
            shifted(curve, -origin) for curve, kept in zip(curves.curves, kept_curves, strict=True) if kept
        ),
        point_observations=as_point_observations(on_points, _renumbered(kept_points)),
        curve_observations=as_curve_observations(on_curves, _renumbered(kept_curves)),
        settings=settings_of(building.model.adjustment),
        arc_lengths=arc_lengths,
        tangents=tangents,
        distances=distances,
        unlabelled=as_unlabelled_points(chains),
    )


def _links(building: Building) -> bool:
    """Whether there are arc lengths or tangents."""
    observations = building.model.observations
    return bool(observations.arc_lengths or observations.tangents)


def _features_taking_part(
    building: Building,
    images: ImageRows,
    points: PointRows,
    curves: CurveRows,
    on_points: ObservationRows,
    on_curves: ObservationRows,
) -> tuple[BoolArray, BoolArray]:
    """Which points and curves enough images see; what a simulation measures, or matching may find, all takes part."""
    to_place, to_match = building.purpose == "simulation", building.purpose == "matching"
    if not to_match and (not to_place or (on_points.groups and on_curves.groups)):
        check_images_seen(building, images, (on_points, on_curves))
    if not to_match and (not to_place or on_points.groups):
        check_resection(building, images, points, on_points, curves, on_curves)
    check_segments(building, curves, on_curves)
    kept_points = np.ones(len(points.ids), dtype=bool)
    if not to_place or on_points.groups:
        seen = images_per_feature(on_points, len(points.ids))
        every = images_per_feature_of_all(on_points, len(points.ids)) if on_points.excluded.any() else seen
        kept_points = check_features_seen(
            building, "point", points.ids, points.roles, points.places, seen, every
        )
    kept_curves = np.ones(len(curves.curves), dtype=bool)
    if not to_match and (not to_place or on_curves.groups):
        ids, roles = [c.id for c in curves.curves], [c.role for c in curves.curves]
        seen = images_per_feature(on_curves, len(ids))
        every = images_per_feature_of_all(on_curves, len(ids)) if on_curves.excluded.any() else seen
        kept_curves = check_features_seen(building, "spline", ids, roles, curves.places, seen, every)
    return kept_points, kept_curves


def _incomplete(building: Building) -> bool:
    """Whether tables, references or features are broken, so that counting who sees whom would mislead."""
    if building.unread:
        return True
    broken = ("SBB4", "SBB301", "SBB302", "SBB307", "SBB308", "SBB312", "SBB206")
    return any(d.severity == "error" and d.code.startswith(broken) for d in building.collector.items)


def _declared_splines(building: Building, curves: CurveRows) -> dict[str, int]:
    """Indices of all declared splines; one that could not be built is -2, so that it is no unknown id."""
    declared = {entry.id: -2 for entry in building.model.splines if not hasattr(entry, "table")}
    return {**declared, **curves.index()}


def _renumbered(kept: BoolArray) -> IntArray:
    return np.where(kept, np.cumsum(kept) - 1, -1).astype(np.int64)


def _points(rows: PointRows, kept: BoolArray, origin: FloatArray) -> Points:
    count = len(rows.ids)
    roles = tuple(role for role, keep in zip(rows.roles, kept, strict=True) if keep)
    given = np.array(rows.sigma).reshape(count, 3)[kept]
    control = np.array([role == "control" for role in roles], dtype=bool)[:, None]
    check = np.array([role == "check" for role in roles], dtype=bool)[:, None]
    return Points(
        ids=tuple(id for id, keep in zip(rows.ids, kept, strict=True) if keep),
        role=roles,
        xyz=np.array(rows.xyz).reshape(count, 3)[kept] - origin,
        sigma=np.where(control, given, np.inf),
        check_sigma=np.where(check, np.where(np.isnan(given), 0.0, given), np.nan),
    )


def local_origin(building: Building, images: ImageRows, points: PointRows, curves: CurveRows) -> FloatArray:
    """The declared origin, else the median of the control (or images, or all), rounded to a kilometre.

    Coordinates that are all small need no shift: the origin is then 0.
    """
    declared = building.model.project.local_origin
    if declared is not None:
        return np.array(declared)
    control_points = [v for v, role in zip(points.xyz, points.roles, strict=True) if role == "control"]
    control_knots = [c.values[position_rows(c)] for c in curves.curves if c.role in ("control", "partial")]
    positions = [orientation[:3] for orientation in images.orientation]
    all_knots = [curve.values[position_rows(curve)] for curve in curves.curves]
    for candidates in ([*control_points, *control_knots], positions, [*points.xyz, *all_knots]):
        rows = np.concatenate([np.atleast_2d(c) for c in candidates]) if candidates else np.empty((0, 3))
        rows = rows[np.isfinite(rows).all(axis=1)]
        if len(rows):
            if np.abs(rows).max() < SMALL_COORDINATES_M:
                return np.zeros(3)
            return np.asarray(np.round(np.median(rows, axis=0) / ORIGIN_STEP_M) * ORIGIN_STEP_M + 0.0)
    return np.zeros(3)
