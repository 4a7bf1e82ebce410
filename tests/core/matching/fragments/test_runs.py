"""Runs: gaps that are bridged, and gaps that end a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.runs import LONG_GAP, SHORT_GAP, runs_of
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains

BEFORE = 10  # points with depth on either side of the gap


def with_gap(gap: int, after: float = 10.0, piece: int = 1) -> tuple[TracedChains, LabelledPoints]:
    """A piece of level depth 10 with a gap; linked to piece 1 before it and to a piece behind it."""
    count, others = 2 * BEFORE + gap, 200
    total = count + 2 * others
    zero = np.zeros(total)
    chains = TracedChains(
        row=np.arange(total), image=np.repeat([0, 1], [count, 2 * others]),
        piece=np.repeat([0, 1, 2], [count, others, others]), start=np.array([0, count, count + others, total]),
        xy=np.column_stack([np.arange(total), zero]), arc=0.1 * np.arange(total),
        tangent=np.tile([1.0, 0.0], (total, 1)), tangent_sigma=zero + 0.03, sigma=zero + 0.003,
        ray=np.tile([0.0, 0.0, -100.0], (total, 1)),
    )  # fmt: skip
    has = np.zeros(total, dtype=bool)
    has[:BEFORE] = has[BEFORE + gap : count] = True
    point = np.flatnonzero(has)
    depth = np.where(has, 10.0, np.nan)
    depth[BEFORE + gap : count] = after
    first = np.where(point < BEFORE, count, count + (piece - 1) * others)
    joined = has.copy()
    joined[[0, BEFORE + gap]] = False
    labels = replace(
        LabelledPoints.none(total), depth=depth, sigma=np.where(has, 0.001, np.nan), slope=zero,
        slope_sigma=zero + 0.001, joined=joined, link_point=point, link_place=first + point + 0.5,
    )  # fmt: skip
    return chains, labels


@pytest.mark.parametrize(
    ("gap", "piece", "bridged"),
    [
        (SHORT_GAP, 2, True),
        (SHORT_GAP + 1, 2, False),
        (SHORT_GAP + 1, 1, True),
        (LONG_GAP, 1, True),
        (LONG_GAP + 1, 1, False),
    ],
)
def test_gaps_are_bridged_along_a_chain_up_to_a_length(gap: int, piece: int, bridged: bool) -> None:
    runs = runs_of(*with_gap(gap, piece=piece))
    assert len(runs) == (1 if bridged else 2)
    assert runs.bridged.sum() == (gap if bridged else 0)
    if bridged:
        assert runs.depth[BEFORE : BEFORE + gap] == pytest.approx(10.0)


def test_a_jump_in_depth_ends_a_run() -> None:
    assert len(runs_of(*with_gap(SHORT_GAP, after=10.5))) == 2
