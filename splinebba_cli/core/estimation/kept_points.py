"""Points that stay in the reduced system because distances couple them, and these distances.

Elimination point by point needs blocks of their own; a distance between two points joins these.  Such points are few
(ends of scale bars), so they keep their unknowns next to cameras and curves:

    N_ix += A_eop' A_x,   N_xx += A_x' A_x + P_prior,   h_x -= A_x' r + P (x - x0)     of their image points
    N_ab += J_a' J_b,     h_a -= J_a' r                                               of distances from a to b
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.estimation.window_map import Slot, WindowMap, pair_map
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.observations.distances import DistanceRows
from splinebba_cli.core.observations.image_points import PointRows

POSITION = 3  # first unknown of the perspective centre in the node of an image


@dataclass(frozen=True)
class KeptPoints:
    """Places of kept points and distances in the reduced system."""

    layout: ParameterLayout
    points: IntArray  # (k,) kept points
    rays: IntArray  # (p,) their image points
    ray_image: IntArray  # (p,)
    ray_point: IntArray  # (p,)
    with_image: WindowMap  # (p,) blocks 6 x 3 of image and point
    own: WindowMap  # (k,) blocks 3 x 3
    ends: WindowMap | None  # (q,) windows 6 x 6 of both ends of distances
    end_unknowns: IntArray  # (q, 6)
    end_mask: FloatArray  # (q, 6)

    @classmethod
    def of(cls, network: Network, layout: ParameterLayout, structure: BlockStructure) -> KeptPoints:
        """Places in a pattern that holds the pairs of :func:`kept_pairs`."""
        observed = network.point_observations
        rays = np.flatnonzero(layout.node_of_point[observed.point] >= 0)
        image, point = observed.image[rays], observed.point[rays]
        node, kept = layout.node_of_point[point], layout.kept_points
        zero = np.zeros_like(image)
        own_node, own_zero = layout.node_of_point[kept], np.zeros_like(kept)
        nodes, starts = end_nodes(network, layout)
        slots = [Slot(nodes[:, end], starts[:, end], 3) for end in range(2)]
        unknowns = (layout.node_starts[nodes] + starts)[:, :, None] + np.arange(3)
        unknowns = unknowns.reshape(len(nodes), 6)
        return cls(
            layout=layout,
            points=kept,
            rays=rays,
            ray_image=image,
            ray_point=point,
            with_image=pair_map(structure, Slot(image, zero, ORIENTATION_SIZE), Slot(node, zero, 3)),
            own=pair_map(structure, Slot(own_node, own_zero, 3), Slot(own_node, own_zero, 3)),
            ends=WindowMap.of(structure, slots) if len(nodes) else None,
            end_unknowns=unknowns,
            end_mask=layout.reduced_mask()[unknowns],
        )

    def add(
        self, values: FloatArray, side: FloatArray, rows: PointRows, distances: DistanceRows,
        inverse_sigma: FloatArray, prior: FloatArray,
    ) -> None:  # fmt: skip
        """Add all equations of kept points and distances to flat values and right-hand side, in place.

        Parameters
        ----------
        rows : equations of all image points
        inverse_sigma, prior : (n, 3) of the control coordinates, and their whitened residuals
        """
        if len(self.points):
            mask = self.layout.point_mask
            a = rows.orientation[self.rays] * self.layout.image_mask[self.ray_image][:, None, :]
            x = rows.object_xyz[self.rays] * mask[self.ray_point][:, None, :]
            self.with_image.add(values, np.matmul(a.transpose(0, 2, 1), x))
            count = len(mask)
            blocks, sides = np.zeros((count, 3, 3)), np.zeros((count, 3))
            np.add.at(blocks, self.ray_point, np.matmul(x.transpose(0, 2, 1), x))
            blocks[:, range(3), range(3)] += (inverse_sigma * mask) ** 2
            np.subtract.at(
                sides, self.ray_point,
                np.matmul(x.transpose(0, 2, 1), rows.residual[self.rays][:, :, None])[:, :, 0],
            )  # fmt: skip
            sides -= inverse_sigma * prior * mask
            self.own.add(values, blocks[self.points])
            side[self.layout.unknown_of_point[self.points]] += sides[self.points]
        if self.ends is not None:
            j = self.end_jacobian(distances)
            self.ends.add(values, j[:, :, None] * j[:, None, :])
            np.subtract.at(side, self.end_unknowns, j * distances.residual[:, None])

    def end_jacobian(self, distances: DistanceRows) -> FloatArray:
        """Equations of distances over the unknowns of both ends that are not removed, (q, 6)."""
        return distances.jacobian.reshape(len(distances.jacobian), 6) * self.end_mask


def end_nodes(network: Network, layout: ParameterLayout) -> tuple[IntArray, IntArray]:
    """Nodes of the ends of distances and the first unknown of the position in them, (q, 2) each."""
    distances = network.distances
    nodes, starts = distances.station.copy(), np.where(distances.is_image, POSITION, 0)
    nodes[~distances.is_image] = layout.node_of_point[distances.station[~distances.is_image]]
    return nodes, starts


def kept_pairs(network: Network, layout: ParameterLayout) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of nodes that kept points and distances couple."""
    observed = network.point_observations
    rays = np.flatnonzero(layout.node_of_point[observed.point] >= 0)
    yield observed.image[rays], layout.node_of_point[observed.point[rays]]
    nodes, _ = end_nodes(network, layout)
    yield nodes[:, 0], nodes[:, 1]
