"""Every point of every chain with its depth and the places of other chains that gave it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.fragments.consensus import Depths, agreed_depths
from splinebba_cli.core.matching.fragments.crossings import Crossings, epipolar_crossings
from splinebba_cli.core.matching.fragments.hypotheses import Hypotheses, depth_hypotheses
from splinebba_cli.core.matching.fragments.labelling import best_depths
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.threads import in_threads


@dataclass(frozen=True)
class LabelledPoints:
    """Depths of the chain points (NaN: none), and links to places on chains of other images."""

    depth: FloatArray  # (n,) m/mm
    sigma: FloatArray  # (n,)
    slope: FloatArray  # (n,) per mm along the piece
    slope_sigma: FloatArray  # (n,)
    joined: BoolArray  # (n,) the depth goes on from the point before
    single: BoolArray  # (n,) no other depth was possible
    link_point: IntArray  # (k,) ascending
    link_place: FloatArray  # (k,) number of a chain point, with fraction

    @classmethod
    def none(cls, count: int) -> LabelledPoints:
        """Points without depth."""
        depth, sigma, slope, slope_sigma = (np.full(count, np.nan) for _ in range(4))
        joined, single = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        return cls(depth, sigma, slope, slope_sigma, joined, single, np.zeros(0, dtype=np.int64), np.zeros(0))

    @property
    def by_point(self) -> tuple[FloatArray | BoolArray, ...]:
        """All arrays that have one entry a point."""
        return self.depth, self.sigma, self.slope, self.slope_sigma, self.joined, self.single

    def with_links(self, keep: BoolArray) -> LabelledPoints:
        """Only some of the links; points that lose all of theirs have no depth."""
        left = np.zeros(len(self.depth), dtype=bool)
        left[self.link_point[keep]] = True
        return replace(
            self,
            depth=np.where(left, self.depth, np.nan),
            joined=self.joined & left,
            link_point=self.link_point[keep],
            link_place=self.link_place[keep],
        )


def hypotheses_of(
    views: Views, chains: TracedChains, points: IntArray, partners: IntArray, depths: FloatArray
) -> Hypotheses:
    """All depths that partner images give to points of one image."""
    parts = [
        epipolar_crossings(views, chains, points, segments, depths)
        for j in partners
        if len(segments := chains.segments_of(int(j)))
    ]
    return depth_hypotheses(views, chains, Crossings.joined(parts))


def label_points(
    views: Views, chains: TracedChains, partners: list[IntArray], depths: FloatArray, gate: float
) -> LabelledPoints:
    """The best depths of the points of all images.

    Parameters
    ----------
    partners : for every image, those that it is compared with
    depths : (m, 2) plausible depths
    gate : sigma of agreement
    """
    images = [int(k) for k in np.unique(chains.image) if len(partners[k])]

    def of_image(k: int) -> LabelledPoints:
        points = chains.points_of(k)
        found = hypotheses_of(views, chains, points, partners[k], depths[k])
        agreed = agreed_depths(found, partners[k], depths[k], gate)
        return _labelled(chains, found, agreed, points)

    out = LabelledPoints.none(len(chains))
    parts = in_threads(of_image, images)
    for k, part in zip(images, parts, strict=True):
        own = chains.points_of(k)
        for whole, piece in zip(out.by_point, part.by_point, strict=True):
            whole[own] = piece
    if not parts:
        return out
    return replace(
        out,
        link_point=np.concatenate([part.link_point for part in parts]),
        link_place=np.concatenate([part.link_place for part in parts]),
    )


def _labelled(chains: TracedChains, found: Hypotheses, agreed: Depths, points: IntArray) -> LabelledPoints:
    """The labels of the points of one image, in their order; links with numbers of all chain points."""
    state, joined = best_depths(chains, found, agreed, points)
    out = LabelledPoints.none(len(points))
    own = np.flatnonzero(state >= 0)
    state = state[own]
    out.depth[own], out.sigma[own] = agreed.depth[state], agreed.sigma[state]
    out.slope[own], out.slope_sigma[own] = agreed.slope[state], agreed.slope_sigma[state]
    out.joined[own] = joined[own]
    out.single[:] = np.bincount(agreed.point - points[0], minlength=len(points)) == 1
    member = agreed.member[state]
    row, column = np.nonzero(member >= 0)
    return replace(out, link_point=points[own[row]], link_place=found.place[member[row, column]])
