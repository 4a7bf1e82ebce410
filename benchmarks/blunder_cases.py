"""Gross errors planted in the six-image block of points and splines (noise 5 µm, 124 points and 660 points on curves).

Errors of curve points are across the projected curve, those of points in one coordinate; sizes in σ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution, solve_with_conditions
from splinebba_cli.core.estimation.datum import datum_layout
from splinebba_cli.core.estimation.design_matrix import design_matrix
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.observations.coefficient_rows import gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.revision.local_statistics import LEAST_REDUNDANCY
from splinebba_cli.core.settings import OutlierPolicy
from splinebba_cli.core.state import State, prepare
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import true_state

BLOCK = "six-image-mixed"
SAMPLES = 400


def with_policy(network: Network, policy: OutlierPolicy) -> Network:
    return replace(network, settings=replace(network.settings, outliers=policy))


def across(network: Network, normal: FloatArray, rows: IntArray, sizes: FloatArray) -> Network:
    """Errors of `sizes` σ across the curves, at measured curve points `rows`."""
    observed = network.curve_observations
    xy = observed.photo_xy.copy()
    xy[rows] += normal[rows] * (sizes * observed.sigma[rows, 0])[:, None]
    return replace(network, curve_observations=replace(observed, photo_xy=xy))


def in_coordinate(network: Network, row: int, axis: int, size: float) -> Network:
    """An error of `size` σ in one coordinate of an image point."""
    observed = network.point_observations
    xy = observed.photo_xy.copy()
    xy[row, axis] += size * observed.sigma[row, axis]
    return replace(network, point_observations=replace(observed, photo_xy=xy))


@dataclass(frozen=True)
class Clean:
    """A block without gross errors and its solution."""

    network: Network
    result: AdjustmentResult


def clean_block(seed: int, kind: str = BLOCK) -> Clean:
    network = simulate_block(kind, seed)[0]
    return Clean(network, adjust(network))


def planted_rows(clean: Clean, share: float, seed: int) -> tuple[IntArray, FloatArray]:
    """A share of the curve points, and errors of 20 to 200 σ of either sign for them."""
    rng = np.random.default_rng(seed)
    count = len(clean.network.curve_observations)
    rows = rng.choice(count, round(share * count), replace=False)
    return rows, rng.uniform(20.0, 200.0, len(rows)) * rng.choice([-1.0, 1.0], len(rows))


def contaminated(clean: Clean, share: float, seed: int) -> Network:
    """A share of the curve points in error across their curves."""
    rows, sizes = planted_rows(clean, share, seed)
    return across(clean.network, clean.result.curve_residuals.normal, rows, sizes)


def without_planted(clean: Clean, share: float, seed: int) -> AdjustmentResult:
    """The adjustment that knows which points are in error and has none of them."""
    excluded = np.zeros(len(clean.network.curve_observations), dtype=bool)
    excluded[planted_rows(clean, share, seed)[0]] = True
    observed = replace(clean.network.curve_observations, excluded=excluded)
    return adjust(replace(clean.network, curve_observations=observed))


def largest_shift(clean: AdjustmentResult, found: AdjustmentResult) -> float:
    """Largest difference of an orientation element, in σ of the clean solution."""
    sigma = np.sqrt(np.einsum("mii->mi", clean.images.dispersion))
    return float((np.abs(found.images.eop - clean.images.eop) / sigma).max())


@dataclass(frozen=True)
class Geometry:
    """What the design alone says of the tests: R = I − A Q A' of all whitened rows, and the tested ones."""

    basis: FloatArray  # (rows, unknowns) orthonormal columns that span A
    tested: IntArray  # (t,) rows that are tested
    entry: IntArray  # (t,) observation of each: points, then curve points
    redundancy: FloatArray  # (rows,)
    first_point_row: int
    points: int

    def row_of(self, entry: int, axis: int) -> int:
        """The row of an observation: a coordinate of a point, or across a curve."""
        return self.first_point_row + 2 * entry + axis if entry < self.points else entry - self.points


@cache
def geometry(kind: str = BLOCK) -> Geometry:
    """The tests of a block at its true state; the same for every seed."""
    network, truth = simulate_block(kind, 1, noise_um=0.0)
    prepared = prepare(network)
    solved = _solved(network, true_state(prepared, truth))
    at = solved.solution.linearization
    basis, _ = np.linalg.qr(design_matrix(solved.assembler, at).matrix)
    redundancy = 1.0 - np.sum(basis**2, axis=1)
    points, curves = len(network.point_observations), len(network.curve_observations)
    first = len(at.curve.point)  # rows of points come after those of curves
    rows = np.concatenate([first + np.arange(2 * points), np.arange(curves)])
    entry = np.concatenate([np.repeat(np.arange(points), 2), points + np.arange(curves)])
    kept = redundancy[rows] > LEAST_REDUNDANCY
    return Geometry(basis, rows[kept], entry[kept], redundancy, first, points)


def _solved(network: Network, state: State) -> ConditionedSolution:
    prepared = prepare(network)
    layout = datum_layout(prepared, state)
    return solve_with_conditions(
        prepared, layout, control_rows(prepared, layout.coefficient_mask),
        gauge_rows(prepared, layout.coefficient_mask, None), state,
        max_iterations=50, stage="truth", damping=0.0, observer=None,
    )  # fmt: skip


def first_probability(
    made: Geometry, entry: int, row: int, size: float, critical: float, rng: np.random.Generator
) -> float:
    """Probability that an error of `size` σ in a row makes its observation the largest of all and beyond `critical`.

    Sampled from w of N(size R_row, R), correlations between all tests included.
    """
    noise = rng.standard_normal((len(made.basis), SAMPLES))
    noise[row] += size
    residual = noise - made.basis @ (made.basis.T @ noise)
    w = np.abs(residual[made.tested]) / np.sqrt(made.redundancy[made.tested])[:, None]
    largest = np.argmax(w, axis=0)
    return float(np.mean((made.entry[largest] == entry) & (w[largest, np.arange(SAMPLES)] > critical)))
