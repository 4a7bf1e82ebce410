"""Elimination of chained locations against dense orthogonal elimination of the same rows."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.chain_elimination import ChainRows, EliminatedChains, eliminate_chains

CHAINS, LENGTH, WIDTH = 5, 6, 9


def random_rows(seed: int, held: bool = False) -> ChainRows:
    """Chains of six, five, ... points; some without tangents; with `held`, some locations are no unknowns."""
    generator = np.random.default_rng(seed)

    def values(*shape: int) -> FloatArray:
        return generator.normal(size=shape)

    rows = ChainRows(
        values(CHAINS, LENGTH, WIDTH), values(CHAINS, LENGTH), values(CHAINS, LENGTH, WIDTH),
        values(CHAINS, LENGTH), values(CHAINS, LENGTH - 1, WIDTH), values(CHAINS, LENGTH - 1, 2),
    )  # fmt: skip
    for chain in range(CHAINS):
        end = LENGTH - chain
        for array in (rows.along, rows.along_slope, rows.tangent, rows.tangent_slope):
            array[chain, end:] = 0.0
        for array in (rows.arc, rows.arc_slopes):
            array[chain, end - 1 :] = 0.0
        rows.tangent[chain, ::2], rows.tangent_slope[chain, ::2] = 0.0, 0.0
        for place in (1, 4) if held and chain % 2 == 0 else ():
            rows.along_slope[chain, place] = rows.tangent_slope[chain, place] = 0.0
            rows.arc_slopes[chain, place - 1, 1] = 0.0
            if place < LENGTH - 1:
                rows.arc_slopes[chain, place, 0] = 0.0
    return rows


def dense(rows: ChainRows, chain: int) -> tuple[FloatArray, FloatArray]:
    """Parameters and locations of all rows of one chain: (k, P + 1) and (k, L)."""
    b = np.zeros((3 * LENGTH - 1, LENGTH))
    b[np.arange(LENGTH), np.arange(LENGTH)] = rows.along_slope[chain]
    b[LENGTH + np.arange(LENGTH), np.arange(LENGTH)] = rows.tangent_slope[chain]
    arc = 2 * LENGTH + np.arange(LENGTH - 1)
    b[arc, np.arange(LENGTH - 1)], b[arc, 1 + np.arange(LENGTH - 1)] = rows.arc_slopes[chain].T
    return np.vstack([rows.along[chain], rows.tangent[chain], rows.arc[chain]]), b


@pytest.fixture(params=[(1, False), (2, True)], ids=["free", "held"])
def both(request: pytest.FixtureRequest) -> tuple[ChainRows, EliminatedChains]:
    rows = random_rows(*request.param)
    return rows, eliminate_chains(rows)


def test_what_is_left_is_the_projection_off_the_locations(both: tuple[ChainRows, EliminatedChains]) -> None:
    rows, found = both
    for chain in range(CHAINS):
        j, b = dense(rows, chain)
        projector = np.eye(len(b)) - b @ np.linalg.pinv(b)
        kept = found.kept[chain]
        np.testing.assert_allclose(kept.T @ kept, j.T @ projector @ j, atol=1e-12)


def test_nothing_is_lost(both: tuple[ChainRows, EliminatedChains]) -> None:
    """Rotations are orthogonal: kept and pivot rows have the sum of squares of all rows."""
    rows, found = both
    for chain in range(CHAINS):
        j, _ = dense(rows, chain)
        both_parts = np.vstack([found.kept[chain], found.pivot[chain]])
        np.testing.assert_allclose(both_parts.T @ both_parts, j.T @ j, atol=1e-12)


def test_the_triangle_gives_the_locations(both: tuple[ChainRows, EliminatedChains]) -> None:
    rows, found = both
    steps = found.steps()
    for chain in range(CHAINS):
        j, b = dense(rows, chain)
        np.testing.assert_allclose(steps[chain], -np.linalg.pinv(b) @ j[:, -1], atol=1e-11)


def test_location_cofactors(both: tuple[ChainRows, EliminatedChains]) -> None:
    rows, found = both
    own, beside = found.location_cofactors()
    for chain in range(CHAINS):
        _, b = dense(rows, chain)
        inverse = np.linalg.pinv(b.T @ b)
        np.testing.assert_allclose(own[chain], np.diag(inverse), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(beside[chain], np.diag(inverse, 1), rtol=1e-9, atol=1e-11)
