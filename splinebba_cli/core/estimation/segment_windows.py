"""Rows of measured curve points grouped by image and segment: the small dense windows in which figures are read.

Assembly of points on curves of powers works with larger windows (:mod:`curve_windows`); this is for what is asked of
single rows after the solution, and for curves whose elementary functions are no powers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.estimation.window_map import Slot, WindowMap
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.curve_points import CurveRows
from splinebba_cli.core.row_groups import RowGroups


@dataclass(frozen=True)
class SegmentWindows:
    """Rows of curve points grouped by image and segment."""

    groups: RowGroups
    image: IntArray  # (G,)
    segment: IntArray  # (G,)
    window: WindowMap

    @classmethod
    def of(
        cls, rows: CurveRows, curves: CurveSet, layout: ParameterLayout, structure: BlockStructure,
        orientation_size: int,
    ) -> SegmentWindows:  # fmt: skip
        """Windows of rows.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        groups = RowGroups.of(rows.image * int(curves.segment_start[-1] + 1) + rows.segment)
        image, segment = rows.image[groups.representative], rows.segment[groups.representative]
        slots = [Slot(image, np.zeros_like(image), ORIENTATION_SIZE)] if orientation_size else []
        slots += coefficient_slots(layout, curves.columns[segment])
        return cls(groups, image, segment, WindowMap.of(structure, slots))


def coefficient_slots(layout: ParameterLayout, columns: IntArray) -> list[Slot]:
    """Slots of the coefficients under windows, (G, w)."""
    return [
        Slot(layout.node_of_coefficient[columns[:, j]], layout.slot_of_coefficient[columns[:, j]], 3)
        for j in range(columns.shape[1])
    ]


def masked_jacobian(
    rows: CurveRows, curves: CurveSet, layout: ParameterLayout, orientation_size: int
) -> FloatArray:
    """Rows over the orientation and the coefficients under each, removed unknowns 0, the residual last."""
    columns = curves.columns[rows.segment]
    local = rows.weights[:, :, None] * rows.direction[:, None, :] * layout.coefficient_mask[columns]
    return np.concatenate(
        [
            (rows.orientation * layout.image_mask[rows.image])[:, :orientation_size],
            local.reshape(len(local), 3 * local.shape[1]),
            rows.residual[:, None],
        ],
        axis=1,
    )


def add_segment_windows(
    jacobian: FloatArray, windows: SegmentWindows, curves: CurveSet, layout: ParameterLayout,
    values: FloatArray, side: FloatArray,
) -> None:  # fmt: skip
    """Add J'J and -J'r of rows to the flat values and the right-hand side, in place."""
    if not len(jacobian):
        return
    size = jacobian.shape[1] - 1 - 3 * curves.support
    gram = windows.groups.gram(jacobian)
    windows.window.add(values, gram[:, :-1, :-1])
    image_unknown = ORIENTATION_SIZE * windows.image[:, None] + np.arange(size)
    np.subtract.at(side, image_unknown, gram[:, :size, -1])
    place = layout.unknown_of_coefficient[curves.columns[windows.segment]][:, :, None] + np.arange(3)
    np.subtract.at(side, place.reshape(len(place), -1), gram[:, size:-1, -1])
