"""Where a chain goes on from the end of one new curve to the begin of another.

    evidence   chains of one image or more do, with few points between, and most of the images that see both ends
    geometry   both ends, carried on straight, come closest within the length of the points between, or they run on into
               each other; they turn by less than a hairpin

Whether one curve fits what both do, and whether it has a corner there, is tried (:mod:`.one_curve`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.matching.shapes.extent import point_spacing
from splinebba_cli.core.network import Curve, FloatArray, IntArray, Network
from splinebba_cli.core.row_groups import split_by

MOST_BETWEEN = 8  # points of a chain that no curve has, around a corner
NEAR_END = 4.0  # spacings of points from the end of a curve
IMAGES_AT_CORNER = 2
SLACK = 2.0  # spacings by which a carried-on end may be too long or too short
BLUNTEST = float(np.cos(np.radians(30.0)))  # corners turn more
BENT = float(np.cos(np.radians(40.0)))  # a chain of one image alone does not show that a bend turns more
ROUNDEST = float(np.cos(np.radians(100.0)))  # bends turn less
SHARPEST = float(np.cos(np.radians(150.0)))  # corners turn less


@dataclass(frozen=True)
class CurveEnds:
    """Ends of the open curves of a draft, two each, (2 n, ...)."""

    location: FloatArray
    xyz: FloatArray
    outward: FloatArray  # (2 n, 3) unit
    spacing: FloatArray  # of the points of the curve
    in_image: FloatArray  # (2 n, m) of those of one image

    @classmethod
    def of(cls, draft: Draft) -> CurveEnds:
        """Those of all curves."""
        spacing = np.repeat(point_spacing(draft), 2)
        in_image = np.repeat(_spacing_in_images(draft), 2, axis=0)
        location, xyz, outward = [], [], []
        for k, basis in enumerate(draft.prepared.curves.bases):
            at, own = basis.break_points[[0, -1]], draft.coefficients_of(k)
            step = basis.evaluate(at, own, 1) * [[-1.0], [1.0]]
            location.append(at)
            xyz.append(basis.evaluate(at, own))
            outward.append(step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300))
        return cls(np.concatenate(location), np.vstack(xyz), np.vstack(outward), spacing, in_image)


@dataclass(frozen=True)
class CurveJoint:
    """Two ends of curves that may be one."""

    first: tuple[int, int]  # curve and end: 0 its begin, 1 its end
    second: tuple[int, int]
    images: int
    reach: tuple[float, float]  # metres from each end to the joint, negative: back
    place: FloatArray  # (3,) metres, of the joint
    row: IntArray  # unlabelled points between that no curve has
    corner: bool  # or a smooth one


def possible_joints(network: Network, draft: Draft, *, corners: bool) -> list[CurveJoint]:
    """Possible joints of one kind, each end once, the surest first."""
    ends = CurveEnds.of(draft)
    seen = _images_at_ends(draft, ends)
    make = _corner_of if corners else _bend_of
    found = []
    for (a, b), between in _chains_between(network, draft, ends).items():
        if len(between) >= len((seen[a] & seen[b]) - set(between)):
            joint = make(ends, a, b, between)
            found += [joint] if joint is not None else []
    found.sort(key=lambda j: (-j.images, j.first, j.second))
    taken: set[tuple[int, int]] = set()
    kept = []
    for joint in found:
        if not {joint.first, joint.second} & taken:
            taken |= {joint.first, joint.second}
            kept.append(joint)
    return kept


def _chains_between(
    network: Network, draft: Draft, ends: CurveEnds
) -> dict[tuple[int, int], dict[int, IntArray]]:
    """Pairs of ends (2 k begin, 2 k + 1 end) between which chains go on: their images, and the points between."""
    order = np.argsort(draft.row, kind="stable")
    row, curve, location = draft.row[order], draft.links.curve[order], draft.state.location[order]
    chain = network.unlabelled.chain[row]
    between = np.diff(row) - 1
    step = np.flatnonzero(
        (np.diff(curve) != 0) & (chain[1:] == chain[:-1]) & (chain[1:] >= 0) & (between <= MOST_BETWEEN)
    )
    found: dict[tuple[int, int], dict[int, IntArray]] = {}
    for k in step.tolist():
        pair = [_end_at(ends, int(curve[n]), float(location[n])) for n in (k, k + 1)]
        if min(pair) >= 0 and not any(draft.curves[end // 2].closed for end in pair):
            image = int(network.unlabelled.image[row[k]])
            found.setdefault((min(pair), max(pair)), {})[image] = np.arange(row[k] + 1, row[k + 1])
    return found


def _end_at(ends: CurveEnds, curve: int, location: float) -> int:
    """The end of a curve that a location is at, -1: none."""
    own = np.array([2 * curve, 2 * curve + 1])
    away = np.abs(ends.location[own] - location) / ends.spacing[own]
    nearest = int(np.argmin(away))
    return int(own[nearest]) if away[nearest] <= NEAR_END else -1


def _spacing_in_images(draft: Draft) -> FloatArray:
    """Usual distance of neighbouring links along every curve in every image, (nc, m); 0 where there are none."""
    images = len(draft.prepared.network.images.ids)
    key = draft.links.curve * images + draft.links.image
    order = np.lexsort((draft.state.location, key))
    inside = np.flatnonzero(np.diff(key[order]) == 0)
    step, group = np.diff(draft.state.location[order])[inside], key[order][inside]
    found = np.zeros(len(draft.curves) * images)
    for own in split_by(group):
        found[group[own[0]]] = np.median(step[own])
    return found.reshape(-1, images)


def _images_at_ends(draft: Draft, ends: CurveEnds) -> list[set[int]]:
    """Images with links near each end."""
    near = (
        np.abs(draft.state.location - ends.location.reshape(-1, 2)[draft.links.curve].T)
        <= NEAR_END * ends.spacing.reshape(-1, 2)[draft.links.curve].T
    )
    return [
        set(draft.links.image[own[near[side, own]]].tolist())
        for own in draft.links_by_curve
        for side in range(2)
    ]


def _corner_of(ends: CurveEnds, a: int, b: int, between: dict[int, IntArray]) -> CurveJoint | None:
    """The corner of two ends where their lines come closest; None where they do so nowhere near."""
    cosine = -float(ends.outward[a] @ ends.outward[b])
    if not SHARPEST < cosine < BLUNTEST or len(between) < IMAGES_AT_CORNER:
        return None
    lines = np.stack([ends.outward[a], -ends.outward[b]], axis=1)
    s = np.linalg.lstsq(lines, ends.xyz[b] - ends.xyz[a], rcond=None)[0]
    corner = 0.5 * (ends.xyz[a] + s[0] * ends.outward[a] + ends.xyz[b] + s[1] * ends.outward[b])
    return _joint(ends, a, b, between, s, corner, corner=True)


def _bend_of(ends: CurveEnds, a: int, b: int, between: dict[int, IntArray]) -> CurveJoint | None:
    """The middle between two ends that run on into each other; None where they do not."""
    if -float(ends.outward[a] @ ends.outward[b]) < (BENT if len(between) == 1 else ROUNDEST):
        return None
    direction = ends.outward[a] - ends.outward[b]
    half = 0.5 * float((ends.xyz[b] - ends.xyz[a]) @ direction) / float(np.linalg.norm(direction))
    middle = 0.5 * (ends.xyz[a] + ends.xyz[b])
    return _joint(ends, a, b, between, np.array([half, half]), middle, corner=False)


def _joint(
    ends: CurveEnds, a: int, b: int, between: dict[int, IntArray], reach: FloatArray, place: FloatArray, *,
    corner: bool,
) -> CurveJoint | None:  # fmt: skip
    """A joint if it is no farther from both ends than the points between say."""
    spacing = ends.spacing[[a, b]]
    longest = np.max(
        [(SLACK + len(rows)) * ends.in_image[[a, b], image] for image, rows in between.items()], axis=0
    )
    if (reach < -SLACK * spacing).any() or (reach > longest).any():
        return None
    return CurveJoint(
        (a // 2, a % 2), (b // 2, b % 2), len(between), (float(reach[0]), float(reach[1])), place,
        np.concatenate(list(between.values())), corner,
    )  # fmt: skip


def turned(curve: Curve) -> Curve:
    """The same curve in the other sense; locations u become first + last - u."""
    parameters = np.asarray(curve.knot_parameters)
    last = len(parameters) - 1
    return replace(
        curve, values=curve.values[::-1], sigma=curve.sigma[::-1], breaks=tuple(last - k for k in curve.breaks[::-1]),
        knot_parameters=parameters[0] + parameters[-1] - parameters[::-1],
    )  # fmt: skip
