"""Digits from tables are those of printf, for every size, at ties and where nothing is finite."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray
from splinebba_cli.output.number_text import fixed_words, integer_words, lines, rounded, text_words
from splinebba_cli.output.significant_text import significant_words


def values(size: float) -> FloatArray:
    """Numbers of many sizes, exact ties of binary fractions, the neighbours of powers of ten, nothing finite."""
    rng = np.random.default_rng(3)
    powers = 10.0 ** np.arange(-12, np.log10(size))
    return np.concatenate(
        [
            rng.normal(0.0, 1.0, 5000) * 10.0 ** rng.uniform(-12.0, np.log10(size) - 1.0, 5000),
            rng.integers(-(2**20), 2**20, 2000) / 2.0 ** rng.integers(0, 20, 2000),
            powers,
            np.nextafter(powers, 0.0),
            np.nextafter(powers, np.inf),
            powers * (1.0 - 1e-10),
            [0.0, 9999.5, 9999.99999999, 0.5, 1.5, 2.5, np.nan, np.inf, -np.inf],
        ]
    )


def printed(given: FloatArray, form: str) -> list[str]:
    return [form % x if np.isfinite(x) else "" for x in given.tolist()]


@pytest.mark.parametrize("decimals", [0, 1, 3, 4, 6, 7, 9])
def test_fixed_decimals(decimals: int) -> None:
    given = values(1e5)
    words = fixed_words(given, decimals)
    assert words is not None
    assert lines([words], b",").decode().split("\n")[:-1] == printed(given, f"%.{decimals}f")


@pytest.mark.parametrize("digits", [1, 4, 6, 9, 12])
def test_significant_digits(digits: int) -> None:
    given = values(1e15)
    words = significant_words(given, digits)
    assert words is not None
    assert lines([words], b",").decode().split("\n")[:-1] == printed(given, f"%.{digits}g")


def test_numbers_beyond_the_tables_are_refused() -> None:
    assert fixed_words(np.array([1e12]), 7) is None
    assert significant_words(np.array([1e-300]), 6) is None


def test_rounded_is_what_is_read_back() -> None:
    given = values(1e5)
    expected = [float(text or "nan") for text in printed(given, "%.7f")]
    np.testing.assert_array_equal(rounded(given, 7), expected)


def test_rows_of_several_columns() -> None:
    cells = [text_words(["é", "", "long enough"]), integer_words(np.array([0, -12345678901, 40_000]))]
    assert lines(cells, b",").decode() == "é,0\n,-12345678901\nlong enough,40000\n"
