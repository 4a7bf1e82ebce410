"""Corners of a natural spline that gets other knots: they stay where they are."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.support import supported_knots
from splinebba_cli.core.network import Curve, FloatArray, IntArray


def corner_parameters(curve: Curve, basis: CurveBasis) -> FloatArray:
    """Locations of the corners of a curve, (b,)."""
    return np.asarray(basis.break_points[list(curve.breaks)])


def breaks_among(parameters: FloatArray, corners: FloatArray) -> tuple[int, ...]:
    """Which inner ones of new knot parameters are corners."""
    inner = np.flatnonzero(np.isin(parameters[1:-1], corners)) + 1
    return tuple(int(k) for k in inner)


def supported_knots_between(number: IntArray, breaks: tuple[int, ...]) -> IntArray:
    """Knots of an open curve to keep so that every segment has enough measured points; corners and ends stay.

    Parameters
    ----------
    number : (S,) measured points per segment
    """
    starts = [0, *breaks]
    pieces = np.split(number, list(breaks))
    kept = [supported_knots(own, False, cut_ends=False) for own in pieces]
    inner = [knots[:-1] + start for knots, start in zip(kept, starts, strict=True)]
    return np.concatenate([*inner, [len(number)]]).astype(np.int64)
