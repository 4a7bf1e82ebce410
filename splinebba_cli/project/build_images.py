"""Images: approximate exterior orientations and their priors, in inner units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray, Images, RotationSequence
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.diagnostics import Place, Places, suggestion
from splinebba_cli.project.model_images import EOP_KEYS, Image, ImageTable, OrientationSigma
from splinebba_cli.project.plausibility import check_angles
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.yaml_source import YamlPath

ANGLE_FACTORS = {"deg": math.pi / 180.0, "gon": math.pi / 200.0, "rad": 1.0}
SEQUENCES: tuple[RotationSequence, ...] = ("omega-phi-kappa", "phi-omega-kappa")
_ANGLE_PATHS = [(part, key) for part in ("orientation", "prior") for key in EOP_KEYS[3:]]
_TABLE = Wanted(
    ("image",),
    (
        "camera",
        "rotation_sequence",
        *EOP_KEYS,
        *(f"prior_{key}" for key in EOP_KEYS),
        *(f"sigma_{key}" for key in EOP_KEYS),
    ),
    {"id": "image"},
)


@dataclass
class ImageRows:
    """Images of all entries; EOPs in the order x, y, z, omega, phi, kappa, in the user's units and frame."""

    ids: list[str] = field(default_factory=list)
    cameras: list[int] = field(default_factory=list)
    sequences: list[RotationSequence | None] = field(default_factory=list)
    places: Places = field(default_factory=Places)
    orientation: list[FloatArray] = field(default_factory=list)  # (6,) NaN where not given
    prior: list[FloatArray] = field(default_factory=list)
    sigma: list[FloatArray] = field(default_factory=list)

    def index(self) -> dict[str, int]:
        """Index of each id."""
        return {id: number for number, id in enumerate(self.ids)}


def read_images(building: Building) -> ImageRows:
    """All images of the project, without duplicates."""
    rows = ImageRows()
    cameras = {camera.id: number for number, camera in enumerate(building.model.cameras)}
    seen: dict[str, int] = {}
    for number, entry in enumerate(building.model.images):
        path = building.source.resolve(("images", number))
        if isinstance(entry, Image):
            _add_image(entry, path, rows, cameras, seen, building)
        else:
            _add_table(entry, path, rows, cameras, seen, building)
    return rows


def _is_new(
    id: str, find: Callable[[], Place], rows: ImageRows, seen: dict[str, int], building: Building
) -> bool:
    if id in seen:
        building.duplicate("image", id, find(), rows.places[seen[id]].line)
        return False
    seen[id] = len(rows.ids)
    return True


def _camera(id: str, place: Place, cameras: dict[str, int], building: Building) -> int:
    if id not in cameras and "camera" not in building.unread:
        building.unknown("camera", id, place, cameras)
    return cameras.get(id, -1)


def _sigma_values(sigma: OrientationSigma | None) -> FloatArray:
    if sigma is None:
        return np.full(6, np.inf)
    return np.array([getattr(sigma, key) for key in EOP_KEYS])


def _add_image(
    entry: Image,
    path: YamlPath,
    rows: ImageRows,
    cameras: dict[str, int],
    seen: dict[str, int],
    building: Building,
) -> None:
    place = building.source.place((*path, "id"))
    if not _is_new(entry.id, lambda: place, rows, seen, building):
        return
    given = [getattr(entry.orientation, key, None) for key in EOP_KEYS]
    prior = [getattr(entry.prior, key, None) for key in EOP_KEYS]
    if entry.fixed and entry.sigma is not None:
        where = building.source.place((*path, "fixed"), key=True)
        building.collector.error("SBB209", "`fixed` and `sigma` both given", where, "give one of them")
    angles = np.array([math.nan if v is None else v for v in (*given[3:], *prior[3:])]).reshape(1, 6)
    check_angles(angles, lambda _, k: building.source.place((*path, *_ANGLE_PATHS[k])), building)
    rows.ids.append(entry.id)
    rows.cameras.append(_camera(entry.camera, building.source.place((*path, "camera")), cameras, building))
    rows.sequences.append(entry.rotation_sequence)
    rows.places.append(lambda: place)
    rows.orientation.append(np.array([math.nan if v is None else v for v in given]))
    rows.prior.append(np.array([math.nan if v is None else v for v in prior]))
    rows.sigma.append(np.zeros(6) if entry.fixed else _sigma_values(entry.sigma))


def _add_table(
    entry: ImageTable,
    path: YamlPath,
    rows: ImageRows,
    cameras: dict[str, int],
    seen: dict[str, int],
    building: Building,
) -> None:
    table = building.reader.read(entry, path, _TABLE)
    if table is None:
        building.unread.add("image")
        return
    ids = table.texts("image")
    camera_ids = _table_cameras(entry, path, table, building)
    sequences = _table_sequences(entry, table, building)
    orientation = _six(table, "", "numbers")
    prior = _six(table, "prior_", "numbers")
    sigma = _six(table, "sigma_", "sigmas")
    names = [*EOP_KEYS[3:], *(f"prior_{key}" for key in EOP_KEYS[3:])]
    angles = np.hstack([orientation[:, 3:], prior[:, 3:]])
    check_angles(angles, lambda row, k: table.place_of(row, names[k]), building)
    default = np.zeros(6) if entry.fixed else _sigma_values(entry.sigma)
    sigma = np.where(np.isnan(sigma), default, sigma)
    for row, id in enumerate(ids):
        find = partial(table.place_of, row, "image")
        if not id or not _is_new(id, find, rows, seen, building):
            continue
        rows.ids.append(id)
        camera = camera_ids[row]
        if camera and camera not in cameras:
            own = table.has("camera")
            place = table.place_of(row, "camera") if own else building.source.place((*path, "camera"))
            building.unknown("camera", camera, place, cameras)
        rows.cameras.append(cameras.get(camera, -1))
        rows.sequences.append(sequences[row])
        rows.places.append(find)
        rows.orientation.append(orientation[row])
        rows.prior.append(prior[row])
        rows.sigma.append(sigma[row])


def _table_cameras(entry: ImageTable, path: YamlPath, table: Table, building: Building) -> list[str]:
    if table.has("camera"):
        return table.texts("camera")
    if entry.camera is None:
        help = "camera: id for all images of the table, or a column `camera`"
        place = building.source.place(path)
        building.collector.error("SBB202", f"no camera for the images of `{table.file}`", place, help)
        return [""] * table.rows
    return [entry.camera] * table.rows


def _table_sequences(entry: ImageTable, table: Table, building: Building) -> list[RotationSequence | None]:
    if not table.has("rotation_sequence"):
        return [entry.rotation_sequence] * table.rows
    out: list[RotationSequence | None] = []
    for row, name in enumerate(table.texts("rotation_sequence")):
        found = next((sequence for sequence in SEQUENCES if sequence == name), None)
        if found is None:
            place = table.place_of(row, "rotation_sequence")
            help = suggestion(name, SEQUENCES) or " or ".join(SEQUENCES)
            building.collector.error(
                "SBB204", f"rotation sequence `{name}` is not known", place, help, kind="sequences"
            )
        out.append(found)
    return out


def _six(table: Table, prefix: str, kind: str) -> FloatArray:
    """Six columns, (n, 6); NaN where they are absent or empty."""
    out = np.full((table.rows, 6), np.nan)
    for number, key in enumerate(EOP_KEYS):
        if table.has(prefix + key):
            name = prefix + key
            out[:, number] = table.sigmas(name) if kind == "sigmas" else table.numbers(name, optional=True)
    return out


def check_images(rows: ImageRows, building: Building) -> None:
    """Priors have values; where there are angles, their unit and sequence are declared."""
    orientation, prior, sigma = _arrays(rows)
    for image in np.flatnonzero((np.isfinite(sigma) & np.isnan(prior)).any(axis=1)).tolist():
        lacking = [
            key
            for k, key in enumerate(EOP_KEYS)
            if np.isfinite(sigma[image, k]) and np.isnan(prior[image, k])
        ]
        message = f"image `{rows.ids[image]}` has a σ of {', '.join(lacking)}, but no value"
        help = "give `orientation` or `prior`, or leave the σ out"
        building.collector.error("SBB314", message, rows.places[image], help, kind="priors without a value")
    angles = np.isfinite(orientation[:, 3:]).any(axis=1) | np.isfinite(prior[:, 3:]).any(axis=1)
    place = building.source.place(("project",), key=True)
    project = building.model.project
    if project.angle_unit is None and angles.any():
        message = "`project` has no `angle_unit`, but there are angles"
        building.collector.error("SBB202", message, place, "angle_unit: deg, gon or rad")
    if project.rotation_sequence is None and any(rows.sequences[i] is None for i in np.flatnonzero(angles)):
        message = "`project` has no `rotation_sequence`, but there are angles"
        building.collector.error("SBB202", message, place, "rotation_sequence: " + " or ".join(SEQUENCES))


def _arrays(rows: ImageRows) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Approximate orientation, prior values, σ; each (m, 6) in the user's units."""
    count = len(rows.ids)
    orientation = np.array(rows.orientation).reshape(count, 6)
    given = np.array(rows.prior).reshape(count, 6)
    prior = np.where(np.isnan(given), orientation, given)
    return orientation, prior, np.array(rows.sigma).reshape(count, 6)


def build_images(rows: ImageRows, origin: FloatArray, building: Building) -> Images:
    """Images in inner units and the local frame; prior order omega, phi, kappa, X0, Y0, Z0."""
    orientation, prior, sigma = _arrays(rows)
    project = building.model.project
    factor = ANGLE_FACTORS[project.angle_unit or "deg"]
    default = project.rotation_sequence or SEQUENCES[0]
    sequences = [sequence or default for sequence in rows.sequences]
    approximate = np.where(np.isnan(orientation) | (sigma == 0.0), prior, orientation)
    order = [3, 4, 5, 0, 1, 2]
    units = np.array([factor] * 3 + [1.0] * 3)
    local = np.concatenate([np.zeros(3), origin])
    rotation = np.full((len(rows.ids), 3, 3), np.nan)
    oriented = np.isfinite(approximate[:, 3:]).all(axis=1)
    for sequence in SEQUENCES:
        chosen = np.flatnonzero(oriented & np.array([s == sequence for s in sequences], dtype=bool))
        if len(chosen):
            rotation[chosen] = rotation_object_from_photo(approximate[chosen, 3:] * factor, sequence)
    return Images(
        ids=tuple(rows.ids),
        camera=np.array(rows.cameras, dtype=np.int64),
        rotation=rotation,
        position=approximate[:, :3] - origin,
        sequence=tuple(sequences),
        prior=np.where(np.isinf(sigma[:, order]), np.nan, (prior[:, order] - local) * units),
        prior_sigma=sigma[:, order] * units,
    )
