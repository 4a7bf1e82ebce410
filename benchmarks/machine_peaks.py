"""What the machine can do: memory bandwidth and dense matrix products, with one thread and with several.

    sum      a = b + c      3 x 8 bytes an element (McCalpin's STREAM counts the same), arrays beyond every cache
    product  C = A B        2 n^3 operations (dgemm of the BLAS that numpy uses)

The best of several runs: a peak, not an average.

References
----------
McCalpin, J. D. (1995): Memory bandwidth and machine balance in current high performance computers.
    IEEE TCCA Newsletter, 19-25.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from threadpoolctl import threadpool_limits

ELEMENTS = 30_000_000  # 240 MB an array
ORDER = 2000
RUNS = 5


def best_seconds(work: Callable[[], object], runs: int = RUNS) -> float:
    """The least wall time of several runs."""
    taken = []
    for _ in range(runs):
        begin = time.perf_counter()
        work()
        taken.append(time.perf_counter() - begin)
    return min(taken)


def memory_bandwidth(threads: int, elements: int = ELEMENTS) -> float:
    """Bytes per second of a = b + c, each thread on its own part."""
    a, b, c = np.zeros(elements), np.ones(elements), np.ones(elements)
    bounds = np.linspace(0, elements, threads + 1).astype(int)

    def part(k: int) -> None:
        rows = slice(bounds[k], bounds[k + 1])
        np.add(b[rows], c[rows], out=a[rows])

    with ThreadPoolExecutor(threads) as pool:
        seconds = best_seconds(lambda: list(pool.map(part, range(threads))))
    return 3 * 8 * elements / seconds


def product_speed(threads: int, order: int = ORDER) -> float:
    """Floating-point operations per second of a dense matrix product."""
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(order, order)), rng.normal(size=(order, order))
    out = np.empty((order, order))
    with threadpool_limits(threads, user_api="blas"):
        seconds = best_seconds(lambda: np.matmul(a, b, out=out))
    return 2.0 * order**3 / seconds
