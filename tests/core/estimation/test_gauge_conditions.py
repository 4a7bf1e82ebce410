"""Gauge conditions where a family has exact nulls: pure S-transformations (theory, section 6).

Straight lines and free segments have two nulls each, u -> alpha u + beta.  Every choice of two conditions gives the
same residuals, the same variance of unit weight and the same dispersion across the curve.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.gauss_markov import solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.coefficient_rows import gauge_rows
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.curve_precision import window_dispersion
from splinebba_cli.core.quality.redundancy import coefficient_leverage
from splinebba_cli.core.state import Prepared, prepare
from tests.core.free_curves import CUBIC, LINE, PARABOLA, block_with, tie
from tests.core.small_networks import start_of

FEATURES = (
    tie("line", "straight_line", LINE),
    tie("cubic", "free_cubic", CUBIC),
    tie("parabola", "polynomial_2", PARABOLA),
)
CHOICES = {  # places of the two conditions of every curve, and their sigma (m)
    "ends": ((0.0, 1.0), 0.1),
    "ends, tight": ((0.0, 1.0), 1e-4),
    "ends, weak": ((0.0, 1.0), 30.0),
    "inside": ((0.3, 0.8), 0.1),
    "outside": ((-0.5, 0.6), 5.0),
}


def with_anchors(prepared: Prepared, anchors: tuple[float, float]) -> Prepared:
    """The conditions of every curve at other places."""
    none = np.zeros(0, dtype=bool)
    bases = [replace(basis, anchors=np.array(anchors), loose_anchors=none) for basis in prepared.curves.bases]
    return replace(prepared, curves=CurveSet.of(bases))


@cache
def solution_of(choice: str) -> ConditionedSolution:
    """The block with the conditions of one choice."""
    network, _ = block_with(*FEATURES)
    anchors, sigma = CHOICES[choice]
    prepared = with_anchors(prepare(network), anchors)
    layout = layout_of(prepared)
    gauge = gauge_rows(prepared, layout.coefficient_mask, sigma)
    assembler = Assembler(prepared, layout, gauge)
    found = solve(assembler, start_of(network), max_iterations=50, stage="joint", damping=1e-3)
    assert found.converged, found.termination
    return ConditionedSolution(assembler, found, np.arange(len(gauge)))


@cache
def dispersions(choice: str) -> tuple[FloatArray, FloatArray]:
    """Object tangents (n, 3) and dispersion (n, 3, 3) of the curve points under the measured points."""
    found = solution_of(choice)
    prepared, state = found.assembler.prepared, found.solution.state
    curves, seen = prepared.curves, prepared.network.curve_observations
    segment, t = curves.locate(seen.curve, state.location)
    spread = window_dispersion(
        Cofactors(found.assembler, found.solution), curves, segment, curves.weights(segment, t)
    )
    tangent = curves.evaluate(state.coefficients, seen.curve, state.location, (1,))[0]
    return tangent / np.linalg.norm(tangent, axis=1)[:, None], spread


def lateral(choice: str) -> FloatArray:
    """Dispersion projected on the normal plane, (n, 3, 3)."""
    tangent, spread = dispersions(choice)
    plane = np.eye(3) - tangent[:, :, None] * tangent[:, None, :]
    return np.asarray(plane @ spread @ plane)


@pytest.mark.parametrize("choice", CHOICES)
def test_conditions_take_no_redundancy(choice: str) -> None:
    """Two for each curve; leverage 1, residual 0."""
    found = solution_of(choice)
    leverage = coefficient_leverage(Cofactors(found.assembler, found.solution))
    assert len(leverage) == 6
    np.testing.assert_allclose(leverage, 1.0, rtol=0.0, atol=1e-5)
    assert np.abs(found.solution.linearization.coefficient_residual).max() < 1e-3


@pytest.mark.parametrize("choice", list(CHOICES)[1:])
def test_residuals_do_not_depend_on_the_choice(choice: str) -> None:
    first, other = solution_of("ends").solution, solution_of(choice).solution
    assert other.linearization.cost == pytest.approx(first.linearization.cost, rel=1e-7)
    difference = other.linearization.curve.residual - first.linearization.curve.residual
    assert np.abs(difference).max() < 1e-3
    assert np.abs(other.linearization.points.residual - first.linearization.points.residual).max() < 1e-3


@pytest.mark.parametrize("choice", list(CHOICES)[1:])
def test_dispersion_across_does_not_depend_on_the_choice(choice: str) -> None:
    """Lateral dispersions agree; those along the curve do not."""
    first, other = lateral("ends"), lateral(choice)
    size = np.trace(first, axis1=1, axis2=2)[:, None, None]
    assert np.abs((other - first) / size).max() < 1e-4
    tangent, spread = dispersions("ends")
    other_tangent, other_spread = dispersions(choice)
    along = np.einsum("ni,nij,nj->n", tangent, spread, tangent)
    other_along = np.einsum("ni,nij,nj->n", other_tangent, other_spread, other_tangent)
    assert np.abs(other_along / along - 1.0).max() > 0.01


@pytest.mark.parametrize("choice", list(CHOICES)[1:])
def test_orientations_do_not_depend_on_the_choice(choice: str) -> None:
    first, other = solution_of("ends"), solution_of(choice)
    blocks = [Cofactors(s.assembler, s.solution).images for s in (first, other)]
    sigma = np.sqrt(np.einsum("mii->mi", blocks[0]))
    assert np.abs((blocks[1] - blocks[0]) / (sigma[:, :, None] * sigma[:, None, :])).max() < 1e-4
    moved = other.solution.state.position - first.solution.state.position
    assert np.abs(moved / sigma[:, 3:]).max() < 1e-3


@pytest.mark.parametrize("sigma_m", [1e-3, 0.1, 20.0])
def test_the_setting_changes_no_result_where_nulls_are_exact(sigma_m: float) -> None:
    """Through the whole adjustment: six conditions fill a defect of six, and take nothing."""
    network, _ = block_with(*FEATURES)
    default = adjust(network)
    found = adjust(replace(network, settings=replace(network.settings, gauge_sigma_m=sigma_m)))
    for statistics in (default.statistics, found.statistics):
        assert (statistics.conditions, statistics.rank_defect) == (6, 6)
        assert abs(statistics.condition_redundancy) < 1e-4 and statistics.condition_cost < 1e-6
        assert statistics.redundancy == statistics.observations + 6 - statistics.unknowns
    assert found.statistics.sigma0 == pytest.approx(default.statistics.sigma0, rel=1e-7)
    sigma_mm = network.curve_observations.sigma[0, 0]
    assert np.abs(found.curve_residuals.across - default.curve_residuals.across).max() < 1e-3 * sigma_mm
