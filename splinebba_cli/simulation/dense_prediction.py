"""Standard deviations of a small design at the truth by singular values: also where normal equations lose all digits.

Table 5.7 of Lee (2008) is regular with a smallest singular value of 1e-11 of the largest: its normal matrix is singular
in double precision, its design is not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.design_matrix import design_matrix
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.numerical_rank import rounding_limit, scaled_columns
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.along_curve import along_rows
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.quality.orientation_dispersion import eop_transform
from splinebba_cli.core.state import State, prepare
from splinebba_cli.simulation.realization import Design
from splinebba_cli.simulation.truth import at_truth, true_state


@dataclass(frozen=True)
class DensePrediction:
    """A priori standard deviations at the truth; 0 where nothing is estimated."""

    rank: int
    unknowns: int  # without locations
    smallest: float  # singular value that is not zero, of the largest
    eop: FloatArray  # (m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m)
    coefficients: FloatArray  # (C, 3) m
    location: FloatArray  # (n,) in units of u
    covariance: FloatArray  # (C, 3, C, 3) of the coefficients, m^2

    def across(self, weights: FloatArray, tangent: FloatArray) -> FloatArray:
        """Semi-axes (2,) m of the lateral standard ellipse where the basis has `weights` (C,); larger first."""
        spread = np.einsum("i,iajb,j->ab", weights, self.covariance, weights)
        unit = tangent / np.linalg.norm(tangent)
        lateral = np.eye(3) - np.outer(unit, unit)
        values = np.linalg.eigvalsh(lateral @ spread @ lateral)
        return np.asarray(np.sqrt(np.maximum(values[[2, 1]], 0.0)))


def dense_prediction(design: Design, *, conditions: bool) -> DensePrediction:
    """Standard deviations of a design; directions that nothing determines are left out of them.

    Parameters
    ----------
    conditions : whether the gauge conditions of all anchors take part
    """
    network = at_truth(design.network, design.truth)
    prepared = prepare(network)
    state, layout = true_state(prepared, design.truth), layout_of(prepared)
    rows = [control_rows(prepared, layout.coefficient_mask)]
    if conditions:
        rows.append(gauge_rows(prepared, layout.coefficient_mask, network.settings.gauge_sigma_m))
    assembler = Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))
    at = assembler.linearize(state, np.zeros(0, dtype=np.int64))
    made = design_matrix(assembler, at)
    full, rank, smallest = _cofactors(made.matrix)
    width = int(layout.node_starts[-1]) + layout.point_mask.size
    q = np.zeros((width, width))
    q[np.ix_(made.unknown, made.unknown)] = full
    images = layout.image_count
    blocks = np.array([q[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] for k in range(images)]).reshape(-1, 6, 6)
    transform = eop_transform(network.images, state.rotation)
    eop = transform @ blocks @ transform.transpose(0, 2, 1)
    place = (layout.unknown_of_coefficient[:, None] + np.arange(3)).ravel()
    count = len(layout.unknown_of_coefficient)
    covariance = q[np.ix_(place, place)].reshape(count, 3, count, 3)
    return DensePrediction(
        rank=rank,
        unknowns=made.matrix.shape[1],
        smallest=smallest,
        eop=np.sqrt(np.maximum(np.einsum("mii->mi", eop), 0.0)),
        coefficients=np.sqrt(np.maximum(np.diag(q)[place].reshape(count, 3), 0.0)),
        location=_locations(assembler, at, state, q),
        covariance=covariance,
    )


def _cofactors(matrix: FloatArray) -> tuple[FloatArray, int, float]:
    """Pseudo-inverse of A'A, rank, and the smallest singular value that counts."""
    if not matrix.shape[1]:
        return np.zeros((0, 0)), 0, 1.0
    scaled, reached = scaled_columns(matrix)
    _, singular, right = np.linalg.svd(scaled, full_matrices=False)
    used = singular > rounding_limit(matrix.shape[1])
    root = (right[used] / singular[used, None]) / np.where(reached, np.linalg.norm(matrix, axis=0), 1.0)
    return root.T @ root, int(used.sum()), float(singular[used][-1] / singular[0])


def _locations(assembler: Assembler, at: Linearization, state: State, q: FloatArray) -> FloatArray:
    """Standard deviations of the locations: those of chains from their triangle, single ones by their own row."""
    prepared = assembler.prepared
    observed = prepared.network.curve_observations
    variance = np.zeros(len(observed))
    for window in at.linked_windows:
        eliminated, chains = window.batch.eliminated, window.batch.chains
        sensitivity = eliminated.solve(window.masked(eliminated.pivot))
        own, _ = eliminated.location_cofactors()
        for g, unknowns in enumerate(window.unknowns):
            spread = sensitivity[g] @ q[np.ix_(unknowns, unknowns)] @ sensitivity[g].T
            used = chains.points[g] >= 0
            variance[chains.points[g][used]] = (own[g] + np.diag(spread))[used]
    single = np.flatnonzero(~prepared.chains.linked)
    along = along_rows(prepared, state, single)
    unknown = assembler.layout.unknown_of_coefficient[prepared.curves.columns[along.segment]]
    for k, point in enumerate(single):
        row = np.zeros(len(q))
        row[6 * observed.image[point] + np.arange(6)] = along.orientation[k]
        np.add.at(row, unknown[k][:, None] + np.arange(3), along.coefficients[k])
        variance[point] = (1.0 + row @ q @ row) / along.slope[k] ** 2
    return np.sqrt(np.maximum(variance, 0.0))


def with_true_locations(design: Design) -> Design:
    """The design with its true locations as approximate ones."""
    observed = replace(design.network.curve_observations, location=design.truth.locations)
    return replace(design, network=replace(design.network, curve_observations=observed))
