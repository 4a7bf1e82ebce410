"""The shortest text of every number that reads back the same, as ``repr`` writes it.

pyarrow finds the same digits in a sixth of the time; it writes whole, small and large numbers in another form, which
are left to ``repr``.  It is used where it has been imported anyway, for large tables.
"""

from __future__ import annotations

import sys

import numpy as np

from splinebba_cli.core.network import FloatArray

_SMALLEST, _LARGEST = 1e-4, 1e9  # between which both write numbers without exponent
_FEWEST = 500


def shortest_texts(values: FloatArray) -> list[str]:
    """Texts of numbers, (n,); nan and inf as ``repr`` has them."""
    if len(values) < _FEWEST or "pyarrow" not in sys.modules:
        return list(map(repr, values.tolist()))
    import pyarrow
    import pyarrow.compute

    size = np.abs(values)
    alike = (size >= _SMALLEST) & (size < _LARGEST) & (values != np.rint(values))
    texts: list[str] = pyarrow.compute.cast(pyarrow.array(values), pyarrow.string()).to_pylist()
    others = np.flatnonzero(~alike)
    if len(others):
        for row, text in zip(others.tolist(), map(repr, values[others].tolist()), strict=True):
            texts[row] = text
    return texts
