"""Tables (CSV) of unlabelled points and chains in photo coordinates, one for each group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from splinebba_cli.core.network import IntArray, Network, UnlabelledPoints
from splinebba_cli.project.build_images import ANGLE_FACTORS
from splinebba_cli.project.network_tables import csv_text, numbers


def chain_groups(network: Network, angle_unit: str, files: dict[str, str]) -> list[dict[str, Any]]:
    """Groups of chains for the project file; `files` gets their tables."""
    points = network.unlabelled
    names = points.group_names or ("chains",)
    group = np.zeros(len(points), dtype=np.int64) if points.group is None else points.group
    out = []
    for number, name in enumerate(names):
        rows = np.flatnonzero(group == number)
        if not len(rows):
            continue
        file = "chains.csv" if len(names) == 1 else f"chains_{number + 1}.csv"
        entry: dict[str, Any] = {"name": name, "table": file, "image_coordinates": "photo_mm"}
        sigma = points.sigma[rows]
        if (sigma == sigma[0]).all():
            x, y = sigma[0].tolist()
            entry["sigma_mm"] = x if x == y else [x, y]
        files[file] = _table(network, rows, angle_unit, with_sigma="sigma_mm" not in entry)
        out.append(entry)
    return out


def _table(network: Network, rows: IntArray, angle_unit: str, *, with_sigma: bool) -> str:
    points = network.unlabelled
    columns: dict[str, Sequence[str]] = {"image": [network.images.ids[k] for k in points.image[rows]]}
    if (points.chain[rows] >= 0).any():
        columns["chain"] = _chain_names(network, points, rows)
    columns |= {axis: numbers(points.photo_xy[rows, k]) for k, axis in enumerate("xy")}
    if np.isfinite(points.direction[rows]).any():
        columns["direction"] = numbers(points.direction[rows] / ANGLE_FACTORS[angle_unit])
    if with_sigma:
        columns |= {f"sigma_{axis}_mm": numbers(points.sigma[rows, k]) for k, axis in enumerate("xy")}
    if points.excluded is not None and points.excluded[rows].any():
        columns["use"] = ["no" if out else "yes" for out in points.excluded[rows]]
    return csv_text(list(columns), zip(*columns.values(), strict=True))


def _chain_names(network: Network, points: UnlabelledPoints, rows: IntArray) -> list[str]:
    """Names of the chains as people have them, without their image in front; empty for single points."""
    return [
        points.chain_ids[chain].removeprefix(f"{network.images.ids[image]}/") if chain >= 0 else ""
        for chain, image in zip(points.chain[rows].tolist(), points.image[rows].tolist(), strict=True)
    ]
