"""Results that do not differ: six images by points, the same truth, new noise a run.

12 runs a case; the mean of d'C^-1 d over its degrees of freedom lies within 3.11 (t of 11 degrees, 99 %) standard
errors of 1 for a known variance; for one estimated from r degrees of freedom of r / (r - 2).
``python -m benchmarks.comparison_rates`` shows the rates of significance.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.comparison_rates import CASES, comparisons

RUNS = 12
RELATIONS = {
    "independent": ("independent", None),
    "nested": ("nested", "b"),
    "model": ("same-data", "b"),
    "free": ("independent", None),
}


@pytest.mark.parametrize("case", CASES)
def test_differences_have_their_dispersion(case: str) -> None:
    size = []
    for found in comparisons(case, RUNS):
        assert (found.relation.name, found.relation.less_precise) == RELATIONS[case]
        assert {problem.code for problem in found.problems} == ({"SBB612"} if case == "free" else set())
        kinds = (found.images,) if case == "free" else (found.images, found.points)
        r = found.b.sum_of_squares.redundancy
        size += [np.nansum(each.statistic) / each.dimensions.sum() * (r - 2.0) / r for each in kinds]
    mean = np.array(size).reshape(RUNS, -1)
    error = mean.std(axis=0, ddof=1) / np.sqrt(RUNS)
    assert (np.abs(mean.mean(axis=0) - 1.0) < 3.11 * error).all(), mean.mean(axis=0)
