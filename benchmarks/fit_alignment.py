"""How many knots does an alignment of 20 km need?  Ours against the smoothing spline of scipy.

python -m benchmarks.fit_alignment [LENGTH_M] [THRESHOLD_M]
"""

from __future__ import annotations

import sys
import time

from benchmarks.alignment import digitised, random_alignment
from benchmarks.smoothing_spline import smoothing_spline
from splinebba_cli.core.curves.fitting import fit_spline

CASES = ((5.0, 0.0), (5.0, 0.001), (1.0, 0.0))  # step, σ of noise, metres


def main(length: str = "20000", threshold: str = "0.004") -> None:
    """Print knots, largest distance and seconds of both; those of scipy are for the whole bisection."""
    metres, limit = float(length), float(threshold)
    alignment = random_alignment(metres)
    print(f"alignment of {metres / 1000:g} km, threshold {1000 * limit:g} mm")
    print(f"{'':24s}{'splinebba fit':^32s}{'scipy make_splprep':^32s}".rstrip())
    heading = f"{'knots':>10s}{'largest [mm]':>14s}{'[s]':>8s}"
    print(f"{'step [m]':>8s}{'noise σ [mm]':>14s}  {heading}{heading}")
    for step, noise in CASES:
        points = digitised(alignment, metres, step, noise)
        start = time.perf_counter()
        fit = fit_spline(points, limit)
        middle = time.perf_counter()
        knots, largest = smoothing_spline(points, limit)
        end = time.perf_counter()
        ours = f"{len(fit.knots):10d}{1000 * fit.largest_distance:14.2f}{middle - start:8.1f}"
        theirs = f"{knots:10d}{1000 * largest:14.2f}{end - middle:8.1f}"
        print(f"{step:8g}{1000 * noise:14g}  {ours}{theirs}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
