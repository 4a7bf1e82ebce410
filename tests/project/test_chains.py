"""Chains: what their tables say becomes unlabelled points in the photo frame."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.errors import ProjectError
from splinebba_cli.project.build_context import Purpose
from splinebba_cli.project.loading import LoadedProject, has_chains, load_project

HEAD = """\
version: 1
project: {name: street, angle_unit: deg, rotation_sequence: omega-phi-kappa}
cameras:
- {id: cam, principal_distance_mm: 50, image_coordinates: pixel_corner, pixel_size_mm: [0.01, 0.02],
   image_size_px: [4000, 2000],
   principal_point_offset_mm: [0, 0]}
images:
- {id: a, camera: cam}
- {id: b, camera: cam, orientation: {x: 5, y: 0, z: 50, omega: 0, phi: 0, kappa: 0}}
splines:
- {id: kerb, role: control, sigma: fixed, knots: [[0, 0, 0], [10, 1, 0], [20, 0, 0]]}
- {id: wall, role: tie, knots: [[0, 9, 0], [10, 8, 1], [20, 9, 0]]}
"""
GROUP = """\
observations:
  chains:
  - name: traced
    sigma_px: 0.5
    columns: [image, chain, x, y, direction, use]
    data: |
      a 7 2000 1000 0   yes
      a 7 2100 1000 45  yes
      b 7 2000 1000 -   no
      b - 2000 900  90  yes
"""


def loaded(folder: Path, text: str, purpose: Purpose = "matching") -> LoadedProject:
    path = folder / "project.yaml"
    path.write_text(text, encoding="utf-8")
    return load_project(path, purpose)


def test_a_table_becomes_points_and_chains(tmp_path: Path) -> None:
    points = loaded(tmp_path, HEAD + GROUP).network.unlabelled
    assert points.image.tolist() == [0, 0, 1, 1]
    np.testing.assert_allclose(points.photo_xy, [[0, 0], [1, 0], [0, 0], [0, 2]], atol=1e-12)  # y up
    np.testing.assert_allclose(points.sigma, [[0.005, 0.01]] * 4)
    assert points.chain.tolist() == [0, 0, 1, -1]
    assert points.chain_ids == ("a/7", "b/7")  # one name in two images: two chains
    assert points.excluded is not None and points.excluded.tolist() == [False, False, True, False]
    assert points.group_names == ("traced",)


def test_directions_are_turned_into_the_photo_frame(tmp_path: Path) -> None:
    """Down to the right by 45° in pixels that are twice as high as wide: atan2(-2, 1) with y up."""
    direction = loaded(tmp_path, HEAD + GROUP).network.unlabelled.direction
    np.testing.assert_allclose(direction[:2], [0.0, math.atan2(-2.0, 1.0)], atol=1e-12)
    assert np.isnan(direction[2])
    assert abs(math.sin(direction[3])) == pytest.approx(1.0)


def test_normals_are_directions_turned_by_a_right_angle(tmp_path: Path) -> None:
    text = GROUP.replace("direction, use", "normal_x, normal_y")
    rows = {"0   yes": "0 -3", "45  yes": "-1 1", "-   no": "- -", "90  yes": "2 0"}
    for old, new in rows.items():
        text = text.replace(old, new)
    given = loaded(tmp_path, HEAD + GROUP).network.unlabelled.direction
    (tmp_path / "normals").mkdir()
    found = loaded(tmp_path / "normals", HEAD + text).network.unlabelled.direction
    np.testing.assert_allclose(np.cos(2 * found), np.cos(2 * given), atol=1e-12)  # up to half a turn
    np.testing.assert_allclose(np.sin(2 * found), np.sin(2 * given), atol=1e-12)


def test_groups_stand_one_after_another(tmp_path: Path) -> None:
    more = "  - {sigma_um: 5, image_coordinates: photo_mm, columns: [image, x, y], data: [[b, 1, 2]]}\n"
    points = loaded(tmp_path, HEAD + GROUP + more).network.unlabelled
    assert points.group is not None and points.group.tolist() == [0, 0, 0, 0, 1]
    assert points.chain[-1] == -1
    np.testing.assert_allclose(points.photo_xy[-1], [1, 2])
    np.testing.assert_allclose(points.sigma[-1], [0.005, 0.005])


def test_a_project_to_be_matched_needs_neither_labels_nor_orientations(tmp_path: Path) -> None:
    found = loaded(tmp_path, HEAD + GROUP)
    assert found.diagnostics == ()
    assert [curve.id for curve in found.network.curves] == ["kerb", "wall"]
    assert found.network.images.has_orientation.tolist() == [False, True]
    assert has_chains(found.path)


def test_an_image_without_chains_is_named(tmp_path: Path) -> None:
    only_a = GROUP.partition("      b 7")[0]
    (warning,) = loaded(tmp_path, HEAD + only_a).diagnostics
    assert (warning.code, warning.severity) == ("SBB303", "warning") and "`b`" in warning.message


def test_without_chains_there_is_nothing_to_match(tmp_path: Path) -> None:
    with pytest.raises(ProjectError) as caught:
        loaded(tmp_path, HEAD)
    assert caught.value.code == "SBB327"
    assert not has_chains(tmp_path / "project.yaml")


def test_chains_alone_cannot_be_adjusted(tmp_path: Path) -> None:
    with pytest.raises(ProjectError) as caught:
        loaded(tmp_path, HEAD + GROUP, "adjustment")
    assert caught.value.code == "SBB303" and "splinebba match" in caught.value.help


@pytest.mark.parametrize("section", ["", "matching: {seed: 3}\n"])
def test_splines_that_wait_for_matching_are_left_out_of_an_adjustment(tmp_path: Path, section: str) -> None:
    """`section` without chains: a project in which everything found its label keeps them out, too."""
    labels = """\
  spline_points:
  - {sigma_px: 1, columns: [image, spline, x, y], data: [[a, kerb, 2000, 1000], [b, kerb, 2000, 1100]]}
"""
    chains = "observations:\n" if section else GROUP
    found = loaded(tmp_path, HEAD + chains + labels + section, "adjustment")
    assert [curve.id for curve in found.network.curves] == ["kerb"]
    codes = [item.code for item in found.diagnostics if item.severity != "info"]
    assert "SBB310" in codes
    said = [item.message for item in found.diagnostics if item.code == "SBB329"]
    assert said == ([] if section else ["points without a label take no part: 3 (in 2 chains)"])


def test_settings_of_matching_reach_the_core(tmp_path: Path) -> None:
    section = """\
matching: {position_sigma_m: 2, angle_sigma_deg: 0.5, alpha: 0.01, wrong_share: 0.1, direction_tolerance_deg: 10,
  new_curves: true, knot_tolerance_sigma: 2, orient_freely: false, rounds: 5, seed: 9}
"""
    settings = loaded(tmp_path, HEAD + GROUP + section).match_settings
    assert (settings.position_sigma_m, settings.alpha, settings.wrong_share) == (2.0, 0.01, 0.1)
    assert settings.angle_sigma_rad == pytest.approx(math.radians(0.5))
    assert settings.direction_tolerance_rad == pytest.approx(math.radians(10.0))
    assert (settings.new_curves, settings.knot_tolerance, settings.orient_freely) == (True, 2.0, False)
    assert (settings.rounds, settings.seed) == (5, 9)


def test_the_defaults_of_the_project_are_those_of_the_core(tmp_path: Path) -> None:
    from splinebba_cli.core.matching.settings import MatchSettings

    found = loaded(tmp_path, HEAD + GROUP).match_settings
    usual = MatchSettings()
    assert found.direction_tolerance_rad == pytest.approx(usual.direction_tolerance_rad, abs=0.002)
    for name in ("position_sigma_m", "angle_sigma_rad", "alpha", "wrong_share", "new_curves", "knot_tolerance",
                 "orient_freely", "rounds", "seed"):  # fmt: skip
        assert getattr(found, name) == getattr(usual, name), name


def test_chains_without_readable_images_are_no_second_error(tmp_path: Path) -> None:
    head = HEAD.replace(HEAD[HEAD.index("images:") : HEAD.index("splines:")], "images: {table: gone.csv}\n")
    with pytest.raises(ProjectError) as caught:
        loaded(tmp_path, head + GROUP)
    assert [item.code for item in caught.value.diagnostics] == ["SBB401"]
