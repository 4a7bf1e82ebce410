"""The rank and nullity table of theory.md, section 6, without arc lengths, and what more points do in their place.

Arc lengths do not change which directions are undetermined: equations and redundancy are smaller by their number, rank
and nullity are the table's where the image points alone suffice.  Where they do not (4 points an image and no more
equations), more points take their place and only the nullity can be compared; each test says so.  The complete rows are
in test_rank_table_of_the_dissertation.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.budget import Budget, budget
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.simulation.assembly import assemble
from splinebba_cli.simulation.block_geometry import six_image_block
from splinebba_cli.simulation.feature_geometry import Feature, PointFeatures
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.six_image_block import LEE_SEGMENT
from splinebba_cli.simulation.truth import at_truth
from tests.core.free_curves import CUBIC, LINE, PARABOLA, STRAIGHT, WINDING

EXACT = Noise(0.0, 0.0, 0.0, 0.0)
FIRST_SEGMENT = np.array(  # of the natural spline whose second one LEE_SEGMENT is
    [[3232.0, 4261.0, 18.0], [119.25, 91.5, 47.0], [0.0, 0.0, 0.0], [-16.25, -9.5, -13.0]]
)
WIDE = (260.0, 260.0)  # mm; Lee's segment lies beyond the corner of 230 mm in some images


def curve(
    id: str, values: FloatArray, sigma: float | FloatArray = np.inf, family: str = "free_cubic"
) -> Feature:
    """A curve with one sigma for all of its values, or one for each row."""
    rows = np.broadcast_to(np.reshape(sigma, (-1, 1)), values.shape).astype(float)
    role = "control" if (rows == 0.0).all() else "tie" if np.isinf(rows).all() else "partial"
    return Feature(id, role, values, rows, family=family)


def started(id: str, values: FloatArray) -> Feature:
    """A segment whose starting point is known (Lee's partial control spline)."""
    return curve(id, values, np.array([0.0, np.inf, np.inf, np.inf]))


def count(*features: Feature, each: int, known: bool, images: int = 6) -> Budget:
    """The budget at the truth.

    Parameters
    ----------
    each : measured points for every curve and image
    known : whether the exterior orientations are fixed
    images : how many of the six images take part
    """
    network = design(*features, each=each, known=known, images=images)
    assert len(network.curve_observations) == images * each * len(features)
    return budget(network)


def design(*features: Feature, each: int, known: bool, images: int = 6) -> Network:
    block = six_image_block(WIDE)
    block = replace(block, eop=block.eop[:images])
    network, truth = assemble(block, features, PointFeatures(), each, None, EXACT, seed=1)
    network = at_truth(network, truth)
    if known:
        fixed = replace(network.images, prior=truth.eop.copy(), prior_sigma=np.zeros_like(truth.eop))
        network = replace(network, images=fixed)
    return network


def figures(found: Budget) -> tuple[int, int, int, int]:
    return found.equations, found.unknowns, found.rank, found.nullity


def test_table_5_4_one_free_segment() -> None:
    """30 / 24, rank 22, nullity 2, redundancy 8 with 6 arc lengths: 24 / 24, 22, 2 and 2 without.

    12 equations across the curve carry the 10 determinable numbers of the segment: the row is complete.
    """
    found = count(curve("free", LEE_SEGMENT), each=2, known=True)
    assert figures(found) == (30 - 6, 24, 22, 2)
    assert found.redundancy == 8 - 6
    assert {problem.subject for problem in found.problems} == {"spline `free`"}


def test_table_5_5_start_point_fixed() -> None:
    """30 / 21, rank 20, nullity 1, redundancy 10; 24 / 21, 20, 1 and 4 without the 6 arc lengths."""
    found = count(started("partial", LEE_SEGMENT), each=2, known=True)
    assert figures(found) == (30 - 6, 21, 20, 1)
    assert found.redundancy == 10 - 6


def test_table_5_6_control_spline_locations_only() -> None:
    """36 / 18, rank 18, nullity 0, redundancy 18: the whole row, it has no arc lengths."""
    found = count(curve("control", LEE_SEGMENT, 0.0), each=3, known=True)
    assert figures(found) == (36, 18, 18, 0)
    assert found.redundancy == 18


def test_a_location_without_a_domain_is_no_unknown() -> None:
    """A curve that is one point: two equations and no location for every measurement."""
    network = design(curve("place", CUBIC[:1], family="polynomial_0"), each=2, known=True)
    assert len(network.curve_observations) == 4
    assert figures(budget(network)) == (8, 3, 3, 0)


def test_locations_at_the_end_of_their_segment_are_unknowns() -> None:
    """Points bound to the first of four segments: those measured beyond its end keep their unknown all the same."""
    network = design(curve("control", WINDING, 0.0, "natural_cubic"), each=12, known=True)
    seen = network.curve_observations
    assert (seen.location > 1.0).any()
    bound = replace(seen, segment=np.zeros(len(seen), dtype=np.int64), location=np.full(len(seen), np.nan))
    found = budget(replace(network, curve_observations=bound))
    assert figures(found) == (2 * len(seen), len(seen), len(seen), 0)
    at_the_end = replace(bound, location=np.ones(len(seen)))
    assert figures(budget(replace(network, curve_observations=at_the_end))) == figures(found)


def test_table_5_7_six_orientations_one_control_segment() -> None:
    """66 / 60, rank 60, nullity 0.

    Its 4 points an image leave 24 equations across the curve for 36 orientation unknowns: without the 18 arc lengths
    the rank is 48, and that they supply the missing 12 can only be shown with them.  With 6 points an image the
    design is regular as in the table (one image of a cubic gives 8 conditions, 7 of a planar one such as Lee's).
    """
    segment = curve("control", LEE_SEGMENT, 0.0)
    assert figures(count(segment, each=4, known=False)) == (66 - 18, 60, 48, 12)
    assert figures(count(segment, each=6, known=False)) == (72, 72, 72, 0)


@pytest.mark.parametrize(("each", "nullity"), [(6, 0), (7, 0), (12, 0)])
@pytest.mark.parametrize("segment", [LEE_SEGMENT, CUBIC], ids=["planar", "twisted"])
def test_a_control_segment_determines_every_image(segment: FloatArray, each: int, nullity: int) -> None:
    assert count(curve("control", segment, 0.0), each=each, known=False).nullity == nullity


def test_section_5_3_two_partial_control_segments_unconnected() -> None:
    """132 / 102, rank 97, nullity 5: seven of the datum and two of each segment, less the six of the start points.

    4 points without the 36 arc lengths: 96 / 102, rank 96, one equation short.  With 6 points the 5 remain.
    """
    features = (started("first", FIRST_SEGMENT), started("second", LEE_SEGMENT))
    few, more = (count(*features, each=each, known=False) for each in (4, 6))
    assert figures(few) == (132 - 36, 102, 96, 6)
    assert figures(more) == (144, 126, 121, 5)


def test_table_5_8_control_and_tie_segment() -> None:
    """96 / 84, rank 82, nullity 2 (3 points an image and segment, 24 arc lengths).

    Without arc lengths 3 points give 36 equations across the curves for 46 determinable unknowns: 72 / 84, rank 72.
    With 6 points the two nulls of the tie segment remain, as in the table.
    """
    features = (curve("control", CUBIC, 0.0), curve("tie", LEE_SEGMENT))
    few = count(*features, each=3, known=False)
    assert figures(few)[:2] == (96 - 24, 84)
    assert few.rank <= 72
    more = count(*features, each=6, known=False)
    assert more.nullity == 2
    assert more.unknowns == 36 + 12 + 72
    assert {problem.subject for problem in more.problems} == {"spline `tie`"}


def test_table_5_10_three_images() -> None:
    """24 / 21, rank 19, nullity 2, redundancy 5: one free segment, three known images, 3 points and 6 arc lengths.

    9 equations across the curve are one short of its 10 numbers (rank 18, nullity 3); with 4 points 2 remain.
    """
    segment = curve("tie", LEE_SEGMENT)
    assert figures(count(segment, each=3, known=True, images=3)) == (24 - 6, 21, 18, 3)
    assert count(segment, each=4, known=True, images=3).nullity == 2


def nulls(*features: Feature) -> int:
    """Nullity with known orientations and more than enough points, in the images that see the curves."""
    return budget(design(*features, each=24, known=True)).nullity


@pytest.mark.parametrize(
    ("family", "values", "nullity"),
    [
        ("polynomial_0", CUBIC[:1], 0),
        ("polynomial_1", LINE - np.array([[0.0], [1.0]]) * LINE[0], 2),
        ("polynomial_2", PARABOLA, 2),
        ("polynomial_3", CUBIC, 2),
        ("free_cubic", CUBIC, 2),
        ("straight_line", LINE, 2),
    ],
)
def test_nullity_of_the_families(family: str, values: FloatArray, nullity: int) -> None:
    """t -> alpha t + beta for everything that has a location."""
    assert nulls(curve("tie", values, family=family)) == nullity


@pytest.mark.parametrize("segments", [2, 3, 4])
def test_unconnected_segments_have_two_nulls_each(segments: int) -> None:
    """4, 6 and 8 for 2, 3 and 4 free segments without continuity.

    C0, C1 and C2 between free segments (3/4/5, 2/2/2, 1/0/0) need constraints between curves, which do not exist yet.
    """
    shifted = [CUBIC + np.array([[15.0 * k, -20.0 * k, 5.0 * k]] + 3 * [[0.0] * 3]) for k in range(segments)]
    assert nulls(*(curve(str(k), values) for k, values in enumerate(shifted))) == 2 * segments


@pytest.mark.parametrize("segments", [2, 3, 4])
def test_natural_splines_are_regular(segments: int) -> None:
    """0, 0 and 0: C2 and natural ends take all nulls away, if the spline is not straight."""
    assert nulls(curve("tie", WINDING[: segments + 1], family="natural_cubic")) == 0


@pytest.mark.parametrize("knots", [2, 3, 4, 5])
def test_a_straight_natural_spline_has_one_null_a_knot(knots: int) -> None:
    """Every knot slides along the line; one segment is a line with its two nulls."""
    assert nulls(curve("tie", STRAIGHT[:knots], family="natural_cubic")) == knots


def test_a_closed_natural_spline_is_regular() -> None:
    angle = 2.0 * np.pi * np.arange(6) / 6.0
    knots = np.array([3300.0, 4310.0, 40.0]) + 90.0 * np.column_stack(
        [np.cos(angle), np.sin(angle), 0.2 * angle % 0.7]
    )
    knots[::2] += [25.0, -10.0, 8.0]
    feature = replace(curve("tie", knots, family="natural_cubic"), closed=True)
    assert nulls(feature) == 0


def test_free_orientations_add_the_seven_of_the_datum() -> None:
    """Nothing known but measurements of a free segment and a spline: 7 and the 2 nulls of the segment."""
    features = (curve("segment", CUBIC), curve("spline", WINDING, family="natural_cubic"))
    assert count(*features, each=40, known=False).nullity == 7 + 2
