"""The redundancy budget on the console: it fits, and long lists are cut with a note."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from rich.console import Console

from splinebba_cli.core.budget import Budget, budget
from splinebba_cli.report.budget_tables import WIDTH, BudgetTables
from splinebba_cli.simulation.six_image_block import simulate_block


@pytest.fixture(scope="module")
def found() -> Budget:
    return budget(simulate_block("six-image-mixed", seed=1)[0])


def shown(found: Budget, width: int = 120) -> list[str]:
    stream = io.StringIO()
    Console(file=stream, width=width).print(BudgetTables(found))
    return [line.rstrip() for line in stream.getvalue().splitlines()]


def renamed(found: Budget, name: str, times: int) -> Budget:
    """The same splines many times, each under a name and with a reason of its own."""
    splines = [f for f in found.features if f.kind == "spline"]
    many = [
        replace(f, id=f"{name}{k}", observations=9_999_999, reason=f"reason {k % 20} of a spline")
        for k, f in enumerate(splines * times)
    ]
    return replace(found, features=tuple(many), images=found.images * times)


def test_nothing_is_left_out_of_a_small_budget(found: Budget) -> None:
    text = "\n".join(shown(found))
    for heading in ("Spline ", "Points ", "Image "):
        assert heading in text
    assert "…" not in text and "left out" not in text
    for feature in found.features:
        assert feature.kind == "point" or f" {feature.id} " in text
    points = [f for f in found.features if f.kind == "point"]
    line = next(line.split() for line in shown(found) if line.split()[:2] == ["tie", "2"])
    ties = [f for f in points if f.role == "tie" and f.images == 2]
    assert line[2:] == [
        str(len(ties)),
        *(
            str(sum(getattr(f, key) for f in ties))
            for key in ("equations", "unknowns", "rank", "redundancy", "orientation_conditions")
        ),
    ]


def test_long_lists_and_names_are_cut(found: Budget) -> None:
    lines = shown(renamed(found, "a name that nobody should have given ", 10))
    assert max(map(len, lines)) <= WIDTH
    assert "… and 38 more" in "\n".join(lines)  # of 50 splines
    assert "… and 48 more" in "\n".join(lines)  # of 60 images
    assert any("more reasons" in line for line in lines)
    assert len(lines) < 70


def test_what_is_not_known_is_a_dash(found: Budget) -> None:
    features = tuple(
        replace(f, rank=None, redundancy=None, orientation_conditions=None, reason="") for f in found.features
    )
    lines = shown(replace(found, features=features))
    row = next(line.split() for line in lines if line.split()[:1] == ["tie-1"])
    assert row[5:8] == ["–", "–", "–"]


def test_a_reason_is_said_once(found: Budget) -> None:
    lines = shown(found)
    (line,) = [line for line in lines if "tie-1" in line and "natural spline" in line]
    assert "tie-1, tie-2: natural spline: 3(n+1) = 21 coefficients, not 12n = 72" in line


def test_a_narrow_console_drops_columns(found: Budget) -> None:
    lines = shown(found, width=70)
    assert max(map(len, lines)) <= 70
    assert any("columns left out" in line for line in lines)
