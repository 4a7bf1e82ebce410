"""What projects that the program derives from a user's have in common: adjusted ones, matched ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from splinebba_cli.core.network import Network
from splinebba_cli.project.loading import LoadedProject
from splinebba_cli.project.network_tables import images_table
from splinebba_cli.project.table_folders import folders_seen_from
from splinebba_cli.project.writer import spline_entries


def sections_as_written(loaded: LoadedProject) -> dict[str, Any]:
    """The sections of the user's file as plain data, without what is not in it."""
    written: dict[str, Any] = loaded.model.model_dump(mode="json", exclude_unset=True, by_alias=True)
    return written


def project_info(loaded: LoadedProject, network: Network) -> dict[str, Any]:
    """The section `project`, with the units and the origin of derived tables; without folders of tables."""
    project = loaded.model.project
    written = sections_as_written(loaded)["project"]
    written.pop("table_folders", None)
    return {
        **written,
        "angle_unit": project.angle_unit or "deg",
        "rotation_sequence": project.rotation_sequence or "omega-phi-kappa",
        "local_origin": network.origin.tolist(),
    }


def first_sections(
    loaded: LoadedProject, network: Network, prefix: str
) -> tuple[dict[str, Any], dict[str, str]]:
    """The sections from `version` to `splines`, images and splines as tables; and these tables, name to text.

    Parameters
    ----------
    prefix : of the names of tables
    """
    written, info = sections_as_written(loaded), project_info(loaded, network)
    files = {f"{prefix}images.csv": images_table(network, info["angle_unit"])}
    data: dict[str, Any] = {
        "version": written["version"],
        "project": info,
        "cameras": written["cameras"],
        "images": {"table": f"{prefix}images.csv"},
    }
    if network.curves:
        data["splines"] = spline_entries(network.curves, network.origin, prefix, files)
    return data, files


def folders_of_tables(loaded: LoadedProject, directory: Path | None) -> list[str]:
    """The folders of the user's tables as a derived project in `directory` names them."""
    return folders_seen_from(directory, loaded.path.parent, loaded.model.project.table_folders)


def present_features(features: dict[str, Any], network: Network) -> dict[str, Any]:
    """Datum features without those that a derived project does not have."""
    ids = {
        "points": network.points.ids,
        "images": network.images.ids,
        "splines": tuple(curve.id for curve in network.curves),
    }
    return {
        key: [one for one in chosen if one in ids[key]] if isinstance(chosen, list) else chosen
        for key, chosen in features.items()
    }
