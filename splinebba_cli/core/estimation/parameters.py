"""Which unknowns there are, which are removed, and the nodes of the reduced system.

Nodes are the blocks of the sparse factorisation: one of six unknowns per image (theta, X0), then the curves: a short
curve is one node, a long one a chain of nodes of four coefficients.  Locations are eliminated before, and so are points
but for those at the ends of distances: each of these is a node of three, after the curves.
A removed (fixed) unknown keeps its place with a unit diagonal, a zero column and a zero step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.network import FloatArray, Images, IntArray
from splinebba_cli.core.observations.coefficient_rows import removed_coefficients
from splinebba_cli.core.state import Prepared, State

SHORT_CURVE = 8  # coefficients up to which a curve is one node
CHAIN_NODE = 4  # coefficients per node of a longer curve
ORIENTATION_SIZE = 6


@dataclass(frozen=True)
class ParameterLayout:
    """Masks (1 free, 0 removed) and the numbering of nodes and unknowns."""

    image_mask: FloatArray  # (m, 6)
    coefficient_mask: FloatArray  # (C, 3)
    point_mask: FloatArray  # (n, 3)
    node_sizes: IntArray  # (nodes,) images first
    node_starts: IntArray  # (nodes + 1,) first unknown
    node_of_coefficient: IntArray  # (C,)
    slot_of_coefficient: IntArray  # (C,) first unknown of the coefficient inside its node
    node_curve: IntArray  # (nodes,) curve of a node, -1 for images and points
    node_of_point: IntArray  # (n,) -1 for points that are eliminated

    @property
    def image_count(self) -> int:
        """Number of image nodes."""
        return len(self.image_mask)

    @property
    def free_count(self) -> int:
        """Number of unknowns without locations, removed ones not counted."""
        return int(self.image_mask.sum() + self.coefficient_mask.sum() + self.point_mask.sum())

    @property
    def unknown_of_coefficient(self) -> IntArray:
        """First unknown of every coefficient in the reduced system, (C,)."""
        return self.node_starts[self.node_of_coefficient] + self.slot_of_coefficient

    def reduced_mask(self) -> FloatArray:
        """Mask of all reduced unknowns, (N,)."""
        mask = np.ones(int(self.node_starts[-1]))
        mask[: self.image_mask.size] = self.image_mask.ravel()
        mask[self.unknown_of_coefficient[:, None] + np.arange(3)] = self.coefficient_mask
        kept = self.kept_points
        mask[self.unknown_of_point[kept]] = self.point_mask[kept]
        return mask

    @property
    def kept_points(self) -> IntArray:
        """Points that stay in the reduced system."""
        return np.flatnonzero(self.node_of_point >= 0)

    @property
    def eliminated_mask(self) -> FloatArray:
        """Mask of the coordinates of points that are eliminated, (n, 3)."""
        return np.where((self.node_of_point < 0)[:, None], self.point_mask, 0.0)

    @property
    def unknown_of_point(self) -> IntArray:
        """Numbers of all coordinates of points, (n, 3): reduced ones, or behind these, point by point."""
        after = int(self.node_starts[-1]) + 3 * np.arange(len(self.node_of_point))
        first = np.where(self.node_of_point >= 0, self.node_starts[self.node_of_point], after)
        return np.asarray(first[:, None] + np.arange(3))

    def hold_images(self) -> ParameterLayout:
        """The same with all orientations removed."""
        return replace(self, image_mask=np.zeros_like(self.image_mask))


def image_mask(images: Images) -> FloatArray:
    """1 for free orientation unknowns, (m, 6); angles are removed only where all three are fixed."""
    mask: FloatArray = (images.prior_sigma != 0.0).astype(np.float64)
    mask[:, :3] = (images.prior_sigma[:, :3] != 0.0).any(axis=1)[:, None]
    return mask


def layout_of(prepared: Prepared) -> ParameterLayout:
    """The layout of a network with everything free that the user left free."""
    images = prepared.network.images
    begin = prepared.curves.coefficient_start
    count = np.diff(begin)
    step = np.where(count <= SHORT_CURVE, np.maximum(count, 1), CHAIN_NODE)
    in_curve = np.arange(begin[-1]) - np.repeat(begin[:-1], count)
    chain, within = np.divmod(in_curve, np.repeat(step, count))
    nodes_of_curve = -(-count // step)
    node = np.repeat(np.cumsum(nodes_of_curve) - nodes_of_curve, count) + chain
    distances = prepared.network.distances
    kept = np.unique(distances.station[~distances.is_image])
    images_and_curves = len(images.ids) + int(nodes_of_curve.sum())
    node_of_point = np.full(len(prepared.network.points.ids), -1, dtype=np.int64)
    node_of_point[kept] = images_and_curves + np.arange(len(kept))
    node_sizes = np.concatenate(
        [np.full(len(images.ids), ORIENTATION_SIZE), 3 * np.bincount(node), np.full(len(kept), 3)]
    ).astype(np.int64)
    node_curve = np.full(len(node_sizes), -1)
    node_curve[len(images.ids) : images_and_curves] = np.repeat(np.arange(len(count)), nodes_of_curve)
    return ParameterLayout(
        image_mask=image_mask(images),
        coefficient_mask=removed_coefficients(prepared),
        point_mask=(prepared.network.points.sigma != 0.0).astype(float),
        node_sizes=node_sizes,
        node_starts=np.concatenate([[0], np.cumsum(node_sizes)]),
        node_of_coefficient=len(images.ids) + node,
        slot_of_coefficient=3 * within,
        node_curve=node_curve,
        node_of_point=node_of_point,
    )


def node_positions(layout: ParameterLayout, state: State) -> FloatArray:
    """Positions of the nodes for the ordering: camera positions, means of coefficients, points, (nodes, 3)."""
    positions = np.zeros((len(layout.node_sizes), 3))
    positions[: layout.image_count] = state.position
    kept = layout.kept_points
    positions[layout.node_of_point[kept]] = state.xyz[kept]
    counts = np.bincount(layout.node_of_coefficient, minlength=len(positions))
    of_curves = layout.node_curve >= 0
    for axis in range(3):
        sums = np.bincount(layout.node_of_coefficient, state.coefficients[:, axis], minlength=len(positions))
        positions[of_curves, axis] = (sums / np.maximum(counts, 1))[of_curves]
    return positions
