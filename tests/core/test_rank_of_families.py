"""Nullities of all families with known orientations and more than enough points, before any gauge condition.

A null is a change of the parameter that the family takes part in.  Joined cubics follow the table of theory.md,
section 6, whose segments belong to one smooth curve; where a joint is a true corner (C0) or a jump of curvature (C1) it
cannot slide, and only the free ends are left.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from splinebba_cli.core.budget import budget
from splinebba_cli.core.curves.conic import CIRCLE_FORMS
from splinebba_cli.core.curves.shape_forms import retracted
from splinebba_cli.simulation.feature_geometry import Feature
from tests.core.family_features import (
    ELLIPSE,
    HARMONICS,
    PLACE,
    RING,
    circle_rows,
    joined,
    parabolas,
    with_options,
)
from tests.core.free_curves import CUBIC, STRAIGHT, WINDING, tie
from tests.core.test_rank_table import design, nulls

MORE = np.vstack([WINDING, [[3480.0, 4250.0, 60.0], [3390.0, 4230.0, 45.0]]])
STRAIGHT_7 = np.linspace(STRAIGHT[0], STRAIGHT[-1], 7)
CORNERS = np.vstack(
    [CUBIC, CUBIC + [[190.0, -40.0, 5.0], [-300.0, 200.0, 40.0], [150.0, -90.0, 9.0], [30.0, 60.0, 9.0]]]
)
CORNERS[4] = CUBIC.sum(axis=0)


@pytest.mark.parametrize("segments", [2, 3, 4])
def test_joined_cubics_of_one_smooth_curve(segments: int) -> None:
    """None 4/6/8, C0 3/4/5, C1 2/2/2, C2 1/0/0, natural 0/0/0."""
    n = segments
    expected = {-1: 2 * n, 0: n + 1, 1: 2, 2: 1 if n == 2 else 0}
    found = {c: nulls(joined(n, c)) for c in expected}
    assert found == expected
    assert nulls(joined(n, 2, natural=True)) == 0


def test_joints_that_are_corners_cannot_slide() -> None:
    """C0 with a corner: both ends. C1 with a jump of curvature: one map for both segments that keeps the joint."""
    assert nulls(with_options(tie("corner", "free_cubic", CORNERS), continuity=0)) == 2
    assert nulls(with_options(tie("parabolas", "polynomial_2", parabolas()), continuity=1)) == 1
    lines = np.vstack([[p, q - p] for p, q in pairwise(WINDING)]).reshape(-1, 3)
    assert nulls(with_options(tie("chain", "polynomial_1", lines), continuity=0)) == 2


@pytest.mark.parametrize(("rows", "expected"), [(2, 2), (3, 0), (4, 0), (7, 0)])
def test_cardinal_splines(rows: int, expected: int) -> None:
    """Tangents are tied to the neighbours: nothing can slide, but along one segment, which is straight."""
    assert nulls(tie("open", "cardinal", MORE[:rows])) == expected
    assert nulls(tie("straight", "cardinal", STRAIGHT_7[:rows])) == rows
    assert nulls(with_options(tie("tense", "cardinal", MORE[:rows]), tension=0.4)) == expected
    if rows > 3:
        assert nulls(with_options(tie("closed", "catmull_rom", (PLACE + RING)[:rows]), closed=True)) == 0


@pytest.mark.parametrize(("degree", "expected"), [(1, (2, 2, 2, 2)), (2, (2, 1, 0, 0)), (3, (2, 1, 0, 0))])
def test_bsplines(degree: int, expected: tuple[int, ...]) -> None:
    """1 to 4 segments. Degree 1: corners cannot slide, the ends can. 2 and 3: as joined polynomials C1 and C2."""
    family = f"bspline_{degree}"
    counts = [degree + segments for segments in (1, 2, 3, 4)]
    assert tuple(nulls(tie("open", family, MORE[:n])) for n in counts) == expected
    for n in counts:
        assert nulls(tie("straight", family, STRAIGHT_7[:n])) == n
    for n in (3, 5, 7):
        assert nulls(with_options(tie("closed", family, (PLACE + RING)[:n]), closed=True)) == 0


@pytest.mark.parametrize("harmonics", [1, 2, 3])
def test_fourier_curves_have_one_phase(harmonics: int) -> None:
    assert nulls(tie("fourier", "fourier", HARMONICS[: 2 * harmonics + 1])) == 1


@pytest.mark.parametrize(("harmonics", "expected"), [(1, 1), (2, 3), (3, 5)])
def test_fourier_curves_of_too_many_harmonics(harmonics: int, expected: int) -> None:
    """An ellipse by m harmonics: 1 and, to the first order, 2 (m - 1) reparametrisations that keep the family."""
    rows = np.vstack([ELLIPSE, np.zeros((2 * harmonics - 2, 3))])
    assert nulls(tie("ellipse", "fourier", rows)) == expected


@pytest.mark.parametrize("arc", [None, (-0.5, 2.0)], ids=["whole", "arc"])
@pytest.mark.parametrize(("family", "rows"), [("conic", ELLIPSE), ("circle", circle_rows())])
def test_conics_have_one_phase(family: str, rows: np.ndarray, arc: tuple[float, float] | None) -> None:
    options = {} if arc is None else {"knot_parameters": np.array(arc)}
    assert nulls(with_options(tie(family, family, rows), **options)) == 1


def test_shape_conditions_are_equations_of_the_budget() -> None:
    """Two more equations than those of a conic; 9 coefficients, 2 conditions, 1 null: the 6 of a circle in space."""
    features = (tie("circle", "circle", circle_rows()), tie("conic", "conic", circle_rows()))
    circle, conic = (budget(design(feature, each=24, known=True)) for feature in features)
    assert circle.equations == conic.equations + 2
    assert circle.unknowns == conic.unknowns and circle.rank == conic.rank
    assert circle.redundancy == conic.redundancy + 2


def test_a_circle_with_its_radius_vectors_held_needs_no_shape_condition() -> None:
    rows = circle_rows()
    sigma = np.full((3, 3), np.inf)
    sigma[1:] = 0.0
    held = Feature("circle", "partial", rows, sigma, family="circle")
    free = tie("conic", "conic", retracted(CIRCLE_FORMS, rows))
    found = budget(design(held, each=24, known=True))
    assert found.equations == budget(design(free, each=24, known=True)).equations
    assert found.nullity == 0
