"""The project with adjusted values as approximate values: adjusting it again changes nothing.

Cameras, observations, acceptance and notes stay as the user wrote them.  Images, points and splines become
tables: priors and given coordinates stay, approximate values are the adjusted ones, the reference values of
the gauge conditions are kept, and the knots are final.  Standard deviations are the given ones, also where variance
components were estimated: adjusting again estimates the same factors.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import Curve, FloatArray, Network
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.revision.group_weights import with_given_sigma
from splinebba_cli.project.build_curves import position_rows
from splinebba_cli.project.derived_project import (
    first_sections,
    folders_of_tables,
    present_features,
    sections_as_written,
)
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.project.network_tables import points_table
from splinebba_cli.project.observation_marks import marked_tables
from splinebba_cli.project.table_folders import seen_from
from splinebba_cli.project.yaml_writing import project_yaml

PREFIX = "adjusted_"
LOCATED: frozenset[str] = frozenset({"location", "segment"})  # columns that belong to the knots


def adjusted_project(
    loaded: LoadedProject, result: AdjustmentResult, directory: Path | None = None
) -> dict[str, str]:
    """Files (name to text) of the adjusted project, for the result folder.

    Parameters
    ----------
    loaded : LoadedProject
        The project that was adjusted.
    result : AdjustmentResult
    directory : Path, optional
        The folder in which the files will lie: tables of observations are referred to from there; without it
        by absolute paths.

    Returns
    -------
    dict
        ``adjusted.yaml`` and its tables ``adjusted_*.csv``.
    """
    network = with_given_sigma(adjusted_network(result), result.evidence.variance_components)
    written = sections_as_written(loaded)
    data, files = first_sections(loaded, network, PREFIX)
    if network.points.ids:
        files[f"{PREFIX}points.csv"] = points_table(network)
        data["points"] = {"table": f"{PREFIX}points.csv"}
    of_old_knots = LOCATED if _knots_changed(loaded.network, network) else frozenset()
    marked = marked_tables(loaded, result, of_old_knots)
    files |= {_marked_name(*group): text for group, text in marked.items() if text}
    data["observations"] = _observations(written.get("observations", {}), loaded, network, directory, marked)
    tables = [group.get("table") or PREFIX for groups in data["observations"].values() for group in groups]
    if not all(table.startswith(PREFIX) for table in tables):
        data["project"]["table_folders"] = folders_of_tables(loaded, directory)
    data["adjustment"] = {**written.get("adjustment", {}), "staged": False}
    if "datum_features" in data["adjustment"]:
        data["adjustment"]["datum_features"] = present_features(data["adjustment"]["datum_features"], network)
    if (
        "outliers" in data["adjustment"]
    ):  # approximate values are final, and what a robust start found is marked
        data["adjustment"]["outliers"] = {
            k: v for k, v in data["adjustment"]["outliers"].items() if k != "start"
        }
    if data["adjustment"].pop("knots", None) is not None:
        data["adjustment"]["gauge_conditions"] = "all"  # as where the program spaces the knots
    for section in ("matching", "acceptance", "simulation"):
        if section in written:
            data[section] = written[section]
    comment = "Adjusted values as approximate values; the knots are final."
    files["adjusted.yaml"] = project_yaml(data, comment)
    return files


def adjusted_network(result: AdjustmentResult) -> Network:
    """The network of a result with adjusted values as approximate values; priors and given values stay."""
    network = result.network
    images = replace(
        network.images,
        rotation=result.images.rotation,
        position=result.images.eop[:, 3:] - network.origin,
    )
    roles = np.array([role == "check" for role in network.points.role], dtype=bool)[:, None]
    given = np.isfinite(network.points.sigma) | roles
    xyz = np.where(given, network.points.xyz, result.points.xyz - network.origin)
    curves = _adjusted_curves(network.curves, CurveColumns.of(result.curves), network.origin)
    return replace(network, images=images, points=replace(network.points, xyz=xyz), curves=curves)


def _adjusted_curves(curves: tuple[Curve, ...], found: CurveColumns, origin: FloatArray) -> tuple[Curve, ...]:
    """The curves with adjusted free values; splines keep the knot parameters of the adjustment."""
    if not curves:
        return ()
    moved = np.concatenate([position_rows(curve) for curve in curves])[:, None] * origin
    given = np.isfinite(np.concatenate([curve.sigma for curve in curves]))
    values = np.where(given, np.concatenate([curve.values for curve in curves]), found.values - moved)
    reference = found.reference - moved
    bounds, interval = found.value_bounds.tolist(), found.segments.interval
    out = []
    for k, curve in enumerate(curves):
        own, parameters = slice(bounds[k], bounds[k + 1]), curve.knot_parameters
        if FAMILIES[curve.family].keeps_parameters:
            first, end = int(found.segment_bounds[k]), int(found.segment_bounds[k + 1])
            parameters = np.append(interval[first:end, 0], interval[end - 1, 1])
        out.append(
            replace(
                curve,
                values=values[own],
                knot_parameters=parameters,
                reference=None if curve.role == "control" else reference[own],
            )
        )
    return tuple(out)


def _observations(
    written: dict[str, Any],
    loaded: LoadedProject,
    network: Network,
    directory: Path | None,
    marked: dict[tuple[str, int], str],
) -> dict[str, Any]:
    """The groups of observations, their tables as seen from the result folder; `marked` ones have a new table.

    A marked group whose table is empty measures nothing that takes part.
    """
    moved: dict[str, Any] = {}
    changed = _knots_changed(loaded.network, network)
    for kind, groups in written.items():
        moved[kind] = []
        for number, group in enumerate(groups):
            if marked.get((kind, number)) == "":
                continue
            group = dict(group)
            if group.get("table"):
                group.setdefault("name", group["table"])  # by which results call it
            if (kind, number) in marked:
                for option in ("data", "columns", "header", "delimiter"):
                    group.pop(option, None)
                group["table"] = _marked_name(kind, number)
            elif group.get("table"):
                group["table"] = seen_from(directory, os.path.realpath(loaded.path.parent / group["table"]))
            if changed and kind == "spline_points":
                group = _without_locations(group)
            moved[kind].append(group)
    return moved


def _marked_name(kind: str, number: int) -> str:
    return f"{PREFIX}{kind}_{number + 1}.csv"


def _knots_changed(before: Network, after: Network) -> bool:
    return any(a.values.shape != b.values.shape for a, b in zip(before.curves, after.curves, strict=True))


def _without_locations(group: dict[str, Any]) -> dict[str, Any]:
    """Approximate locations and segments belong to the knots that were; without them they are found anew."""
    columns = group.get("columns")
    if isinstance(columns, list):
        return {**group, "columns": ["-" if name in LOCATED else name for name in columns]}
    if isinstance(columns, dict):
        return {**group, "columns": {k: v for k, v in columns.items() if k not in LOCATED}}
    return group
