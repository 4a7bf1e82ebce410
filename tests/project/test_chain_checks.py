"""Warnings about chains: directions of another convention, points given twice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.project.diagnostics import Diagnostic
from tests.project import test_chains
from tests.project.test_chains import loaded

HEAD = test_chains.HEAD.replace("[0.01, 0.02]", "0.01")
X = np.linspace(500.0, 3500.0, 40)
Y = 1000.0 + 300.0 * np.sin(X / 500.0)
ANGLE = np.degrees(np.arctan2(0.6 * np.cos(X / 500.0), 1.0))


def said(folder: Path, columns: str, rows: list[str]) -> list[Diagnostic]:
    text = "\n      ".join(rows)
    group = f"observations:\n  chains:\n  - sigma_px: 1\n    columns: {columns}\n    data: |\n      {text}\n"
    found = loaded(folder, HEAD + group).diagnostics
    return [item for item in found if item.code in ("SBB330", "SBB331")]


def rows_of(*values: np.ndarray, noise: float = 0.3) -> list[str]:
    generator = np.random.default_rng(1)
    table = np.stack([X, Y, *values], axis=1)
    table[:, :2] += noise * generator.normal(size=(len(X), 2))
    return [f"a 7 {' '.join(f'{value:.3f}' for value in row)}" for row in table]


@pytest.mark.parametrize(
    ("turned", "words"),
    [
        (lambda a: a, None),
        (lambda a: a + 180.0, None),
        (lambda a: a + 90.0, "they are the normals of the edges"),
        (lambda a: -a, "they are mirrored"),
        (lambda a: 90.0 - a, "they are the normals of the edges, and mirrored"),
        (lambda a: 17.0 * np.arange(len(a)), ""),
    ],
)
def test_directions_of_another_convention_are_named(
    turned: Callable[[np.ndarray], np.ndarray], words: str | None, tmp_path: Path
) -> None:
    found = said(tmp_path, "[image, chain, x, y, direction]", rows_of(turned(ANGLE)))
    if words is None:
        assert found == []
        return
    (item,) = found
    assert item.code == "SBB330" and item.severity == "warning"
    assert item.message.endswith(f"{words}, it seems" if words else "°)")


def test_normals_that_are_directions(tmp_path: Path) -> None:
    columns = "[image, chain, x, y, normal_x, normal_y]"
    along = np.cos(np.radians(ANGLE)), np.sin(np.radians(ANGLE))
    (item,) = said(tmp_path, columns, rows_of(*along))
    assert item.message.startswith("normals of") and "they are the directions of the edges" in item.message
    assert said(tmp_path, columns, rows_of(-along[1], along[0])) == []


def test_points_given_twice_are_counted_and_shown(tmp_path: Path) -> None:
    rows = rows_of(noise=0.0)
    again = [row.replace("a 7", "a 8") for row in rows[10:15]]
    (item,) = said(tmp_path, "[image, chain, x, y]", [*rows, *again])
    assert item.code == "SBB331" and item.message.startswith("5 of 45 points")
    head = (HEAD + "observations:\n  chains:\n  - sigma_px: 1\n    columns:\n    data:\n").count("\n")
    assert item.line == head + len(rows) + 1


@pytest.mark.parametrize("name", ["a 8", "b 7"])
def test_a_closed_chain_and_another_image_are_no_copies(name: str, tmp_path: Path) -> None:
    rows = rows_of(noise=0.0)
    other = [row.replace("a 7", name) for row in rows] if name.startswith("b") else []
    assert said(tmp_path, "[image, chain, x, y]", [*rows, rows[0], *other]) == []
