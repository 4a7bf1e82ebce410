"""Many pixel coordinates outside of their image are one warning that says which frame would explain them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray
from splinebba_cli.project.diagnostics import SHOWN_PER_KIND, Diagnostic
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.pixel_frames import likely_frame

SIZE = np.array([5400.0, 3600.0])
INSIDE = np.random.default_rng(1).uniform(0.0, 1.0, (200, 2)) * SIZE
PROJECT = """\
version: 1
project: {{name: p, angle_unit: deg, rotation_sequence: omega-phi-kappa}}
cameras:
- {{id: c, principal_distance_mm: 36, image_coordinates: pixel_corner, pixel_size_mm: 0.01,
   image_size_px: [5400, 3600], principal_point_offset_mm: [0, 0]}}
images:
- {{id: a, camera: c, orientation: {{x: 0, y: 0, z: 50, omega: 0, phi: 0, kappa: 0}}}}
splines:
- {{id: s, role: control, sigma: 0.02, knots: [[0, 0, 0], [5, 0, 0], [9, 1, 0]]}}
observations:
  chains:
  - name: traced
    sigma_px: 0.5
    columns: [image, chain, x, y]
    data: |
{rows}
"""


@pytest.mark.parametrize(
    ("xy", "words"),
    [
        (INSIDE[:, ::-1], "swapped"),
        (INSIDE * [1.0, -1.0], "point up"),
        (INSIDE - 0.5 * SIZE, "middle of the image"),
        (3.0 * INSIDE, "smaller or larger image"),
    ],
    ids=["swapped", "up", "centred", "larger"],
)
def test_the_frame_that_explains_them(xy: FloatArray, words: str) -> None:
    assert words in likely_frame(xy, SIZE)


def outside(folder: Path, xy: FloatArray) -> list[Diagnostic]:
    rows = "\n".join(f"      a, c, {x:.2f}, {y:.2f}" for x, y in xy)
    (folder / "project.yaml").write_text(PROJECT.format(rows=rows), encoding="utf-8")
    return [item for item in load_project(folder, "matching").diagnostics if item.code == "SBB313"]


def test_many_are_one_warning_at_the_first_of_them(tmp_path: Path) -> None:
    xy = INSIDE[:, ::-1]
    number = int((xy > SIZE + 1.0).any(axis=1).sum())
    first = int(np.flatnonzero((xy > SIZE + 1.0).any(axis=1))[0])
    (warning,) = outside(tmp_path, xy)
    assert f"{number} of 200 measurements" in warning.message and "swapped" in warning.help
    assert warning.line == PROJECT.count("\n", 0, PROJECT.index("{rows}")) + 1 + first


def test_few_are_told_one_by_one(tmp_path: Path) -> None:
    xy = INSIDE.copy()
    xy[:SHOWN_PER_KIND, 0] = -100.0
    assert len(outside(tmp_path, xy)) == SHOWN_PER_KIND
