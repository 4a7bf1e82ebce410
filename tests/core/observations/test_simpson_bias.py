"""Bias of one Simpson step against the true length, and of Gauss-Legendre: the figures of theory.md, section 4.

Lee's block at c = 150 mm, his two segments, his locations.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import ArcLengths, CurveObservations, FloatArray
from splinebba_cli.core.observations.arc_lengths import arc_lengths_at
from splinebba_cli.core.state import State, prepare
from splinebba_cli.simulation.dissertation import FIRST, SECOND, design_of, experiment
from splinebba_cli.simulation.dissertation_tables import TABLE_5_4, TABLE_5_6, PrintedTable
from splinebba_cli.simulation.truth import true_state

IMAGES = 6


def lengths(
    segment: FloatArray, low: FloatArray, high: FloatArray, *, simpson: bool, pieces: int = 1
) -> FloatArray:
    """Image lengths (6, k) µm of the segment from low to high (k,), each summed over equal pieces."""
    design = design_of(experiment("table_5_6"))
    curve = replace(design.network.curves[0], values=segment)
    edges = np.linspace(low, high, pieces + 1)  # (pieces + 1, k)
    location = np.tile(edges.T.ravel(), IMAGES)
    image = np.repeat(np.arange(IMAGES), edges.size)
    count, step = len(location), pieces + 1
    first = np.flatnonzero(np.arange(count) % step < pieces)
    observed = CurveObservations(
        image, np.zeros(count, dtype=np.int64), np.zeros((count, 2)), np.ones((count, 2)), location,
        np.full(count, -1),
    )  # fmt: skip
    arcs = ArcLengths(
        first, first + 1, np.ones(len(first)), np.ones(len(first)), np.full(len(first), simpson)
    )
    network = replace(design.network, curves=(curve,), curve_observations=observed, arc_lengths=arcs)
    prepared = prepare(network)
    truth = replace(design.truth, curves=(segment,), locations=location)
    state: State = true_state(prepared, truth)
    found = arc_lengths_at(prepared, state, np.arange(len(first)))
    return 1e3 * found.reshape(IMAGES, len(low), pieces).sum(axis=2)


def biases(table: PrintedTable, key: str, last: int, *, simpson: bool) -> FloatArray:
    """|one step - true length| µm from the first to a later of Lee's locations, both segments, six images, (12,)."""
    location = table.locations[key].estimate
    low, high = location[:, 0], location[:, last]
    found = []
    for segment in (FIRST, SECOND):
        true = lengths(segment, low, high, simpson=False, pieces=40)
        found.append(np.abs(np.diag(lengths(segment, low, high, simpson=simpson) - true)))
    return np.concatenate(found)


def whole(*, simpson: bool) -> FloatArray:
    """The same for whole segments, (12,)."""
    zero, one = np.zeros(1), np.ones(1)
    return np.concatenate(
        [
            np.abs(lengths(s, zero, one, simpson=simpson) - lengths(s, zero, one, simpson=False, pieces=40))[
                :, 0
            ]
            for s in (FIRST, SECOND)
        ]
    )


def test_simpson_of_a_third_of_a_segment() -> None:
    """Table 5.4, steps of 0.28 to 0.32: theory 0.2 µm at most; here nine of twelve, the largest is 0.37."""
    found = biases(TABLE_5_4, "tie", 1, simpson=True)
    assert np.quantile(found, 0.75) < 0.2 and found.max() < 0.4


def test_simpson_of_two_thirds() -> None:
    """Table 5.6, steps of 0.6: theory 1 to 2 µm; here the median, single ones 0.03 to 4.7."""
    found = biases(TABLE_5_6, "control", 2, simpson=True)
    assert 1.0 < np.median(found) < 2.0 and found.max() < 5.0


def test_simpson_of_a_whole_segment() -> None:
    """Theory 30 to 110 µm; here 6 to 110 with the median 29: the error grows like the fifth power of the step."""
    found = whole(simpson=True)
    assert 25.0 < np.median(found) < 35.0 and 109.0 < found.max() < 111.0


def test_gauss_legendre() -> None:
    """At most 0.01 µm, for a whole segment too: eight nodes would leave 0.01003 in one image."""
    assert biases(TABLE_5_4, "tie", 1, simpson=False).max() < 1e-6
    assert biases(TABLE_5_6, "control", 2, simpson=False).max() < 1e-6
    assert whole(simpson=False).max() < 1e-3
