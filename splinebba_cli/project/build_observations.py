"""Measured image coordinates as photo coordinates in millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from splinebba_cli.core.network import BoolArray, CurveObservations, FloatArray, IntArray, PointObservations
from splinebba_cli.project.build_cameras import PhotoFrame
from splinebba_cli.project.build_context import Building, stacked
from splinebba_cli.project.build_images import ImageRows
from splinebba_cli.project.diagnostics import Place
from splinebba_cli.project.model_observations import ObservationGroup
from splinebba_cli.project.pixel_frames import warn_of_outside
from splinebba_cli.project.plausibility import check_field_of_view
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.yaml_source import YamlPath

UNITS = ("px", "um", "mm")
_SIGMAS = tuple(f"sigma_{unit}" for unit in UNITS)
_SIGMAS_XY = tuple(f"sigma_{axis}_{unit}" for unit in UNITS for axis in "xy")
SIGMA_COLUMNS = (*_SIGMAS, *_SIGMAS_XY)
POINT_COLUMNS = Wanted(("image", "point", "x", "y"), (*SIGMA_COLUMNS, "use"), {"id": "point"})
SPLINE_COLUMNS = Wanted(
    ("image", "spline", "x", "y"),
    (*SIGMA_COLUMNS, "location", "segment", "mark", "use"),
    {"id": "spline"},
)


@dataclass
class GroupRows:
    """Observations of one group; -1 where an id is unknown."""

    table: Table
    name: str
    image: IntArray  # (n,)
    feature: IntArray  # (n,)
    photo_xy: FloatArray  # (n, 2) mm
    sigma: FloatArray  # (n, 2) mm
    location: FloatArray  # (n,) NaN where unknown
    segment: IntArray  # (n,) -1 where unknown
    excluded: BoolArray  # (n,) taken out by the user


@dataclass
class ObservationRows:
    """All groups of one kind of observation."""

    kind: str  # "point" or "spline"
    groups: list[GroupRows] = field(default_factory=list)

    @property
    def image(self) -> IntArray:
        """Image of every observation, (n,)."""
        return _joined([group.image for group in self.groups])

    @property
    def feature(self) -> IntArray:
        """Point or curve of every observation, (n,)."""
        return _joined([group.feature for group in self.groups])

    @property
    def excluded(self) -> BoolArray:
        """Which observations the user has taken out, (n,)."""
        parts = [group.excluded for group in self.groups]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=bool)

    def place(self, row: int, column: str) -> Place:
        """Where an observation stands."""
        for group in self.groups:
            if row < len(group.image):
                return group.table.place_of(row, column)
            row -= len(group.image)
        raise IndexError(row)


def _joined(parts: Sequence[IntArray]) -> IntArray:
    if len(parts) == 1:
        return parts[0]
    return np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)


def read_observations(
    kind: str, building: Building, images: ImageRows, features: dict[str, int], frames: list[PhotoFrame]
) -> ObservationRows:
    """All observations of points ("point") or on splines ("spline")."""
    key = f"{kind}s" if kind == "point" else "spline_points"
    rows = ObservationRows(kind)
    groups: Sequence[ObservationGroup] = getattr(building.model.observations, key)
    for number, group in enumerate(groups):
        path: YamlPath = ("observations", key, number)
        read = _read_group(kind, group, path, building, images, features, frames)
        if read is not None:
            rows.groups.append(read)
    return rows


def _read_group(
    kind: str,
    group: ObservationGroup,
    path: YamlPath,
    building: Building,
    images: ImageRows,
    features: dict[str, int],
    frames: list[PhotoFrame],
) -> GroupRows | None:
    table = building.reader.read(group, path, POINT_COLUMNS if kind == "point" else SPLINE_COLUMNS)
    if table is None:
        building.unread.add("observations")
        return None
    feature = building.indices(kind, table, kind, features)
    measured = read_measured(table, group, path, building, images, frames)
    return GroupRows(
        table=table,
        name=group_name(group, path),
        image=measured.image,
        feature=feature,
        photo_xy=measured.photo_xy,
        sigma=measured.sigma,
        location=table.numbers("location", optional=True)
        if table.has("location")
        else np.full(table.rows, np.nan),
        segment=table.integers("segment")
        if table.has("segment")
        else np.full(table.rows, -1, dtype=np.int64),
        excluded=table.excluded(),
    )


def group_name(group: ObservationGroup, path: YamlPath) -> str:
    """How results call a group: its name, its table, or its place in the project file."""
    return group.name or group.table or f"{path[1]}[{path[2]}]"


@dataclass(frozen=True)
class Measured:
    """Image, coordinates and σ of the rows of a table."""

    image: IntArray  # (n,) -1 where the id is unknown
    photo_xy: FloatArray  # (n, 2) mm
    sigma: FloatArray  # (n, 2) mm


def read_measured(
    table: Table,
    group: ObservationGroup,
    path: YamlPath,
    building: Building,
    images: ImageRows,
    frames: list[PhotoFrame],
) -> Measured:
    """Measured image points of a table with columns image, x, y, checked against their cameras."""
    image = building.indices("image", table, "image", images.index())
    measured = np.column_stack([table.numbers("x"), table.numbers("y")])
    cameras = np.array(images.cameras, dtype=np.int64)
    camera = np.where(image >= 0, cameras[image] if len(cameras) else -1, -1)
    photo_xy = _photo_xy(measured, camera, group, path, building, frames)
    sigma = _sigma(camera, group, table, path, building, frames)
    check_field_of_view(photo_xy, camera, table, building, frames)
    _check_inside(measured, camera, group, table, building, frames)
    return Measured(image, photo_xy, sigma)


def _photo_xy(
    measured: FloatArray,
    camera: IntArray,
    group: ObservationGroup,
    path: YamlPath,
    building: Building,
    frames: list[PhotoFrame],
) -> FloatArray:
    out = np.zeros_like(measured)
    for number in _cameras_of(camera):
        frame = frames[number]
        wanted = group.image_coordinates or frame.image_coordinates
        if not frame.allows(wanted):
            if wanted == frame.image_coordinates:
                continue  # the camera lacks something, which is reported there
            place = building.source.place((*path, "image_coordinates"))
            name = building.model.cameras[number].id
            message = f"`{wanted}` cannot be converted to the `{frame.image_coordinates}` of camera `{name}`"
            help = "photo coordinates of a camera with pixels need its image_size_px"
            building.collector.error("SBB209", message, place, help)
            continue
        chosen = camera == number
        if chosen.all():
            return np.asarray(frame.photo_xy(measured, wanted))
        out[chosen] = frame.photo_xy(measured[chosen], wanted)
    return out


def _cameras_of(camera: IntArray) -> IntArray:
    """The different numbers of cameras, without -1."""
    return np.flatnonzero(np.bincount(camera + 1)[1:]).astype(np.int64)


def _sigma(
    camera: IntArray,
    group: ObservationGroup,
    table: Table,
    path: YamlPath,
    building: Building,
    frames: list[PhotoFrame],
) -> FloatArray:
    """σ of x and y in millimetres, (n, 2)."""
    declared = [name for name in _SIGMAS if getattr(group, name) is not None]
    columns = [name for name in SIGMA_COLUMNS if table.has(name)]
    units = {name.rsplit("_", 1)[1] for name in (*declared, *columns)}
    place = building.source.place(path)
    help = "one of sigma_px, sigma_um, sigma_mm, for the group or as a column"
    if not units:
        building.collector.error("SBB202", f"no σ for `{group.name or table.file}`", place, help)
        return np.ones((table.rows, 2))
    if len(units) > 1 or len(declared) > 1:
        building.collector.error("SBB209", "σ given in two units", place, help)
        return np.ones((table.rows, 2))
    unit = units.pop()
    value = getattr(group, declared[0]) if declared else (np.nan, np.nan)
    sigma = np.tile(np.array(value, dtype=np.float64), (table.rows, 1))
    for name in columns:
        axes = [0, 1] if name in _SIGMAS else [0 if name.startswith("sigma_x") else 1]
        values = table.sigmas(name)
        bad = np.flatnonzero((values == 0.0) | np.isinf(values))
        for row in bad[:1]:
            building.collector.error("SBB309", f"`{name}` must be a number", table.place_of(int(row), name))
        sigma[:, axes] = np.where(np.isnan(values)[:, None], sigma[:, axes], values[:, None])
    for row in np.flatnonzero(np.isnan(sigma).any(axis=1))[:1]:
        building.collector.error(
            "SBB202", "a measurement without σ", table.place_of(int(row), columns[0]), help
        )
    if unit == "px":
        return sigma * _pixel_sizes(camera, place, building, frames)
    return sigma * (1e-3 if unit == "um" else 1.0)


def _pixel_sizes(camera: IntArray, place: Place, building: Building, frames: list[PhotoFrame]) -> FloatArray:
    sizes = np.ones((len(camera), 2))
    for number in _cameras_of(camera):
        pixel = frames[number].pixel_size_mm
        if pixel is not None:
            sizes[camera == number] = pixel
        elif not frames[number].image_coordinates.startswith("pixel"):
            message = f"`sigma_px`, but camera `{building.model.cameras[number].id}` has no `pixel_size_mm`"
            building.collector.error("SBB202", message, place, "give σ in mm or µm, or the pixel size")
    return sizes


def _check_inside(
    measured: FloatArray,
    camera: IntArray,
    group: ObservationGroup,
    table: Table,
    building: Building,
    frames: list[PhotoFrame],
) -> None:
    """Warn of pixel coordinates outside of the image."""
    for number in _cameras_of(camera):
        frame = frames[number]
        wanted = group.image_coordinates or frame.image_coordinates
        if frame.size_px is None or not wanted.startswith("pixel"):
            continue
        rows = np.flatnonzero(camera == number)
        warn_of_outside(rows, measured[rows], np.array(frame.size_px, dtype=float), table, building)


def kept_rows(rows: ObservationRows, renumbered: IntArray) -> IntArray:
    """Number of every observation among those whose feature is kept, -1 for those left out, (n,)."""
    feature = rows.feature
    kept = renumbered[feature] >= 0 if len(feature) else np.zeros(0, dtype=bool)
    return np.where(kept, np.cumsum(kept) - 1, -1).astype(np.int64)


def as_point_observations(rows: ObservationRows, renumbered: IntArray) -> PointObservations:
    """Observations of points for the core; `renumbered` maps points to those kept, -1 for those left out."""
    joined = _joined_rows(rows, renumbered)
    return PointObservations(
        joined.image, joined.feature, joined.photo_xy, joined.sigma, joined.group, joined.group_names,
        joined.excluded,
    )  # fmt: skip


def as_curve_observations(rows: ObservationRows, renumbered: IntArray) -> CurveObservations:
    """Observations on curves for the core; `renumbered` as for points."""
    j = _joined_rows(rows, renumbered)
    return CurveObservations(
        j.image, j.feature, j.photo_xy, j.sigma, j.location, j.segment, j.group, j.group_names, j.excluded
    )


@dataclass(frozen=True)
class _Joined:
    image: IntArray
    feature: IntArray
    photo_xy: FloatArray
    sigma: FloatArray
    location: FloatArray
    segment: IntArray
    group: IntArray
    group_names: tuple[str, ...]
    excluded: BoolArray | None


def _joined_rows(rows: ObservationRows, renumbered: IntArray) -> _Joined:
    groups = rows.groups
    old = rows.feature
    feature = renumbered[old] if len(old) else old
    kept = feature >= 0
    number = _joined([np.full(len(g.image), i, dtype=np.int64) for i, g in enumerate(groups)])
    location = stacked([g.location[:, None] for g in groups], 1)[:, 0]
    chosen = slice(None) if kept.all() else kept
    return _Joined(
        image=rows.image[chosen],
        feature=feature[chosen],
        photo_xy=stacked([g.photo_xy for g in groups], 2)[chosen],
        sigma=stacked([g.sigma for g in groups], 2)[chosen],
        location=location[chosen],
        segment=_joined([g.segment for g in groups])[chosen],
        group=number[chosen],
        group_names=tuple(g.name for g in groups),
        excluded=rows.excluded[chosen] if rows.excluded.any() else None,
    )
