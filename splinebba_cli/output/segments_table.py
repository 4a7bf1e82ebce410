"""Segments of splines that stand in their table alone, as result.json of a smaller network has them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.output.read_table import read_table


def with_segments(content: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The content of result.json with the segments of all splines.

    Parameters
    ----------
    content : dict
        As it is stored; taken as it is where the segments stand in it.
    folder : Path
        The result folder.
    """
    name = content.get("segments_table")
    if name is None:
        return content
    table = read_table(folder, name)
    if not table.rows:
        return content
    letters = {
        f"{sigma}{axis}": [f"{sigma}{axis}{power}_m" for power in range(4)] for sigma, axis in _LETTERS
    }
    interval = np.stack([table.numbers("u_start"), table.numbers("u_end")], axis=1)
    columns = {key: np.stack([table.numbers(one) for one in names], axis=1) for key, names in letters.items()}
    segments: dict[str, list[dict[str, Any]]] = {}
    for row, spline in enumerate(table["spline"]):
        found = {"interval": interval[row].tolist(), **{key: _row(columns[key][row]) for key in letters}}
        segments.setdefault(spline, []).append(found)
    splines = [{**spline, "segments": segments.get(spline["id"], [])} for spline in content["splines"]]
    return {**content, "splines": splines}


_LETTERS = [(sigma, axis) for sigma in ("", "sigma_") for axis in "abc"]


def _row(values: Any) -> list[float | None]:
    return [None if x != x else x for x in values.tolist()]
