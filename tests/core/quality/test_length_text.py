"""Lengths in messages have units that suit them."""

import pytest

from splinebba_cli.core.quality.length_text import length_text


@pytest.mark.parametrize(
    ("metres", "text"), [(0.000804, "0.804 mm"), (0.0675, "67.5 mm"), (1.8612, "1.86 m")]
)
def test_length_text(metres: float, text: str) -> None:
    assert length_text(metres) == text
