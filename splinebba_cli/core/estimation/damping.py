"""Levenberg-Marquardt damping with a share of its own for every stretch of a curve.

One curve that would fold must not slow all others down, nor one stretch the rest of a long curve: a rejected step
raises the damping of its culprits where there are any, else of everything.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockMatrix
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.stretches import Stretches
from splinebba_cli.core.network import BoolArray, FloatArray

SMALLEST, LARGEST = 1e-9, 1e8


@dataclass
class Damping:
    """Factors of the diagonal of the normal matrix."""

    everywhere: float
    of_stretch: FloatArray  # (s,) added for the coefficients of each stretch of a curve

    @classmethod
    def starting(cls, assembler: Assembler, everywhere: float) -> Damping:
        """The same damping for all."""
        stretches = Stretches.of(assembler.layout, assembler.prepared.curves)
        return cls(everywhere, np.zeros(len(stretches.curve)))

    @property
    def none(self) -> bool:
        """Whether nothing is damped."""
        return self.everywhere == 0.0 and not self.of_stretch.any()

    @property
    def exhausted(self) -> bool:
        """Whether damping more makes no sense."""
        return self.everywhere > LARGEST

    def relaxed(self, gain: float) -> Damping:
        """After an accepted step, by the ratio of actual and predicted decrease."""
        factor = 0.01 if gain > 0.95 else 0.1 if gain > 0.75 else 4.0 if gain < 0.25 else 1.0
        return Damping(
            _vanishing(np.array(factor * self.everywhere)).item(), _vanishing(0.2 * self.of_stretch)
        )

    def raised(self, culprits: BoolArray) -> Damping:
        """After a rejected step."""
        if culprits.any():
            more = np.maximum(10.0 * self.of_stretch, 1e-3)
            return replace(self, of_stretch=np.where(culprits, more, self.of_stretch))
        return replace(self, everywhere=max(10.0 * self.everywhere, 1e-6))

    def of_unknowns(self, assembler: Assembler, at: Linearization) -> FloatArray | None:
        """What the stretches' own factors add to the diagonal of the reduced normal matrix, (N,)."""
        if not self.of_stretch.any():
            return None
        stretches = Stretches.of(assembler.layout, assembler.prepared.curves)
        diagonal = BlockMatrix(assembler.structure, at.base_values).diagonal()
        return stretches.of_unknowns(self.of_stretch) * diagonal


def _vanishing(damping: FloatArray) -> FloatArray:
    return np.where(damping < SMALLEST, 0.0, damping)
