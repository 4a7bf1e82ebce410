"""Check points and check splines of the six-image block: the statistics follow their predicted distribution.

20 runs.  The mean of a statistic over its degrees of freedom lies within 2.86 (t of 19 degrees, 99 %) standard errors
of its expectation; with sigma0 estimated from r = 637 that is r / (r - 2) = 1.003.  Points: six, given to 2 cm, of
which sigma is not scaled.  ``python -m benchmarks.check_rates`` shows the rates of rejection.
"""

from __future__ import annotations

import numpy as np

from benchmarks.check_rates import KINDS, rates

RUNS = 20


def test_statistics_have_their_expectation() -> None:
    rejected, size = rates(RUNS)
    error = size.std(axis=0, ddof=1) / np.sqrt(RUNS)
    assert (np.abs(size.mean(axis=0) - 1.003) < 2.86 * error).all(), dict(
        zip(KINDS, size.mean(axis=0), strict=True)
    )
    # binomial, 99.9 % for each of five: at most 5 of 20 where the rate is 5 %
    assert (rejected.sum(axis=0) <= 5).all(), rejected.sum(axis=0)
