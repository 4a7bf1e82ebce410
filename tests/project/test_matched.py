"""The matched project: labels are among the spline points, the rest are chains, everything else stays."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.project.loading import LoadedProject, load_project
from splinebba_cli.project.matched import MATCHED_FILE, matched_project
from tests.labelled_chains import LOST, known_matching, street


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> LoadedProject:
    folder = tmp_path_factory.mktemp("street")
    extra = "points: {table: marks/points.csv}\nacceptance: {max_sigma0: 2}\n"
    project = street(folder, extra)
    (folder / "marks").mkdir()
    (folder / "marks" / "points.csv").write_text(
        "point,role,x,y,z,sigma\nP,control,1,2,0,0.01\n", encoding="utf-8"
    )
    text = project.read_text(encoding="utf-8").replace(
        "observations:\n",
        "observations:\n  points:\n  - {sigma_um: 5, columns: [image, point, x, y], "
        "data: [[1, P, 1, 2], [2, P, 3, 4]]}\n",
    )
    project.write_text(text, encoding="utf-8", newline="\n")
    return load_project(project, "matching")


@pytest.fixture(scope="module")
def result(given: LoadedProject) -> MatchResult:
    return known_matching(given)


def written(loaded: LoadedProject, result: MatchResult, folder: Path) -> Path:
    folder.mkdir()
    for name, text in matched_project(loaded, result, folder).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / MATCHED_FILE


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_it_can_be_adjusted_with_the_labels(
    given: LoadedProject, result: MatchResult, tmp_path: Path
) -> None:
    after = load_project(written(given, result, tmp_path / "m"))
    assert [d.code for d in after.diagnostics if d.severity == "error"] == []
    labelled, points = result.network.curve_observations, after.network.curve_observations
    np.testing.assert_array_equal(points.photo_xy, labelled.photo_xy)
    np.testing.assert_array_equal(points.sigma, labelled.sigma)
    names = [after.network.curves[k].id for k in points.curve]
    assert names == [result.network.curves[k].id for k in labelled.curve]
    assert points.group_names == ("chains",)
    ids = after.network.images.ids
    assert LOST not in ids and len(ids) == 5
    rows = [result.network.images.ids.index(id) for id in ids]
    np.testing.assert_allclose(
        after.network.images.rotation, result.network.images.rotation[rows], atol=1e-12
    )
    np.testing.assert_allclose(
        after.network.images.position, result.network.images.position[rows], rtol=1e-12
    )
    np.testing.assert_array_equal(after.network.points.xyz, given.network.points.xyz)
    assert after.model.acceptance == given.model.acceptance
    assert after.match_settings == given.match_settings


def test_it_can_be_matched_again(given: LoadedProject, result: MatchResult, tmp_path: Path) -> None:
    """What is left are the unmatched points of the images that are left, in their order."""
    again = load_project(written(given, result, tmp_path / "m"), "matching").network.unlabelled
    left = result.network.unlabelled
    kept = left.image != given.network.images.ids.index(LOST)
    np.testing.assert_array_equal(again.photo_xy, left.photo_xy[kept])
    assert set(again.chain_ids) == {left.chain_ids[k] for k in left.chain[kept]}


def test_tables_of_points_have_the_user_s_frame_and_the_figures(
    given: LoadedProject, result: MatchResult
) -> None:
    files = matched_project(given, result)
    matched, unmatched = rows_of(files["matched_points.csv"]), rows_of(files["unmatched_points.csv"])
    total = len(given.network.unlabelled)
    assert len(matched) == int((result.matches.curve >= 0).sum()) and len(matched) + len(unmatched) == total
    assert list(matched[0]) == ["image", "spline", "x", "y", "location", "chain", "distance", "runner_up"]
    first = int(np.flatnonzero(result.matches.curve >= 0)[0])
    assert float(matched[0]["x"]) == given.network.unlabelled.photo_xy[first, 0]
    assert matched[0]["distance"] == f"{result.matches.distance[first]:.3g}"
    assert {row["reason"] for row in unmatched} == {"far", "chain"}
    assert {row["image"] for row in unmatched} >= {LOST}
    source = rows_of((given.path.parent / "chains.csv").read_text(encoding="utf-8"))
    assert {(r["image"], r["chain"], r["x"], r["y"]) for r in matched} <= {tuple(r.values()) for r in source}


def test_user_s_tables_are_named_as_seen_from_the_folder(
    given: LoadedProject, result: MatchResult, tmp_path: Path
) -> None:
    project = written(given, result, tmp_path / "m")
    text = project.read_text(encoding="utf-8")
    assert "marks/points.csv" in text and "table_folders" in text


def test_points_taken_out_stay_out(tmp_path: Path) -> None:
    project = street(tmp_path)
    table = project.with_name("chains.csv")
    lines = table.read_text(encoding="utf-8").splitlines()
    lines = [f"{lines[0]},use", f"{lines[1]},no", *(f"{line},yes" for line in lines[2:])]
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    loaded = load_project(project, "matching")
    result = known_matching(loaded, lost="")
    after = load_project(written(loaded, result, tmp_path / "m"))
    observed, unlabelled = after.network.curve_observations, after.network.unlabelled
    excluded = [rows.excluded for rows in (observed, unlabelled) if rows.excluded is not None]
    assert sum(int(rows.sum()) for rows in excluded) == 1


def test_new_points_do_not_take_the_marks_of_others(tmp_path: Path) -> None:
    """Without marks of their own, points count from 1: the number of one that a tangent names may be given already."""
    project = street(tmp_path)
    text = project.read_text(encoding="utf-8").replace(
        "observations:\n",
        "observations:\n  spline_points:\n  - {sigma_um: 5, columns: [image, spline, x, y, mark], "
        "data: [[1, kerb-1, -0.08, 9.39, 3], [2, kerb-1, -0.1, 9.3, 2]]}\n"
        "  tangents:\n  - {columns: [image, spline, at, direction], sigma: 1, data: [[1, kerb-1, 3, 10]]}\n",
    )
    project.write_text(text, encoding="utf-8", newline="\n")
    loaded = load_project(project, "matching")
    after = load_project(written(loaded, known_matching(loaded), tmp_path / "m")).network
    assert after.tangents.point.tolist() == [0]
    np.testing.assert_allclose(after.curve_observations.photo_xy[0], [-0.08, 9.39])


def test_where_everything_is_matched_no_chains_are_left(given: LoadedProject, tmp_path: Path) -> None:
    result = known_matching(given, lost="")
    unmatched = np.flatnonzero(result.matches.curve < 0)
    curve = result.matches.curve.copy()
    curve[unmatched] = 0
    from splinebba_cli.core.matching.match import with_labels

    labelled = with_labels(given.network, curve, result.matches.location)
    whole = replace(result, network=labelled, matches=replace(result.matches, curve=curve))
    project = written(given, whole, tmp_path / "m")
    assert not (tmp_path / "m" / "unmatched_points.csv").exists()
    after = load_project(project)
    assert len(after.network.unlabelled) == 0 and not after.model.observations.chains
