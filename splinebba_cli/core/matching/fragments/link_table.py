"""Pairs of a chain point and a place on a fragment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Links:
    """Pairs of a chain point and a place on a fragment, sorted by fragment and point."""

    fragment: IntArray  # (k,)
    point: IntArray  # (k,) of the chains
    place: FloatArray  # (k,)
    z: FloatArray  # (k,) distance across over its sigma, with sign

    def __len__(self) -> int:
        return len(self.point)

    def only(self, rows: IntArray | BoolArray) -> Links:
        """Some of the links."""
        return Links(self.fragment[rows], self.point[rows], self.place[rows], self.z[rows])


def rows_of_links(chains: TracedChains, links: Links) -> IntArray:
    """Rows of consecutive points linked to one fragment, a point may be left out; (k,)."""
    new = np.ones(len(links), dtype=bool)
    new[1:] = (
        (links.fragment[1:] != links.fragment[:-1])
        | (chains.piece[links.point[1:]] != chains.piece[links.point[:-1]])
        | (links.point[1:] - links.point[:-1] > 2)
    )
    return np.asarray(np.cumsum(new) - 1)
