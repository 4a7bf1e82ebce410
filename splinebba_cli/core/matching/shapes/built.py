"""New curves as results tell of them: chains, images, length, weak parts."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.matches import BuiltCurve
from splinebba_cli.core.matching.shapes.curve_normals import curve_normals
from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.matching.shapes.extent import point_spacing
from splinebba_cli.core.matching.shapes.weak_parts import seen_places, weak_parts
from splinebba_cli.core.network import Network


def built_curves(network: Network, draft: Draft, usual: float) -> tuple[BuiltCurve, ...]:
    """One entry a curve of the draft.

    Parameters
    ----------
    usual : sigma across the new curves, metres
    """
    spacing, found = point_spacing(draft), []
    for k, own in enumerate(curve_normals(draft)):
        chains = np.unique(network.unlabelled.chain[draft.row[own.link]])
        seen = seen_places(draft, own, spacing[k])
        found.append(
            BuiltCurve(
                curve=k,
                chains=chains[chains >= 0],
                images=np.unique(draft.links.image[own.link]),
                length_m=float(seen.step.sum()),
                length_in_three_images_m=float(seen.step[seen.images >= 3].sum()),
                weak_parts=weak_parts(seen, usual),
            )
        )
    return tuple(found)
