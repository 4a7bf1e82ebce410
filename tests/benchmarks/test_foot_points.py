"""The long comparison of foot points with dense sampling, in small."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.foot_point_cases import random_cases
from benchmarks.foot_points import KINDS, failures, found, sampled


@pytest.mark.parametrize("kind", KINDS)
def test_no_sample_is_nearer_than_the_foot_point(kind: str) -> None:
    cases = random_cases(np.random.default_rng(11), 3000)
    distance, least = found(cases, kind), sampled(cases, 1000, kind)
    assert failures(distance, least) == 0
    assert (
        failures(distance + 1e-2 * (1.0 + least), least) > 0.5 * np.isfinite(least).sum()
    )  # no comfort in it
    assert not np.isfinite(distance[np.isinf(least)]).any() or kind != "ray, m"
