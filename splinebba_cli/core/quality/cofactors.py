"""Cofactors of the unknowns from the selected inverse: images, curve windows, points.

Whitened units: Q = (A'PA)^-1 with P = 1/sigma^2, so that dispersion = sigma0^2 Q.  With M_a = H^-1 W_a' of image
point a of an object point (elimination.py),

    Q_ix = -sum_b Q_i,b M_b',      Q_xx = H^-1 + sum_a,b M_a Q_ab M_b'
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.gauss_markov import Solution
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE
from splinebba_cli.core.estimation.window_map import Slot, WindowMap
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.curve_figures import CurveFigures, curve_figures
from splinebba_cli.core.quality.inner_datum import STransformation


@dataclass(frozen=True)
class PointCofactors:
    """Cofactors that belong to object points."""

    own: FloatArray  # (n, 3, 3) Q_xx
    with_image: FloatArray  # (n_obs, 6, 3) Q_ix of every image point


class Cofactors:
    """Blocks of the inverse of the full normal matrix at the solution, in the inner datum where one is given."""

    def __init__(
        self, assembler: Assembler, solution: Solution, datum: STransformation | None = None
    ) -> None:
        if solution.factor is None or solution.eliminated is None:
            raise ValueError("no factor: the estimation did not converge")
        self.assembler = assembler
        self.solution = solution
        self.datum = datum
        inverse = solution.factor.selected_inverse()
        self.values: FloatArray = inverse.values

    @cached_property
    def images(self) -> FloatArray:
        """Q of (theta, X0) of every image, (m, 6, 6), removed unknowns zero."""
        return self.solved_images if self.datum is None else self.datum.of_images(self.solved_images)

    @cached_property
    def solved_images(self) -> FloatArray:
        """The same in the datum of the solution."""
        layout, structure = self.assembler.layout, self.assembler.structure
        nodes = np.arange(layout.image_count)
        place = structure.offsets[structure.find(nodes, nodes)][:, None] + np.arange(ORIENTATION_SIZE**2)
        blocks = self.values[place].reshape(-1, ORIENTATION_SIZE, ORIENTATION_SIZE)
        mask = layout.image_mask
        return np.asarray(blocks * mask[:, :, None] * mask[:, None, :])

    @property
    def image_mask(self) -> FloatArray:
        """1 for orientation unknowns that have a dispersion, (m, 6)."""
        return self.assembler.layout.image_mask if self.datum is None else self.datum.image_mask

    def coefficient_windows(self, columns: IntArray) -> FloatArray:
        """Q of the coefficients under windows (G, w), (G, 3 w, 3 w); pairs must lie in the pattern."""
        own = columns is self.assembler.prepared.curves.columns
        blocks = self.segments if own else self.solved_windows(columns)
        return blocks if self.datum is None else self.datum.of_coefficients(blocks, columns)

    def solved_windows(self, columns: IntArray) -> FloatArray:
        """The same in the datum of the solution, to which its gauge conditions belong."""
        window = WindowMap.of(self.assembler.structure, self.assembler.slots_of_columns(columns))
        mask = self.assembler.layout.coefficient_mask[columns].reshape(len(columns), 3 * columns.shape[1])
        return window.gather(self.values) * mask[:, :, None] * mask[:, None, :]

    @cached_property
    def orientation_weights(self) -> FloatArray:
        """Q_ii^-1 of the orientations, (m, 6, 6); zero rows where unknowns are removed."""
        removed = np.zeros_like(self.images)
        removed[:, range(6), range(6)] = 1.0 - self.image_mask
        return np.asarray(np.linalg.inv(self.images + removed) - removed)

    def coordinate_windows(self, columns: IntArray, axis: IntArray) -> FloatArray:
        """Q of one coordinate (G,) of coefficients under windows (G, w), (G, w, w), in the datum of the solution."""
        slots = self.assembler.slots_of_columns(columns)
        single = [Slot(slot.node, slot.start + axis, 1) for slot in slots]
        mask = self.assembler.layout.coefficient_mask[columns, axis[:, None]]
        blocks = WindowMap.of(self.assembler.structure, single).gather(self.values)
        return np.asarray(blocks * mask[:, :, None] * mask[:, None, :])

    @cached_property
    def segments(self) -> FloatArray:
        """Q of the coefficients under every segment, (S, 3 w, 3 w), in the datum of the solution."""
        return self.solved_windows(self.assembler.prepared.curves.columns)

    def curve_windows(self, image: IntArray, segment: IntArray) -> FloatArray:
        """Q of images (g,) with the coefficients under segments (g,), (g, P, P), in the datum of the solution."""
        size, own = self.assembler.orientation_size, self.segments
        if not size:
            return own[segment]
        layout, structure = self.assembler.layout, self.assembler.structure
        columns = self.assembler.prepared.curves.columns[segment]
        node = layout.node_of_coefficient[columns]  # later than that of any image
        pair = structure.find(np.repeat(image, columns.shape[1]), node.ravel()).reshape(node.shape)
        corner = structure.offsets[pair] + layout.slot_of_coefficient[columns]
        line = np.arange(ORIENTATION_SIZE)[:, None] * structure.sizes[node][:, None, :]  # (g, 6, w)
        place = (corner[:, None, :] + line)[:, :, :, None] + np.arange(3)
        out = np.empty((len(image), size + own.shape[1], size + own.shape[1]))
        cross = out[:, :size, size:]
        np.multiply(self.values[place].reshape(cross.shape), layout.image_mask[image][:, :, None], out=cross)
        if not layout.coefficient_mask.all():
            cross *= layout.coefficient_mask[columns].reshape(len(image), 1, -1)
        out[:, size:, :size] = cross.transpose(0, 2, 1)
        out[:, :size, :size] = self.solved_images[image]
        out[:, size:, size:] = own[segment]
        return out

    @cached_property
    def curve(self) -> CurveFigures:
        """Leverages of the equations of all curve points, and cofactors of their locations."""
        return curve_figures(self)

    @cached_property
    def points(self) -> PointCofactors:
        """Q of all points and of points with the images that see them."""
        observed = self.assembler.prepared.network.point_observations
        eliminated = self.solution.eliminated
        if eliminated is None:
            raise ValueError("no eliminated points")
        mask = self.assembler.layout.eliminated_mask
        own = eliminated.inverse * mask[:, :, None] * mask[:, None, :]
        with_image = np.zeros((len(observed), ORIENTATION_SIZE, 3))
        pairs, pair_map = self.assembler.pairs, self.assembler.pair_window()
        if not len(observed) or pair_map is None:
            return PointCofactors(own, with_image)
        back = np.matmul(own[observed.point], eliminated.coupling.transpose(0, 2, 1))  # M (n_obs, 3, 6)
        blocks = self._image_pairs(pair_map)
        reached = np.matmul(blocks, back[pairs.b].transpose(0, 2, 1))  # Q_ab M_b'
        np.subtract.at(with_image, pairs.a, reached)
        other = observed.image[pairs.a] != observed.image[pairs.b]
        a, b = pairs.a[other], pairs.b[other]
        np.subtract.at(with_image, b, np.matmul(blocks[other].transpose(0, 2, 1), back[a].transpose(0, 2, 1)))
        np.subtract.at(own, observed.point, np.matmul(back, with_image))
        self._take_kept(own, with_image)
        if self.datum is not None:
            own = self.datum.of_points(own)
            with_image = self.datum.of_points_with_images(with_image, observed.image, observed.point)
        return PointCofactors(own, with_image)

    def _take_kept(self, own: FloatArray, with_image: FloatArray) -> None:
        """Blocks of the points that stay in the reduced system, in place."""
        kept, layout = self.assembler.kept_points, self.assembler.layout
        if not len(kept.points):
            return
        mask = layout.point_mask
        blocks = kept.own.gather(self.values)
        own[kept.points] = blocks * mask[kept.points][:, :, None] * mask[kept.points][:, None, :]
        blocks = kept.with_image.gather(self.values)
        with_image[kept.rays] = (
            blocks * layout.image_mask[kept.ray_image][:, :, None] * mask[kept.ray_point][:, None, :]
        )

    def distance_leverage(self) -> FloatArray:
        """a Q a' of the distances, (q,)."""
        kept = self.assembler.kept_points
        if kept.ends is None:
            return np.zeros(0)
        j = kept.end_jacobian(self.solution.linearization.distances)
        return np.asarray(np.einsum("qi,qij,qj->q", j, kept.ends.gather(self.values), j))

    def _image_pairs(self, pair_map: WindowMap) -> FloatArray:
        observed = self.assembler.prepared.network.point_observations
        mask = self.assembler.layout.image_mask
        a, b = observed.image[self.assembler.pairs.a], observed.image[self.assembler.pairs.b]
        return pair_map.gather(self.values) * mask[a][:, :, None] * mask[b][:, None, :]
