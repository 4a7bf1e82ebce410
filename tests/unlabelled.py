"""Networks whose labels are taken away, and what the labels were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import IntArray, Network, UnlabelledPoints, select_rows


def without_labels(network: Network, *, chains: bool = True) -> tuple[Network, IntArray]:
    """All curve observations as unlabelled points, and the curve of each, (n,).

    Parameters
    ----------
    chains : whether the points of one curve in one image stay a chain, else all points are single; directions are
        unknown
    """
    observed = network.curve_observations
    key = observed.curve * len(network.images.ids) + observed.image
    names, chain = np.unique(key, return_inverse=True)
    order = np.argsort(chain, kind="stable") if chains else np.arange(len(observed))
    points = UnlabelledPoints(
        image=observed.image[order],
        photo_xy=observed.photo_xy[order],
        sigma=observed.sigma[order],
        chain=chain[order] if chains else np.full(len(observed), -1),
        direction=np.full(len(observed), np.nan),
        chain_ids=tuple(str(number) for number in range(len(names))) if chains else (),
    )
    none = select_rows(observed, np.zeros(0, dtype=np.int64))
    return replace(network, curve_observations=none, unlabelled=points), observed.curve[order]
