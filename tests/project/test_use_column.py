"""The column `use`: what the user takes out, what a run marks, and what comes back."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Network, select_rows
from splinebba_cli.core.settings import OutlierPolicy
from splinebba_cli.errors import ProjectError
from splinebba_cli.project.adjusted import adjusted_project
from splinebba_cli.project.loading import LoadedProject, load_project
from splinebba_cli.project.observation_marks import rejected_rows
from splinebba_cli.project.overrides import with_outliers
from splinebba_cli.project.writer import write_project
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.project.project_text import changed, written

ROW = 40


def with_use(*words: str) -> str:
    text = changed("columns: [image, spline, x, y]", "columns: [image, spline, x, y, use]")
    rows = ("no    coast 1.5 2", "12:30 coast 2.5 3", "no    road  1.5 2", "12:30 road  2.5 3")
    for row, word in zip(rows, words, strict=True):
        text = changed(row + "\n", f"{row} {word}\n", text)
    return text


def test_rows_are_taken_out_and_stay_in_the_network(tmp_path: Path) -> None:
    network = load_project(written(tmp_path, with_use("yes", "-", "No", "true"))).network
    assert network.curve_observations.excluded is not None
    assert network.curve_observations.excluded.tolist() == [False, False, True, False]
    assert network.point_observations.excluded is None


def test_anything_but_yes_and_no_is_an_error_at_its_place(tmp_path: Path) -> None:
    with pytest.raises(ProjectError) as caught:
        load_project(written(tmp_path, with_use("yes", "maybe", "yes", "yes")))
    (found,) = [d for d in caught.value.diagnostics if d.severity == "error"]
    assert (found.code, "maybe" in found.message) == ("SBB403", True)
    assert "12:30 coast" in found.snippet


def test_a_tie_that_marks_leave_in_one_image_is_left_out_with_a_warning(tmp_path: Path) -> None:
    loaded = load_project(written(tmp_path, with_use("yes", "no", "yes", "yes")))
    assert [curve.id for curve in loaded.network.curves] == ["road"]
    assert any(d.code == "SBB304" and "`use`" in d.message for d in loaded.diagnostics)


def blundered(tmp_path: Path) -> tuple[LoadedProject, Network]:
    """A written block with arcs and tangents, one curve point and one ray of a point in gross error."""
    network, truth = simulate_block("six-image-mixed", 3)
    network = with_arc_lengths(network, truth, 0.02, np.random.default_rng(1))
    network = with_tangents(network, truth, 5e-3, np.random.default_rng(2))
    arcs, tangents = network.arc_lengths, network.tangents
    network = replace(
        network,
        arc_lengths=select_rows(arcs, np.flatnonzero(arcs.second < 60)),
        tangents=select_rows(tangents, np.flatnonzero(tangents.point < 60)),
    )
    curves, points = network.curve_observations, network.point_observations
    curve_xy, point_xy = curves.photo_xy.copy(), points.photo_xy.copy()
    curve_xy[ROW] += 0.3
    point_xy[9] += 0.2
    network = replace(
        network,
        curve_observations=replace(curves, photo_xy=curve_xy),
        point_observations=replace(points, photo_xy=point_xy),
    )
    path = write_project(network, tmp_path / "block", name="block")
    return with_outliers(load_project(path), "snooping"), network


def test_adjusting_the_adjusted_project_changes_nothing_and_a_yes_brings_back(tmp_path: Path) -> None:
    loaded, _ = blundered(tmp_path)
    first = adjust(loaded.network)
    gone = {(each.kind, each.row) for each in first.revision.rejections if not each.returned}
    assert ("spline", ROW) in gone and ("point", 9) in gone
    assert any(kind in ("arc length", "tangent") for kind, _ in gone)  # they hang on the curve point
    folder = tmp_path / "out"
    folder.mkdir()
    for name, text in adjusted_project(loaded, first, folder).items():
        (folder / name).write_text(text, encoding="utf-8")
    again = load_project(folder / "adjusted.yaml")
    assert again.network.settings.outliers.method == "snooping"
    second = adjust(again.network)
    assert second.revision.rejected == 0
    sigma = np.sqrt(np.einsum("mii->mi", first.images.dispersion))
    assert (np.abs(second.images.eop - first.images.eop) < 1e-3 * sigma).all()
    assert second.statistics.redundancy == first.statistics.redundancy
    np.testing.assert_array_equal(
        again.network.curve_observations.photo_xy, loaded.network.curve_observations.photo_xy
    )

    table = folder / "adjusted_spline_points_1.csv"
    rows = list(csv.reader(io.StringIO(table.read_text(encoding="utf-8"))))
    use = rows[0].index("use")
    assert [n for n, row in enumerate(rows[1:]) if row[use] == "no"] == sorted(
        row for kind, row in gone if kind == "spline"
    )
    rows[1 + ROW][use] = "yes"
    table.write_text("\n".join(map(",".join, rows)) + "\n", encoding="utf-8")
    back = load_project(folder / "adjusted.yaml").network
    assert back.curve_observations.excluded is not None
    assert not back.curve_observations.excluded[ROW]


def test_only_the_run_s_own_rejections_are_marked(tmp_path: Path) -> None:
    loaded, _ = blundered(tmp_path)
    curves = loaded.network.curve_observations
    excluded = np.zeros(len(curves), dtype=bool)
    excluded[ROW] = True
    network = replace(
        loaded.network,
        curve_observations=replace(curves, excluded=excluded),
        settings=replace(loaded.network.settings, outliers=OutlierPolicy()),
    )
    result = adjust(network)
    assert not any(rows.any() for rows in rejected_rows(result).values())
    assert result.curve_residuals.across[ROW] != 0.0
    assert abs(result.curve_residuals.standardized[ROW, 0]) > 10.0


def test_an_override_keeps_the_other_settings(tmp_path: Path) -> None:
    text = written(tmp_path).read_text(encoding="utf-8")
    text += "adjustment: {alpha: 0.01, outliers: {method: huber, max_share: 0.2}}\n"
    loaded = with_outliers(load_project(written(tmp_path, text)), "tukey")
    policy = loaded.network.settings.outliers
    assert (policy.method, policy.max_share, loaded.network.settings.alpha) == ("tukey", 0.2, 0.01)
    assert loaded.model.adjustment.outliers.method == "tukey"
