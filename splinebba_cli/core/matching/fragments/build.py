"""build_fragments(network, ...): pieces of tie curves from chains of image points that nobody has assigned.

    crossings of epipolar lines with chains  ->  depths on which images agree  ->  one depth a point, smooth along the
    chain  ->  links that hold from both sides  ->  runs, bridged  ->  the best supported first  ->  triangulation  ->
    links of all images

Nothing here knows shapes: joining fragments and fitting splines is the work of :mod:`...matching.shapes`.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
from scipy.stats import norm

from splinebba_cli.core.matching.fragments.confirmed_links import confirmed
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints, label_points
from splinebba_cli.core.matching.fragments.links import Links, links_of
from splinebba_cli.core.matching.fragments.runs import Runs, runs_of
from splinebba_cli.core.matching.fragments.scene_depths import partner_images, plausible_depths
from splinebba_cli.core.matching.fragments.selection import Stretch, selected_stretches
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.triangulation import largest_across, smallest_across, triangulated
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import FloatArray, IntArray, Network

_log = logging.getLogger(__name__)

WEAK = 4.0  # times the usual sigma across: the depth is open
LEAST_POINTS = 3  # of an image that sees a fragment


def build_fragments(
    network: Network,
    rotation: FloatArray,
    position: FloatArray,
    settings: MatchSettings | None = None,
    rows: IntArray | None = None,
) -> list[Fragment]:
    """Pieces of curves in space from unlabelled chains.

    Parameters
    ----------
    rotation, position : (m, 3, 3) and (m, 3) present exterior orientations; NaN: the image is left out
    rows : (q,) unlabelled points without a curve, default all; single points are left out

    Returns
    -------
    list of Fragment
        Best supported first.  Neighbours of one edge overlap by a few places and share image points there.
    """
    settings = settings or MatchSettings()
    rows = np.arange(len(network.unlabelled)) if rows is None else np.asarray(rows)
    views = Views.of(network, rotation, position)
    chains = TracedChains.of(network, views, rows)
    if len(np.unique(chains.image)) < 2:
        return []
    gate = float(norm.isf(settings.alpha / 2.0))
    depths = plausible_depths(network, views, chains)
    partners = partner_images(views, chains, depths)
    if not any(len(each) for each in partners):
        return []
    labels = confirmed(chains, label_points(views, chains, partners, depths, gate), partners)
    runs = runs_of(chains, labels)
    stretches = selected_stretches(chains, labels, runs, two_images=labels.single)
    found = _fragments(views, chains, labels, runs, stretches, gate, settings)
    _log.info("%d fragments from %d pieces of chains", len(found), len(chains.start) - 1)
    return found


def _fragments(
    views: Views, chains: TracedChains, labels: LabelledPoints, runs: Runs, stretches: list[Stretch],
    gate: float, settings: MatchSettings,
) -> list[Fragment]:  # fmt: skip
    if not stretches:
        return []
    points = [np.arange(stretch.first, stretch.last) for stretch in stretches]
    everything, back = np.unique(np.concatenate(points), return_inverse=True)
    xyz, dispersion = triangulated(views, chains, labels, runs, everything)
    xyz, dispersion = xyz[back], dispersion[back]
    start = np.concatenate([[0], np.cumsum([len(each) for each in points])])
    along = _tangents(start, xyz)
    sigma, fine = largest_across(dispersion, along), smallest_across(dispersion, along)
    weak = (sigma > WEAK * np.median(sigma)) & (sigma > WEAK * fine) | runs.bridged[np.concatenate(points)]
    links = links_of(views, chains, start, xyz, dispersion, gate, settings.direction_tolerance_rad)
    border = np.searchsorted(links.fragment, np.arange(len(points) + 1))
    out = []
    for k in range(len(points)):
        own = slice(int(start[k]), int(start[k + 1]))
        linked = links.only(np.arange(border[k], border[k + 1]))
        fragment = Fragment(
            xyz=xyz[own], dispersion=dispersion[own], image_count=_image_count(chains, linked, len(points[k])),
            weak=weak[own], link_row=chains.row[linked.point], link_place=linked.place,
            closed=False, reference_image=int(chains.image[points[k][0]]),
        )  # fmt: skip
        order = np.argsort(fragment.link_row)
        out.append(replace(fragment, link_row=fragment.link_row[order], link_place=fragment.link_place[order]))
    return [each for each in out if (each.image_count >= 2).all() or (each.image_count >= 3).any()]


def _tangents(start: IntArray, xyz: FloatArray) -> FloatArray:
    """Unit directions of fragments at their places, (k, 3)."""
    fragment = np.repeat(np.arange(len(start) - 1), np.diff(start))
    number = np.arange(len(xyz))
    after = np.minimum(number + 1, start[1:][fragment] - 1)
    before = np.maximum(number - 1, start[:-1][fragment])
    along = xyz[after] - xyz[before]
    return np.asarray(along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300))


def _image_count(chains: TracedChains, linked: Links, places: int) -> IntArray:
    """Images with linked points beside every place, (places,)."""
    count = np.zeros(places, dtype=np.int64)
    image = chains.image[linked.point]
    for k in np.unique(image):
        place = np.sort(linked.place[image == k])
        if len(place) < LEAST_POINTS:
            continue
        number = np.arange(places)
        after = np.clip(np.searchsorted(place, number), 0, len(place) - 1)
        before = np.maximum(after - 1, 0)
        near = np.minimum(np.abs(place[after] - number), np.abs(place[before] - number)) <= 1.5
        count += near
    return count
