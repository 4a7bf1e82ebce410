"""Arc lengths and tangents in a project: marks, units, frames, and every mistake with its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.network import Network
from splinebba_cli.errors import ProjectError
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.writer import write_project
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.six_image_block import simulate_block

HEAD = """\
version: 1
project: {name: linked, angle_unit: deg, rotation_sequence: omega-phi-kappa}
cameras:
  - {id: cam, principal_distance_mm: 100, image_coordinates: CAMERA}
images:
  - {id: a, camera: cam, orientation: {x: 0, y: 0, z: 1000, omega: 0, phi: 0, kappa: 0}}
  - {id: b, camera: cam, orientation: {x: 500, y: 0, z: 1000, omega: 0, phi: 0, kappa: 0}}
splines:
  - {id: coast, role: control, sigma: fixed, knots: [[0, 0, 0], [100, 10, 5], [200, 20, 0]]}
observations:
  spline_points:
    - sigma_um: 5
      columns: [image, spline, x, y, mark]
      data: |
        a coast 1 2 p
        a coast 3 2 q
        a coast 5 2 r
        b coast 1 2 p
        b coast 4 2 q
"""
ARCS = """\
  arc_lengths:
    - sigma_um: 7
      columns: [image, spline, from, to, length]
      data: |
        a coast p q 2.01
        a coast q r 2.02
        b coast p q 3.01
"""
TANGENTS = """\
  tangents:
    - sigma: 0.5
      columns: [image, spline, at, direction]
      data: |
        a coast p 10
        b coast q -30
"""
PIXELS = "pixel_corner, pixel_size_mm: 0.01, image_size_px: [1000, 1000], principal_point_offset_mm: [0, 0]"


def project(folder: Path, text: str, camera: str = "photo_mm") -> Path:
    path = folder / "project.yaml"
    path.write_text(HEAD.replace("CAMERA", camera) + text, encoding="utf-8")
    return path


def load(folder: Path, text: str = ARCS + TANGENTS, camera: str = "photo_mm") -> Network:
    return load_project(project(folder, text, camera)).network


def test_marks_name_measured_points(tmp_path: Path) -> None:
    network = load(tmp_path)
    arcs, tangents = network.arc_lengths, network.tangents
    assert arcs.first.tolist() == [0, 1, 3] and arcs.second.tolist() == [1, 2, 4]
    np.testing.assert_allclose(arcs.length, [2.01, 2.02, 3.01])
    np.testing.assert_allclose(arcs.sigma, 0.007)
    assert not arcs.simpson.any() and not tangents.directed.any()
    assert tangents.point.tolist() == [0, 4]
    np.testing.assert_allclose(np.degrees(tangents.direction), [10.0, -30.0])
    np.testing.assert_allclose(np.degrees(tangents.sigma), 0.5)


def test_points_without_marks_are_counted(tmp_path: Path) -> None:
    text = HEAD.replace("CAMERA", "photo_mm").replace(", mark]", ", -]") + ARCS
    for mark, number in (("p", "1"), ("q", "2"), ("r", "3")):
        text = text.replace(f"coast {mark} ", f"coast {number} ").replace(f" {mark} 2.0", f" {number} 2.0")
    text = (
        text.replace("1 q 2.01", "1 2 2.01").replace("2 r 2.02", "2 3 2.02").replace("1 q 3.01", "1 2 3.01")
    )
    path = tmp_path / "project.yaml"
    path.write_text(text, encoding="utf-8")
    assert load_project(path).network.arc_lengths.second.tolist() == [1, 2, 4]


def test_units_and_frames(tmp_path: Path) -> None:
    """Lengths in pixels of 0.01 mm; directions count from x towards y, which points down in pixel frames."""
    network = load(tmp_path, (ARCS + TANGENTS).replace("sigma_um: 7", "sigma_px: 0.7"), PIXELS)
    np.testing.assert_allclose(network.arc_lengths.length, [0.0201, 0.0202, 0.0301])
    np.testing.assert_allclose(network.arc_lengths.sigma, 0.007)
    np.testing.assert_allclose(np.degrees(network.tangents.direction), [-10.0, 30.0])
    gon = TANGENTS.replace("- sigma: 0.5\n", "- sigma: 0.5\n      angle_unit: gon\n      directed: true\n")
    network = load(tmp_path, gon)
    np.testing.assert_allclose(np.degrees(network.tangents.direction), [9.0, -27.0])
    assert network.tangents.directed.all()


BAD = [
    # what is replaced, by what, code, message contains, line, column
    ("a coast q r", "a coast q s", "SBB301", "no measured point `s`", 25, 19),
    ("b coast p q 3", "b coast r q 3", "SBB301", "no measured point `r`", 26, 17),
    ("a coast q r 2.02", "a coast p r 2.02", "SBB302", "two arc lengths begin", 25, 17),
    ("a coast q r 2.02", "a coast r q 2.02", "SBB302", "two arc lengths end", 25, 19),
    ("a coast q r 2.02", "a coast q p 2.02", "SBB209", "close a ring", 24, 17),
    ("a coast q r 2.02", "a coast q q 2.02", "SBB209", "to itself", 25, 19),
    ("2.02", "-2.02", "SBB205", "positive", 25, 21),
    ("2.02", "2.0x", "SBB403", "`2.0x`", 25, 21),
    ("    - sigma_um: 7\n      col", "    - col", "SBB202", "no σ", 21, 7),
    ("sigma_um: 7", "sigma_um: 7\n      sigma_mm: 1", "SBB209", "two units", 21, 7),
    ("sigma_um: 7", "sigma_um: 7\n      method: trapezoid", "SBB204", "trapezoid", 22, 15),
    ("sigma_um: 7", "sigma_px: 7", "SBB202", "pixel", 21, 7),
    ("b coast q -30", "a coast p -30", "SBB302", "two tangents", 32, 17),
    ("    - sigma: 0.5\n      col", "    - col", "SBB202", "without σ", 28, 7),
    ("a coast 3 2 q", "a coast 3 2 p", "SBB302", "given twice", 16, 21),
]


@pytest.mark.parametrize(("old", "new", "code", "message", "line", "column"), BAD, ids=lambda v: str(v)[:20])
def test_a_mistake_has_its_place(
    tmp_path: Path, old: str, new: str, code: str, message: str, line: int, column: int
) -> None:
    text = HEAD.replace("CAMERA", "photo_mm") + ARCS + TANGENTS
    assert old in text
    path = tmp_path / "project.yaml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ProjectError) as caught:
        load_project(path)
    found = [d for d in caught.value.diagnostics if d.severity == "error"]
    assert any(
        d.code == code and message in d.message and (d.line, d.column) == (line, column) for d in found
    ), [(d.code, d.message, d.line, d.column) for d in found]


def errors_of(folder: Path, text: str) -> list[tuple[str, int | None]]:
    path = folder / "project.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ProjectError) as caught:
        load_project(path)
    return [(d.message, d.line) for d in caught.value.diagnostics if d.severity == "error"]


def test_groups_together_make_the_chains(tmp_path: Path) -> None:
    """A fork, a ring or a second tangent through two groups is one, too."""
    more = ARCS.split("\n", 1)[1]
    base = HEAD.replace("CAMERA", "photo_mm") + ARCS
    fork = more.replace("        a coast q r 2.02\n        b coast p q 3.01\n", "")
    assert any("two arc lengths begin" in m and line == 30 for m, line in errors_of(tmp_path, base + fork))
    ring = fork.replace("p q 2.01", "r p 2.01")
    assert any(
        "close a ring" in m
        for m, _ in errors_of(tmp_path, base.replace("        b coast p q 3.01\n", "") + ring)
    )
    twice = base + TANGENTS + TANGENTS.split("\n", 1)[1]
    assert any("two tangents" in m for m, _ in errors_of(tmp_path, twice))


def test_a_point_has_no_direction(tmp_path: Path) -> None:
    knots = "knots: [[0, 0, 0], [100, 10, 5], [200, 20, 0]]"
    text = (
        HEAD.replace("CAMERA", "photo_mm").replace(knots, "family: polynomial_0, knots: [[0, 0, 0]]")
        + TANGENTS
    )
    assert any("that is a point" in m for m, _ in errors_of(tmp_path, text))


def test_without_any_measured_point_on_splines(tmp_path: Path) -> None:
    begin = HEAD.index("  spline_points:")
    text = HEAD[:begin].replace("CAMERA", "photo_mm") + ARCS + TANGENTS
    assert errors_of(tmp_path, text)


def test_a_network_is_written_and_read_back(tmp_path: Path) -> None:
    network, truth = simulate_block("six-image-mixed", seed=2)
    generator = np.random.default_rng(3)
    network = with_tangents(network, truth, 0.01, generator, directed=True)
    network = with_arc_lengths(network, truth, 0.007, generator, simpson=True)
    back = load_project(write_project(network, tmp_path, name="linked", angle_unit="gon")).network
    for name in ("first", "second", "simpson"):
        np.testing.assert_array_equal(getattr(back.arc_lengths, name), getattr(network.arc_lengths, name))
    for name in ("point", "directed"):
        np.testing.assert_array_equal(getattr(back.tangents, name), getattr(network.tangents, name))
    np.testing.assert_array_equal(back.arc_lengths.length, network.arc_lengths.length)
    np.testing.assert_allclose(back.tangents.direction, network.tangents.direction, rtol=1e-14)
