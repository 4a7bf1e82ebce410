"""Strands that follow each other on one edge joined across the gap between them.

    chain       a chain of an image goes on from the end of the one to the begin of the other: it shows that the edge
                does, also where it is the only one that sees the gap
    geometry    both ends, carried on straight to the middle of the gap, meet there: with g the gap and D the
                dispersions of the ends, F'(difference) is tested against F'(D_a + D_b)F + (g SAG)^2 I; the gap is
                short against both strands, and no other end fits as well

An end is joined once, the surest first.  Corners are not crossed: each side becomes a curve of its own, and one of them
with a corner when both have been adjusted (:mod:`.one_curve`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import chi2

from splinebba_cli.core.matching.shapes.end_to_end import end_to_end
from splinebba_cli.core.matching.shapes.strand import Strand
from splinebba_cli.core.matching.shapes.strand_ends import LEVER, StrandEnds, meeting, runs_on
from splinebba_cli.core.network import FloatArray, IntArray

SHORT = 0.3  # gaps without a chain across, of the length of the shorter strand
SHORT_WITH_CHAIN = 1.0  # gaps that a chain crosses, of the length of both strands together
MEETS = float(chi2.ppf(0.99, 2))
CORNER = float(np.cos(np.radians(40.0)))  # a chain that turns more goes around a corner
CLEARLY_BETTER = 3.0  # times the statistic: another end that fits nearly as well leaves the joint open
SURELY_MEETS = float(chi2.ppf(0.9, 2))
STRAIGHT = float(np.cos(np.radians(10.0)))
NEAR_END = 0.25  # of a strand


@dataclass(frozen=True)
class Joint:
    """Two ends that belong together."""

    first: tuple[int, int]  # strand and end: 0 its begin, 1 its end
    second: tuple[int, int]
    chains: int  # chains across the gap
    statistic: float
    gap: float  # metres


def joined_strands(strands: list[Strand], chain: IntArray, image: IntArray) -> list[Strand]:
    """Strands of whole edges.

    Parameters
    ----------
    chain, image : (n,) of all unlabelled points, -1: single
    """
    if not strands:
        return []
    links = links_between([(j.first, j.second) for j in joints_of(strands, chain, image)])
    done: set[int] = set()
    found = []
    for k in range(len(strands)):
        if k not in done:
            path, ring = path_from(k, links)
            done.update(number for number, _ in path)
            found.append(
                end_to_end([strands[n] if forward else strands[n].reversed() for n, forward in path], ring)
            )
    return found


def joints_of(strands: list[Strand], chain: IntArray, image: IntArray) -> list[Joint]:
    """Ends that belong together, each end once, the surest first."""
    ends = StrandEnds.of(strands)
    crossing = _chain_joints(strands, chain)
    seen = [_images_near_end(strand, end, image) for strand in strands for end in (0, 1)]
    joints = []
    for (a, b), chains in crossing.items():
        gap = float(np.linalg.norm(ends.xyz[a] - ends.xyz[b]))
        if -float(ends.outward[a] @ ends.outward[b]) < CORNER:
            continue
        if a == b or gap > SHORT_WITH_CHAIN * (ends.length[a] + ends.length[b]):
            continue
        if len(chains) >= len((seen[a] & seen[b]) - {int(image[row]) for row in chains.values()}):
            joints.append(Joint(divmod(a, 2), divmod(b, 2), len(chains), meeting(ends, a, b), gap))
    for joint in _near_joints(strands, ends):
        a, b = key = joint_key(joint)
        two_ends = len(seen[a] & seen[b]) >= 2
        if key not in crossing and not (two_ends and _doubtful(ends, joint)):
            joints.append(joint)
    joints.sort(key=lambda j: (-j.chains, j.statistic, j.first, j.second))
    taken: set[tuple[int, int]] = set()
    kept = []
    for joint in joints:
        if joint.first in taken or joint.second in taken:
            continue
        if not (strands[joint.first[0]].closed or strands[joint.second[0]].closed):
            taken.update((joint.first, joint.second))
            kept.append(joint)
    return kept


def _doubtful(ends: StrandEnds, joint: Joint) -> bool:
    """Whether a joint is not straight enough for ends at which the chains of two images or more end, too."""
    a, b = joint_key(joint)
    return joint.statistic > SURELY_MEETS or -float(ends.outward[a] @ ends.outward[b]) < STRAIGHT


def _images_near_end(strand: Strand, end: int, image: IntArray) -> set[int]:
    """Images with links in the quarter of a strand at its begin (0) or end (1)."""
    place = _from_begin(strand)
    near = place < NEAR_END if end == 0 else place > 1.0 - NEAR_END
    return set(image[strand.link_row[near]].tolist())


def joint_key(joint: Joint) -> tuple[int, int]:
    """Both ends as numbers, ascending."""
    a, b = 2 * joint.first[0] + joint.first[1], 2 * joint.second[0] + joint.second[1]
    return min(a, b), max(a, b)


def _near_joints(strands: list[Strand], ends: StrandEnds) -> list[Joint]:
    """Joints that geometry alone allows, without those that are not clearly the best of both ends."""
    reach = np.maximum(SHORT * ends.length, 2.0 * ends.spacing)
    tree = cKDTree(ends.xyz)
    found: dict[tuple[int, int], float] = {}
    for a, near in enumerate(tree.query_ball_point(ends.xyz, reach)):
        for b in near:
            gap = float(np.linalg.norm(ends.xyz[a] - ends.xyz[b]))
            if b <= a or gap > reach[b] or not runs_on(ends, a, b, gap):
                continue
            statistic = meeting(ends, a, b)
            if statistic <= MEETS:
                found[a, b] = statistic
    joints = []
    for (a, b), statistic in found.items():
        others = [s for (i, j), s in found.items() if (i, j) != (a, b) and {i, j} & {a, b}]
        if all(s > CLEARLY_BETTER * statistic + 1.0 for s in others) and not _same_strand(strands, a, b):
            gap = float(np.linalg.norm(ends.xyz[a] - ends.xyz[b]))
            joints.append(Joint(divmod(a, 2), divmod(b, 2), 0, statistic, gap))
    return joints


def _same_strand(strands: list[Strand], a: int, b: int) -> bool:
    """Ends of one strand that would close a ring too short to be one."""
    return a // 2 == b // 2 and len(strands[a // 2].location) < 4 * LEVER


def _chain_joints(strands: list[Strand], chain: IntArray) -> dict[tuple[int, int], dict[int, int]]:
    """Ends between which chains go on: these chains, and a point of each; ends are 2 k (begin) and 2 k + 1."""
    row = np.concatenate([s.link_row for s in strands])
    owner = np.repeat(np.arange(len(strands)), [len(s.link_row) for s in strands])
    low = np.concatenate([_from_begin(s) for s in strands])
    order = np.lexsort((owner, row))
    row, owner, low = row[order], owner[order], low[order]
    crossing: dict[tuple[int, int], dict[int, int]] = {}
    step = np.flatnonzero(
        (owner[1:] != owner[:-1]) & (chain[row[1:]] == chain[row[:-1]]) & (chain[row[1:]] >= 0)
    )
    for k in step.tolist():
        ends = [2 * int(owner[n]) + int(low[n] > 0.5) for n in (k, k + 1)]
        if max(min(low[n], 1.0 - low[n]) for n in (k, k + 1)) > 0.15:
            continue
        key = (min(ends), max(ends))
        crossing.setdefault(key, {})[int(chain[row[k]])] = int(row[k])
    return crossing


def _from_begin(strand: Strand) -> FloatArray:
    """Where links are, 0 at the begin and 1 at the end, (q,)."""
    return np.asarray((strand.link_location - strand.location[0]) / max(strand.length, 1e-300))


def links_between(
    joints: list[tuple[tuple[int, int], tuple[int, int]]],
) -> dict[tuple[int, int], tuple[int, int]]:
    """What is joined to an end, for both ends of every joint."""
    links = dict(joints)
    links.update({second: first for first, second in joints})
    return links


def path_from(
    start: int, links: dict[tuple[int, int], tuple[int, int]]
) -> tuple[list[tuple[int, bool]], bool]:
    """Strands in their order along the edge of one of them, with their sense; whether it is a ring."""
    strand, forward = start, True
    while (back := links.get((strand, 0 if forward else 1))) is not None:
        strand, forward = back[0], back[1] == 1
        if strand == start:
            break
    first = (strand, forward)
    path = [first]
    while (on := links.get((strand, 1 if forward else 0))) is not None:
        strand, forward = on[0], on[1] == 0
        if strand == first[0]:
            return path, True
        path.append((strand, forward))
    return path, False
