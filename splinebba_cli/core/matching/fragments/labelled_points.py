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
    segments = chains.segment
    of_image = chains.image[segments]
    parts = [
        epipolar_crossings(views, chains, points, segments[of_image == j], depths)
        for j in partners
        if (of_image == j).any()
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

    def of_image(k: int) -> tuple[IntArray, IntArray, Depths, Hypotheses, BoolArray, BoolArray]:
        points = np.flatnonzero(chains.image == k)
        found = hypotheses_of(views, chains, points, partners[k], depths[k])
        agreed = agreed_depths(found, partners[k], depths[k], gate)
        state, joined = best_depths(chains, found, agreed, points)
        single = np.bincount(agreed.point, minlength=len(chains))[points] == 1
        return points, state, agreed, found, joined, single

    count = len(chains)
    value = np.full((4, count), np.nan)  # depth, sigma, slope, sigma of slope
    joined_all, single_all = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    links: list[tuple[IntArray, FloatArray]] = []
    for points, state, agreed, found, joined, single in in_threads(of_image, images):
        has = state >= 0
        own, state = points[has], state[has]
        value[:, own] = (
            agreed.depth[state],
            agreed.sigma[state],
            agreed.slope[state],
            agreed.slope_sigma[state],
        )
        joined_all[points], single_all[points] = joined & has, single
        member = agreed.member[state]
        row, column = np.nonzero(member >= 0)
        links.append((own[row], found.place[member[row, column]]))
    link_point = np.concatenate([one for one, _ in links]) if links else np.zeros(0, dtype=np.int64)
    link_place = np.concatenate([two for _, two in links]) if links else np.zeros(0)
    order = np.argsort(link_point, kind="stable")
    depth, sigma, slope, slope_sigma = value
    return LabelledPoints(
        depth, sigma, slope, slope_sigma, joined_all, single_all, link_point[order], link_place[order]
    )
