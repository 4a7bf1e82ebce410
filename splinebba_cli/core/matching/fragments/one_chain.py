"""One chain an image: two chains of one image side by side are two edges, and at most one of them is the fragment's.

Of rows of links that compete for the same places of a fragment in the same image the better one stays, by the mean of
the squared distances; the others lose the places that it has.  Rows that lie on each other are one edge traced twice,
or two edges that the image shows as one: both stay.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.link_table import Links, rows_of_links
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains

SHARED_PLACES = 2.0  # by which rows of one edge may overlap: a chain cut in two
ASIDE = 2.0  # difference of mean distances in sigma from which two rows are two edges


def one_chain_an_image(chains: TracedChains, links: Links) -> Links:
    """Links without those of chains that run beside a better one."""
    if not len(links):
        return links
    row = rows_of_links(chains, links)
    first = np.flatnonzero(np.diff(row, prepend=-1))
    size = np.bincount(row)
    square, mean = np.add.reduceat(links.z**2, first) / size, np.add.reduceat(links.z, first) / size
    low, high = np.minimum.reduceat(links.place, first), np.maximum.reduceat(links.place, first)
    fragment, image = links.fragment[first], chains.image[links.point[first]]
    begin = np.append(first, len(links))
    keep = np.ones(len(links), dtype=bool)
    order = np.lexsort((square / np.sqrt(size), image, fragment))
    border = np.flatnonzero(
        (np.diff(fragment[order], prepend=-1) != 0) | (np.diff(image[order], prepend=-1) != 0)
    )
    for rival in np.split(order, border[1:]):
        for number, loser in enumerate(rival[1:], start=1):
            own = np.arange(begin[loser], begin[loser + 1])
            place = links.place[own]
            for better in rival[:number]:
                shared = min(high[better], high[loser]) - max(low[better], low[loser])
                if shared > SHARED_PLACES and abs(mean[better] - mean[loser]) > ASIDE:
                    keep[own[(place > low[better]) & (place < high[better])]] = False
    return links.only(keep)
