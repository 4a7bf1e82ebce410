"""Equations over coefficients alone (given values, gauge and shape conditions) in the normal equations.

All but shape conditions are linear: their part of the normal matrix is computed once for a pattern.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.estimation.segment_windows import coefficient_slots
from splinebba_cli.core.estimation.window_map import Slot, WindowMap
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE, SHAPE, CoefficientRows

PART = 4_000_000
"""Entries of products that are held at once."""


@dataclass(frozen=True)
class CoefficientNormals:
    """The constant part of the normal matrix, and where the rest goes."""

    mask: FloatArray  # (q, w, 3) of the coefficients under the rows
    constant: FloatArray  # flat values of all linear rows
    shape: IntArray  # (s,) quadratic rows
    window: WindowMap  # of these
    entry: IntArray  # (e,) entries of the masked jacobian (q, w, 3), flat, that are or may become different from 0
    unknown: IntArray  # (e,) their unknowns

    @classmethod
    def of(
        cls, rows: CoefficientRows, layout: ParameterLayout, structure: BlockStructure
    ) -> CoefficientNormals:
        """Products of the linear rows.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        mask = layout.coefficient_mask[rows.columns]
        shape = np.flatnonzero(rows.component == SHAPE)
        constant = np.zeros(structure.n_entries)
        for kind in (np.flatnonzero(rows.component == GAUGE), np.flatnonzero(rows.component < GAUGE)):
            wide = 1 if len(kind) and rows.component[kind[0]] < GAUGE else 3
            size = PART // (wide * rows.columns.shape[1]) ** 2
            for begin in range(0, len(kind), size):
                part = kind[begin : begin + size]
                j = rows.jacobian[part] * mask[part]
                slots = coefficient_slots(layout, rows.columns[part])
                if rows.component[part[0]] < GAUGE:  # of one coordinate only
                    component = rows.component[part]
                    j = j[np.arange(len(part)), :, component]
                    slots = [Slot(slot.node, slot.start + component, 1) for slot in slots]
                j = j.reshape(len(part), -1)
                WindowMap.of(structure, slots).add(constant, j[:, :, None] * j[:, None, :])
        used = rows.jacobian * mask != 0.0
        used[shape] = mask[shape] != 0.0
        entry = np.flatnonzero(used)
        unknown = layout.unknown_of_coefficient[rows.columns.ravel()[entry // 3]] + entry % 3
        window = WindowMap.of(structure, coefficient_slots(layout, rows.columns[shape]))
        return cls(mask, constant, shape, window, entry, unknown)

    def add(self, jacobian: FloatArray, residual: FloatArray, values: FloatArray, side: FloatArray) -> None:
        """Add the quadratic rows to the flat values and all rows to the right-hand side, in place.

        Parameters
        ----------
        jacobian : (q, w, 3) at the state
        residual : (q,)
        """
        if len(self.shape):
            j = (jacobian[self.shape] * self.mask[self.shape]).reshape(len(self.shape), -1)
            self.window.add(values, j[:, :, None] * j[:, None, :])
        self.add_right_side(jacobian, residual, side)

    def add_right_side(self, jacobian: FloatArray, residual: FloatArray, side: FloatArray) -> None:
        """Add all rows to the right-hand side, in place."""
        if len(self.entry):
            row = self.entry // (jacobian.shape[1] * 3)
            share = jacobian.ravel()[self.entry] * residual[row]
            side -= np.bincount(self.unknown, share, minlength=len(side))
