"""One value for every image point of what is tested in it: x and y of points, across of points on splines."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.output.read_table import ReadTable


def mean_of_tested(table: ReadTable, name: str) -> FloatArray:
    """Mean over the tested components of every image point, (n,)."""
    values = np.stack([table.numbers(name.format(each)) for each in ("x", "y", "across")])
    count = np.isfinite(values).sum(axis=0)
    found = np.full(len(count), np.nan)
    np.divide(np.nansum(values, axis=0), count, out=found, where=count > 0)
    return found
