"""What is zero up to rounding, and what is only small."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.estimation.numerical_rank import nested_ranks, numerical_ranks
from splinebba_cli.core.network import FloatArray


def numerical_rank(matrix: np.ndarray) -> int:
    return int(numerical_ranks(matrix[None])[0])


def with_singular_values(values: list[float], rows: int, seed: int) -> FloatArray:
    random = np.random.default_rng(seed)
    left = np.linalg.qr(random.standard_normal((rows, len(values))))[0]
    right = np.linalg.qr(random.standard_normal((len(values), len(values))))[0]
    return np.asarray(left * np.array(values) @ right.T)


@pytest.mark.parametrize("seed", range(5))
def test_a_weak_direction_is_no_null(seed: int) -> None:
    """A direction of 1e-12 of the largest is far above rounding; decimals that a product loses are not."""
    for smallest, rank in ((1e-12, 60), (0.0, 59)):
        values = [*np.geomspace(1.0, 1e-9, 59), smallest]
        assert numerical_rank(with_singular_values(values, 66, seed)) == rank


def test_units_do_not_matter() -> None:
    matrix = with_singular_values([1.0, 0.5, 0.1, 0.0], 9, 3)
    assert numerical_rank(matrix * [1e-9, 1.0, 1e6, 1e12]) == numerical_rank(matrix) == 3


def test_columns_that_nothing_reaches() -> None:
    assert numerical_rank(np.zeros((4, 3))) == 0
    assert numerical_rank(np.zeros((0, 3))) == 0
    assert numerical_rank(np.zeros((3, 0))) == 0
    assert numerical_rank(np.array([[0.0, 2.0], [0.0, 1.0]])) == 1


def test_stacks_have_the_ranks_of_their_matrices() -> None:
    """Also where some have fewer rows, made up by zeros, and of their leading columns."""
    matrices = [
        with_singular_values([1.0, 0.5, 0.1, 1e-9, last], rows, seed)
        for seed, (rows, last) in enumerate([(9, 0.0), (7, 1e-12), (5, 0.0), (9, 0.1)])
    ]
    matrices[3][:, 1] = 0.0  # an unknown that nothing reaches
    stack = np.zeros((4, 9, 5))
    for number, matrix in enumerate(matrices):
        stack[number, : len(matrix)] = matrix
    assert numerical_ranks(stack).tolist() == [4, 5, 4, 4]
    assert numerical_ranks(stack).tolist() == [numerical_rank(matrix) for matrix in matrices]
    leading, every = nested_ranks(stack, 3)
    assert every.tolist() == [4, 5, 4, 4]
    assert leading.tolist() == [numerical_rank(matrix[:, :3]) for matrix in matrices]
