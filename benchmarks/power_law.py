"""Exponents of growth: value = a size^b by least squares of the logarithms."""

from __future__ import annotations

import math
from collections.abc import Sequence


def exponent(points: Sequence[tuple[float, float]]) -> float | None:
    """The exponent b of (size, value) pairs; None with fewer than two sizes or where a value is not positive.

    b = sum (x - mean x)(y - mean y) / sum (x - mean x)^2,   x = log size, y = log value
    """
    if len({size for size, _ in points}) < 2 or any(value <= 0.0 for _, value in points):
        return None
    x = [math.log(size) for size, _ in points]
    y = [math.log(value) for _, value in points]
    middle_x, middle_y = sum(x) / len(x), sum(y) / len(y)
    above = sum((a - middle_x) * (b - middle_y) for a, b in zip(x, y, strict=True))
    return above / sum((a - middle_x) ** 2 for a in x)
