"""The guarantee of the candidates: what an image sees of a curve lies in the hulls of its pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.curves.cubic_spans import CubicSpans
from splinebba_cli.core.matching.candidates.projected_pieces import (
    Window,
    distance_to_chords,
    projected_pieces,
)
from splinebba_cli.core.matching.candidates.span_groups import SpanGroups
from tests.core.matching.scenes import DISTANCE, many_curves, scene_of, tilted_images


@pytest.mark.parametrize(("size", "error"), [(5.0, 0.0), (0.3, 0.2), (1000.0, 0.0)])
def test_every_place_in_the_window_lies_in_a_hull(size: float, error: float) -> None:
    """Also of curves that are up to `error` metres away from their spans."""
    none, g = np.zeros(0, dtype=np.int64), np.random.default_rng(4)
    scene = scene_of(many_curves(2), none, np.zeros((0, 2)), *tilted_images(2))
    spans = CubicSpans.of(scene.curves, scene.polynomials)
    spans = replace(spans, error=spans.error + error)
    window = Window(np.full((2, 3), -30.0), np.array([[40.0] * 3, [35.0] * 3]), np.full(3, size))
    groups = SpanGroups.of(spans, scene.curves)
    image, group = groups.seen(scene, window, np.arange(3))
    assert 0 < len(image) < 3 * len(groups.first)  # some are seen by no image
    which, span = groups.spans(group)
    pieces = projected_pieces(scene, spans, window, image[which], span)
    cut = np.isfinite(pieces.deviation)
    assert cut.sum() > 0.9 * len(pieces)
    assert (pieces.extent[cut] <= size).all()
    owner = np.repeat(np.arange(len(scene.curves.bases)), np.diff(scene.curves.segment_start))
    begin = spans.begin[pieces.span] + spans.width[pieces.span] * pieces.begin
    width = spans.width[pieces.span] * pieces.width
    seen = 0
    for k, part in np.ndindex(3, 40):
        t = np.full(len(owner), (part + 0.37) / 40.0)
        xyz = scene.curves.derivatives(scene.polynomials, np.arange(len(t)), t)[0]
        away = g.normal(size=xyz.shape)
        xyz += error * away / np.linalg.norm(away, axis=1)[:, None]
        xy = project(np.full(len(t), DISTANCE), scene.rotation[k][None], scene.position[k], xyz)
        inside = (xy >= window.low[:, k]).all(axis=1) & (xy <= window.high[:, k]).all(axis=1)
        for s in np.flatnonzero(inside & scene.curves.has_location[owner]):
            own = (
                (pieces.image == k)
                & (spans.segment[pieces.span] == s)
                & (begin <= t[s])
                & (t[s] < begin + width)
            )
            assert own.sum() == 1, (k, s, t[s])
            (row,) = np.flatnonzero(own)
            assert (xy[s] >= pieces.low[:, row] - 1e-9).all() and (xy[s] <= pieces.high[:, row] + 1e-9).all()
            off = distance_to_chords(xy[s][:, None], *pieces.chord[:, :, [row]])
            assert off[0] <= pieces.deviation[row] + 1e-9
            seen += 1
    assert seen > 2000
