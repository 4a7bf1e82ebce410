"""Depths on which several images agree."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.consensus import ALONE, LARGEST_WORTH, agreed_depths
from splinebba_cli.core.matching.fragments.hypotheses import Hypotheses

PARTNERS = np.array([2, 5, 7])
LIMITS = np.array([0.0, 100.0])


def hypotheses(rows: list[tuple[int, int, float, float]], sigma: float = 0.1) -> Hypotheses:
    """Of rows point, image, depth, slope."""
    table = np.array(sorted(rows, key=lambda row: (row[0], row[2])))
    count = len(table)
    return Hypotheses(
        point=table[:, 0].astype(np.int64),
        image=table[:, 1].astype(np.int64),
        place=np.arange(count, dtype=float),
        depth=table[:, 2],
        sigma=np.full(count, sigma),
        slope=table[:, 3],
        slope_sigma=np.full(count, 0.1),
    )


def test_the_third_image_decides() -> None:
    found = hypotheses([(0, 2, 10.0, 0.0), (0, 2, 10.6, 0.0), (0, 5, 10.65, 0.0)])
    agreed = agreed_depths(found, PARTNERS, LIMITS, 3.0)
    assert agreed.depth[0] == pytest.approx(10.625)
    assert agreed.sigma[0] == pytest.approx(0.1 / np.sqrt(2.0))
    assert agreed.worth[0] > agreed.worth[1] == ALONE


def test_one_image_counts_once() -> None:
    found = hypotheses([(0, 2, 10.0, 0.0), (0, 5, 10.0, 0.0), (0, 5, 10.1, 0.0)])
    agreed = agreed_depths(found, PARTNERS, LIMITS, 3.0)
    assert (agreed.member[0] >= 0).sum() == 2
    assert agreed.depth[0] == pytest.approx(10.0)


def test_another_direction_does_not_agree() -> None:
    found = hypotheses([(0, 2, 10.0, 0.0), (0, 5, 10.0, 0.5)])
    agreed = agreed_depths(found, PARTNERS, LIMITS, 3.0)
    assert (agreed.member >= 0).sum(axis=1).max() == 1


def test_points_do_not_mix() -> None:
    found = hypotheses([(0, 2, 10.0, 0.0), (1, 5, 10.0, 0.0)])
    agreed = agreed_depths(found, PARTNERS, LIMITS, 3.0)
    assert list(agreed.point) == [0, 1]
    assert agreed.worth == pytest.approx(ALONE)


def test_agreement_is_worth_the_logarithm_of_the_densities() -> None:
    found = hypotheses([(0, 2, 10.0, 0.0), (0, 5, 10.1, 0.0)], sigma=1.0)
    agreed = agreed_depths(found, PARTNERS, LIMITS, 3.0)
    z = 0.1 / np.sqrt(2.0)
    width = 100.0 / 2.0
    expected = np.log(width / (np.sqrt(2.0) * np.sqrt(2.0 * np.pi))) - 0.5 * z**2
    assert expected < LARGEST_WORTH
    assert agreed.worth[0] == pytest.approx(ALONE + expected)


def test_uncertain_depths_find_certain_ones() -> None:
    """The window of a pair is that of its less certain member."""
    found = hypotheses([(0, 2, 10.0, 0.0), (0, 5, 14.0, 0.0)])
    wide = Hypotheses(
        found.point,
        found.image,
        found.place,
        found.depth,
        np.array([0.1, 2.0]),
        found.slope,
        found.slope_sigma,
    )
    assert (agreed_depths(wide, PARTNERS, LIMITS, 3.0).member[0] >= 0).sum() == 2
