"""Whether two fragments that run side by side show one edge or two.

shared      the same image points belong to both: in two or more images that is one edge, whatever the places say
two edges   an image shows two lines there, side by side and further apart than they are measured precisely
lateral     d' (F' (D_a + D_b) F)^-1 d of the places beside each other, chi-square with 2 degrees of freedom where
            they are one edge; the median over the common stretch decides
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import chi2

from splinebba_cli.core.matching.shapes.place_fit import normal_frames
from splinebba_cli.core.matching.shapes.polyline_feet import Feet, feet_on_polyline
from splinebba_cli.core.matching.shapes.strand import Strand
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

ONE_EDGE = float(chi2.ppf(0.99, 2))  # median of the lateral statistic up to which two strands are one edge
ALONG = float(np.cos(np.radians(30.0)))  # strands that are one edge run alike
FEWEST = 3  # places, or points of an image, that tell something
SHARED = 0.5  # of the points of an image in the common stretch: the same line
APART = 4.0  # sigma between two lines of one image
REACH = 4.0  # sigma around places in which neighbours are looked for


@dataclass(frozen=True)
class ImagePoints:
    """Unlabelled points as overlaps need them, rows of the network."""

    image: IntArray  # (n,)
    xy: FloatArray  # (n, 2) mm, corrected
    sigma: FloatArray  # (n,) mm


@dataclass(frozen=True)
class Overlap:
    """A common stretch of two strands."""

    first: int
    second: int
    shared: int  # image points of both
    shared_images: int  # images in which most points of the stretch belong to both
    separate_images: int  # images that show two lines side by side
    statistic: float  # median of the lateral test
    sense: int  # 1: they run the same way

    @property
    def one_edge(self) -> bool:
        """Whether they are the same edge."""
        if self.shared_images >= 2 and self.shared_images >= self.separate_images:
            return True
        return not self.two_edges and self.statistic <= ONE_EDGE

    @property
    def two_edges(self) -> bool:
        """Whether an image proves that they are different edges."""
        return self.separate_images > 0 and (
            self.shared_images < 2 or self.separate_images > self.shared_images
        )


def overlaps_of(strands: list[Strand], points: ImagePoints) -> list[Overlap]:
    """All pairs of strands with a common stretch."""
    found = []
    for a, b in sorted(_near_pairs(strands)):
        overlap = overlap_of(strands, a, b, points)
        if overlap is not None:
            found.append(overlap)
    return found


def overlap_of(strands: list[Strand], a: int, b: int, points: ImagePoints) -> Overlap | None:
    """The common stretch of two strands; None where they do not run side by side."""
    first, second = strands[a], strands[b]
    feet = feet_on_polyline(first.line, second.line, closed=first.closed)
    back = feet_on_polyline(second.line, first.line, closed=second.closed)
    along = _directions(second)
    cosine = np.sum(feet.tangent * along, axis=1)
    statistic = lateral_statistics(first, second, feet)
    near = feet.beside & (np.abs(cosine) > ALONG) & (statistic < 10.0 * ONE_EDGE)
    shared = np.intersect1d(first.link_row, second.link_row)
    if np.count_nonzero(near) < FEWEST:
        if len(shared) < FEWEST or not feet.beside.any():
            return None
        near = feet.beside
    sense = 1 if np.median(cosine[near]) > 0.0 else -1
    rows_a = _rows_beside(first, back.beside)
    rows_b = _rows_beside(second, near)
    same, separate = _images(rows_a, rows_b, points)
    return Overlap(a, b, len(shared), same, separate, float(np.median(statistic[near])), sense)


def lateral_statistics(first: Strand, second: Strand, feet: Feet) -> FloatArray:
    """Lateral test of the places of the second strand against the first one, (k,)."""
    last = len(first.location) - 1
    nearest = np.rint(feet.place).astype(np.int64) % (last + 1)
    frame = normal_frames(feet.tangent)
    inner = np.einsum("nia,nij,njb->nab", frame, first.dispersion[nearest] + second.dispersion, frame)
    d = np.einsum("nia,ni->na", frame, feet.offset)
    return np.asarray(np.einsum("na,nab,nb->n", d, np.linalg.inv(inner), d))


def _near_pairs(strands: list[Strand]) -> set[tuple[int, int]]:
    """Pairs of strands that have places near each other, or image points in common."""
    pairs: set[tuple[int, int]] = set()
    if len(strands) < 2:
        return pairs
    owner = np.repeat(np.arange(len(strands)), [len(s.location) for s in strands])
    xyz = np.vstack([s.line for s in strands])
    sigma = np.sqrt(np.vstack([np.trace(s.dispersion, axis1=1, axis2=2)[:, None] for s in strands])[:, 0])
    spacing = np.concatenate([np.full(len(s.location), s.spacing) for s in strands])
    reach = REACH * np.minimum(sigma, 4.0 * np.median(sigma)) + spacing
    tree = cKDTree(xyz)
    for begin in range(0, len(xyz), 4096):
        part = slice(begin, begin + 4096)
        for own, near in zip(owner[part], tree.query_ball_point(xyz[part], reach[part]), strict=True):
            pairs.update((min(own, other), max(own, other)) for other in set(owner[near].tolist()) - {own})
    rows = np.concatenate([s.link_row for s in strands])
    holder = np.repeat(np.arange(len(strands)), [len(s.link_row) for s in strands])
    order = np.argsort(rows, kind="stable")
    groups = np.split(holder[order], np.flatnonzero(np.diff(rows[order])) + 1)
    for group in groups:
        members = sorted(set(group.tolist()))
        pairs.update((x, y) for i, x in enumerate(members) for y in members[i + 1 :])
    return {(int(x), int(y)) for x, y in pairs}


def _directions(strand: Strand) -> FloatArray:
    """Unit directions of the smooth line, (k, 3)."""
    step = np.gradient(strand.line, axis=0)
    return np.asarray(step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300))


def _rows_beside(strand: Strand, beside: BoolArray) -> IntArray:
    """Linked points in the stretch from the first to the last place that is beside the other strand, along it."""
    if not beside.any():
        return np.zeros(0, dtype=np.int64)
    known = strand.location[beside]
    inside = (strand.link_location >= known.min()) & (strand.link_location <= known.max())
    rows = strand.link_row[inside]
    return np.asarray(rows[np.argsort(strand.link_location[inside], kind="stable")])


def _images(rows_a: IntArray, rows_b: IntArray, points: ImagePoints) -> tuple[int, int]:
    """Images that show the same points, and those that show two lines."""
    same = separate = 0
    for image in np.intersect1d(points.image[rows_a], points.image[rows_b]):
        a, b = (rows[points.image[rows] == image] for rows in (rows_a, rows_b))
        common = len(np.intersect1d(a, b))
        if common >= SHARED * min(len(a), len(b)):
            same += common > 0
        else:
            separate += _apart(a[~np.isin(a, b)], b[~np.isin(b, a)], points)
    return same, separate


def _apart(a: IntArray, b: IntArray, points: ImagePoints) -> bool:
    """Whether points of one image make two lines: typically further apart than their sigma explain."""
    if len(a) < FEWEST or len(b) < FEWEST:
        return False
    line = np.column_stack([points.xy[b], np.zeros(len(b))])
    feet = feet_on_polyline(line, np.column_stack([points.xy[a], np.zeros(len(a))]))
    distance = np.linalg.norm(feet.offset, axis=1)[feet.beside]
    if len(distance) < FEWEST:
        return False
    return bool(np.median(distance) > APART * np.sqrt(2.0) * np.median(points.sigma[a]))
