"""Heat maps of the correlations of orientation unknowns: −1 … 1, the colour fades to nothing at 0."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.orientation_correlations import PARAMETERS, OrientationCorrelations
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.svg_text import escaped_line, number, titled

WHOLE = 12  # images in one matrix
MAPS = 12  # images with a small map, those with the largest |r|
_WIDTH, _CELL, _GAP = 760.0, 24.0, 34.0
_BAR = (-1.0, -0.8, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0)


def correlation_figure(data: ResultData) -> str:
    """One matrix of all images where that is possible, else a small map of every one; empty without dispersion."""
    found = OrientationCorrelations.of(data)
    if found is None or not found.largest().any():
        return ""
    if found.whole is not None and len(found.images) <= WHOLE:
        return _whole(found.images, found.whole)
    return _small(found)


def mapped_images(found: OrientationCorrelations) -> list[int]:
    """Numbers of the images with a small map: the most correlated ones, in their own order."""
    return sorted(np.argsort(-found.largest(), kind="stable")[:MAPS].tolist())


def _small(found: OrientationCorrelations) -> str:
    images = mapped_images(found)
    across = 4
    step_x, step_y = _WIDTH / across, 6 * _CELL + 2 * _GAP - 8
    parts = []
    for k, image in enumerate(images):
        x, y = (k % across) * step_x + 22, (k // across) * step_y + _GAP
        labels = _names_across(x, y, _CELL) + _names_down(x, y, _CELL)
        name = found.images[image]
        parts.append(
            f'<text x="{number(x)}" y="{number(y - 18)}" font-weight="600">{escaped_line(name, 20)}</text>{labels}'
            + _cells(found.inside[image], (x, y), _CELL, [f"image {name} {p}" for p in PARAMETERS])
        )
    height = (1 + (len(images) - 1) // across) * step_y + _GAP
    return _drawing("".join(parts), height)


def _whole(images: tuple[str, ...], matrix: FloatArray) -> str:
    left, top = 92.0, 40.0
    cell = (_WIDTH - left - 40.0) / len(matrix)
    cell = min(cell, 0.75 * _CELL)
    names = [f"image {image} {parameter}" for image in images for parameter in PARAMETERS]
    parts = [_cells(matrix, (left, top), cell, names)]
    size = cell * len(matrix)
    for k, image in enumerate(images):
        begin = 6 * k * cell
        shown = escaped_line(image, 9)
        parts.append(
            f'<text x="{number(left + begin + 3 * cell)}" y="{number(top - 18)}" text-anchor="middle">{shown}</text>'
            f'<text x="{number(left - 24)}" y="{number(top + begin + 3.3 * cell)}" text-anchor="end">{shown}</text>'
            f'<path class="frame" d="M{number(left + begin)} {number(top)}v{number(size)}M{number(left)} '
            f'{number(top + begin)}h{number(size)}"/>'
        )
        if cell >= 11.0:
            parts.append(_names_across(left + begin, top, cell) + _names_down(left, top + begin, cell))
    return _drawing("".join(parts), top + size + 34.0)


def _names_across(x: float, y: float, cell: float) -> str:
    """The six unknowns above a map whose corner is at x, y."""
    return "".join(
        f'<text class="soft" x="{number(x + (i + 0.5) * cell)}" y="{number(y - 4)}" text-anchor="middle">'
        f"{name}</text>"
        for i, name in enumerate(PARAMETERS)
    )


def _names_down(x: float, y: float, cell: float) -> str:
    """The six unknowns to the left of a map."""
    return "".join(
        f'<text class="soft" x="{number(x - 4)}" y="{number(y + (i + 0.72) * cell)}" text-anchor="end">'
        f"{name}</text>"
        for i, name in enumerate(PARAMETERS)
    )


def _cells(r: FloatArray, corner: tuple[float, float], cell: float, names: list[str]) -> str:
    side = number(cell)
    parts = []
    for i, row in enumerate(r):
        y = number(corner[1] + i * cell)
        for j, value in enumerate(row):
            place = f'x="{number(corner[0] + j * cell)}" y="{y}" width="{side}" height="{side}"'
            if np.isnan(value) or (i == j and value == 0.0):
                parts.append(f'<rect class="none" {place}/>')
            elif i == j:
                parts.append(f'<rect class="self" {place}/>')
            else:
                kind = "positive" if value >= 0.0 else "negative"
                tip = f"{names[i]}\n{names[j]}\nr = {value:+.3f}"
                parts.append(titled("rect", f'class="{kind}" fill-opacity="{abs(value):.2f}" {place}', tip))
    return "".join(parts)


def _drawing(parts: str, bottom: float) -> str:
    """The maps with the bar of colours under them."""
    width, left = 34.0, _WIDTH - 34.0 * len(_BAR) - 6.0
    bar = "".join(
        f'<rect class="{"positive" if r >= 0 else "negative"}" fill-opacity="{abs(r):g}" '
        f'x="{number(left + k * width)}" y="{number(bottom)}" width="{number(width)}" height="10"/>'
        f'<text class="soft" x="{number(left + (k + 0.5) * width)}" y="{number(bottom + 23)}" text-anchor="middle">'
        f"{_signed(r)}</text>"
        for k, r in enumerate(_BAR)
    )
    text = f'<text x="{number(left - 10)}" y="{number(bottom + 10)}" text-anchor="end">correlation r</text>'
    view = f"0 0 {number(_WIDTH)} {number(bottom + 28)}"
    return f'<svg class="chart map" viewBox="{view}">{parts}{text}{bar}</svg>'


def _signed(r: float) -> str:
    return "0" if r == 0.0 else f"{r:+.1f}".replace("-", "−")
