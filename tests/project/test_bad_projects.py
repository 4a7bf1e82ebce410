"""A catalogue of bad projects: each error with its code and position."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinebba_cli.errors import ProjectError
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.project.loading import load_project
from tests.project.project_text import PROJECT, changed, written


def errors(folder: Path, text: str, **tables: str) -> list[Diagnostic]:
    with pytest.raises(ProjectError) as caught:
        load_project(written(folder, text, **tables))
    return [d for d in caught.value.diagnostics if d.severity == "error"]


FREE = "image_coordinates: photo_mm\n    interior: free"
PIXELS = "image_coordinates: pixel_one\n    principal_point_px: [1, 2]"
TWICE = "  - {id: road, role: tie, knots: [[0, 0, 0], [1, 1, 1]]}\n"
GROUP = "      sigma_um: 5\n      columns: [image, spline"
TWO = "      sigma_um: 5\n      sigma_mm: 1\n      columns: [image, spline"

BAD: list[tuple[str, str, str, str, int, int]] = [
    # what is replaced, by what, code, help or message contains, line, column
    ("    role: tie\n", "    rolle: tie\n", "SBB201", "did you mean `role`?", 15, 5),
    ("  angle_unit: deg\n", "  angel_unit: deg\n", "SBB201", "`angle_unit`", 4, 3),
    ("version: 1\n", "version: 2\n", "SBB205", "version 2", 1, 10),
    ("version: 1\n", "", "SBB202", "`version`", 1, 1),
    ("angle_unit: deg", "angle_unit: degree", "SBB204", "did you mean `deg`?", 4, 15),
    ("  angle_unit: deg\n", "", "SBB202", "angle_unit", 2, 1),
    ("  rotation_sequence: omega-phi-kappa\n", "", "SBB202", "rotation_sequence", 2, 1),
    ("principal_distance_mm: 150", "principal_distance_mm: 15O", "SBB203", "`15O`", 8, 28),
    ("principal_distance_mm: 150", "principal_distance_mm: -150", "SBB205", "greater than 0", 8, 28),
    ("principal_distance_mm: 150", "principal_distance_mm: .nan", "SBB203", "`.nan`", 8, 28),
    ("principal_distance_mm: 150", "principal_distance_mm: inf", "SBB207", "finite", 8, 28),
    ("principal_distance_mm: 150", "principal_distance_mm:", "SBB203", "no value", 8, 27),
    ("image_coordinates: photo_mm", "image_coordinates: photo", "SBB204", "photo_", 9, 24),
    ("image_coordinates: photo_mm", PIXELS, "SBB202", "pixel_size_mm", 9, 24),
    ("image_coordinates: photo_mm", FREE, "SBB208", "fixed", 10, 15),
    ("{id: no, camera: 0101", "{id: no, camera: 101", "SBB301", "did you mean `0101`?", 11, 22),
    ("splines:\n", "  - {id: no, camera: 0101}\nsplines:\n", "SBB302", "line 11", 13, 10),
    ("kappa: 90}}", "kappa: 90}, sigma: {x: 0}}", "SBB309", "fixed", 12, 109),
    ("sigma: fixed}", "sigma: fixed, fixed: true}", "SBB209", "one of them", 11, 106),
    ("points:\n  - {", TWICE + "points:\n  - {", "SBB302", "line 20", 24, 10),
    ("      200 20 0\n", "      200 20\n", "SBB404", "2 fields", 19, 1),
    ("      200 20 0\n", "      200 20 O\n", "SBB403", "`O`", 19, 14),
    ("      200 20 0\n", "      100 10 5\n", "SBB206", "the same", 16, 5),
    ("      100 10 5\n      200 20 0\n", "", "SBB307", "needs 2", 16, 5),
    ("    role: tie\n", "    role: control\n", "SBB202", "has no σ", 14, 9),
    ("    role: tie\n", "    role: tie\n    sigma: 0.1\n", "SBB209", "partial", 16, 5),
    ("    role: tie\n", "    role: tie\n    family: free_cubic\n", "SBB307", "free_cubic has 4", 17, 5),
    ("    role: tie\n", "    role: tie\n    breaks: [2]\n", "SBB311", "1 … 1", 16, 5),
    ("    role: tie\n", "    role: tie\n    knot_parameters: [0, 2, 2]\n", "SBB205", "parameter 2", 16, 5),
    ("    role: tie\n", "    role: tie\n    knot_parameters: [0, 1]\n", "SBB206", "3 needed", 16, 5),
    ("{knot: 2, components", "{knot: 3, components", "SBB311", "0 … 2", 23, 30),
    ("    held: [{knot: 0}, {knot: 2, components: [z]}]\n", "", "SBB308", "no known", 20, 9),
    ("components: [z]", "components: [h]", "SBB204", "`h`", 23, 46),
    ("sigma: 0.02}", "sigma: -1}", "SBB309", "positive", 25, 59),
    ("sigma: 0.02}", "sigma: [1, 2]}", "SBB206", "not 2", 25, 59),
    (", sigma: 0.02}", "}", "SBB202", "has no σ", 25, 10),
    (", xyz: [100, 100, 10]", "", "SBB308", "no x, y, z", 25, 10),
    ("xyz: [100, 100, 10]", "xyz: [100, 100]", "SBB206", "than 2", 25, 36),
    ("xyz: [100, 100, 10]", "xyz: [100, 1e8, 10]", "SBB306", "km", 25, 10),
    ("{id: t1, role: tie}", "{id: t1, role: tie, sigma: 1}", "SBB209", "control", 26, 10),
    ("        12:30 coast 2.5 3\n", "        12:31 coast 2.5 3\n", "SBB301", "did you mean `12:30`?", 36, 9),
    ("        12:30 coast 2.5 3\n", "        12:30 coats 2.5 3\n", "SBB301", "did you mean `coast`?", 36, 15),
    ("        12:30 coast 2.5 3\n", "        12:30 coast nan 3\n", "SBB403", "finite", 36, 21),
    ("        12:30 coast 2.5 3\n", "        12:30 coast 2.5\n", "SBB404", "3 fields", 36, 1),
    ("        12:30 coast 2.5 3\n", "", "SBB304", "one image only", 14, 9),
    ("[no, t1, 1, 2]", "[no, t2, 1, 2]", "SBB301", "`t1`", 42, 37),
    (", [no, t1, 1, 2]", "", "SBB304", "one image only", 26, 10),
    (', [no, t1, 1, 2], ["12:30", t1, 1, 2]', "", "SBB310", "no image", 26, 10),
    ("      columns: [image, spline, x, y]\n", "", "SBB402", "need `columns`", 29, 7),
    ("columns: [image, spline, x, y]", "columns: [image, spline, x, yy]", "SBB402", "`yy`", 31, 35),
    ("columns: [image, spline, x, y]", "columns: [image, spline, x, x]", "SBB402", "twice", 31, 16),
    ("    - name: traced\n      sigma_um: 5\n", "    - name: traced\n", "SBB202", "σ", 29, 7),
    (GROUP, TWO, "SBB209", "two units", 29, 7),
    (GROUP, GROUP.replace("_um", ""), "SBB201", "`sigma_px`, `sigma_um` or `sigma_mm`?", 30, 7),
    ("    - sigma_um: 5\n      columns", "      sigma_um: 5\n      columns", "SBB203", "`points: [{…}]`", 40, 7),
    (GROUP, GROUP.replace("_um", "_px"), "SBB202", "pixel_size_mm", 29, 7),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "code", "says", "line", "column"), BAD)
def test_code_and_position(
    old: str, new: str, code: str, says: str, line: int, column: int, tmp_path: Path
) -> None:
    found = errors(tmp_path, changed(old, new))
    assert [(d.code, d.line, d.column) for d in found] == [(code, line, column)], found
    assert says in found[0].message + found[0].help


def test_the_project_itself_is_valid(tmp_path: Path) -> None:
    assert load_project(written(tmp_path)).diagnostics == ()


def test_all_errors_in_one_go(tmp_path: Path) -> None:
    """Errors of the schema, of references and of tables are reported together."""
    text = changed("    role: tie\n", "    rolle: tie\n")
    text = changed("principal_distance_mm: 150", "principal_distance_mm: 15O", text)
    text = changed("        12:30 coast 2.5 3\n", "        12:31 coast 2.5 nan\n", text)
    assert [(d.code, d.line) for d in errors(tmp_path, text)] == [
        ("SBB203", 8),
        ("SBB201", 15),
        ("SBB301", 36),
        ("SBB403", 36),
    ]


def test_image_without_observations(tmp_path: Path) -> None:
    text = changed("splines:\n", "  - {id: idle, camera: 0101}\nsplines:\n")
    (found,) = errors(tmp_path, text)
    assert (found.code, found.line) == ("SBB303", 13)


def test_image_without_approximation_is_a_warning(tmp_path: Path) -> None:
    text = changed(", orientation: {x: 500, y: 0, z: 1000, omega: 1, phi: 2, kappa: 90}", "")
    (warning,) = load_project(written(tmp_path, text)).diagnostics
    assert (warning.code, warning.severity, warning.line) == ("SBB315", "warning", 12)


def test_segment_without_measurements_is_a_warning(tmp_path: Path) -> None:
    text = changed("columns: [image, spline, x, y]", "columns: [image, spline, x, y, segment]")
    for row in ("no    coast 1.5 2", "12:30 coast 2.5 3", "no    road  1.5 2"):
        text = changed(row + "\n", row + " 0\n", text)
    text = changed("12:30 road  2.5 3\n", "12:30 road  2.5 3 1\n", text)
    (warning,) = load_project(written(tmp_path, text)).diagnostics
    assert (warning.code, warning.line) == ("SBB305", 14)
    (found,) = errors(tmp_path, changed("2.5 3 1\n", "2.5 3 2\n", text))
    assert (found.code, found.line) == ("SBB311", 38)


def test_check_features_that_nobody_measured_are_left_out(tmp_path: Path) -> None:
    text = changed("  - {id: t1,", "  - {id: c1, role: check, xyz: [1, 2, 3]}\n  - {id: t1,")
    loaded = load_project(written(tmp_path, text))
    assert [d.code for d in loaded.diagnostics] == ["SBB310"]
    assert loaded.network.points.ids == ("1e-6", "t1")
    assert loaded.network.point_observations.point.tolist() == [0, 1, 1]


def test_prior_without_a_value(tmp_path: Path) -> None:
    text = changed(", orientation: {x: 500, y: 0, z: 1000, omega: 1, phi: 2, kappa: 90}", ", sigma: {x: 1}")
    (found,) = errors(tmp_path, text)
    assert (found.code, found.line) == ("SBB314", 12)


def test_a_missing_file_and_a_list(tmp_path: Path) -> None:
    with pytest.raises(ProjectError) as caught:
        load_project(tmp_path / "none.yaml")
    assert caught.value.code == "SBB101"
    assert errors(tmp_path, "- 1\n")[0].code == "SBB106"


def test_nothing_is_measured(tmp_path: Path) -> None:
    text = PROJECT[: PROJECT.index("observations:")]
    assert errors(tmp_path, text)[0].code == "SBB303"


def test_a_folder_with_a_project_of_another_name(tmp_path: Path) -> None:
    written(tmp_path).rename(tmp_path / "harbour.yaml")
    with pytest.raises(ProjectError) as caught:
        load_project(tmp_path)
    assert caught.value.code == "SBB101"
    assert "the folder holds `harbour.yaml`" in caught.value.diagnostics[0].help
