"""Standard ellipses in the block plan, enlarged by a round factor that the legend names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.canvas import INK
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import round_length

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DRAWN = 400
_SHARE = 0.03  # of the extent, for the semi-major axis at the 90th percentile


def draw_ellipses(axes: Axes, data: ResultData, extent: FloatArray) -> None:
    """Ellipses of stations and points; of very many positions those that are evenly spread over the list."""
    table = data.ellipses
    if not table.rows:
        return
    major, minor = table.numbers("semi_major_m"), table.numbers("semi_minor_m")
    azimuth = np.radians(table.numbers("azimuth_deg"))
    place = _places(data)
    keys = list(zip(table["kind"], table["id"], strict=True))
    kept = [row for row, key in enumerate(keys) if key in place and major[row] > 0.0]
    kept = kept[:: 1 + len(kept) // _DRAWN]
    if not kept:
        return
    factor = round_length(
        _SHARE * float((extent[1] - extent[0]).max()) / float(np.percentile(major[kept], 90))
    )
    phi = np.linspace(0.0, 2.0 * np.pi, 41)
    along = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    lines = [
        place[keys[row]]
        + factor * major[row] * np.cos(phi)[:, None] * along[row]
        + factor * minor[row] * np.sin(phi)[:, None] * across[row]
        for row in kept
    ]
    _draw(axes, lines, factor)


def _draw(axes: Axes, lines: list[FloatArray], factor: float) -> None:
    from matplotlib.collections import LineCollection

    name = f"standard ellipse × {factor:,.0f}" if factor >= 1.0 else f"standard ellipse × {factor:g}"
    axes.add_collection(
        LineCollection(lines, colors=INK, linewidths=0.7, alpha=0.8, label=name.replace(",", " "))
    )


def _places(data: ResultData) -> dict[tuple[str, str], FloatArray]:
    """Horizontal positions of images and points by kind and id."""
    return {
        (kind, item["id"]): np.array([item["x"], item["y"]], dtype=float)
        for kind in ("image", "point")
        for item in data[f"{kind}s"]
    }
