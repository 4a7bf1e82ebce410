"""Image points and priors of orientations in the blocks of the images.

N_ii += sum J'J,   h_i -= sum J'r      J the equations of image i over (theta, X0)
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.block_sums import Grouping
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.observations.image_points import PointRows
from splinebba_cli.core.observations.orientation_priors import PriorRows


def add_images(
    network: Network, layout: ParameterLayout, structure: BlockStructure, points: PointRows, priors: PriorRows,
    values: FloatArray, side: FloatArray,
) -> None:  # fmt: skip
    """Add image points and priors to the flat values and the right-hand side, in place."""
    mask = layout.image_mask
    blocks = np.zeros((len(mask), 6, 6))
    image_side = side[: mask.size].reshape(-1, ORIENTATION_SIZE)
    for image, jacobian, residual in (
        (network.point_observations.image, points.orientation, points.residual),
        (priors.image, priors.jacobian, priors.residual),
    ):
        if not len(image):
            continue
        a = jacobian * mask[image][:, None, :]
        transposed, by_image = a.transpose(0, 2, 1), Grouping.of(image)
        for out, rows in (
            (blocks, np.matmul(transposed, a)),
            (image_side, -np.matmul(transposed, residual[:, :, None])),
        ):
            sums = by_image.sums(rows.reshape(len(image), -1))
            out[image[by_image.one]] += sums.reshape(-1, *out.shape[1:])
    images = np.arange(len(mask))
    place = structure.offsets[structure.find(images, images)][:, None] + np.arange(36)
    values[place] += blocks.reshape(-1, 36)
