"""Standard ellipses in a view of the block, enlarged by a round factor that the legend names.

The ellipsoid with the semi-axes a_k along e_k gives C = Σ a_k² e_k e_kᵀ; the ellipse of a parallel projection P has

    P C Pᵀ = Q diag(λ₁, λ₂) Qᵀ,   semi-axes √λ along the columns of Q
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.output.read_table import ReadTable
from splinebba_cli.report.canvas import INK
from splinebba_cli.report.object_view import ObjectView
from splinebba_cli.report.scale import grouped, length_scale, round_length
from splinebba_cli.report.svg_text import Tips

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DRAWN = 400
_SHARE = 0.03  # of the extent, for the semi-major axis at the 90th percentile
_MOST = 0.09  # of the extent, for the largest semi-major axis


def draw_ellipses(axes: Axes, view: ObjectView, extent: FloatArray, tips: Tips) -> None:
    """Ellipses of stations and points; of very many positions those that are evenly spread over the list."""
    from matplotlib.collections import LineCollection

    table = view.data.ellipses
    if not table.rows:
        return
    semi_axes, directions = projected_ellipses(table, view.axes)
    place = _places(view)
    keys = list(zip(table["kind"], table["id"], strict=True))
    kept = [row for row, key in enumerate(keys) if key in place and semi_axes[row, 0] > 0.0]
    step = 1 + len(kept) // _DRAWN
    kept = kept[::step]
    if not kept:
        return
    factor = enlargement(semi_axes[kept, 0], float((extent[1] - extent[0]).max()))
    phi = np.linspace(0.0, 2.0 * np.pi, 33)
    circle = np.stack([np.cos(phi), np.sin(phi)])
    lines = [
        place[keys[row]] + factor * (directions[row] @ (semi_axes[row][:, None] * circle)).T for row in kept
    ]
    name = f"standard ellipse × {grouped(factor)}" + (f" (1 of {step})" if step > 1 else "")
    drawn = LineCollection(lines, colors=INK, linewidths=0.7, alpha=0.8, label=name)
    tips.on(drawn, [_tip(keys[row], semi_axes[row]) for row in kept])
    axes.add_collection(drawn)


def enlargement(semi_major: FloatArray, size: float) -> float:
    """A round factor with which most ellipses can be seen, and none covers a drawing of this size."""
    usual, largest = np.percentile(semi_major, (90.0, 100.0)).tolist()
    return round_length(size * min(_SHARE / usual, _MOST / largest))


def projected_ellipses(table: ReadTable, axes: list[int]) -> tuple[FloatArray, FloatArray]:
    """Semi-axes (n, 2), the larger first, and their directions in the plane as columns (n, 2, 2)."""
    covariance = np.zeros((table.rows, 2, 2))
    for k in (1, 2, 3):
        axis = np.stack([table.numbers(f"ellipsoid_{k}_{name}") for name in "xyz"], axis=1)[:, axes]
        scaled = np.nan_to_num(table.numbers(f"ellipsoid_{k}_m")[:, None] * axis)
        covariance += scaled[:, :, None] * scaled[:, None, :]
    values, vectors = np.linalg.eigh(covariance)
    return np.sqrt(np.maximum(values[:, ::-1], 0.0)), vectors[:, :, ::-1]


def _tip(key: tuple[str, str], semi_axes: FloatArray) -> str:
    scale = length_scale(semi_axes.tolist())
    return f"{key[0]} {key[1]}: standard ellipse\n{scale.text(semi_axes[0])} × {scale.text(semi_axes[1])}"


def _places(view: ObjectView) -> dict[tuple[str, str], FloatArray]:
    """Positions of images and points in the plane by kind and id."""
    found: dict[tuple[str, str], FloatArray] = {}
    for kind, xy in (("image", view.stations), ("point", view.points(view.data["points"]))):
        found |= {(kind, item["id"]): xy[i] for i, item in enumerate(view.data[f"{kind}s"])}
    return found
