"""Distances and datum features in a project: what they become, what is wrong with them and where."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import DatumFeatures
from splinebba_cli.errors import ProjectError
from splinebba_cli.project.adjusted import adjusted_project
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.writer import write_project
from tests.project.project_text import PROJECT, changed, written

BARS = """\
  distances:
    - name: bars
      sigma_m: 0.001
      columns: [from, to, length]
      data: [["1e-6", t1, 3.5]]
    - between: images
      columns: [from, to, length, sigma_m]
      data: [[no, "12:30", 500.1, 0.02], ["12:30", no, 500.2, 0.03]]
"""


def errors_of(folder: Path, text: str) -> list[tuple[str, str, str]]:
    """Code, message and the line of every error."""
    with pytest.raises(ProjectError) as caught:
        load_project(written(folder, text))
    return [(d.code, d.message, d.snippet) for d in caught.value.diagnostics if d.severity == "error"]


def test_distances_between_points_and_between_images(tmp_path: Path) -> None:
    network = load_project(written(tmp_path, PROJECT + BARS)).network
    found = network.distances
    ids = [[(network.images if i else network.points).ids[k] for k, i in zip(*row, strict=True)]
           for row in zip(found.station, found.is_image, strict=True)]  # fmt: skip
    assert ids == [["1e-6", "t1"], ["no", "12:30"], ["12:30", "no"]]
    np.testing.assert_array_equal(found.is_image, [[False, False], [True, True], [True, True]])
    np.testing.assert_array_equal(found.length, [3.5, 500.1, 500.2])
    np.testing.assert_array_equal(found.sigma, [0.001, 0.02, 0.03])
    assert found.group is not None and found.group.tolist() == [0, 1, 1]
    assert found.group_names == ("bars", "distances[1]") and found.excluded is None


@pytest.mark.parametrize(
    ("old", "new", "code", "message"),
    [
        ('["1e-6", t1, 3.5]', '["1e-6", t9, 3.5]', "SBB301", "point `t9` is not declared"),
        (
            '[no, "12:30", 500.1, 0.02]',
            '[no, "12:31", 500.1, 0.02]',
            "SBB301",
            "image `12:31` is not declared",
        ),
        ('["1e-6", t1, 3.5]', '["1e-6", "1e-6", 3.5]', "SBB209", "from a station to itself"),
        ('["1e-6", t1, 3.5]', '["1e-6", t1, -3.5]', "SBB205", "must be positive"),
        ("      sigma_m: 0.001\n", "", "SBB202", "without σ"),
        ("500.1, 0.02]", "500.1, 0]", "SBB309", "sigma 0 is not positive"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, code: str, message: str) -> None:
    found = errors_of(tmp_path, PROJECT + changed(old, new, BARS))
    assert any(code == each[0] and message in each[1] for each in found), found


def test_a_point_that_no_image_determines_is_no_end_of_a_distance(tmp_path: Path) -> None:
    text = changed("  - {id: t1, role: tie}\n", "  - {id: t1, role: tie}\n  - {id: t2, role: tie}\n")
    text = changed("[no, t1, 1, 2],", '[no, t1, 1, 2], [no, t2, 3, 2, no], ["12:30", t2, 3, 2],', text)
    text = changed("columns: [image, point, x, y]", "columns: [image, point, x, y, use]", text)
    text = changed("[no, 1e-6, 1, 2], [no, t1, 1, 2],", "[no, 1e-6, 1, 2, yes], [no, t1, 1, 2, yes],", text)
    text = changed('["12:30", t2, 3, 2],', '["12:30", t2, 3, 2, yes],', text)
    text = changed('["12:30", t1, 1, 2]]', '["12:30", t1, 1, 2, yes]]', text)
    found = errors_of(tmp_path, text + changed('["1e-6", t1, 3.5]', '["1e-6", t2, 3.5]', BARS))
    assert [each[0] for each in found] == ["SBB304"]
    assert "`t2` of a distance is not measured in enough images" in found[0][1]


def test_distances_that_are_not_used_stay_in_the_network(tmp_path: Path) -> None:
    text = changed("columns: [from, to, length, sigma_m]", "columns: [from, to, length, sigma_m, use]", BARS)
    text = changed("500.1, 0.02]", "500.1, 0.02, no]", changed("500.2, 0.03]", "500.2, 0.03, yes]", text))
    found = load_project(written(tmp_path, PROJECT + text)).network.distances
    assert found.excluded is not None and found.excluded.tolist() == [False, True, False]


def test_a_written_network_is_read_back(tmp_path: Path) -> None:
    network = load_project(written(tmp_path, PROJECT + BARS)).network
    again = load_project(write_project(network, tmp_path / "again", name="again")).network
    np.testing.assert_array_equal(again.distances.station, network.distances.station)
    np.testing.assert_array_equal(again.distances.is_image, network.distances.is_image)
    np.testing.assert_array_equal(again.distances.length, network.distances.length)
    np.testing.assert_array_equal(again.distances.sigma, network.distances.sigma)


def with_datum(text: str) -> str:
    return PROJECT + f"adjustment:\n  {text}\n"


def test_datum_features_by_id_and_all(tmp_path: Path) -> None:
    text = with_datum("datum: inner\n  datum_features: {points: [t1], images: all, splines: [coast]}")
    settings = load_project(written(tmp_path, text)).network.settings
    assert settings.datum == "inner"
    assert settings.datum_features == DatumFeatures(points=("t1",), images=None, curves=("coast",))


@pytest.mark.parametrize(
    ("section", "code", "message"),
    [
        ("datum: inner\n  datum_features: {points: [t9]}", "SBB301", "point `t9` is not declared"),
        ("datum: inner\n  datum_features: {splines: [coasts]}", "SBB301", "spline `coasts` is not declared"),
        (
            "datum: minimal\n  datum_features: {points: all}",
            "SBB209",
            "`datum_features` with `datum: minimal`",
        ),
        ("datum: inner\n  datum_features: {}", "SBB202", "names no feature"),
    ],
)
def test_wrong_datum_features_are_named(tmp_path: Path, section: str, code: str, message: str) -> None:
    found = errors_of(tmp_path, with_datum(section))
    assert [(each[0], message in each[1]) for each in found] == [(code, True)]


def test_rejected_distances_are_marked_in_the_adjusted_project(tmp_path: Path) -> None:
    """The sample of a free network with one bar 5 mm too long beside three good ones."""
    sample = Path(__file__).parents[2] / "sample_projects" / "free_network"
    truth = load_project(sample / "project.yaml")
    ends = truth.network.points.ids
    start = adjust(truth.network).points.xyz
    rows = ["from,to,length,sigma_m"]
    for number, (a, b) in enumerate([(4, 5), (6, 7), (8, 9), (10, 11)]):
        length = float(np.linalg.norm(start[a] - start[b])) + 0.005 * (number == 2)
        rows.append(f"{ends[a]},{ends[b]},{length!r},5e-05")
    folder = tmp_path / "block"
    folder.mkdir()
    for file in sample.glob("*.csv"):
        (folder / file.name).write_bytes(file.read_bytes())
    (folder / "distances_points.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    text = (sample / "project.yaml").read_text(encoding="utf-8")
    text = text.replace(
        "  datum: inner\n", "  datum: inner\n  outliers: {method: snooping, max_share: 0.01}\n"
    )
    (folder / "project.yaml").write_text(text, encoding="utf-8")
    loaded = load_project(folder / "project.yaml")
    result = adjust(loaded.network)
    files = adjusted_project(loaded, result, tmp_path / "results")
    (table,) = [content for name, content in files.items() if "distances" in name]
    uses = [line.rsplit(",", 1)[1] for line in table.splitlines()]
    assert uses == ["use", "yes", "yes", "no", "yes"]
