"""Chains of image points as geometry: pieces without jumps, direction and noise at every point.

A chain is cut where tracing jumped: at a step much longer than the others of the chain, and where it turns back on
itself.  Directions are slopes of a straight line through a few neighbours on either side, which never reach beyond
a corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network, select_rows
from splinebba_cli.core.state import image_rays

JUMP = 3.0  # steps longer than this many times the ninth decile of the chain are jumps
STANDING = 3.0  # sigma; the direction of a shorter step says nothing
WINDOW = 3  # neighbours on either side that give the direction
CORNER_RAD = 0.6  # change of direction over the window, beyond which it is a corner
DIRECTION_FLOOR_RAD = 0.03  # what curvature and edge detection add to the noise of directions


@dataclass(frozen=True)
class TracedChains:
    """Points of all pieces, image by image, piece by piece in the order of tracing; corrected photo frame."""

    row: IntArray  # (n,) unlabelled point of the network
    image: IntArray  # (n,)
    piece: IntArray  # (n,) ascending from 0
    start: IntArray  # (pieces + 1,) first point of every piece
    xy: FloatArray  # (n, 2) mm
    arc: FloatArray  # (n,) mm along the piece from its first point
    tangent: FloatArray  # (n, 2) unit, in the order of tracing
    tangent_sigma: FloatArray  # (n,) rad
    sigma: FloatArray  # (n,) mm across the chain
    ray: FloatArray  # (n, 3) of the views

    def __len__(self) -> int:
        return len(self.row)

    @property
    def normal(self) -> FloatArray:
        """Unit vectors across the chain, (n, 2)."""
        return np.column_stack([-self.tangent[:, 1], self.tangent[:, 0]])

    @property
    def segment(self) -> IntArray:
        """Points that have a next one in their piece, (s,)."""
        return np.flatnonzero(self.piece[1:] == self.piece[:-1])

    def points_of(self, image: int) -> IntArray:
        """Points of an image, consecutive."""
        return np.arange(*np.searchsorted(self.image, [image, image + 1]))

    def segments_of(self, image: int) -> IntArray:
        """Points of an image that have a next one in their piece."""
        points = self.points_of(image)[:-1]
        return np.asarray(points[self.piece[points + 1] == self.piece[points]])

    @classmethod
    def of(
        cls, network: Network, views: Views, rows: IntArray, orientation_sigma_mm: float = 0.0
    ) -> TracedChains:
        """Pieces of the chains among some unlabelled points.

        Single points and images without orientation are left out.

        Parameters
        ----------
        rows : (q,) unlabelled points
        orientation_sigma_mm : what uncertain orientations add to the noise of a point
        """
        points = network.unlabelled
        use = (points.chain[rows] >= 0) & views.oriented[points.image[rows]]
        if points.excluded is not None:
            use &= ~points.excluded[rows]
        rows = rows[use]
        rows = rows[np.lexsort((rows, points.chain[rows], points.image[rows]))]
        own = select_rows(points, rows)
        rays = image_rays(network, own.image, own.photo_xy, own.sigma)
        covariance = np.linalg.inv(np.matmul(np.swapaxes(rays.whitening, 1, 2), rays.whitening))
        noise = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 2.0)
        piece = _pieces(own.image, own.chain, rays.xy, noise)
        tangent, tangent_sigma = _directions(piece, rays.xy, noise)
        normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
        step = np.linalg.norm(np.diff(rays.xy, axis=0, prepend=rays.xy[:1]), axis=1)
        start = np.flatnonzero(np.diff(piece, prepend=-1, append=piece[-1] + 1 if len(piece) else 0))
        along = np.cumsum(step)
        return cls(
            row=rows,
            image=own.image,
            piece=piece,
            start=start,
            xy=rays.xy,
            arc=along - along[start[:-1]][piece] if len(piece) else along,
            tangent=tangent,
            tangent_sigma=np.hypot(tangent_sigma, DIRECTION_FLOOR_RAD),
            sigma=np.hypot(
                orientation_sigma_mm, np.sqrt(np.einsum("ni,nij,nj->n", normal, covariance, normal))
            ),
            ray=views.rays(own.image, rays.xy),
        )


def _pieces(image: IntArray, chain: IntArray, xy: FloatArray, sigma: FloatArray) -> IntArray:
    """Number of the piece of every point, (n,)."""
    if not len(chain):
        return np.zeros(0, dtype=np.int64)
    same = (chain[1:] == chain[:-1]) & (image[1:] == image[:-1])
    group = np.concatenate([[0], np.cumsum(~same)])
    step = np.diff(xy, axis=0)
    length = np.linalg.norm(step, axis=1)
    cut = ~same | (
        length > JUMP * _ninth_decile(group[1:][same], length[same], int(group[-1]) + 1)[group[1:]]
    )
    moves = length > STANDING * sigma[1:]
    back = (np.sum(step[1:] * step[:-1], axis=1) < 0.0) & same[1:] & same[:-1]
    cut[1:] |= back & moves[1:] & moves[:-1]
    return np.concatenate([[0], np.cumsum(cut)])


def _ninth_decile(group: IntArray, value: FloatArray, count: int) -> FloatArray:
    """Ninth decile of the values of every group, (count,); inf for groups of less than four values."""
    order = np.lexsort((value, group))
    size = np.bincount(group, minlength=count)
    first = np.concatenate([[0], np.cumsum(size)[:-1]])
    out = np.full(count, np.inf)
    enough = size >= 4
    out[enough] = value[order][first[enough] + (0.9 * (size[enough] - 1)).astype(np.int64)]
    return out


def _directions(piece: IntArray, xy: FloatArray, sigma: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit tangents (n, 2) and their sigma (n,)."""
    smooth = piece + np.cumsum(_corners(piece, xy))
    offset = np.arange(-WINDOW, WINDOW + 1)
    near = np.arange(len(piece))[:, None] + offset
    inside = (near >= 0) & (near < len(piece))
    near = np.clip(near, 0, max(len(piece) - 1, 0))
    inside &= piece[near] == piece[:, None]
    kept = inside & (smooth[near] == smooth[:, None])
    alone = kept.sum(axis=1) < 2
    kept[alone] = inside[alone] & (np.abs(offset) <= 1)
    number = np.broadcast_to(offset.astype(float), kept.shape)
    weight = np.where(kept, number - _masked_mean(number, kept), 0.0)
    tangent = np.einsum("nk,nkd->nd", weight, xy[near])
    length = np.linalg.norm(tangent, axis=1)
    ok = length > 0.0
    unit = np.where(ok[:, None], tangent / np.where(ok, length, 1.0)[:, None], [1.0, 0.0])
    along = np.einsum("nkd,nd->nk", xy[near], unit)
    centred = np.where(kept, along - _masked_mean(along, kept), 0.0)
    spread = np.sqrt(np.sum(centred**2, axis=1))
    return unit, np.where(spread > 0.0, sigma / np.where(spread > 0.0, spread, 1.0), np.pi)


def _masked_mean(value: FloatArray, kept: BoolArray) -> FloatArray:
    count = np.maximum(kept.sum(axis=1, keepdims=True), 1)
    return np.asarray(np.where(kept, value, 0.0).sum(axis=1, keepdims=True) / count)


def _corners(piece: IntArray, xy: FloatArray) -> BoolArray:
    """Points at which a new smooth part begins, (n,): where the direction turns most, over a corner's angle."""
    n = len(piece)
    turn = np.zeros(n)
    number = np.arange(WINDOW, n - WINDOW)
    number = number[piece[number - WINDOW] == piece[number + WINDOW]]
    before, after = xy[number] - xy[number - WINDOW], xy[number + WINDOW] - xy[number]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn[number] = np.abs(np.arctan2(cross, np.sum(before * after, axis=1)))
    corner = turn > CORNER_RAD
    for shift in range(1, WINDOW + 1):
        corner[shift:] &= turn[shift:] > turn[:-shift]
        corner[:-shift] &= turn[:-shift] >= turn[shift:]
    return corner
