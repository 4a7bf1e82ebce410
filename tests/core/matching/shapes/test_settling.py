"""New curves are handed on as an adjustment leaves them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.estimation.curve_stage import curves_alone
from splinebba_cli.core.estimation.gauss_markov import solve
from splinebba_cli.core.matching.shapes import settling
from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.matching.shapes.settling import settled_curves
from splinebba_cli.core.state import initial_coefficients, prepare
from tests.core.matching.fragments.small_scenes import arc, scene
from tests.core.matching.shapes.edges import curve_through, draft_through


@pytest.fixture(scope="module")
def block() -> ChainBlock:
    return scene([arc(60.0, 1.5)])


@pytest.fixture(scope="module")
def draft(block: ChainBlock) -> Draft:
    return draft_through(block, [curve_through(block.curves[0], every=8)], {0: 0}).solved()


def test_knots_are_where_an_adjustment_leaves_them(draft: Draft) -> None:
    prepared = prepare(replace(draft.prepared.network, curves=draft.present_curves()))
    state = replace(draft.state, coefficients=initial_coefficients(prepared))
    solved = solve(curves_alone(prepared), state, max_iterations=50, stage="x", stationary=0.0)
    adjusted = prepared.curves.bases[0].values_from_coefficients(solved.state.coefficients)
    (before,), (after,) = draft.present_curves(), settled_curves(draft).present_curves()
    inner = slice(1, -1)  # ends are carried on to the outermost points
    moved, left = (np.abs(curve.values - adjusted)[inner].max() for curve in (before, after))
    assert left < 0.2 * moved  # along the curve they are known to decimetres only


def test_no_point_is_behind_an_end(draft: Draft) -> None:
    settled = settled_curves(draft)
    breaks = settled.prepared.curves.bases[0].break_points
    reach = 1e-6 * (breaks[-1] - breaks[0])
    assert settled.state.location.min() >= breaks[0] - reach
    assert settled.state.location.max() <= breaks[-1] + reach


def test_a_curve_that_does_not_settle_gets_other_knots(draft: Draft, monkeypatch: pytest.MonkeyPatch) -> None:
    once = iter([True])
    solved = settling._solved

    def unsettled_once(prepared, state):  # type: ignore[no-untyped-def]
        found = solved(prepared, state)
        return replace(found, converged=False) if next(once, False) else found

    monkeypatch.setattr(settling, "_solved", unsettled_once)
    before = np.asarray(draft.present_curves()[0].knot_parameters)
    after = np.asarray(settled_curves(draft).present_curves()[0].knot_parameters)
    assert len(before) != len(after) or not np.allclose(np.diff(before), np.diff(after), rtol=0.01)
    spacing = np.diff(after)[1:-1]
    assert np.ptp(spacing) < 0.1 * spacing.mean()  # evenly spaced


def test_a_curve_that_nothing_helps_stays(draft: Draft, monkeypatch: pytest.MonkeyPatch) -> None:
    solved = settling._solved
    monkeypatch.setattr(settling, "_solved", lambda p, s: replace(solved(p, s), converged=False))
    (before,), (after,) = draft.present_curves(), settled_curves(draft).present_curves()
    np.testing.assert_allclose(after.values, before.values, atol=1e-9)
