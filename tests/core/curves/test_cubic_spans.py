"""Curves of all families as cubics."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.bernstein import value_and_slope
from splinebba_cli.core.curves.cubic_spans import SPANS, CubicSpans
from splinebba_cli.core.matching.scene import Scene
from tests.core.matching.scenes import many_curves, scene_of, tilted_images


def scene(seed: int) -> Scene:
    none = np.zeros(0, dtype=np.int64)
    return scene_of(many_curves(seed), none, np.zeros((0, 2)), *tilted_images(seed))


def test_they_are_the_curves_and_say_how_exactly() -> None:
    own = scene(3)
    curves = own.curves
    spans = CubicSpans.of(curves, own.polynomials)
    turning = curves.trigonometric[spans.segment]
    assert turning.sum() == SPANS * curves.trigonometric.sum() > 0
    assert (spans.error[~turning] == 0.0).all() and (spans.error[turning] > 0.0).all()
    worst = np.zeros(len(spans.error))
    for part in np.linspace(0.0, 1.0, 21):
        at = spans.begin + part * spans.width
        exact = curves.derivatives(own.polynomials, spans.segment, at)[0].T
        value, _ = value_and_slope(spans.points, np.full(len(at), part))
        worst = np.maximum(worst, np.linalg.norm(value - exact, axis=0))
    assert (worst[~turning] < 1e-11).all()
    assert (worst[turning] <= spans.error[turning] + 1e-13).all()
    assert (worst[turning] > 0.2 * spans.error[turning]).any()  # the bound is none of comfort
    radii = np.abs(own.polynomials[spans.segment, 1:]).sum(axis=(1, 2))
    assert (spans.error[turning] < 2.5e-7 * radii[turning]).all()
