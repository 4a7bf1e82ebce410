"""Pairs of unknowns that are hardly told apart: r_ij = c_ij / sqrt(c_ii c_jj) beyond a threshold.

Inside every image (6 x 6) and every point (3 x 3) always; between images, and between images and values of curves,
where the full dispersion is computed.  Values of one curve are left out: they slide along it together.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from splinebba_cli.core.evidence import HighCorrelation
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.result import AdjustmentResult, DispersionBlocks

LISTED = 200  # the highest ones
EOP = ("ω", "φ", "κ", "X₀", "Y₀", "Z₀")
XYZ = ("X", "Y", "Z")

Candidates = list[tuple[float, str, str]]


def high_correlations(result: AdjustmentResult, threshold: float) -> tuple[tuple[HighCorrelation, ...], int]:
    """The highest correlations beyond `threshold`, highest first, and how many are beyond it."""
    images, points = result.network.images.ids, result.network.points.ids
    parts = [
        _in_blocks(result.images.dispersion, threshold, lambda n, i: f"image `{images[n]}` {EOP[i]}"),
        _in_blocks(result.points.dispersion, threshold, lambda n, i: f"point `{points[n]}` {XYZ[i]}"),
        _between(result.dispersion, len(images), threshold),
    ]
    found = sorted((pair for part, _ in parts for pair in part), key=lambda pair: -abs(pair[0]))
    listed = tuple(HighCorrelation(first, second, r) for r, first, second in found[:LISTED])
    return listed, sum(count for _, count in parts)


def correlations(dispersion: FloatArray) -> FloatArray:
    """Correlations of dispersions (..., k, k); 0 where an unknown is held."""
    sigma = np.sqrt(np.maximum(np.diagonal(dispersion, axis1=-2, axis2=-1), 0.0))
    inverse = np.where(sigma > 0.0, 1.0 / np.where(sigma > 0.0, sigma, 1.0), 0.0)
    return np.asarray(dispersion * inverse[..., :, None] * inverse[..., None, :])


def _in_blocks(
    dispersion: FloatArray, threshold: float, name: Callable[[int, int], str]
) -> tuple[Candidates, int]:
    """Pairs inside blocks (n, k, k)."""
    r = correlations(dispersion)
    i, j = np.triu_indices(dispersion.shape[1], 1)
    upper = r[:, i, j]
    block, pair = np.nonzero(np.abs(upper) > threshold)
    values = upper[block, pair]
    order = _highest(values)
    found = [
        (float(values[k]), name(int(block[k]), int(i[pair[k]])), name(int(block[k]), int(j[pair[k]])))
        for k in order
    ]
    return found, len(values)


def _between(full: DispersionBlocks | None, images: int, threshold: float) -> tuple[Candidates, int]:
    """Pairs of unknowns of two images, or of an image and a curve."""
    if full is None or full.matrix is None or not images:
        return [], 0
    count = 6 * images
    r = np.abs(correlations(full.matrix)[:count])
    owner = np.concatenate([np.repeat(np.arange(images), 6), np.full(len(full.names) - count, images)])
    later = owner[None, :] > owner[:count, None]
    first, second = np.nonzero((r > threshold) & later)
    values = correlations(full.matrix)[first, second]
    order = _highest(values)
    found = [(float(values[k]), full.names[first[k]], full.names[second[k]]) for k in order]
    return found, len(values)


def _highest(values: FloatArray) -> IntArray:
    return np.argsort(-np.abs(values), kind="stable")[:LISTED]
