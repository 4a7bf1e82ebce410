"""Redundancy numbers r_i = (Q_vv P)_ii = 1 - a_i Q a_i' of every observation, in whitened units.

They sum to the redundancy, which is checked.  A measured point on a curve has one equation across the curve; the
other is used up by its location, its redundancy along the curve is 0 unless arc lengths or a tangent tell more.
(theory, section 7; Baarda 1968)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import LinkedCofactors


@dataclass(frozen=True)
class RedundancyNumbers:
    """Redundancy numbers of all kinds of observations; 0 where there is no observation."""

    curve_rows: FloatArray  # (k,) across, then along for held locations
    linked_along: FloatArray  # (n,) along the curve at linked points
    arc_lengths: FloatArray  # (q,)
    tangents: FloatArray  # (t,)
    image_points: FloatArray  # (n, 2)
    orientation_priors: FloatArray  # (q, 6)
    point_priors: FloatArray  # (n_points, 3)
    coefficient_rows: FloatArray  # (q,)

    @property
    def total(self) -> float:
        """Sum over all observations and conditions."""
        parts = (
            self.curve_rows,
            self.linked_along,
            self.arc_lengths,
            self.tangents,
            self.image_points,
            self.orientation_priors,
            self.point_priors,
            self.coefficient_rows,
        )
        return float(sum(part.sum() for part in parts))


def redundancy_numbers(cofactors: Cofactors, linked: LinkedCofactors) -> RedundancyNumbers:
    """Redundancy numbers of all observations from the selected inverse."""
    assembler, at = cofactors.assembler, cofactors.solution.linearization
    network, layout = assembler.prepared.network, assembler.layout
    curve = 1.0 - cofactors.curve_leverage(at.curve_jacobian[:, :-1])
    image_points = np.zeros((len(network.point_observations), 2))
    points = cofactors.points
    observed = network.point_observations
    if len(observed):
        a = at.points.orientation * layout.image_mask[observed.image][:, None, :]
        x = at.points.object_xyz * layout.point_mask[observed.point][:, None, :]
        leverage = np.einsum("nri,nij,nrj->nr", a, cofactors.images[observed.image], a, optimize=True)
        leverage += 2.0 * np.einsum("nri,nij,nrj->nr", a, points.with_image, x, optimize=True)
        leverage += np.einsum("nri,nij,nrj->nr", x, points.own[observed.point], x, optimize=True)
        image_points = 1.0 - leverage
    priors = at.orientation_priors
    p = priors.jacobian * layout.image_mask[priors.image][:, None, :]
    prior_leverage = np.einsum("qri,qij,qrj->qr", p, cofactors.images[priors.image], p, optimize=True)
    weight = assembler.point_inverse_sigma**2
    point_leverage = np.einsum("nii->ni", points.own) * weight
    return RedundancyNumbers(
        curve_rows=curve,
        linked_along=np.where(assembler.prepared.chains.linked, 1.0 - linked.along, 0.0),
        arc_lengths=1.0 - linked.arc,
        tangents=1.0 - linked.tangent,
        image_points=image_points,
        orientation_priors=np.where(priors.active, 1.0 - prior_leverage, 0.0),
        point_priors=np.where(weight > 0.0, 1.0 - point_leverage, 0.0),
        coefficient_rows=1.0 - coefficient_leverage(cofactors),
    )


def coefficient_leverage(cofactors: Cofactors) -> FloatArray:
    """a Q a' of the equations over coefficients (control of values, gauge conditions), (q,)."""
    rows = cofactors.assembler.coefficient_rows
    if not len(rows):
        return np.zeros(0)
    j = cofactors.solution.linearization.coefficient_jacobian.reshape(len(rows), -1)
    windows = cofactors.coefficient_windows(rows.columns)
    return np.asarray(np.einsum("qi,qij,qj->q", j, windows, j, optimize=True))
