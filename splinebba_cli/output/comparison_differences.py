"""Differences of images and points of two results, with the dispersion that their relation gives them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.rotation import angle_jacobian, angles_from_rotation, wrap_angle
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.datum_transformation import centred_dispersion, datum_matrix
from splinebba_cli.core.quality.parameter_test import SHARE, wald_tests
from splinebba_cli.core.quality.similarity_fit import Similarity
from splinebba_cli.output.comparison_relation import Relation
from splinebba_cli.output.stored_result import StoredResult


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


def image_differences(
    a: StoredResult, b: StoredResult, weighting: Weighting | None, similarity: Similarity | None, alpha: float
) -> Differences:
    """Orientations of A less those of B, angles in the rotation sequences of A."""
    own, other = common_rows(a.image_ids, b.image_ids)
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
    if similarity is not None:
        transform[:, 3:, 3:] = similarity.scale * similarity.rotation
        dispersions = _centred(a, b, (own, other), transform)
        weighting = None if dispersions is None else weighting
    else:
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


def _centred(
    a: StoredResult, b: StoredResult, rows: tuple[IntArray, IntArray], transform: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Blocks (m, 6, 6) of both dispersions in the datum of the mean of the perspective centres; None if not full."""
    if a.full_images is None or b.full_images is None:
        return None
    own, other = rows
    count = len(own)
    datum = datum_matrix(a.rotation[own], a.angles[own], a.position[own], [a.sequences[k] for k in own])
    turn = np.zeros((6 * count, 6 * count))
    place = 6 * np.arange(count)[:, None] + np.arange(6)
    turn[place[:, :, None], place[:, None, :]] = transform
    first = a.full_images[np.ix_(*2 * [(6 * own[:, None] + np.arange(6)).ravel()])]
    second = b.full_images[np.ix_(*2 * [(6 * other[:, None] + np.arange(6)).ravel()])]
    centred = [centred_dispersion(each, datum) for each in (first, turn @ second @ turn.T)]
    blocks = [each[place[:, :, None], place[:, None, :]] for each in centred]
    return blocks[0], blocks[1]


def point_differences(
    a: StoredResult, b: StoredResult, weighting: Weighting | None, similarity: Similarity | None, alpha: float
) -> Differences:
    """Points of A less those of B."""
    own, other = common_rows(a.point_ids, b.point_ids)
    xyz = b.xyz[other] if similarity is None else similarity.apply(b.xyz[other])
    dispersions = _of_both(a.point_dispersion[own], b.point_dispersion[other])
    correlated = a.correlated and b.correlated
    weighting = weighting if similarity is None else None  # covariances with the datum are not known
    return _tested(a.point_ids, b.point_ids, own, a.xyz[own] - xyz, dispersions, weighting, correlated, alpha)


def _of_both(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Dispersions (n, k, k), 0 in both where one of them is not known: such a row is not tested."""
    known = np.isfinite(a).all(axis=(1, 2), keepdims=True) & np.isfinite(b).all(axis=(1, 2), keepdims=True)
    return np.where(known, a, 0.0), np.where(known, b, 0.0)


def _tested(
    ids_a: list[str], ids_b: list[str], own: IntArray, difference: FloatArray,
    dispersions: tuple[FloatArray, FloatArray] | None, weighting: Weighting | None, correlated: bool, alpha: float,
) -> Differences:  # fmt: skip
    """Differences with their sigma and the test of each row."""
    count = len(own)
    sigma, nan = np.full(difference.shape, np.nan), np.full(count, np.nan)
    statistic, dimensions, probability = nan, np.zeros(count, dtype=np.int64), nan
    significant = np.zeros(count, dtype=bool)
    if weighting is not None and dispersions is not None and count:
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


def common_rows(a: list[str], b: list[str]) -> tuple[IntArray, IntArray]:
    """Rows of A and of B that have the same id."""
    place = {name: row for row, name in enumerate(b)}
    own = [row for row, name in enumerate(a) if name in place]
    return np.array(own, dtype=np.int64), np.array([place[a[row]] for row in own], dtype=np.int64)
