"""Foot points against dense sampling: no sample of a segment is nearer, in any of many difficult cases.

    python -m benchmarks.foot_points [--cases 100000] [--samples 100000] [--seed 1]

Distances in the photo (millimetres, and sigma of error ellipses) and from rays in space.  Prints how often a sample is
nearer than the foot point by more than rounding (1e-9 of the distance, and 1e-9 mm, sigma or m), which must be never,
and microseconds a foot point.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from benchmarks.foot_point_cases import FootPointCases, random_cases, sampled_from_rays, sampled_in_photo
from splinebba_cli.core.curves.segment_feet import feet_in_photo, feet_of_rays
from splinebba_cli.core.network import FloatArray

AT_ONCE = 5000
KINDS = ("photo, mm", "photo, sigma", "ray, m")


def found(cases: FootPointCases, kind: str) -> FloatArray:
    """Distances of the nearest foot points, (k,); inf where a segment is behind the camera."""
    count = len(cases.xy)
    if kind == "ray, m":
        return feet_of_rays(cases.powers, np.zeros((count, 3)), cases.direction).nearest(count)[1]
    whitening = cases.whitening if kind == "photo, sigma" else None
    return feet_in_photo(cases.seen, cases.xy, whitening).nearest(count)[1]


def sampled(cases: FootPointCases, samples: int, kind: str) -> FloatArray:
    """Distances of the nearest samples."""
    if kind == "ray, m":
        return sampled_from_rays(cases, samples)
    return sampled_in_photo(cases, samples, "sigma" if kind == "photo, sigma" else "mm")


def failures(distance: FloatArray, least: FloatArray) -> int:
    """How many samples are nearer."""
    return int(np.count_nonzero((distance > least * (1.0 + 1e-9) + 1e-9) & np.isfinite(least)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    generator = np.random.default_rng(chosen.seed)
    failed, seconds = dict.fromkeys(KINDS, 0), dict.fromkeys(KINDS, 0.0)
    for begin in range(0, chosen.cases, AT_ONCE):
        cases = random_cases(generator, min(AT_ONCE, chosen.cases - begin))
        for kind in KINDS:
            start = time.process_time()
            distance = found(cases, kind)
            seconds[kind] += time.process_time() - start
            failed[kind] += failures(distance, sampled(cases, chosen.samples, kind))
    for kind in KINDS:
        print(
            f"{kind:14s} {failed[kind]} of {chosen.cases} failed, {1e6 * seconds[kind] / chosen.cases:.2f} us each"
        )


if __name__ == "__main__":
    main()
