"""Image points that belong to fragments: every image is asked, those too whose chain fixes no depth.

A point belongs to a fragment where it lies within the gate across the projected fragment, its chain has the direction
of the projection, and its neighbours on the chain belong as well.  Where several fragments pass, the one wins that fits
the chain best over a stretch.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.fragments.link_table import Links, rows_of_links
from splinebba_cli.core.matching.fragments.one_chain import one_chain_an_image
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

WIDEST = 3.0  # what the dispersion of a fragment may add to the gate, in sigma of the image point
NEIGHBOURS = 2  # on either side, over which the fit to a fragment is averaged
LEAST_ROW = 3  # linked points in a row
EQUAL = 1.0  # difference of mean squares up to which two fragments explain a chain equally well
BEYOND = 0.75  # of a step, beyond the ends of a fragment


def links_of(
    views: Views, chains: TracedChains, start: IntArray, xyz: FloatArray, dispersion: FloatArray,
    gate: float, direction_tolerance: float,
) -> Links:  # fmt: skip
    """Chain points of all images that belong to fragments.

    Parameters
    ----------
    start : (f + 1,) first place of every fragment
    xyz, dispersion : places of all fragments, one after the other
    gate : sigma
    direction_tolerance : rad, beyond the noise
    """
    fragment = np.repeat(np.arange(len(start) - 1), np.diff(start))
    steps = np.flatnonzero(fragment[1:] == fragment[:-1])
    parts = []
    for k in np.unique(chains.image):
        own = chains.points_of(int(k))
        near = _near_steps(views, chains, int(k), own, xyz, steps, gate)
        parts.append(_fitting(views, chains, *near, xyz, dispersion, gate, direction_tolerance))
    point = np.concatenate([part[0] for part in parts])
    step = np.concatenate([part[1] for part in parts])
    place = step + np.concatenate([part[2] for part in parts]) - start[fragment[step]]
    links = Links(fragment[step], point, place, np.concatenate([part[3] for part in parts]))
    apart = np.concatenate([part[4] for part in parts])
    order = np.lexsort((apart, links.point, links.fragment))
    links = links.only(order)
    new = np.ones(len(links), dtype=bool)
    new[1:] = (links.point[1:] != links.point[:-1]) | (links.fragment[1:] != links.fragment[:-1])
    links = _in_rows(chains, links.only(new))
    links = _in_rows(chains, one_chain_an_image(chains, links))
    return _in_rows(chains, _best_fragment(chains, links))


def _near_steps(
    views: Views,
    chains: TracedChains,
    image: int,
    own: IntArray,
    xyz: FloatArray,
    steps: IntArray,
    gate: float,
) -> tuple[IntArray, IntArray]:
    """Pairs of a chain point of an image and a step of a fragment that passes near, (q,) each."""
    xy = views.project(np.full(len(xyz), image), xyz)
    one, two = xy[steps], xy[steps + 1]
    seen = np.isfinite(one).all(axis=1) & np.isfinite(two).all(axis=1)
    reach = gate * np.hypot(1.0, WIDEST) * float(chains.sigma[own].max())
    low, high = chains.xy[own].min(axis=0) - reach, chains.xy[own].max(axis=0) + reach
    with np.errstate(invalid="ignore"):
        seen &= ((np.maximum(one, two) >= low) & (np.minimum(one, two) <= high)).all(axis=1)
    steps, one, two = steps[seen], one[seen], two[seen]
    radius = (0.5 + BEYOND) * np.linalg.norm(two - one, axis=1) + reach
    found = cKDTree(chains.xy[own]).query_ball_point(0.5 * (one + two), radius)
    count = np.array([len(each) for each in found], dtype=np.int64)
    point = np.concatenate([np.asarray(each, dtype=np.int64) for each in found]) if count.sum() else own[:0]
    return own[point], np.repeat(steps, count)


def _fitting(
    views: Views, chains: TracedChains, point: IntArray, step: IntArray, xyz: FloatArray,
    dispersion: FloatArray, gate: float, direction_tolerance: float,
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Of pairs of a point and a step those that fit: point, step, fraction of the step, z, distance from the step."""
    image = chains.image[point]
    one = views.project(image, xyz[step])
    two = views.project(image, xyz[step + 1])
    along = two - one
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-300)
    unit = along / length[:, None]
    offset = chains.xy[point] - one
    fraction = np.sum(offset * unit, axis=1) / length
    normal = np.column_stack([-unit[:, 1], unit[:, 0]])
    distance = np.sum(offset * normal, axis=1)
    t = np.clip(fraction, 0.0, 1.0)
    middle = xyz[step] + t[:, None] * (xyz[step + 1] - xyz[step])
    _, jacobian = views.project_with_jacobian(image, middle)
    across = np.einsum("kr,kri->ki", normal, jacobian)
    spread = (1.0 - t)[:, None, None] * dispersion[step] + t[:, None, None] * dispersion[step + 1]
    own = np.einsum("ki,kij,kj->k", across, spread, across)
    sigma = chains.sigma[point]
    z = distance / np.sqrt(sigma**2 + np.minimum(own, (WIDEST * sigma) ** 2))
    cosine = np.abs(np.sum(unit * chains.tangent[point], axis=1))
    turned = np.arccos(np.clip(cosine, 0.0, 1.0))
    good = (np.abs(z) < gate) & (fraction > -BEYOND) & (fraction < 1.0 + BEYOND)
    good &= turned < direction_tolerance + gate * chains.tangent_sigma[point]
    rows = np.flatnonzero(good)
    apart = np.hypot(distance, (fraction - t) * length)
    return point[rows], step[rows], t[rows], z[rows], apart[rows]


def _in_rows(chains: TracedChains, links: Links) -> Links:
    """Links whose points follow each other on their piece, at least three or the whole piece."""
    if not len(links):
        return links
    group = rows_of_links(chains, links)
    size = np.bincount(group)
    least = np.minimum(LEAST_ROW, np.diff(chains.start)[chains.piece[links.point]])
    return links.only(size[group] >= least)


def _best_fragment(chains: TracedChains, links: Links) -> Links:
    """Links to the fragment that fits best over the neighbours; to others as well where they fit equally."""
    if not len(links):
        return links
    group, square = rows_of_links(chains, links), links.z**2
    total, number = square.copy(), np.ones(len(links))
    for shift in range(1, NEIGHBOURS + 1):
        same = group[shift:] == group[:-shift]
        total[shift:] += np.where(same, square[:-shift], 0.0)
        number[shift:] += same
        total[:-shift] += np.where(same, square[shift:], 0.0)
        number[:-shift] += same
    mean = total / number
    least = np.full(len(chains), np.inf)
    np.minimum.at(least, links.point, mean)
    return links.only(mean <= least[links.point] + EQUAL)
