"""Points near another curve as an image sees it, and points apart."""

from __future__ import annotations

import numpy as np

from benchmarks.points_apart import points_apart
from tests.core.matching.known_curves.one_image import control, network, seen


def test_only_other_curves_count() -> None:
    """Three lines a millimetre (3.3 m) and 0.1 mm apart, and one that crosses itself seen from above."""
    lines = [control([(-100, y, 0), (100, y, 0)], str(y)) for y in (0.0, 3.33, 3.66)]
    loop = control([(-100, -100, 0), (0, -60, 0), (40, -100, 0), (0, -140, 0), (-100, -100.3, 0)], "loop")
    curves = [*lines, loop]
    chains = [seen(curve, 11, 0.1, 0.9) for curve in curves]
    label = np.repeat(np.arange(4), 11)
    apart = points_apart(network(curves, chains), label, 0.5)
    np.testing.assert_array_equal(apart, np.isin(label, [0, 3]))
    np.testing.assert_array_equal(points_apart(network(curves, chains), label, 1.5), label == 3)
