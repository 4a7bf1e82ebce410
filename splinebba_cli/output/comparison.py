"""Two result folders compared: statistics, tests of variances and models, differences of all that they share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from splinebba_cli.core.camera.rotation import angle_jacobian, angles_from_rotation, wrap_angle
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.parameter_test import SHARE, RatioTest, wald_tests
from splinebba_cli.core.quality.similarity import Similarity, fit_similarity
from splinebba_cli.core.quality.variance_comparison import additional_parameters, equal_variances
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import OutputError
from splinebba_cli.output.comparison_relation import Relation, RelationName, compared_inputs, relation_of
from splinebba_cli.output.comparison_splines import SplineDifference, spline_differences
from splinebba_cli.output.stored_result import StoredResult, read_result


@dataclass(frozen=True)
class Weighting:
    """C = factor_a C_a + factor_b C_b, whose variance factor has so many degrees of freedom; None: it is known."""

    factor_a: float
    factor_b: float
    degrees: float | None
    reference: str  # "a", "b" or "both": whose dispersion is the larger one

    def of(self, a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Dispersion of the differences and the one that it is judged against, (n, k, k) each."""
        dispersion = self.factor_a * a + self.factor_b * b
        if self.reference == "both":
            return dispersion, dispersion
        return dispersion, self.factor_a * a if self.reference == "a" else self.factor_b * b


@dataclass(frozen=True)
class Differences:
    """A - B of images or points that both have; rows in the order of A."""

    ids: tuple[str, ...]
    difference: FloatArray  # (n, k) rad and m, or m
    sigma: FloatArray  # (n, k) NaN where it has none
    statistic: FloatArray  # (n,) d'C^-1 d of all k together
    dimensions: IntArray  # (n,)
    probability: FloatArray  # (n,)
    significant: BoolArray  # (n,) by Sidak's alpha of one of all
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]

    @property
    def standardized(self) -> FloatArray:
        """Differences over their sigma, (n, k)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.sigma > 0.0, self.difference / self.sigma, np.nan)


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
    first, second = read_result(Path(a)), read_result(Path(b))
    related = relation_of(first, second, relation)
    similarity = _datum_shift(first, second)
    weighting = None if first.free or second.free else weighting_of(first, second, related)
    images = _images(first, second, weighting, similarity, alpha)
    points = _points(first, second, weighting, similarity, alpha)
    splines = spline_differences(first, second, _factors(weighting), similarity, alpha)
    if not images.ids and not points.ids and not splines:
        raise OutputError(
            "SBB611",
            f"{a} and {b} have no image, point or spline in common",
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


def weighting_of(a: StoredResult, b: StoredResult, relation: Relation) -> Weighting | None:
    """Factors of both dispersions; None where differences have no dispersion."""
    if relation.name in ("independent", "overlapping"):
        degrees = [r.sum_of_squares.redundancy for r in (a, b) if r.estimated_variance]
        return Weighting(1.0, 1.0, min(degrees) if degrees else None, "both")
    if relation.less_precise is None:
        return None
    larger = a if relation.less_precise == "a" else b
    degrees_of_larger = larger.sum_of_squares.redundancy if larger.estimated_variance else None
    factor_a, factor_b = larger.scale / a.scale, larger.scale / b.scale
    if relation.less_precise == "a":
        return Weighting(factor_a, -factor_b, degrees_of_larger, "a")
    return Weighting(-factor_a, factor_b, degrees_of_larger, "b")


def _factors(weighting: Weighting | None) -> tuple[float, float, float | None] | None:
    return None if weighting is None else (weighting.factor_a, weighting.factor_b, weighting.degrees)


def _datum_shift(a: StoredResult, b: StoredResult) -> Similarity | None:
    """The similarity of B onto A by common perspective centres and points, where one of the datums is free."""
    if not (a.free or b.free):
        return None
    rows = [_common(a.image_ids, b.image_ids), _common(a.point_ids, b.point_ids)]
    target = np.vstack([a.position[rows[0][0]], a.xyz[rows[1][0]]])
    source = np.vstack([b.position[rows[0][1]], b.xyz[rows[1][1]]])
    return fit_similarity(source, target)


def _images(
    a: StoredResult, b: StoredResult, weighting: Weighting | None, similarity: Similarity | None, alpha: float
) -> Differences:
    own, other = _common(a.image_ids, b.image_ids)
    count = len(own)
    rotation, position = b.rotation[other], b.position[other]
    if similarity is not None:
        rotation, position = similarity.turn(rotation), similarity.apply(position)
    angles, transform = np.zeros((count, 3)), np.zeros((count, 6, 6))
    transform[:, [3, 4, 5], [3, 4, 5]] = 1.0
    for k in range(count):  # angles of B in the rotation sequence of A
        sequence = a.sequences[own[k]]
        angles[k] = angles_from_rotation(rotation[k], sequence)
        mine = angle_jacobian(angles[k], sequence)
        transform[k, :3, :3] = np.linalg.pinv(mine) @ angle_jacobian(
            b.angles[other[k]], b.sequences[other[k]]
        )
    difference = np.hstack([wrap_angle(a.angles[own] - angles), a.position[own] - position])
    spread = transform @ b.image_dispersion[other] @ transform.transpose(0, 2, 1)
    dispersions = a.image_dispersion[own], spread
    return _tested(
        a.image_ids,
        b.image_ids,
        own,
        difference,
        dispersions,
        weighting,
        a.correlated and b.correlated,
        alpha,
    )


def _points(
    a: StoredResult, b: StoredResult, weighting: Weighting | None, similarity: Similarity | None, alpha: float
) -> Differences:
    own, other = _common(a.point_ids, b.point_ids)
    xyz = b.xyz[other] if similarity is None else similarity.apply(b.xyz[other])
    dispersions = a.point_dispersion[own], b.point_dispersion[other]
    correlated = a.correlated and b.correlated
    return _tested(a.point_ids, b.point_ids, own, a.xyz[own] - xyz, dispersions, weighting, correlated, alpha)


def _tested(
    ids_a: list[str], ids_b: list[str], own: IntArray, difference: FloatArray,
    dispersions: tuple[FloatArray, FloatArray], weighting: Weighting | None, correlated: bool, alpha: float,
) -> Differences:  # fmt: skip
    """Differences with their sigma and the test of each row."""
    count = len(own)
    sigma, nan = np.full(difference.shape, np.nan), np.full(count, np.nan)
    statistic, dimensions, probability = nan, np.zeros(count, dtype=np.int64), nan
    significant = np.zeros(count, dtype=bool)
    if weighting is not None and count:
        dispersion, reference = weighting.of(*dispersions)
        variance, judged = np.einsum("nii->ni", dispersion), np.einsum("nii->ni", reference)
        told = (variance > SHARE * judged) & (judged > 0.0)
        sigma = np.where(told, np.sqrt(np.where(told, variance, 1.0)), np.nan)
        if correlated:
            tests = wald_tests(difference, dispersion, reference, weighting.degrees)
            statistic, dimensions, probability = tests.statistic, tests.dimensions, tests.probability
            tested = int((dimensions > 0).sum())
            significant = tests.significant(single_alpha(alpha, "sidak", tested))
    here, there = set(ids_a), set(ids_b)
    return Differences(
        ids=tuple(ids_a[k] for k in own),
        difference=difference,
        sigma=sigma,
        statistic=statistic,
        dimensions=dimensions,
        probability=probability,
        significant=significant,
        only_a=tuple(name for name in ids_a if name not in there),
        only_b=tuple(name for name in ids_b if name not in here),
    )


def _common(a: list[str], b: list[str]) -> tuple[IntArray, IntArray]:
    """Rows of A and of B that have the same id."""
    place = {name: row for row, name in enumerate(b)}
    own = [row for row, name in enumerate(a) if name in place]
    return np.array(own, dtype=np.int64), np.array([place[a[row]] for row in own], dtype=np.int64)


def _problems(
    a: StoredResult, b: StoredResult, relation: Relation, weighting: Weighting | None
) -> tuple[Problem, ...]:
    found = []
    if a.free or b.free:
        found.append(
            Problem(
                "SBB612",
                "info",
                "the datum of at least one adjustment is free: B was transformed onto A, and the "
                "differences have no σ",
                "datum",
                "their dispersions refer to different datums",
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
    if weighting is not None and weighting.reference != "both" and _less(a, b, weighting):
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


def _less(a: StoredResult, b: StoredResult, weighting: Weighting) -> bool:
    """Whether variances of images contradict the order of precision."""
    own, other = _common(a.image_ids, b.image_ids)
    dispersion, reference = weighting.of(a.image_dispersion[own], b.image_dispersion[other])
    variance, judged = np.einsum("nii->ni", dispersion)[:, 3:], np.einsum("nii->ni", reference)[:, 3:]
    return bool((variance < -10.0 * SHARE * judged).any())
