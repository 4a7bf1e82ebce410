"""What the budget says about single features and images, and why the printed count of the dissertation differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.budget import FeatureBudget, budget
from splinebba_cli.core.network import FloatArray, PointObservations, Tangents
from splinebba_cli.core.quality import rank_contributions
from splinebba_cli.simulation.dissertation import design_of, experiment
from splinebba_cli.simulation.feature_geometry import Feature
from splinebba_cli.simulation.six_image_block import LEE_SEGMENT, simulate_block
from tests.core.family_features import PLACE, RING, circle_rows, joined, of_family, with_options
from tests.core.free_curves import CUBIC, LINE, PARABOLA, WINDING, tie
from tests.core.test_rank_table import curve, design, started


def counted(feature: Feature, each: int = 24, images: int = 6) -> FeatureBudget:
    """A curve alone, orientations known."""
    (found,) = budget(design(feature, each=each, known=True, images=images)).features
    return found


@pytest.mark.parametrize(
    ("family", "rows", "conditions", "printed"),
    [
        ("free_cubic", CUBIC, 8, 4),
        ("free_cubic", LEE_SEGMENT, 7, 4),  # planar
        ("polynomial_2", PARABOLA, 5, 3),
        ("straight_line", LINE, 2, 2),
        ("polynomial_0", CUBIC[:1], 1, 1),
    ],
    ids=["twisted", "planar", "quadratic", "line", "constant"],
)
def test_independent_points_of_one_segment(
    family: str, rows: FloatArray, conditions: int, printed: int
) -> None:
    """Table 5.2 has 4, 3, 2, 1 points on a segment in one image; the equations across it have rank 8 (7), 5, 2, 1."""
    for each in (2, 6, 12):
        found = counted(tie("tie", family, rows), each)
        assert found.independent_points == found.images * min(each, conditions)
        assert found.lee_independent_points == found.images * min(each, printed)
        assert ("table 5.2" in found.reason) == (min(each, conditions) > printed)


def test_a_segment_of_a_control_spline_has_the_same_conditions() -> None:
    """Its coefficients are no unknowns; one image still cannot tell more than 8 things about a segment."""
    found = counted(curve("control", CUBIC, 0.0), 12)
    assert (found.coefficients, found.independent_points) == (0, 6 * 8)


@pytest.mark.parametrize("knots", [3, 5])
def test_natural_splines(knots: int) -> None:
    """3 (n + 1) coefficients, 12 n in table 5.1."""
    found = counted(tie("spline", "natural_cubic", WINDING[:knots]))
    segments = knots - 1
    points = 6 * 24
    assert (found.coefficients, found.unknowns, found.rank) == (
        3 * knots,
        3 * knots + points,
        3 * knots + points,
    )
    assert (found.lee_unknowns, found.lee_redundancy) == (12 * segments + points, points - 12 * segments)
    assert found.redundancy == 2 * points - points - 3 * knots
    assert f"3(n+1) = {3 * knots} coefficients, not 12n = {12 * segments}" in found.reason


def test_closed_natural_spline() -> None:
    found = counted(with_options(tie("lake", "natural_cubic", PLACE + RING), closed=True))
    assert found.lee_unknowns == 12 * 7 + found.locations
    assert "3n = 21 coefficients, not 12n = 84" in found.reason


def test_joined_cubics() -> None:
    found = counted(joined(3, 2))
    assert (found.coefficients, found.lee_unknowns) == (18, 36 + found.locations)
    assert "C2 joints: 18 free coefficients, not 12n = 36" in found.reason


def test_known_start_points() -> None:
    """9 unknowns instead of 12 (table 5.1), one gauge direction instead of two."""
    found = counted(started("partial", CUBIC))
    assert (found.coefficients, found.lee_unknowns) == (9, 9 + found.locations)
    assert (
        f"known start point is seen by no measurement, arc lengths included: rank {found.rank} of"
        in found.reason
    )
    knots = np.full(WINDING.shape, np.inf)
    knots[0] = 0.0
    spline = counted(Feature("partial", "partial", WINDING, knots, family="natural_cubic"))
    assert (spline.coefficients, spline.lee_unknowns) == (12, 45 + spline.locations)
    assert "15 coefficients, 3 of them given, not 12n = 48" in spline.reason


def test_weighted_control_is_counted_with_its_values() -> None:
    found = counted(curve("control", CUBIC, 0.02))
    assert (found.given_values, found.coefficients) == (12, 12)
    assert found.equations == 2 * found.observations + 12
    assert found.lee_unknowns == found.locations
    assert found.redundancy == found.lee_redundancy == found.observations
    assert "weighted control" in found.reason


def test_families_that_the_tables_do_not_know() -> None:
    circle = counted(tie("circle", "circle", circle_rows()))
    assert (circle.lee_unknowns, circle.lee_redundancy, circle.lee_independent_points) == (None, None, None)
    assert circle.shape_conditions == 2
    assert circle.equations == 2 * circle.observations + 2
    assert circle.rank == circle.unknowns - 1
    assert "phase" in circle.reason
    assert counted(of_family("bspline_3")).lee_unknowns is None


def test_lines_have_four_parameters() -> None:
    """Lee: r = 2 m - 4 of two points in m images; the two end points that slide give the same."""
    found = counted(tie("line", "straight_line", LINE), each=2)
    assert (found.unknowns, found.rank, found.lee_unknowns) == (6 + 12, 4 + 12, 4 + 12)
    assert found.redundancy == found.lee_redundancy == 2 * 6 - 4


def test_tangents_are_equations_of_their_curve_and_image() -> None:
    network = design(curve("free", CUBIC), each=4, known=True)
    point = np.flatnonzero(network.curve_observations.image == 2)
    tangents = Tangents(point, np.zeros(4), np.full(4, 1e-3), np.zeros(4, dtype=bool))
    found, before = budget(replace(network, tangents=tangents)), budget(network)
    assert (found.features[0].tangents, found.images[2].tangents, found.images[1].tangents) == (4, 4, 0)
    assert found.features[0].equations == before.features[0].equations + 4
    assert found.images[2].equations == before.images[2].equations + 4
    assert found.features[0].rank == before.features[0].rank


def test_points_and_images_of_a_mixed_block() -> None:
    """Counts of features and of images are those of the network: every equation has one feature and one image."""
    found = budget(simulate_block("six-image-mixed", seed=1)[0])
    priors = sum(image.priors for image in found.images)
    assert sum(f.equations for f in found.features) + priors == found.equations
    assert sum(f.unknowns for f in found.features) + 36 == found.unknowns
    measured = 2 * sum(f.observations for f in found.features)
    assert sum(image.equations for image in found.images) == measured + priors
    for feature in found.features:
        assert feature.rank == feature.unknowns  # all are determined, orientations known
        if feature.kind == "point" and not feature.given_values:
            assert (
                feature.redundancy == feature.orientation_conditions == 2 * feature.images - 3
            )  # Lee: r = 2 m - 3
            assert feature.lee_redundancy == feature.redundancy
    assert all(image.rank == image.unknowns for image in found.images)


def test_given_coordinates_are_equations_of_their_point() -> None:
    """A control point of known height that one image sees: two rays and one coordinate determine it."""
    network = simulate_block("six-image-mixed", seed=1)[0]
    number = next(k for k, role in enumerate(network.points.role) if role == "control")
    sigma = network.points.sigma.copy()
    sigma[number] = [np.inf, np.inf, 0.02]
    seen = network.point_observations
    rays = np.flatnonzero((seen.point != number) | (np.arange(len(seen)) == np.argmax(seen.point == number)))
    kept = PointObservations(
        seen.image[rays],
        seen.point[rays],
        seen.photo_xy[rays],
        seen.sigma[rays],
    )
    points = replace(network.points, sigma=sigma)
    found = budget(replace(network, points=points, point_observations=kept)).features[
        len(network.curves) + number
    ]
    assert (found.images, found.given_values, found.equations) == (1, 1, 3)
    assert (found.rank, found.redundancy, found.orientation_conditions) == (3, 0, 0)


def test_priors_are_equations_of_their_image() -> None:
    network = design_of(experiment("table_5_7")).network
    sigma = network.images.prior_sigma.copy()
    prior = network.images.prior.copy()
    sigma[1, 3:], prior[1, 3:] = 0.1, network.images.position[1]
    found = budget(replace(network, images=replace(network.images, prior=prior, prior_sigma=sigma)))
    assert [image.priors for image in found.images] == [0, 3, 0, 0, 0, 0]
    assert found.images[1].redundancy == found.images[0].redundancy + 3
    assert found.equations == 66 + 3


def test_an_image_that_its_measurements_do_not_determine() -> None:
    """Four points on one known segment: 8 equations for 4 locations and 6 orientation unknowns."""
    found = budget(design(curve("control", LEE_SEGMENT, 0.0), each=4, known=False))
    assert {(image.unknowns, image.rank, image.redundancy) for image in found.images} == {(10, 8, 0)}
    (feature,) = found.features
    assert (feature.rank, feature.orientation_conditions) == (24, 24)
    assert found.rank == feature.rank + feature.orientation_conditions


def test_features_too_large_for_a_dense_decomposition(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their ranks are left out; all else stays."""
    network = simulate_block("six-image-mixed", seed=1)[0]
    before = budget(network)
    monkeypatch.setattr(rank_contributions, "WORK", 0.0)
    monkeypatch.setattr(rank_contributions, "MOST_FEATURES", 40)  # fewer than points, more than splines
    found = budget(network)
    assert found.rank == before.rank
    for feature, known in zip(found.features, before.features, strict=True):
        assert (feature.rank, feature.redundancy, feature.orientation_conditions) == (None, None, None)
        assert (feature.equations, feature.unknowns) == (known.equations, known.unknowns)
