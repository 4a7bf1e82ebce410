"""Which orientation of a search is believed."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.free_orientation.refinement import FittedOrientation
from splinebba_cli.core.matching.free_orientation.search import SearchResult

SIGMA = 0.005


def result(score: float, rms_sigma: float, second: float = 0.0) -> SearchResult:
    best = FittedOrientation(np.eye(3), np.zeros(3), score, 0.9, rms_sigma * SIGMA, 500, np.eye(6))
    return SearchResult(best, second, SIGMA)


@pytest.mark.parametrize(
    ("score", "rms_sigma", "explains"),
    [
        (0.9, 1.0, True),
        (0.9, 2.3, True),
        (0.9, 2.7, False),
        (0.45, 1.0, True),
        (0.45, 2.3, False),
        (0.1, 1.0, False),
    ],
)
def test_what_explains_much_must_fit_and_what_explains_little_must_fit_better(
    score: float, rms_sigma: float, explains: bool
) -> None:
    """A camera reversed before a distant object sees nearly the same, and leaves 2.7 sigma."""
    assert result(score, rms_sigma).explains is explains


def test_another_orientation_that_explains_as_much() -> None:
    assert result(0.9, 1.0, second=0.2).unique
    assert not result(0.9, 1.0, second=0.89).unique
    assert not SearchResult(None, 0.0, SIGMA).unique
