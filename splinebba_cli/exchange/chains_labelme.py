"""Chains in a file of labelme: its shapes ``linestrip``, ``line`` and ``polygon``.

A label is a class, which many shapes share: the chains of one label are numbered.  A polygon is a chain that ends where
it begins.  Coordinates are those of the page on which the image is drawn: the corner of the first pixel is (0, 0).
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.exchange.traced_chains import TracedChain, TracingOptions, image_name, warn_of_others
from splinebba_cli.project.diagnostics import Collector, Place

LINES = ("linestrip", "line", "polygon")
_OF_OLD_FILES = "polygon"  # shapes without a type


def chains_from_labelme(
    data: dict[str, Any], file: str, image: str, options: TracingOptions, collector: Collector
) -> list[TracedChain]:
    """Chains of the data of a labelme file; errors go to the collector.

    Parameters
    ----------
    image : str
        Where the file has no ``imagePath``.
    """
    place = Place(file)
    path, shapes = data.get("imagePath"), data["shapes"]
    if isinstance(path, str) and path.strip():
        image = image_name(path.strip(), options)
    if not isinstance(shapes, list) or not all(isinstance(shape, dict) for shape in shapes):
        collector.error("SBB332", "`shapes` is no list of shapes", place)
        return []
    chains: list[TracedChain] = []
    of_label: Counter[str] = Counter()
    passed_over = []
    for number, shape in enumerate(shapes, start=1):
        kind = str(shape.get("shape_type") or _OF_OLD_FILES)
        if kind not in LINES:
            passed_over.append(kind)
            continue
        xy = _points(shape.get("points"))
        if xy is None:
            collector.error("SBB332", f"the points of shape {number} are no list of [x, y]", place)
            continue
        label = str(shape.get("label") or "").strip()
        of_label[label] += 1
        if kind == "polygon" and len(xy):
            xy = np.concatenate([xy, xy[:1]])
        chains.append(TracedChain(image, f"{label}-{of_label[label]}" if label else "", xy, place))
    warn_of_others(passed_over, file, collector)
    return chains


def _points(rows: Any) -> FloatArray | None:
    """Points, (n, 2); None where they are something else."""
    try:
        xy = np.array(rows, dtype=float)
    except (TypeError, ValueError):
        return None
    return xy if xy.ndim == 2 and xy.shape[1] == 2 else None
