"""Write a project: of a network as a whole, or a loaded project with adjusted values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Network,
    PointObservations,
)
from splinebba_cli.project.chain_tables import chain_groups
from splinebba_cli.project.file_content import PROJECT_FILE
from splinebba_cli.project.model import FORMAT_VERSION
from splinebba_cli.project.network_tables import (
    arc_lengths_table,
    curve_tables,
    distances_table,
    images_table,
    marks_of,
    observations_table,
    points_table,
    spline_table,
    tangents_table,
)
from splinebba_cli.project.scalars import sigma_as_written
from splinebba_cli.project.settings_writer import adjustment_section
from splinebba_cli.project.yaml_writing import project_yaml
from splinebba_cli.write_errors import cannot_write

MANY = 50  # splines alike share a table from this number on


def write_project(
    network: Network,
    folder: Path,
    *,
    name: str,
    description: str = "",
    crs: str = "",
    angle_unit: str = "deg",
    matching: Mapping[str, Any] | None = None,
    acceptance: Mapping[str, Any] | None = None,
    simulation: Mapping[str, Any] | None = None,
    comment: str = "",
) -> Path:
    """Write a network as a project that loads back to it.

    Parameters
    ----------
    network : Network
        Its features must be valid for a project: ties are seen by two images and so on.
    folder : Path
        Made if it does not exist; files of the same names are replaced.
    name : str
        Name of the project.
    description, crs, comment : str
        Notes; the comment stands in the head of the file.
    angle_unit : {"deg", "gon", "rad"}
        Unit of angles in the project.
    matching, acceptance, simulation : mapping, optional
        These sections of the project file.

    Returns
    -------
    Path
        The project file ``project.yaml``.

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB607, if a file cannot be written.
    """
    files = project_files(
        network,
        name=name,
        description=description,
        crs=crs,
        angle_unit=angle_unit,
        matching=matching,
        acceptance=acceptance,
        simulation=simulation,
        comment=comment,
    )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise cannot_write(folder, error) from error
    return folder / PROJECT_FILE


def project_files(
    network: Network,
    *,
    name: str,
    description: str = "",
    crs: str = "",
    angle_unit: str = "deg",
    matching: Mapping[str, Any] | None = None,
    acceptance: Mapping[str, Any] | None = None,
    simulation: Mapping[str, Any] | None = None,
    comment: str = "",
) -> dict[str, str]:
    """The files of a project, name to text; parameters as in :func:`write_project`."""
    info: dict[str, Any] = {"name": name}
    if description:
        info["description"] = description
    if crs:
        info["crs"] = crs
    info |= {"angle_unit": angle_unit, "rotation_sequence": "omega-phi-kappa"}
    if network.origin.any():
        info["local_origin"] = network.origin.tolist()
    files = {"images.csv": images_table(network, angle_unit)}
    data: dict[str, Any] = {
        "version": FORMAT_VERSION,
        "project": info,
        "cameras": [_camera(camera) for camera in network.cameras],
        "images": {"table": "images.csv"},
    }
    if network.curves:
        data["splines"] = spline_entries(network.curves, network.origin, "", files)
    if network.points.ids:
        files["points.csv"] = points_table(network)
        data["points"] = {"table": "points.csv"}
    data["observations"] = {}
    for key, rows in (("spline_points", network.curve_observations), ("points", network.point_observations)):
        if len(rows):
            data["observations"][key] = _groups(network, rows, key, files)
    if len(network.unlabelled):
        data["observations"]["chains"] = chain_groups(network, angle_unit, files)
    data["observations"] |= _linked_groups(network, angle_unit, files)
    if len(network.distances):
        data["observations"]["distances"] = _distance_groups(network, files)
    data["adjustment"] = adjustment_section(network.settings)
    if matching:
        data["matching"] = dict(matching)
    if acceptance:
        data["acceptance"] = dict(acceptance)
    if simulation:
        data["simulation"] = dict(simulation)
    files[PROJECT_FILE] = project_yaml(data, comment)
    return files


def _camera(camera: Camera) -> dict[str, Any]:
    out: dict[str, Any] = {
        "id": camera.id,
        "principal_distance_mm": float(camera.principal_distance_mm),
        "image_coordinates": "photo_mm",
        "principal_point_mm": [float(v) for v in camera.principal_point_mm],
    }
    if camera.pixel_size_mm is not None:
        out["pixel_size_mm"] = float(camera.pixel_size_mm)
    if camera.format_mm is not None:
        out["format_mm"] = [float(v) for v in camera.format_mm]
    if camera.radial.any() or camera.decentring.any():
        values = [*camera.radial, *camera.decentring]
        out["distortion"] = {k: float(v) for k, v in zip(("k1", "k2", "k3", "p1", "p2"), values, strict=True)}
    if camera.affinity.any():
        out["affinity"] = {"b1": float(camera.affinity[0]), "b2": float(camera.affinity[1])}
    return out


def spline_entry(curve: Curve, prefix: str = "") -> dict[str, Any]:
    """The entry of a spline whose rows stand in the tables of all splines (`prefix` + knots.csv …)."""
    out = _spline_head(curve)
    out["knots"] = {"table": f"{prefix}knots.csv"}
    if curve.reference is not None:
        out["reference_knots"] = {"table": f"{prefix}reference_knots.csv"}
    if curve.check_values is not None:
        out["check_values"] = {"table": f"{prefix}check_values.csv"}
    if curve.check_sigma:
        out["check_sigma_m"] = float(curve.check_sigma)
    return out


def spline_entries(
    curves: Sequence[Curve], origin: FloatArray, prefix: str, files: dict[str, str]
) -> list[dict[str, Any]]:
    """Entries of splines; those of which there are many alike share a table, the others stand one by one.

    Parameters
    ----------
    curves : sequence of Curve
    origin : (3,) metres, of their coordinates
    prefix : str
        Of the names of tables.
    files : dict
        Gets the texts of the tables.
    """
    groups: dict[str, list[Curve]] = {}
    for curve in curves:
        groups.setdefault(_kind(curve), []).append(curve)
    alike = [kind for kind, members in groups.items() if kind and len(members) >= MANY]
    apart = [curve for kind, members in groups.items() if kind not in alike for curve in members]
    place = {curve.id: number for number, curve in enumerate(curves)}
    apart.sort(key=lambda curve: place[curve.id])
    files |= {f"{prefix}{key}.csv": text for key, text in curve_tables(apart, origin).items()}
    entries = [spline_entry(curve, prefix) for curve in apart]
    for number, kind in enumerate(alike):
        file = f"{prefix}splines_{number + 1}.csv"
        files[file] = spline_table(groups[kind], origin)
        entries.append({**_shared(groups[kind][0]), "table": file})
    return entries


def _shared(curve: Curve) -> dict[str, Any]:
    """What the splines of one table have in common."""
    return {k: v for k, v in _spline_head(curve).items() if k not in ("id", "knot_parameters")}


def _kind(curve: Curve) -> str:
    """The same for splines that may share a table; empty where one must stand alone."""
    parameters, reference = curve.knot_parameters, curve.reference
    alone = (
        bool(curve.breaks)
        or curve.check_values is not None
        or bool(curve.check_sigma)
        or (parameters is not None and len(parameters) != len(curve.values))
        or (reference is not None and reference.shape != curve.values.shape)
    )
    return "" if alone else repr((_shared(curve), parameters is None, reference is None))


def inline_spline_entry(curve: Curve) -> dict[str, Any]:
    """The entry of a spline with one σ for all knots (or none: free), its knots as rows in the project file."""
    out = _spline_head(curve)
    sigma = float(curve.sigma[0, 0])
    if not math.isinf(sigma):
        out["sigma"] = sigma_as_written(sigma)
    out["knots"] = curve.values.tolist()
    return out


def _spline_head(curve: Curve) -> dict[str, Any]:
    out: dict[str, Any] = {"id": curve.id, "role": curve.role}
    if curve.family != "natural_cubic":
        out["family"] = curve.family
    if curve.closed:
        out["closed"] = True
    if curve.knot_parameters is not None:
        out["knot_parameters"] = curve.knot_parameters.tolist()
    if curve.parameterization != "chord_length":
        out["parameterization"] = curve.parameterization
    if curve.continuity >= 0:
        out["continuity"] = f"C{curve.continuity}"
    if curve.natural_ends:
        out["natural_ends"] = True
    if curve.tension:
        out["tension"] = float(curve.tension)
    if curve.breaks:
        out["breaks"] = list(curve.breaks)
    return out


def _linked_groups(network: Network, angle_unit: str, files: dict[str, str]) -> dict[str, Any]:
    """Groups of arc lengths (by rule) and of tangents (with and without sense), each with its table."""
    marks = marks_of(network.curve_observations)
    out: dict[str, list[dict[str, Any]]] = {}
    arcs, tangents = network.arc_lengths, network.tangents
    for key, chosen, options in (
        ("arc_lengths", ~arcs.simpson, {"method": "gauss-legendre"}),
        ("arc_lengths", arcs.simpson, {"method": "simpson"}),
        ("tangents", tangents.directed, {"directed": True}),
        ("tangents", ~tangents.directed, {"directed": False}),
    ):
        rows = np.flatnonzero(chosen)
        if not len(rows):
            continue
        file = f"{key}.csv" if key not in out else f"{key}_2.csv"
        if key == "arc_lengths":
            files[file] = arc_lengths_table(network, marks, rows)
        else:
            files[file] = tangents_table(network, marks, rows, angle_unit)
        out.setdefault(key, []).append({"table": file, **options})
    return out


def _distance_groups(network: Network, files: dict[str, str]) -> list[dict[str, str]]:
    """Distances between points and between images, each with its table."""
    out = []
    of_images = network.distances.is_image.all(axis=1)
    for kind, chosen in (("points", ~of_images), ("images", of_images)):
        if chosen.any():
            file = f"distances_{kind}.csv"
            files[file] = distances_table(network, np.flatnonzero(chosen))
            out.append({"table": file, "between": kind})
    return out


def _groups(network: Network, rows: Any, key: str, files: dict[str, str]) -> list[dict[str, str]]:
    """One table for each group of observations, in the order of the groups."""
    names = rows.group_names or (key.replace("_", " "),)
    group = np.zeros(len(rows), dtype=np.int64) if rows.group is None else rows.group
    out = []
    for number, name in enumerate(names):
        chosen = np.flatnonzero(group == number)
        if not len(chosen):
            continue
        stem = "point_observations" if isinstance(rows, PointObservations) else "spline_observations"
        file = f"{stem}.csv" if len(names) == 1 else f"{stem}_{number + 1}.csv"
        changes = {
            field: getattr(rows, field)[chosen]
            for field in ("image", "point", "curve", "photo_xy", "sigma", "location", "segment")
            if hasattr(rows, field)
        }
        marks = None
        if isinstance(rows, CurveObservations) and (len(network.arc_lengths) or len(network.tangents)):
            marks = marks_of(rows)[chosen]
        files[file] = observations_table(network, replace(rows, group=None, group_names=(), **changes), marks)
        out.append({"name": name, "table": file})
    return out
