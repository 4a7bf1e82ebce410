"""The project with the labels that matching has found: it can be checked, adjusted, and matched again.

Cameras, points, other observations, settings and notes stay as the user wrote them.  Images and splines become tables:
approximate orientations are the best ones known, built splines are among the others.  The matched points of every group
of chains are a group of spline points, the others stay chains.  Images in which nothing is measured are left out, since
nothing determines them, and with them their chains.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.network import BoolArray, Images, IntArray, Network
from splinebba_cli.project.derived_project import (
    first_sections,
    folders_of_tables,
    present_features,
    sections_as_written,
)
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.project.matched_tables import ChainTable, chain_tables, matched_columns
from splinebba_cli.project.table_folders import seen_from
from splinebba_cli.project.yaml_writing import project_yaml

MATCHED_FILE = "matched.yaml"
PREFIX = "matched_"
TABLE_OPTIONS = ("table", "data", "columns", "header", "delimiter", "angle_unit")


def matched_project(
    loaded: LoadedProject, result: MatchResult, directory: Path | None = None
) -> dict[str, str]:
    """Files (name to text) of the matched project.

    Parameters
    ----------
    loaded : LoadedProject
        The project that was matched.
    result : MatchResult
    directory : Path, optional
        The folder in which the files will lie: tables that stay are referred to from there; without it by absolute
        paths.

    Returns
    -------
    dict
        ``matched.yaml``, its tables ``matched_*.csv``, and ``unmatched_points*.csv`` for people.
    """
    kept = images_kept(result.network)
    network = replace(result.network, images=_some_images(result.network.images, np.flatnonzero(kept)))
    written = sections_as_written(loaded)
    data, files = first_sections(loaded, network, PREFIX)
    if "points" in written:
        data["points"] = [_moved(entry, loaded, directory) for entry in written["points"]]
    observations = {
        kind: [_moved(group, loaded, directory) for group in groups]
        for kind, groups in written.get("observations", {}).items()
        if kind != "chains"
    }
    data["observations"] = _labelled(observations, loaded, result, kept, files)
    if _refers_elsewhere(data):
        data["project"]["table_folders"] = folders_of_tables(loaded, directory)
    if "adjustment" in written:
        data["adjustment"] = dict(written["adjustment"])
        if "datum_features" in data["adjustment"]:
            features = data["adjustment"]["datum_features"]
            data["adjustment"]["datum_features"] = present_features(features, network)
    data["matching"] = written.get("matching", {})
    for section in ("acceptance", "simulation"):
        if section in written:
            data[section] = written[section]
    files[MATCHED_FILE] = project_yaml(
        data, "Labels found by matching; what found no spline is left in chains."
    )
    return files


def images_kept(network: Network) -> BoolArray:
    """Images that can be adjusted: something is measured in them, nothing of them is estimated, or bases end there."""
    kept = np.zeros(len(network.images.ids), dtype=bool)
    kept[np.isfinite(network.images.prior_sigma).all(axis=1)] = True
    for observed in (network.point_observations, network.curve_observations):
        kept[observed.image] = True
    distances = network.distances
    kept[distances.station[distances.is_image]] = True
    return kept


def _some_images(images: Images, rows: IntArray) -> Images:
    return Images(
        ids=tuple(images.ids[k] for k in rows),
        camera=images.camera[rows],
        rotation=images.rotation[rows],
        position=images.position[rows],
        sequence=tuple(images.sequence[k] for k in rows),
        prior=images.prior[rows],
        prior_sigma=images.prior_sigma[rows],
    )


def _moved(entry: dict[str, Any], loaded: LoadedProject, directory: Path | None) -> dict[str, Any]:
    """An entry whose table is named as seen from the new folder."""
    if not entry.get("table"):
        return entry
    return {**entry, "table": seen_from(directory, os.path.realpath(loaded.path.parent / entry["table"]))}


def _refers_elsewhere(data: dict[str, Any]) -> bool:
    """Whether a table of the user's is read."""
    groups = [*data.get("points", ()), *(group for kind in data["observations"].values() for group in kind)]
    return any(not group.get("table", PREFIX).startswith(PREFIX) for group in groups)


def _labelled(
    observations: dict[str, Any],
    loaded: LoadedProject,
    result: MatchResult,
    kept: BoolArray,
    files: dict[str, str],
) -> dict[str, Any]:
    """The observations with the groups of matched points, and the chains that are left."""
    labelled, left = [], []
    linked = bool(len(result.given.arc_lengths) or len(result.given.tangents))
    tables = chain_tables(loaded, result)
    written = sections_as_written(loaded)["observations"]["chains"]
    for number, (table, entry) in enumerate(zip(tables, written, strict=True), start=1):
        suffix = "" if len(tables) == 1 else f"_{number}"
        options = {key: value for key, value in entry.items() if key not in TABLE_OPTIONS}
        options = {"name": table.name, **options}
        if table.matched.any():
            name = f"{PREFIX}points{suffix}.csv"
            files[name] = table.matched_text(marked=linked)
            columns = {column: column for column in matched_columns(table, marked=linked)}
            labelled.append({**options, "table": name, "columns": columns})
        if not table.matched.all():
            files[f"unmatched_points{suffix}.csv"] = table.unmatched_text()
        rest = ~table.matched & kept[table.image]
        if rest.any():
            name = f"{PREFIX}chains{suffix}.csv"
            files[name] = table.chains_text(rest)
            left.append({**options, "table": name, **_angle_unit(entry, table, loaded)})
    out = dict(observations)
    if labelled:
        out["spline_points"] = [*out.get("spline_points", ()), *labelled]
    if left:
        out["chains"] = left
    return out


def _angle_unit(entry: dict[str, Any], table: ChainTable, loaded: LoadedProject) -> dict[str, str]:
    """The unit of directions where it is not that of the project."""
    unit = entry.get("angle_unit")
    return {} if unit is None or not table.has("direction") else {"angle_unit": unit}
