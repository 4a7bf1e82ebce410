"""What counts say before anything is computed: who is seen by whom, and how far apart things are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import BoolArray, Curve, IntArray
from splinebba_cli.project.build_chains import ChainRows
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_curves import CurveRows, position_rows
from splinebba_cli.project.build_images import ImageRows
from splinebba_cli.project.build_observations import ObservationRows
from splinebba_cli.project.build_points import PointRows
from splinebba_cli.project.diagnostics import Place, Places
from splinebba_cli.project.yaml_source import YamlPath

LARGEST_EXTENT_M = 1.0e6
RESECTION_POINTS = 3
LOCATED_POINTS = 2  # enough where they have tangents


def images_per_feature(rows: ObservationRows, count: int) -> IntArray:
    """Number of different images that see each feature, by what takes part, (count,)."""
    return _images_per_feature(rows, count, ~rows.excluded)


def images_per_feature_of_all(rows: ObservationRows, count: int) -> IntArray:
    """The same by all measurements, also those that the user has taken out, (count,)."""
    return _images_per_feature(rows, count, np.ones(len(rows.image), dtype=bool))


def _images_per_feature(rows: ObservationRows, count: int, chosen: BoolArray) -> IntArray:
    feature, _ = _seen_pairs(rows, chosen)
    return np.bincount(feature, minlength=count)[:count].astype(np.int64)


def _seen_pairs(rows: ObservationRows, chosen: BoolArray) -> tuple[IntArray, IntArray]:
    """Features and images that see them, each pair once."""
    image, feature = rows.image, rows.feature
    valid = (image >= 0) & (feature >= 0) & chosen
    size = int(image.max(initial=0)) + 1
    pair = feature * size + image if valid.all() else feature[valid] * size + image[valid]
    runs = pair[np.concatenate([[True], pair[1:] != pair[:-1]])] if len(pair) else pair
    pairs = np.unique(runs)
    return pairs // size, pairs % size


def check_chains(building: Building, chains: ChainRows, measured: bool) -> bool:
    """Whether the project has what it is read for; `measured`: it has other image points.  What chains are good for."""
    place = building.source.place(("observations",), key=True)
    if building.purpose == "matching":
        if not chains.groups and "observations" not in building.unread:
            help = "`observations: {chains: [{table: chains.csv, …}]}` with columns image, x, y, and chain"
            building.collector.error(
                "SBB327", "the project has no chains: nothing is to be matched", place, help
            )
        return bool(chains.groups)
    if building.purpose == "adjustment" and not measured:
        help = "its chains have no labels yet: run `splinebba match` first" if chains.groups else ""
        building.collector.error("SBB303", "the project has no observations", place, help)
        return False
    if chains.points and building.purpose == "adjustment" and not building.collector.has_errors:
        number = sum(len(group.chain_ids) for group in chains.groups)
        which = f" (in {number} chains)" if number > 1 else ""
        message = f"points without a label take no part: {chains.points}{which}"
        place = building.source.place(("observations", "chains"), key=True)
        building.collector.add("info", "SBB329", message, place, "`splinebba match` labels them")
    return True


def _seen_images(images: ImageRows, kinds: Sequence[ObservationRows]) -> BoolArray:
    """Images with observations that take part, (m,)."""
    seen = np.zeros(len(images.ids), dtype=bool)
    for rows in kinds:
        image = rows.image
        seen[image[(image >= 0) & ~rows.excluded]] = True
    return seen


def check_images_to_match(
    building: Building, images: ImageRows, kinds: Sequence[ObservationRows], chains: ChainRows
) -> None:
    """Name the images in which nothing can be matched."""
    seen = _seen_images(images, kinds)
    seen[chains.image[chains.image >= 0]] = True
    for number in np.flatnonzero(~seen).tolist():
        message = f"image `{images.ids[number]}` has no observations and no chains"
        help = "nothing can be matched in it"
        place = images.places[number]
        building.collector.warning("SBB303", message, place, help, kind="images without observations")


def check_images_seen(building: Building, images: ImageRows, kinds: Sequence[ObservationRows]) -> None:
    """Every image has observations, unless nothing of it is to be estimated."""
    seen = _seen_images(images, kinds)
    for number in np.flatnonzero(~seen).tolist():
        name, place = images.ids[number], images.places[number]
        if np.isfinite(images.sigma[number]).all():
            help = "it has no influence on the result"
            message = f"image `{name}` has no observations"
            building.collector.warning("SBB303", message, place, help, kind="images without observations")
        else:
            help = "measure something in it, or remove it; rows with `use: no` do not count"
            message = f"image `{name}` has no observations"
            building.collector.error("SBB303", message, place, help, kind="images without observations")


def check_features_seen(
    building: Building,
    kind: str,
    ids: Sequence[str],
    roles: Sequence[str],
    places: Sequence[Place],
    seen: IntArray,
    measured: IntArray,
) -> BoolArray:
    """Ties need two images; which features can take part, (n,).

    `seen` counts the images with measurements that take part, `measured` those with any.
    """
    usable = np.ones(len(ids), dtype=bool)
    model = building.model
    unlabelled = kind == "spline" and bool(model.observations.chains or "matching" in model.model_fields_set)
    for number in np.flatnonzero(seen < 2).tolist():
        role, count = roles[number], int(seen[number])
        name = f"{role} {kind} `{ids[number]}`"
        where = "in no image" if count == 0 else "in one image only"
        if measured[number] >= 2 and (role in ("tie", "check") or count == 0):
            usable[number] = False
            message = f"{name} takes part {where}: the column `use` excludes the others"
            building.collector.warning(
                "SBB304", message, places[number], "it is left out", kind=f"{kind}s excluded"
            )
        elif unlabelled and (role in ("tie", "check") or count == 0):
            usable[number] = False
            code, message = ("SBB310" if count == 0 else "SBB304"), f"{name} is measured {where}"
            help = "it is left out: `splinebba match` has not found it, or has not run yet"
            building.collector.warning(code, message, places[number], help, kind=f"{role} {kind}s {where}")
        elif role == "tie" or (role == "partial" and count == 0):
            help = "measure it in a second image, or remove it"
            code = "SBB310" if count == 0 else "SBB304"
            building.collector.error(
                code, f"{name} is measured {where}", places[number], help, kind=f"{kind}s {where}"
            )
        elif role == "check" or count == 0:
            usable[number] = False
            code = "SBB310" if count == 0 else "SBB304"
            message, help = f"{name} is measured {where}", "it is left out"
            building.collector.warning(code, message, places[number], help, kind=f"{role} {kind}s {where}")
    return usable


def check_resection(
    building: Building,
    images: ImageRows,
    points: PointRows,
    observed: ObservationRows,
    curves: CurveRows,
    on_curves: ObservationRows,
) -> None:
    """An image without an approximate orientation wants control points, or located points on control splines."""
    control = np.array([role == "control" for role in points.roles], dtype=bool)
    control &= np.isfinite(np.array(points.xyz).reshape(-1, 3)).all(axis=1)
    orientation, prior = (np.array(v).reshape(-1, 6) for v in (images.orientation, images.prior))
    unknown = np.isnan(np.where(np.isnan(orientation), prior, orientation)).any(axis=1)
    point, image = _seen_pairs(observed, ~observed.excluded)
    count = np.bincount(image[control[point]], minlength=len(images.ids))
    located = _located(curves, on_curves, len(images.ids))
    for number in np.flatnonzero(unknown).tolist():
        name = images.ids[number]
        if count[number] < RESECTION_POINTS and located[number] < LOCATED_POINTS:
            message = f"image `{name}` has no approximate orientation and {count[number]} control points"
            help = f"give `orientation`, or measure at least {RESECTION_POINTS} control points (better 4)"
            building.collector.warning(
                "SBB315",
                message,
                images.places[number],
                help,
                kind="images without an approximate orientation",
            )


def _located(curves: CurveRows, rows: ObservationRows, images: int) -> IntArray:
    """Measured points with a location on control splines, in every image, (images,)."""
    if not rows.groups:
        return np.zeros(images, dtype=np.int64)
    control = np.array([bool((curve.sigma == 0.0).all()) for curve in curves.curves], dtype=bool)
    location = np.concatenate([group.location for group in rows.groups])
    known = (rows.feature >= 0) & (rows.image >= 0) & ~rows.excluded & np.isfinite(location)
    known[known] = control[rows.feature[known]]
    return np.bincount(rows.image[known], minlength=images)


def check_segments(building: Building, curves: CurveRows, rows: ObservationRows) -> None:
    """Where the segments of all measurements of a spline are given: each exists and has some."""
    if not rows.groups:
        return
    segment = np.concatenate([group.segment for group in rows.groups])
    feature = rows.feature
    given = np.flatnonzero((segment >= 0) & (feature >= 0))
    if not len(given):
        return
    counts = np.array([segment_count(curve) for curve in curves.curves], dtype=np.int64)
    for row in given[segment[given] >= counts[feature[given]]]:
        curve = curves.curves[feature[row]]
        message = f"spline `{curve.id}` has no segment {segment[row]}"
        help = f"its segments are 0 … {counts[feature[row]] - 1}"
        building.collector.error(
            "SBB311", message, rows.place(int(row), "segment"), help, kind="unknown segments"
        )
    for number in np.unique(feature[given]):
        own = segment[feature == number]
        if (own < 0).any() or curves.curves[number].role == "control":
            continue
        empty = sorted(set(range(counts[number])) - set(own.tolist()))
        if empty:
            message = f"spline `{curves.curves[number].id}`: no measurement in segment {empty[0]}"
            more = f" and {len(empty) - 1} more" if len(empty) > 1 else ""
            help = "remove a knot there, or set adjustment.knots.drop"
            building.collector.warning("SBB305", message + more, curves.places[number], help)


def segment_count(curve: Curve) -> int:
    """Number of segments of a curve."""
    return basis_of(curve).segment_count


def check_extent(building: Building, images: ImageRows, points: PointRows, curves: CurveRows) -> None:
    """Nothing lies a thousand kilometres from the middle of the project."""
    kinds: list[tuple[str, Sequence[str], Places]] = [
        ("image", images.ids, images.places),
        ("point", points.ids, points.places),
        ("spline", [curve.id for curve in curves.curves], curves.places),
    ]
    positions = [o[:3] for o in images.orientation] + points.xyz
    shapes = [curve.values[position_rows(curve)] for curve in curves.curves]
    rows = np.concatenate([np.array(positions).reshape(-1, 3), *shapes])
    counts = np.array([1] * len(positions) + [len(shape) for shape in shapes], dtype=np.int64)
    owner = np.repeat(np.arange(len(counts)), counts)
    finite = np.isfinite(rows).all(axis=1)
    if not finite.any():
        return
    middle = np.median(rows[finite], axis=0)
    distance = np.zeros(len(counts))
    np.maximum.at(distance, owner[finite], np.abs(rows[finite] - middle).max(axis=1))
    for number in np.flatnonzero(distance > LARGEST_EXTENT_M).tolist():
        name, place = _feature_of(kinds, number)
        message = f"{name} lies {distance[number] / 1000:,.0f} km from the middle of the project"
        help = "swapped columns, or another coordinate system?"
        building.collector.error("SBB306", message, place, help, kind="coordinates far apart")


def _feature_of(kinds: list[tuple[str, Sequence[str], Places]], number: int) -> tuple[str, Place]:
    """Name and place of a feature by its number in the lists of all kinds, one after another."""
    for kind, ids, places in kinds:
        if number < len(ids):
            return f"{kind} `{ids[number]}`", places[number]
        number -= len(ids)
    raise IndexError(number)


def check_datum_features(
    building: Building, images: Sequence[str], points: Sequence[str], splines: Sequence[str]
) -> None:
    """Features of the datum exist, and it is one that they carry."""
    adjustment = building.model.adjustment
    features = adjustment.datum_features
    if features is None:
        return
    path: YamlPath = ("adjustment", "datum_features")
    if adjustment.datum != "inner":
        help = "`datum: inner`, or leave `datum_features` out"
        building.collector.error(
            "SBB209",
            f"`datum_features` with `datum: {adjustment.datum}`",
            building.source.place(path, key=True),
            help,
        )
    for key, ids in (("images", images), ("points", points), ("splines", splines)):
        names = getattr(features, key)
        for number, name in enumerate(() if names == "all" else names):
            if name not in ids:
                place = building.source.place((*path, key, number))
                building.unknown(key[:-1], name, place, ids)
    if not any(getattr(features, key) for key in ("images", "points", "splines")):
        building.collector.error(
            "SBB202",
            "`datum_features` names no feature",
            building.source.place(path, key=True),
            "points: all",
        )
