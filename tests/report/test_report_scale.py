"""Units for people."""

from __future__ import annotations

import pytest

from splinebba_cli.report.scale import angle_scale, length_scale, position_decimals


@pytest.mark.parametrize(
    ("metres", "text"),
    [
        (0.0123, "12.3 mm"),
        (0.0004, "0.400 mm"),
        (2e-5, "20.0 µm"),
        (3.0, "3.00 m"),
        (56_000.0, "56.0 km"),
        (1e-12, "0.0010 nm"),
    ],
)
def test_lengths(metres: float, text: str) -> None:
    assert length_scale([metres]).text(metres) == text


def test_fixed_and_missing_do_not_choose_the_unit() -> None:
    scale = length_scale([0.0, None, 0.02, 0.0, float("nan")])
    assert (scale.unit, scale.factor) == ("mm", 1e3)
    assert length_scale([]).text(None) == "–"
    assert length_scale([0.0]).text(0.0) == "0.0 mm"


@pytest.mark.parametrize(("degrees", "text"), [(0.001, "3.60 ″"), (2.0, "2.00 °"), (1e-6, "3.60 m″")])
def test_angles(degrees: float, text: str) -> None:
    assert angle_scale([degrees]).text(degrees) == text


@pytest.mark.parametrize(("sigma", "decimals"), [(0.02, 3), (0.002, 4), (1e-5, 6), (5.0, 3), (1e-15, 9)])
def test_decimals_show_two_digits_of_sigma(sigma: float, decimals: int) -> None:
    assert position_decimals([sigma]) == decimals
