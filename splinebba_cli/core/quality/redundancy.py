"""Redundancy numbers r_i = (Q_vv P)_ii = 1 - a_i Q a_i' of every observation, in whitened units.

They sum to the redundancy, which is checked.  A measured point on a curve has one equation across the curve; the
other is used up by its location, its redundancy along the curve is 0 unless arc lengths or a tangent tell more.
(theory, section 7; Baarda 1968)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.curve_chunks import CurveEquations
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import LinkedCofactors
from splinebba_cli.core.quality.reliability import CONTROLLED

CHUNK = 100_000  # equations over coefficients at once


@dataclass(frozen=True)
class RedundancyNumbers:
    """Redundancy numbers of all kinds of observations; 0 where there is no observation."""

    curve: CurveEquations  # of curve points: across, then along for held locations
    curve_rows: FloatArray  # (k,) of these
    linked_along: FloatArray  # (n,) along the curve at linked points
    arc_lengths: FloatArray  # (q,)
    tangents: FloatArray  # (t,)
    distances: FloatArray  # (d,)
    image_points: FloatArray  # (n, 2)
    orientation_priors: FloatArray  # (q, 6)
    point_priors: FloatArray  # (n_points, 3)
    coefficient_rows: FloatArray  # (q,)
    curve_orientation: (
        FloatArray  # (k,) part of the leverage of curve rows that the orientation of the image has
    )
    point_orientation: FloatArray  # (n, 2) the same of image points

    @property
    def total(self) -> float:
        """Sum over all observations and conditions."""
        return float(sum(part.sum() for part in (*self._measured, self.coefficient_rows)))

    @property
    def _measured(self) -> tuple[FloatArray, ...]:
        return (
            self.curve_rows,
            self.linked_along,
            self.arc_lengths,
            self.tangents,
            self.distances,
            self.image_points,
            self.orientation_priors,
            self.point_priors,
        )

    def tested(self, conditions: BoolArray) -> int:
        """Number of equations whose errors can be found; `conditions` are those among the coefficient rows, (q,)."""
        parts = (*self._measured, self.coefficient_rows[~conditions])
        return sum(int((part > CONTROLLED).sum()) for part in parts)


def redundancy_numbers(cofactors: Cofactors, linked: LinkedCofactors) -> RedundancyNumbers:
    """Redundancy numbers of all observations from the selected inverse."""
    assembler, at = cofactors.assembler, cofactors.solution.linearization
    network, layout, image_mask = assembler.prepared.network, assembler.layout, cofactors.image_mask
    curve = cofactors.curve
    image_points = np.zeros((len(network.point_observations), 2))
    point_orientation = image_points
    weights = cofactors.orientation_weights
    points = cofactors.points
    observed = network.point_observations
    if len(observed):
        a = at.points.orientation * image_mask[observed.image][:, None, :]
        x = at.points.object_xyz * layout.point_mask[observed.point][:, None, :]
        leverage = np.einsum("nri,nij,nrj->nr", a, cofactors.images[observed.image], a, optimize=True)
        leverage += 2.0 * np.einsum("nri,nij,nrj->nr", a, points.with_image, x, optimize=True)
        leverage += np.einsum("nri,nij,nrj->nr", x, points.own[observed.point], x, optimize=True)
        image_points = 1.0 - leverage
        reached = np.matmul(a, cofactors.images[observed.image])
        reached += np.matmul(x, points.with_image.transpose(0, 2, 1))
        point_orientation = _share(reached, weights[observed.image])
    priors = at.orientation_priors
    p = priors.jacobian * image_mask[priors.image][:, None, :]
    prior_leverage = np.einsum("qri,qij,qrj->qr", p, cofactors.images[priors.image], p, optimize=True)
    weight = assembler.point_inverse_sigma**2
    point_leverage = np.einsum("nii->ni", points.own) * weight
    return RedundancyNumbers(
        curve=curve.equations,
        curve_rows=1.0 - curve.leverage,
        linked_along=np.where(assembler.prepared.chains.linked, 1.0 - linked.along, 0.0),
        arc_lengths=1.0 - linked.arc,
        tangents=1.0 - linked.tangent,
        distances=1.0 - cofactors.distance_leverage(),
        image_points=image_points,
        orientation_priors=np.where(priors.active, 1.0 - prior_leverage, 0.0),
        point_priors=np.where(weight > 0.0, 1.0 - point_leverage, 0.0),
        coefficient_rows=1.0 - coefficient_leverage(cofactors),
        curve_orientation=curve.orientation_share,
        point_orientation=point_orientation,
    )


def _share(reached: FloatArray, weights: FloatArray) -> FloatArray:
    """q Q_ii^-1 q' of q = a Q_.i, (..., r) for rows (..., r, 6) and weights (..., 6, 6)."""
    return np.asarray(np.sum(np.matmul(reached, weights) * reached, axis=-1))


def coefficient_leverage(cofactors: Cofactors) -> FloatArray:
    """a Q a' of the equations over coefficients (control of values, gauge conditions), (q,)."""
    rows = cofactors.assembler.coefficient_rows
    leverage = np.zeros(len(rows))
    jacobian = cofactors.solution.linearization.coefficient_jacobian
    for begin in range(0, len(rows), CHUNK):
        own = np.arange(begin, min(begin + CHUNK, len(rows)))
        given, conditions = own[rows.component[own] < GAUGE], own[rows.component[own] >= GAUGE]
        axis = rows.component[given]
        leverage[given] = _quadratic(
            jacobian[given, :, axis], cofactors.coordinate_windows(rows.columns[given], axis)
        )
        j = jacobian[conditions].reshape(len(conditions), 3 * rows.columns.shape[1])
        leverage[conditions] = _quadratic(j, cofactors.solved_windows(rows.columns[conditions]))
    return leverage


def _quadratic(rows: FloatArray, blocks: FloatArray) -> FloatArray:
    """j Q j' of rows (q, p) and blocks (q, p, p), (q,)."""
    return np.asarray(np.sum(np.matmul(rows[:, None, :], blocks)[:, 0] * rows, axis=1))
