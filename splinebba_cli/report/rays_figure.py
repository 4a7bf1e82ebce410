"""Where along a spline every image has measured it: one row an image, knots as lines, gaps to be seen."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.result_data import ResultData, SplineSamples
from splinebba_cli.report.scale import length_scale
from splinebba_cli.report.svg_text import escaped_line, number, titled

ROWS = 40  # images, those with the most points
_LEFT, _RIGHT, _TOP, _ROW, _BOTTOM, _WIDTH = 96.0, 52.0, 18.0, 15.0, 36.0, 760.0
_TICKS = 5


def rays_figure(data: ResultData, spline_id: str) -> str:
    """SVG of the measured points along one spline; empty without samples or measured points."""
    samples, rays = data.samples_by_spline.get(spline_id), measured_along(data, spline_id)
    if samples is None or len(samples.u) < 2 or not rays:
        return ""
    spline = next(spline for spline in data["splines"] if spline["id"] == spline_id)
    distance = lengths(samples, closed=spline["closed"])
    u = samples.u if len(distance) == len(samples.u) else np.append(samples.u, _end(samples))
    scale = (_WIDTH - _LEFT - _RIGHT) / max(float(distance[-1]), 1e-12)
    chosen = sorted(rays, key=lambda image: -len(rays[image]))[:ROWS]
    rows = [image for image in rays if image in set(chosen)]
    bottom = _TOP + _ROW * len(rows)
    parts = [_knots(np.interp(spline["knot_parameters"], u, distance) * scale + _LEFT, bottom)]
    for row, image in enumerate(rows):
        along = np.sort(np.interp(rays[image], u, distance))
        parts.append(_row(image, along, _TOP + _ROW * row, scale))
    parts.append(_axis(float(distance[-1]), bottom, scale))
    return (
        f'<svg class="chart" viewBox="0 0 {number(_WIDTH)} {number(bottom + _BOTTOM)}">{"".join(parts)}</svg>'
    )


def measured_along(data: ResultData, spline_id: str) -> dict[str, FloatArray]:
    """Locations u of the measured points of one spline by image, in the order of the images."""
    return data.locations_by_spline.get(spline_id, {})


def longest_gap(data: ResultData, spline: dict[str, Any]) -> float | None:
    """The longest part, in metres, that no image has measured; None without measured points."""
    samples, rays = data.samples_by_spline.get(spline["id"]), measured_along(data, spline["id"])
    if samples is None or len(samples.u) < 2 or not rays:
        return None
    distance = lengths(samples, closed=spline["closed"])
    along = np.interp(np.concatenate(list(rays.values())), samples.u, distance[: len(samples.u)])
    total = float(distance[-1])
    ends = [float(along.min()) + total] if spline["closed"] else [0.0, total]
    return float(np.diff(np.sort(np.append(along, ends))).max(initial=0.0))


def lengths(samples: SplineSamples, *, closed: bool = False) -> FloatArray:
    """Distance along the curve at every sample, and at the end of a closed one, metres."""
    xyz = np.concatenate([samples.xyz, samples.xyz[:1]]) if closed else samples.xyz
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz, axis=0), axis=1))])


def _end(samples: SplineSamples) -> float:
    return float(2.0 * samples.u[-1] - samples.u[-2])


def _knots(x: FloatArray, bottom: float) -> str:
    lines = "".join(
        titled("path", f'class="axis" d="M{number(each)} {number(_TOP - 4)}V{number(bottom)}"', f"knot {i}")
        for i, each in enumerate(x)
    )
    kept: list[int] = []
    for i, each in enumerate(x):
        if not kept or each - x[kept[-1]] > 18.0:
            kept.append(i)
    names = "".join(f'<text class="soft" x="{number(x[i])}" y="11">{i}</text>' for i in kept)
    title = f'<text class="soft" x="{number(_LEFT - 8)}" y="11" text-anchor="end">knot</text>'
    return f'{title}<g text-anchor="middle">{names}</g>{lines}'


def _row(image: str, along: FloatArray, top: float, scale: float) -> str:
    marks = "".join(f"M{number(_LEFT + scale * x, 1)} {number(top + 2)}v{number(_ROW - 5)}" for x in along)
    base = top + _ROW - 3
    unit = length_scale([float(along[-1])])
    tip = f"image {image}: {len(along)} points\nfrom {unit.text(float(along[0]))} to {unit.text(float(along[-1]))}"
    if len(along) > 1:
        gap = float(np.diff(along).max())
        tip += f"\nlongest gap {length_scale([gap]).text(gap)}"
    return (
        f'<path class="axis" d="M{number(_LEFT)} {number(base)}H{number(_WIDTH - _RIGHT)}"/>'
        f'<text x="{number(_LEFT - 8)}" y="{number(base)}" text-anchor="end">{escaped_line(image, 12)}</text>'
        f'<text class="soft" x="{number(_WIDTH - _RIGHT + 8)}" y="{number(base)}">{len(along)}</text>'
        + titled("path", f'class="rays" d="{marks}"', tip)
    )


def _axis(length: float, bottom: float, scale: float) -> str:
    from matplotlib.ticker import MaxNLocator

    ticks = [t for t in MaxNLocator(_TICKS, steps=[1, 2, 5, 10]).tick_values(0.0, length) if 0 <= t <= length]
    labels = "".join(
        f'<text class="soft" x="{number(_LEFT + scale * t)}" y="{number(bottom + 15)}">{t:g}</text>'
        for t in ticks
    )
    marks = "".join(f"M{number(_LEFT + scale * t)} {number(bottom)}v4" for t in ticks)
    middle = 0.5 * (_LEFT + _WIDTH - _RIGHT)
    return (
        f'<path class="frame" d="M{number(_LEFT)} {number(bottom)}H{number(_WIDTH - _RIGHT)}{marks}"/>'
        f'<g text-anchor="middle">{labels}<text x="{number(middle)}" y="{number(bottom + 31)}">distance along the '
        "spline [m]</text></g>"
    )
