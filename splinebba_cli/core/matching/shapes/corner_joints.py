"""Where a chain goes around a corner from the end of one new curve to the begin of another.

    evidence   chains of two images or more do, with few points between, and most of the images that see both ends
    geometry   both ends, carried on straight, come closest within the length of the points between; they turn by more
               than a bend and less than a hairpin
    test       v'Pv of both curves as one with a corner exceeds that of the two by no more than chance allows:
               chi square with the three coordinates that they no longer have apart
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.matching.shapes.extent import point_spacing
from splinebba_cli.core.network import Curve, FloatArray, IntArray, Network

MOST_BETWEEN = 8  # points of a chain that no curve has, around a corner
NEAR_END = 4.0  # spacings of points from the end of a curve
FEWEST_IMAGES = 2
SLACK = 2.0  # spacings by which a carried-on end may be too long or too short
BLUNTEST, SHARPEST = np.cos(np.radians(30.0)), np.cos(np.radians(150.0))  # turn


@dataclass(frozen=True)
class CurveEnds:
    """Ends of the open curves of a draft, two each, (2 n, ...)."""

    location: FloatArray
    xyz: FloatArray
    outward: FloatArray  # (2 n, 3) unit
    spacing: FloatArray  # of the points of the curve

    @classmethod
    def of(cls, draft: Draft) -> CurveEnds:
        """Those of all curves."""
        spacing = np.repeat(point_spacing(draft), 2)
        location, xyz, outward = [], [], []
        for k, basis in enumerate(draft.prepared.curves.bases):
            at, own = basis.break_points[[0, -1]], draft.coefficients_of(k)
            step = basis.evaluate(at, own, 1) * [[-1.0], [1.0]]
            location.append(at)
            xyz.append(basis.evaluate(at, own))
            outward.append(step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300))
        return cls(np.concatenate(location), np.vstack(xyz), np.vstack(outward), spacing)


@dataclass(frozen=True)
class CornerJoint:
    """Two ends that are the legs of a corner."""

    first: tuple[int, int]  # curve and end: 0 its begin, 1 its end
    second: tuple[int, int]
    images: int
    reach: tuple[float, float]  # metres from each end to the corner, negative: back
    corner: FloatArray  # (3,) metres
    row: IntArray  # unlabelled points around the corner that no curve has


def corner_joints(network: Network, draft: Draft) -> list[CornerJoint]:
    """Possible corners, each end once, the surest first."""
    ends = CurveEnds.of(draft)
    seen = _images_at_ends(draft, ends)
    found = []
    for (a, b), around in _chains_around(network, draft, ends).items():
        images = len(around)
        if images < FEWEST_IMAGES or images < len((seen[a] & seen[b]) - set(around)):
            continue
        joint = _corner_of(ends, a, b, around)
        if joint is not None:
            found.append(joint)
    found.sort(key=lambda j: (-j.images, j.first, j.second))
    taken: set[tuple[int, int]] = set()
    kept = []
    for joint in found:
        if not {joint.first, joint.second} & taken:
            taken |= {joint.first, joint.second}
            kept.append(joint)
    return kept


def _chains_around(
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


def _images_at_ends(draft: Draft, ends: CurveEnds) -> list[set[int]]:
    """Images with links near each end."""
    near = (
        np.abs(draft.state.location - ends.location.reshape(-1, 2)[draft.links.curve].T)
        <= NEAR_END * ends.spacing.reshape(-1, 2)[draft.links.curve].T
    )
    return [
        set(draft.links.image[near[end % 2] & (draft.links.curve == end // 2)].tolist())
        for end in range(len(ends.location))
    ]


def _corner_of(ends: CurveEnds, a: int, b: int, around: dict[int, IntArray]) -> CornerJoint | None:
    """The corner of two ends where their lines come closest; None where they do so nowhere near."""
    cosine = -float(ends.outward[a] @ ends.outward[b])
    if not SHARPEST < cosine < BLUNTEST:
        return None
    step = ends.xyz[b] - ends.xyz[a]
    lines = np.stack([ends.outward[a], -ends.outward[b]], axis=1)
    s = np.linalg.lstsq(lines, step, rcond=None)[0]
    spacing = ends.spacing[[a, b]]
    longest = (SLACK + max(len(rows) for rows in around.values())) * spacing
    if (s < -SLACK * spacing).any() or (s > longest).any():
        return None
    corner = 0.5 * (ends.xyz[a] + s[0] * ends.outward[a] + ends.xyz[b] + s[1] * ends.outward[b])
    return CornerJoint(
        (a // 2, a % 2), (b // 2, b % 2), len(around), (float(s[0]), float(s[1])), corner,
        np.concatenate(list(around.values())),
    )  # fmt: skip


def turned(curve: Curve) -> Curve:
    """The same curve in the other sense; locations u become first + last - u."""
    parameters = np.asarray(curve.knot_parameters)
    last = len(parameters) - 1
    return replace(
        curve, values=curve.values[::-1], sigma=curve.sigma[::-1], breaks=tuple(last - k for k in curve.breaks[::-1]),
        knot_parameters=parameters[0] + parameters[-1] - parameters[::-1],
    )  # fmt: skip
