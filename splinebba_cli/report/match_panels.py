"""Images with their chains, matched and unmatched, and the curves as the images see them; as SVG."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.network import Camera, FloatArray, IntArray
from splinebba_cli.project.matched_tables import reason_word
from splinebba_cli.report.projected_curves import ProjectedCurves
from splinebba_cli.report.svg_text import escaped_line, number, titled

SHOWN = 6  # images that are drawn at once
POINTS = 60_000  # of all images together that are drawn
_WIDTH, _EDGE = 400.0, 1.0
_KINDS = ("matched", "new", "unmatched")
_MARKS = (
    ("d-matched", "━", "on a spline of the project"),
    ("d-unmatched", "━", "unmatched"),
    ("d-projected", "╌", "projected spline"),
)
_MARKS_OF_NEW = (("d-new", "━", "on a new spline"), ("d-weak", "╍", "weak part of a new spline"))


def match_images(result: MatchResult, images: list[dict[str, Any]]) -> str:
    """Panels of the images with the smallest matched share, further ones to choose from.

    Parameters
    ----------
    images : of match.json
    """
    order = drawn_images(images)
    panels = _Panels(result)
    first = "".join(panels.svg(k, images[k]) for k in order[:SHOWN])
    marks = (*_MARKS, *(_MARKS_OF_NEW if result.built else ()))
    legend = "".join(f'<span><i class="{kind}">{mark}</i> {text}</span>' for kind, mark, text in marks)
    text = f'<p class="legend">{legend}</p><div class="panels">{first}</div>'
    rest = order[SHOWN:]
    if rest:
        more = "".join(
            f"<details><summary>{escaped_line(images[k]['id'])}</summary>{panels.svg(k, images[k])}</details>"
            for k in sorted(rest)
        )
        text += f'<div class="choice" data-label="Another image">{more}</div>'
    return text


def drawn_images(images: list[dict[str, Any]]) -> list[int]:
    """Numbers of the images that have a drawing, the smallest matched share first."""
    order = [k for k in range(len(images)) if images[k]["points"]]
    order.sort(key=lambda k: (images[k]["share"], k))
    total = np.cumsum([images[k]["points"] for k in order])
    return order[: max(SHOWN, int(np.searchsorted(total, POINTS, side="right")))]


class _Panels:
    """Draws images of one result."""

    def __init__(self, result: MatchResult) -> None:
        self._result, self._points = result, result.given.unlabelled
        self._curves = ProjectedCurves.of(result.network, result.built)
        self._names = [curve.id for curve in result.network.curves]
        built = np.zeros(len(self._names) + 1, dtype=bool)
        built[[each.curve for each in result.built]] = True
        curve = result.matches.curve
        self._kind = np.where(curve < 0, 2, np.where(built[curve], 1, 0))
        order = np.argsort(self._points.image, kind="stable")
        starts = np.searchsorted(self._points.image[order], np.arange(len(result.given.images.ids) + 1))
        self._rows = [order[a:b] for a, b in pairwise(starts)]

    def svg(self, image: int, about: dict[str, Any]) -> str:
        """The drawing of one image."""
        rows = self._rows[image]
        camera = self._result.given.cameras[int(self._result.given.images.camera[image])]
        half = _half(self._points.photo_xy[rows], camera)
        scale = 0.5 * (_WIDTH - 2.0) / half[0]
        height = 2.0 * half[1] * scale
        middle = np.array([0.5 * _WIDTH, _EDGE + 0.5 * height])
        flip = scale * np.array([1.0, -1.0])
        parts = [_frame(camera, half, scale, height)]
        for curve, weak, xy in self._curves.lines(image, half):
            kind, says = ("weak", ": weak part") if weak else ("projected", "")
            line = f'class="{kind}" d="{_line(middle + flip * xy)}"'
            parts.append(titled("path", line, f"spline {self._names[curve]}{says}"))
        parts += self._chains(rows, middle + flip * self._points.photo_xy[rows])
        name, view = f"chains-{image}", f"0 0 {number(_WIDTH)} {number(height + 2 * _EDGE)}"
        title = (
            f'<p id="{name}">Image <strong>{escaped_line(about["id"], 40)}</strong> '
            f"{about['matched']} of {about['points']} points matched</p>"
        )
        return (
            f'<div class="panel">{title}<div class="scroll" tabindex="0" role="img" aria-labelledby="{name}">'
            f'<svg class="map" viewBox="{view}">{"".join(parts)}</svg></div></div>'
        )

    def _chains(self, rows: IntArray, places: FloatArray) -> list[str]:
        """A path for every run of points of one chain with one curve, unmatched ones last."""
        chain, curve = self._points.chain[rows], self._result.matches.curve[rows]
        alone = chain < 0
        breaks = np.flatnonzero((chain[1:] != chain[:-1]) | (curve[1:] != curve[:-1]) | alone[1:]) + 1
        runs = np.split(np.arange(len(rows)), breaks) if len(rows) else []
        runs.sort(key=lambda run: int(self._kind[rows[run[0]]]))
        return [self._run(rows[run], places[run]) for run in runs]

    def _run(self, rows: IntArray, places: FloatArray) -> str:
        found, first = self._result.matches, int(rows[0])
        curve, chain = int(found.curve[first]), int(self._points.chain[first])
        what = f"chain {self._points.chain_ids[chain]}" if chain >= 0 else "a single point"
        if curve >= 0:
            says = f"{what}, {len(rows)} points\nspline {self._names[curve]}"
        else:
            words = sorted({reason_word(reason) for reason in found.reason[rows].tolist()})
            says = f"{what}, {len(rows)} points\nunmatched: {', '.join(words)}"
        kind = _KINDS[int(self._kind[first])]
        return titled("path", f'class="chain chain-{kind}" d="{_line(places)}"', says)


def _line(places: FloatArray) -> str:
    """A polyline; a single place is a dot."""
    if len(places) == 1:
        x, y = places[0]
        return f"M{number(x - 1, 1)} {number(y, 1)}h2"
    return "M" + "L".join(f"{number(x, 1)} {number(y, 1)}" for x, y in places)


def _half(xy: FloatArray, camera: Camera) -> FloatArray:
    """Half of what is shown, (2,) mm: the image format, else all points."""
    reach: FloatArray = np.abs(xy).max(axis=0)
    if camera.format_mm is None:
        return np.maximum(1.08 * reach, 1e-6)
    half = 0.5 * np.array(camera.format_mm, dtype=float)
    return np.where(reach > half, 1.04 * reach, half)


def _frame(camera: Camera, half: FloatArray, scale: float, height: float) -> str:
    size = half if camera.format_mm is None else 0.5 * np.array(camera.format_mm, dtype=float)
    left, top = 0.5 * _WIDTH - scale * size[0], _EDGE + 0.5 * height - scale * size[1]
    return (
        f'<rect class="frame" x="{number(left)}" y="{number(top)}" width="{number(2 * scale * size[0])}" '
        f'height="{number(2 * scale * size[1])}"/>'
    )
