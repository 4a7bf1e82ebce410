"""Messages on weak parts: the weakest splines by name, the others together."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.matches import BuiltCurve, WeakPart
from splinebba_cli.core.matching.shapes.new_curve_problems import weak_problems


def built(curve: int, kind: str, sigma_m: float) -> BuiltCurve:
    none = np.zeros(0, dtype=np.int64)
    return BuiltCurve(curve, none, none, 5.0, 5.0, (WeakPart(0.0, 1.0, kind, sigma_m),))


def test_the_weakest_come_first_and_the_rest_together() -> None:
    curves = [built(k, "epipolar", 0.01 * (k + 1)) for k in range(6)]
    found = weak_problems(curves, [f"new-{k}" for k in range(6)], 0.001)
    assert [each.subject for each in found[:3]] == ["spline `new-5`", "spline `new-4`", "spline `new-3`"]
    assert found[3].message == "3 more new splines with weak parts: `new-2`, `new-1`, `new-0`"
    assert len(found) == 4


def test_two_images_alone_are_no_weakness() -> None:
    assert weak_problems([built(0, "two_images", 0.5)], ["new-1"], 0.001) == []
    (one,) = weak_problems([built(0, "bridged", 0.5)], ["new-1"], 0.001)
    assert "1 part bridged" in one.message
