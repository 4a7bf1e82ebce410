"""pyarrow's digits are those of repr, and what it writes in another form is left to repr."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.project.shortest_text import shortest_texts


def test_with_pyarrow_as_without() -> None:
    pytest.importorskip("pyarrow.compute")
    rng = np.random.default_rng(5)
    powers = 10.0 ** np.arange(-20.0, 20.0)
    values = np.concatenate(
        [
            rng.normal(0, 1, 20_000) * 10.0 ** rng.uniform(-20, 20, 20_000),
            np.round(rng.normal(0, 1e4, 5000), 3),
            powers,
            np.nextafter(powers, 0.0),
            np.nextafter(powers, np.inf),
            np.arange(-5.0, 5.0),
            [-0.0, 5e-324, 1.7e308, np.nan, np.inf, -np.inf],
        ]
    )
    assert shortest_texts(values) == list(map(repr, values.tolist()))
