"""How good fragments are, held against the labels that were taken away and the labelled solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import image_rays

FINER = 40  # points between two samples of a curve
SIGMAS = 3.0  # from the labelled curve, beyond which a link with another label is wrong
LIMIT_95 = 2.4477  # sqrt of the 95 % quantile of chi square with two degrees of freedom


@dataclass(frozen=True)
class FragmentFigures:
    """Counts over all fragments."""

    fragments: int
    false_fragments: int  # most of whose links have no label
    curves: int  # that have a fragment
    links: int
    other_label: int  # links to another curve than that of the fragment
    wrong: int  # of them farther than three sigma from the labelled curve of the fragment in their image
    covered: float  # share of the labelled points that are linked to a fragment of their curve

    @property
    def right_share(self) -> float:
        """Share of links that are not wrong."""
        return 1.0 - self.wrong / max(self.links, 1)


def main_curves(fragments: Sequence[Fragment], truth: IntArray) -> IntArray:
    """Curve that most links of every fragment have as their label, -1: none has one; (f,)."""
    out = np.full(len(fragments), -1)
    for k, fragment in enumerate(fragments):
        label = truth[fragment.link_row]
        if (label >= 0).sum() * 2 > len(label):
            out[k] = np.bincount(label[label >= 0]).argmax()
    return out


def figures(
    network: Network, fragments: Sequence[Fragment], truth: IntArray, curves: Sequence[FloatArray]
) -> FragmentFigures:
    """Figures of fragments.

    Parameters
    ----------
    truth : (n,) label of every unlabelled point, -1: a wrong chain
    curves : samples (k, 3) of every labelled curve, local frame
    """
    main = main_curves(fragments, truth)
    covered = np.zeros(len(truth), dtype=bool)
    links = other = wrong = 0
    for fragment, curve in zip(fragments, main, strict=True):
        rows = fragment.link_row
        links += len(rows)
        if curve < 0:
            continue
        covered[rows[truth[rows] == curve]] = True
        differing = rows[truth[rows] != curve]
        other += len(differing)
        wrong += int((_sigmas_from(network, differing, finer(curves[curve])) > SIGMAS).sum())
    return FragmentFigures(
        fragments=len(fragments),
        false_fragments=int((main < 0).sum()),
        curves=len(np.unique(main[main >= 0])),
        links=links,
        other_label=other,
        wrong=wrong,
        covered=float(covered[truth >= 0].mean()),
    )


def finer(samples: FloatArray) -> FloatArray:
    """Samples of a curve with straight pieces between them, dense."""
    place = np.linspace(0.0, len(samples) - 1.0, FINER * len(samples))
    return np.stack([np.interp(place, np.arange(len(samples)), samples[:, k]) for k in range(3)], axis=1)


def _sigmas_from(network: Network, rows: IntArray, curve: FloatArray) -> FloatArray:
    """Distance of image points from a projected curve in their sigma, (q,)."""
    points, images = network.unlabelled, network.images
    c = np.array([camera.principal_distance_mm for camera in network.cameras])[images.camera]
    rays = image_rays(network, points.image[rows], points.photo_xy[rows], points.sigma[rows])
    out = np.full(len(rows), np.inf)
    for k in np.unique(points.image[rows]):
        many = np.full(len(curve), k)
        xy = project(c[many], images.rotation[many], images.position[many], curve)
        own = points.image[rows] == k
        seen = xy[np.isfinite(xy).all(axis=1)]
        if len(seen):
            out[own] = cKDTree(seen).query(rays.xy[own])[0] / points.sigma[rows[own]].mean(axis=1)
    return out


def lateral_sigmas(fragment: Fragment, curve: FloatArray) -> FloatArray:
    """Distance of every place from a curve in the normal plane over its dispersion, (k,)."""
    curve = finer(curve)
    distance = np.empty(len(fragment))
    _, nearest = cKDTree(curve).query(fragment.xyz)
    nearest = np.clip(nearest, 1, len(curve) - 2)
    along = curve[nearest + 1] - curve[nearest - 1]
    for k, n in enumerate(nearest):
        across = np.linalg.svd(along[k][None, :])[2][1:]
        offset = across @ (fragment.xyz[k] - curve[n])
        spread = across @ fragment.dispersion[k] @ across.T
        distance[k] = np.sqrt(offset @ np.linalg.solve(spread, offset))
    return distance


def agreement(
    fragments: Sequence[Fragment], truth: IntArray, curves: Sequence[FloatArray]
) -> tuple[float, float, float]:
    """Share of places in three images; of these within 2 sigma, and within the 95 % ellipse, of the labelled curve."""
    sigmas, three = [], []
    for fragment, curve in zip(fragments, main_curves(fragments, truth), strict=True):
        if curve >= 0:
            sigmas.append(lateral_sigmas(fragment, curves[curve]))
            three.append(fragment.image_count >= 3)
    z, seen = np.concatenate(sigmas), np.concatenate(three)
    return float(seen.mean()), float((z[seen] < 2.0).mean()), float((z[seen] < LIMIT_95).mean())
