"""Images with their chains, matched and unmatched, and the curves as the images see them: what is drawn of a result."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.network import Camera, FloatArray, IntArray
from splinebba_cli.exchange.chain_thinning import thinned
from splinebba_cli.project.matched_tables import reason_word
from splinebba_cli.report.projected_curves import ProjectedCurves
from splinebba_cli.report.svg_text import number

SHOWN = 6  # images that are seen at once
POINTS = 60_000  # of all images together that are drawn
WIDTH, EDGE = 400.0, 1.0
UNMATCHED = "unmatched"
_KINDS = ("matched", "new", UNMATCHED)
_STEP = 0.4  # of a drawing: points of dense chains that are nearer to each other are left out


@dataclass(frozen=True)
class Stroke:
    """A line of a drawing."""

    kind: str  # projected, weak, matched, new, unmatched
    path: str  # of SVG
    says: str  # when it is pointed at


@dataclass(frozen=True)
class Panel:
    """The drawing of one image, EDGE around it; what is unmatched lies below the rest."""

    image: int  # its number among the images of match.json
    height: float
    frame: tuple[float, float, float, float]  # of the format: left, top, width, height
    strokes: tuple[Stroke, ...]


def panels_of(result: MatchResult, images: list[dict[str, Any]]) -> list[Panel]:
    """The drawings of a result, the image with the smallest matched share first.

    Parameters
    ----------
    images : of match.json
    """
    panels = _Panels(result)
    return [panels.panel(k) for k in drawn_images(images)]


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

    def panel(self, image: int) -> Panel:
        """The drawing of one image."""
        rows = self._rows[image]
        camera = self._result.given.cameras[int(self._result.given.images.camera[image])]
        half = _half(self._points.photo_xy[rows], camera)
        scale = 0.5 * (WIDTH - 2.0) / half[0]
        height = 2.0 * half[1] * scale
        middle = np.array([0.5 * WIDTH, EDGE + 0.5 * height])
        flip = scale * np.array([1.0, -1.0])
        curves = []
        for curve, weak, xy in self._curves.lines(image, half):
            kind, says = ("weak", ": weak part") if weak else ("projected", "")
            curves.append(Stroke(kind, _line(middle + flip * xy), f"spline {self._names[curve]}{says}"))
        chains = self._chains(rows, middle + flip * self._points.photo_xy[rows])
        matched = [stroke for stroke in chains if stroke.kind != UNMATCHED]
        strokes = [*(stroke for stroke in chains if stroke.kind == UNMATCHED), *curves, *matched]
        return Panel(image, height, _frame(camera, half, scale, height), tuple(strokes))

    def _chains(self, rows: IntArray, places: FloatArray) -> list[Stroke]:
        """A line for every run of points of one chain with one curve, those on new curves last."""
        chain, curve = self._points.chain[rows], self._result.matches.curve[rows]
        alone = chain < 0
        breaks = np.flatnonzero((chain[1:] != chain[:-1]) | (curve[1:] != curve[:-1]) | alone[1:]) + 1
        runs = np.split(np.arange(len(rows)), breaks) if len(rows) else []
        runs.sort(key=lambda run: int(self._kind[rows[run[0]]]))
        return [self._run(rows[run], places[run]) for run in runs]

    def _run(self, rows: IntArray, places: FloatArray) -> Stroke:
        found, first = self._result.matches, int(rows[0])
        curve, chain = int(found.curve[first]), int(self._points.chain[first])
        what = f"chain {self._points.chain_ids[chain]}" if chain >= 0 else "a single point"
        if curve >= 0:
            says = f"{what}, {len(rows)} points\nspline {self._names[curve]}"
        else:
            words = sorted({reason_word(reason) for reason in found.reason[rows].tolist()})
            says = f"{what}, {len(rows)} points\nunmatched: {', '.join(words)}"
        return Stroke(_KINDS[int(self._kind[first])], _line(places), says)


def _line(places: FloatArray) -> str:
    """A polyline; a single place is a dot."""
    if len(places) == 1:
        x, y = places[0]
        return f"M{number(x - 1, 1)} {number(y, 1)}h2"
    return "M" + "L".join(f"{number(x, 1)} {number(y, 1)}" for x, y in thinned(places, _STEP))


def _half(xy: FloatArray, camera: Camera) -> FloatArray:
    """Half of what is shown, (2,) mm: the image format, else all points."""
    reach: FloatArray = np.abs(xy).max(axis=0)
    if camera.format_mm is None:
        return np.maximum(1.08 * reach, 1e-6)
    half = 0.5 * np.array(camera.format_mm, dtype=float)
    return np.where(reach > half, 1.04 * reach, half)


def _frame(
    camera: Camera, half: FloatArray, scale: float, height: float
) -> tuple[float, float, float, float]:
    size = half if camera.format_mm is None else 0.5 * np.array(camera.format_mm, dtype=float)
    left, top = 0.5 * WIDTH - scale * size[0], EDGE + 0.5 * height - scale * size[1]
    return (float(left), float(top), float(2 * scale * size[0]), float(2 * scale * size[1]))
