"""build_fragments(network, ...): pieces of tie curves from chains of image points that nobody has assigned.

    crossings of epipolar lines with chains  ->  depths on which images agree  ->  one depth a point, smooth along the
    chain  ->  links that hold from both sides  ->  runs, bridged  ->  the best supported first  ->  triangulation  ->
    links of all images

Nothing here knows shapes: joining fragments and fitting splines is the work of :mod:`...matching.shapes`.
"""

from __future__ import annotations

import logging

import numpy as np
from scipy.stats import norm

from splinebba_cli.core.matching.fragments.confirmed_links import confirmed
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints, label_points
from splinebba_cli.core.matching.fragments.link_table import Links
from splinebba_cli.core.matching.fragments.links import links_of
from splinebba_cli.core.matching.fragments.narrowed_depths import narrowed
from splinebba_cli.core.matching.fragments.partners import partner_images
from splinebba_cli.core.matching.fragments.runs import Runs, runs_of
from splinebba_cli.core.matching.fragments.scene_depths import plausible_depths
from splinebba_cli.core.matching.fragments.selection import Stretch, selected_stretches
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.triangulation import sigmas_across, triangulated
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.matching.fragments.witnesses import seeing_share, third_image_possible
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network

_log = logging.getLogger(__name__)

WEAK = 4.0  # times the usual sigma across: the depth is open
LEAST_POINTS = 3  # of an image that sees a fragment
FEWEST_OF_CLOSED = 8  # places
CLOSING_STEPS = 2.0  # from the last place to the first
LEAST_SEEING = 0.5  # of the images that should see a fragment


def build_fragments(
    network: Network,
    rotation: FloatArray,
    position: FloatArray,
    settings: MatchSettings | None = None,
    rows: IntArray | None = None,
    object_xyz: FloatArray | None = None,
    orientation_sigma_mm: float = 0.0,
) -> list[Fragment]:
    """Pieces of curves in space from unlabelled chains.

    Parameters
    ----------
    rotation, position : (m, 3, 3) and (m, 3) present exterior orientations; NaN: the image is left out
    rows : (q,) unlabelled points without a curve, default all; single points are left out
    object_xyz : (n, 3) present coordinates of the points of the network, default those given: where objects lie
    orientation_sigma_mm : what uncertain orientations add to the noise of an image point across a chain

    Returns
    -------
    list of Fragment
        Best supported first.  Neighbours of one edge overlap by a few places and share image points there.
    """
    settings = settings or MatchSettings()
    rows = np.arange(len(network.unlabelled)) if rows is None else np.asarray(rows)
    views = Views.of(network, rotation, position)
    chains = TracedChains.of(network, views, rows, orientation_sigma_mm)
    if len(np.unique(chains.image)) < 2:
        return []
    gate = float(norm.isf(settings.alpha / 2.0))
    frames = Frames.of(views, chains)
    known = network.points.xyz if object_xyz is None else object_xyz
    scene = plausible_depths(network, known, views, chains, frames)
    scene = narrowed(views, chains, frames, scene, gate)
    partners = partner_images(views, chains, frames, scene)
    if not any(len(each) for each in partners):
        return []
    labels = confirmed(chains, label_points(views, chains, partners, scene.limits, gate), partners)
    runs = runs_of(chains, labels)
    stretches = selected_stretches(chains, labels, runs, two_images=labels.single)
    found = _fragments(views, chains, frames, labels, runs, stretches, gate, settings)
    _log.info("%d fragments from %d pieces of chains", len(found), len(chains.start) - 1)
    return found


def _fragments(
    views: Views, chains: TracedChains, frames: Frames, labels: LabelledPoints, runs: Runs,
    stretches: list[Stretch], gate: float, settings: MatchSettings,
) -> list[Fragment]:  # fmt: skip
    if not stretches:
        return []
    points = [np.arange(stretch.first, stretch.last) for stretch in stretches]
    everything, back = np.unique(np.concatenate(points), return_inverse=True)
    xyz, dispersion = triangulated(views, chains, labels, runs, everything)
    xyz, dispersion = xyz[back], dispersion[back]
    start = np.concatenate([[0], np.cumsum([len(each) for each in points])])
    along = _tangents(start, xyz)
    fine, sigma = sigmas_across(dispersion, along)
    weak = (sigma > WEAK * np.median(sigma)) & (sigma > WEAK * fine) | runs.bridged[np.concatenate(points)]
    links = links_of(views, chains, start, xyz, dispersion, gate, settings.direction_tolerance_rad)
    border = np.searchsorted(links.fragment, np.arange(len(points) + 1))
    out = []
    for k in range(len(points)):
        own = slice(int(start[k]), int(start[k + 1]))
        linked = links.only(np.arange(border[k], border[k + 1]))
        seen = _seen(chains, linked, len(points[k]), len(views.position))
        if not _believable(views, frames, xyz[own], seen):
            continue
        order = np.argsort(chains.row[linked.point])
        out.append(
            Fragment(
                xyz=xyz[own], dispersion=dispersion[own], image_count=seen.sum(axis=1), weak=weak[own],
                link_row=chains.row[linked.point][order], link_place=linked.place[order],
                closed=_closes(xyz[own]), reference_image=int(chains.image[points[k][0]]),
            )
        )  # fmt: skip
    return out


def _closes(xyz: FloatArray) -> bool:
    """Whether the first place follows the last one: a usual step away, and ahead."""
    step = np.linalg.norm(np.diff(xyz, axis=0), axis=1)
    gap = xyz[0] - xyz[-1]
    if len(xyz) < FEWEST_OF_CLOSED or np.linalg.norm(gap) > CLOSING_STEPS * np.median(step):
        return False
    return bool(gap @ (xyz[-1] - xyz[-3]) > 0.0 or np.linalg.norm(gap) < 0.5 * np.median(step))


def _believable(views: Views, frames: Frames, xyz: FloatArray, seen: BoolArray) -> bool:
    """Whether three images see the fragment and most of those between them; or two where no third one could."""
    if seeing_share(views, frames, xyz, seen) < LEAST_SEEING:
        return False
    if (seen.sum(axis=1) >= 3).any():
        return True
    return not third_image_possible(views, frames, xyz, np.asarray(seen.any(axis=0))).any()


def _tangents(start: IntArray, xyz: FloatArray) -> FloatArray:
    """Unit directions of fragments at their places, (k, 3)."""
    fragment = np.repeat(np.arange(len(start) - 1), np.diff(start))
    number = np.arange(len(xyz))
    after = np.minimum(number + 1, start[1:][fragment] - 1)
    before = np.maximum(number - 1, start[:-1][fragment])
    along = xyz[after] - xyz[before]
    return np.asarray(along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300))


def _seen(chains: TracedChains, linked: Links, places: int, images: int) -> BoolArray:
    """Whether images have linked points beside the places, (places, images)."""
    seen = np.zeros((places, images), dtype=bool)
    image = chains.image[linked.point]
    for k in np.unique(image):
        place = np.sort(linked.place[image == k])
        if len(place) < LEAST_POINTS:
            continue
        number = np.arange(places)
        after = np.clip(np.searchsorted(place, number), 0, len(place) - 1)
        before = np.maximum(after - 1, 0)
        seen[:, k] = np.minimum(np.abs(place[after] - number), np.abs(place[before] - number)) <= 1.5
    return seen
