"""Which images can see which spans: spheres around groups of them against the pyramids of the photos."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.cubic_spans import CubicSpans
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.matching.candidates.point_grid import expand
from splinebba_cli.core.matching.candidates.projected_pieces import Window
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import FloatArray, IntArray

GROUP = 8  # spans of one sphere, of one curve
PART = 2_000_000  # pairs of images and groups that are looked at together


@dataclass(frozen=True)
class SpanGroups:
    """Spheres around groups of spans; groups that are not known are left out."""

    first: IntArray  # (g,) first span
    last: IntArray  # (g,) one behind the last
    centre: FloatArray  # (3, g)
    radius: FloatArray  # (g,)

    @classmethod
    def of(cls, spans: CubicSpans, curves: CurveSet) -> SpanGroups:
        """Groups of spans that follow each other; of curves that are single points there are none."""
        curve = curves.owner[spans.segment]
        if not len(curve):
            none = np.zeros(0, dtype=np.int64)
            return cls(none, none, np.zeros((3, 0)), np.zeros(0))
        begins = np.flatnonzero(np.append(True, curve[1:] != curve[:-1]))
        within = np.arange(len(curve)) - np.repeat(begins, np.diff(np.append(begins, len(curve))))
        first = np.flatnonzero(within % GROUP == 0)
        low = np.minimum.reduceat(spans.points.min(axis=0), first, axis=1)
        high = np.maximum.reduceat(spans.points.max(axis=0), first, axis=1)
        radius = 0.5 * np.linalg.norm(high - low, axis=0) + np.maximum.reduceat(spans.error, first)
        known = np.isfinite(radius) & curves.has_location[curve[first]]
        last = np.append(first[1:], len(curve))
        return cls(first[known], last[known], 0.5 * (low + high)[:, known], radius[known])

    def seen(self, scene: Scene, window: Window, images: IntArray) -> tuple[IntArray, IntArray]:
        """Pairs of image and group that can be seen in the windows, sorted by image."""
        pairs = [np.zeros((2, 0), dtype=np.int64)]
        step = max(1, PART // max(1, len(self.first)))
        for begin in range(0, len(images), step):
            own = images[begin : begin + step]
            inside = np.ones((len(own), len(self.first)), dtype=bool)
            for normal in _planes(scene, window, own):
                height = normal @ self.centre - np.sum(normal * scene.position[own], axis=1)[:, None]
                inside &= height >= -self.radius
            image, group = np.nonzero(inside)
            pairs.append(np.stack([own[image], group]))
        image, group = np.concatenate(pairs, axis=1)
        return image, group

    def spans(self, group: IntArray) -> tuple[IntArray, IntArray]:
        """Which of some groups, and the span, of all their spans."""
        return expand(self.first[group], self.last[group])


def _planes(scene: Scene, window: Window, images: IntArray) -> list[FloatArray]:
    """Unit normals, inwards, of the planes through the perspective centres that bound what is seen, (k, 3) each."""
    c, zero = scene.principal_distance[images], np.zeros(len(images))
    rows = [(zero, zero, -np.ones(len(images)))]
    for axis in range(2):
        for bound, sign in ((window.low, 1.0), (window.high, -1.0)):
            along = sign * c
            depth = sign * bound[axis, images]  # x D = -x w
            rows.append((along, zero, depth) if axis == 0 else (zero, along, depth))
    normals = [np.stack(row, axis=1) for row in rows]
    turned = [np.einsum("kij,kj->ki", scene.rotation[images], each) for each in normals]
    return [each / np.linalg.norm(each, axis=1)[:, None] for each in turned]
