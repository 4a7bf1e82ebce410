"""Two result folders compared: statistics, tests of variances and models, differences of all that they share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from splinebba_cli.core.quality.parameter_test import SHARE, RatioTest
from splinebba_cli.core.quality.similarity_fit import Similarity, fit_similarity
from splinebba_cli.core.quality.variance_comparison import additional_parameters, equal_variances
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import OutputError
from splinebba_cli.output.comparison_differences import (
    Differences,
    Weighting,
    common_rows,
    image_differences,
    point_differences,
    weighting_of,
)
from splinebba_cli.output.comparison_relation import Relation, RelationName, compared_inputs, relation_of
from splinebba_cli.output.comparison_splines import SplineDifference, spline_differences
from splinebba_cli.output.damaged_results import complete_results
from splinebba_cli.output.stored_result import StoredResult, read_result


@dataclass(frozen=True)
class Comparison:
    """What differs between the results A and B, and whether it is significant."""

    a: StoredResult
    b: StoredResult
    inputs: list[dict[str, str]]
    relation: Relation
    alpha: float
    variance_test: RatioTest | None  # of independent adjustments
    model_test: RatioTest | None  # additional parameters of the same data
    similarity: Similarity | None  # of B onto A, where a datum is free
    images: Differences
    points: Differences
    splines: tuple[SplineDifference, ...]
    problems: tuple[Problem, ...]

    @property
    def significant(self) -> bool:
        """Whether anything differs significantly."""
        tests = [test for test in (self.variance_test, self.model_test) if test is not None]
        return (
            any(test.significant for test in tests)
            or bool(self.images.significant.any() or self.points.significant.any())
            or any(spline.significant for spline in self.splines)
        )


def compare(
    a: Path | str, b: Path | str, *, relation: RelationName | None = None, alpha: float = 0.05
) -> Comparison:
    """Compare two result folders.

    Parameters
    ----------
    a, b : Path or str
        Folders that `adjust` wrote, or their result.json.
    relation : {"independent", "nested", "same-data", "overlapping"}, optional
        How the adjustments are related; by default seen from hashes and measurements.
    alpha : float
        Significance of every kind of test, over all of its subjects together (Sidak).

    Raises
    ------
    OutputError
        SBB602 if one is no result folder, SBB611 if they have nothing in common.
    """
    with complete_results(Path(a)):
        first = read_result(Path(a))
    with complete_results(Path(b)):
        second = read_result(Path(b))
    with complete_results(Path(b)):
        return _compared(first, second, relation, alpha)


def _compared(
    first: StoredResult, second: StoredResult, relation: RelationName | None, alpha: float
) -> Comparison:
    related = relation_of(first, second, relation)
    similarity = _datum_shift(first, second)
    unrelated = similarity is None and (first.free or second.free)
    weighting = None if unrelated else weighting_of(first, second, related)
    images = image_differences(first, second, weighting, similarity, alpha)
    points = point_differences(first, second, weighting, similarity, alpha)
    splines = spline_differences(first, second, _factors(weighting, similarity), similarity, alpha)
    if not images.ids and not points.ids and not splines:
        raise OutputError(
            "SBB611",
            f"{first.folder} and {second.folder} have no image, point or spline in common",
            "compare results of one project",
        )
    sums = first.sum_of_squares, second.sum_of_squares
    known = not (first.estimated_variance and second.estimated_variance)
    variance_test = equal_variances(*sums, alpha) if related.name == "independent" else None
    model_test = None
    if related.name == "same-data" and related.less_precise is not None:
        larger, smaller = sums if related.less_precise == "a" else sums[::-1]
        model_test = additional_parameters(smaller, larger, alpha, sigma0_known=known)
    return Comparison(
        first, second, compared_inputs(first, second), related, alpha, variance_test, model_test, similarity,
        images, points, splines, _problems(first, second, related, weighting),
    )  # fmt: skip


def _factors(
    weighting: Weighting | None, similarity: Similarity | None
) -> tuple[float, float, float | None] | None:
    return (
        None
        if weighting is None or similarity is not None
        else (weighting.factor_a, weighting.factor_b, weighting.degrees)
    )


def _datum_shift(a: StoredResult, b: StoredResult) -> Similarity | None:
    """The similarity of B onto A where one of the datums is free: by the common perspective centres where the full
    dispersions are there to test what it leaves, else by these and the points.
    """
    if not (a.free or b.free):
        return None
    rows = [common_rows(a.image_ids, b.image_ids), common_rows(a.point_ids, b.point_ids)]
    centres = fit_similarity(b.position[rows[0][1]], a.position[rows[0][0]])
    if centres is not None and a.full_images is not None and b.full_images is not None:
        return centres
    target = np.vstack([a.position[rows[0][0]], a.xyz[rows[1][0]]])
    source = np.vstack([b.position[rows[0][1]], b.xyz[rows[1][1]]])
    return fit_similarity(source, target)


def _problems(
    a: StoredResult, b: StoredResult, relation: Relation, weighting: Weighting | None
) -> tuple[Problem, ...]:
    found = []
    if a.free or b.free:
        found.append(
            Problem(
                "SBB612",
                "info",
                f"the datum of at least one adjustment is free: B was transformed onto A; {_left(a, b)}",
                "datum",
                "σ of free networks refer to their datums; images are tested with `adjust --dispersion full`",
            )
        )
    if not (a.correlated and b.correlated):
        found.append(
            Problem(
                "SBB613",
                "warning",
                "a folder has no dispersion.npz: images and points are not tested, only their "
                "single differences are standardised",
                "dispersion",
                "adjust with `--dispersion blocks`",
            )
        )
    free = a.free or b.free
    if weighting is not None and not free and weighting.reference != "both" and _less(a, b, weighting):
        found.append(
            Problem(
                "SBB614",
                "warning",
                f"the relation `{relation.name}` does not hold: σ of images become larger where "
                "they should become smaller",
                "relation",
                "with other weights or another model: `--relation independent`",
            )
        )
    return tuple(found)


def _left(a: StoredResult, b: StoredResult) -> str:
    if a.full_images is None or b.full_images is None:
        return "differences have no σ"
    return "σ of images are those of what a similarity leaves, points and splines have none"


def _less(a: StoredResult, b: StoredResult, weighting: Weighting) -> bool:
    """Whether variances of images contradict the order of precision."""
    own, other = common_rows(a.image_ids, b.image_ids)
    dispersion, reference = weighting.of(a.image_dispersion[own], b.image_dispersion[other])
    variance, judged = np.einsum("nii->ni", dispersion)[:, 3:], np.einsum("nii->ni", reference)[:, 3:]
    return bool((variance < -10.0 * SHARE * judged).any())
