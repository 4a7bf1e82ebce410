"""Residual vectors in every image: the worst images at once, more of them to choose from."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.report.measured_image import MeasuredPoints
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.scale import round_length
from splinebba_cli.report.svg_text import escaped_line
from splinebba_cli.report.vectors_panel import Panel

SHOWN = 6  # images that are drawn at once
VECTORS = 20_000  # of all images together
_LONG = 0.06  # of the image format: vector at the 90th percentile

_MARKS = (
    ("d-point", "●", "point"),
    ("d-spline", "●", "on a spline, across the curve"),
    ("d-bad", "━", "|w| beyond the critical value"),
    ("d-bad", "✕", "rejected or excluded"),
    ("", "+", "principal point"),
)
_LEGEND = "".join(f'<span><i class="{kind}">{mark}</i> {text}</span>' for kind, mark, text in _MARKS)


def image_vectors(data: ResultData) -> str:
    """Panels of the images with the largest root mean square; empty without residuals."""
    if not data.image_points.rows:
        return ""
    points = MeasuredPoints.of(data)
    factor = enlargement(data, points)
    panel = Panel(data, points, factor)
    images = drawn_images(points)
    first = "".join(panel.svg(image) for image in images[:SHOWN])
    text = f'<p class="legend">{_LEGEND}</p><div class="panels">{first}</div>'
    if len(images) > SHOWN:
        rest = "".join(
            f"<details><summary>{escaped_line(image)}</summary>{panel.svg(image)}</details>"
            for image in sorted(images[SHOWN:], key=_natural)
        )
        text += f'<div class="choice" data-label="Another image">{rest}</div>'
    return text


def drawn_images(points: MeasuredPoints) -> list[str]:
    """The images that have a drawing, the worst first: as many as the page can carry."""
    order = list(points.worst_first())
    total = np.cumsum([min(len(points.rows[image]), Panel.DRAWN) for image in order])
    return order[: max(SHOWN, int(np.searchsorted(total, VECTORS, side="right")))]


def enlargement(data: ResultData, points: MeasuredPoints) -> float:
    """One round factor for all images: their vectors can be compared."""
    length = np.hypot(*points.vector[~points.out].T)
    length = length[np.isfinite(length) & (length > 0.0)]
    if not len(length):
        return 1.0
    return round_length(_LONG * _format(data, points) / float(np.percentile(length, 90)))


def _format(data: ResultData, points: MeasuredPoints) -> float:
    sizes = [max(camera["format_mm"]) for camera in data["cameras"] if camera["format_mm"] is not None]
    return float(np.median(sizes)) if sizes else float(np.nanmax(np.ptp(points.xy, axis=0)))


def _natural(name: str) -> tuple[Any, ...]:
    return (0, int(name), "") if name.isascii() and name.isdigit() else (1, 0, name)
