"""What reports call the kinds of observations and equations of result.json."""

from __future__ import annotations

KINDS = {
    "point": "image points of points",
    "spline": "image points on splines",
    "arc length": "arc lengths",
    "tangent": "tangents",
    "control point": "control points",
    "control spline": "control splines",
    "eop prior": "prior orientations",
}


def in_words(kind: str) -> str:
    """A kind as a reader knows it: ``eop prior, angles`` is ``prior orientation, angles``."""
    return kind.replace("eop prior", "prior orientation")
