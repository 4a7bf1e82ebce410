"""Side tables of a project: columns, mappings, selections, hashes."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.errors import ProjectError
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.project.loading import LoadedProject, load_project
from tests.project.project_text import PROJECT, changed, written

OBSERVATIONS = PROJECT[: PROJECT.index("  points:\n    - sigma_um")]


def with_group(group: str) -> str:
    return OBSERVATIONS + "  points:\n    - {sigma_um: 5, table: obs.csv" + group + "}\n"


ROWS = "no,1e-6,1,2\nno,t1,1,2\n12:30,t1,1,2\n"


def diagnostics(path: Path) -> tuple[Diagnostic, ...]:
    with pytest.raises(ProjectError) as caught:
        load_project(path)
    return caught.value.diagnostics


def load(folder: Path, text: str, **tables: str) -> LoadedProject:
    return load_project(written(folder, text, **tables))


def test_header(tmp_path: Path) -> None:
    loaded = load(tmp_path, with_group(""), obs="image,point,x,y\n" + ROWS)
    assert loaded.network.point_observations.point.tolist() == [0, 1, 1]
    assert loaded.network.point_observations.group_names == ("obs.csv",)


def test_declared_columns(tmp_path: Path) -> None:
    loaded = load(tmp_path, with_group(", columns: [image, point, x, y]"), obs=ROWS)
    assert loaded.network.point_observations.image.tolist() == [0, 0, 1]


def test_mapping_of_names(tmp_path: Path) -> None:
    obs = "foto,nr,x_mm,y_mm,quality\n" + ROWS.replace("\n", ",9\n")
    group = ", columns: {image: foto, point: nr, x: x_mm, y: y_mm}"
    loaded = load(tmp_path, with_group(group), obs=obs)
    assert loaded.network.point_observations.photo_xy.tolist() == [[1, 2]] * 3
    assert loaded.diagnostics == ()
    written(tmp_path, with_group(group.replace("x: x_mm", "x: x_m")))
    (found,) = diagnostics(tmp_path / "project.yaml")
    assert (found.code, found.line) == ("SBB402", 40)
    assert "`x_mm`" in found.help


def test_unused_column_is_a_warning(tmp_path: Path) -> None:
    obs = "image,point,x,y,nx\n" + ROWS.replace("\n", ",9\n")
    (warning,) = load(tmp_path, with_group(""), obs=obs).diagnostics
    assert (warning.code, warning.severity) == ("SBB402", "warning")
    assert "`nx`" in warning.message


def test_header_lacks_a_column(tmp_path: Path) -> None:
    path = written(tmp_path, with_group(""), obs="image,pint,x,y\n" + ROWS)
    found = [d for d in diagnostics(path) if d.severity == "error"]
    assert [(d.code, d.line) for d in found] == [("SBB402", 40)]
    assert "pint" in found[0].help


def test_missing_table_with_a_suggestion(tmp_path: Path) -> None:
    path = written(tmp_path, with_group(""), obss="x\n1\n")
    (found,) = diagnostics(path)
    assert (found.code, found.line) == ("SBB401", 40)
    assert "obss.csv" in found.help


def test_dangling_ids_of_a_table_are_reported_once_each(tmp_path: Path) -> None:
    obs = "image,point,x,y\n" + ROWS + "no,t9,1,2\n" * 50 + "no,t8,1,2\n"
    found = diagnostics(written(tmp_path, with_group(""), obs=obs))
    assert [(d.code, Path(d.file).name, d.line, d.column) for d in found] == [
        ("SBB301", "obs.csv", 5, 4),
        ("SBB301", "obs.csv", 55, 4),
    ]


def test_sigma_of_each_row(tmp_path: Path) -> None:
    obs = "image,point,x,y,sigma_um\n" + ROWS.replace("\n", ",3\n", 1).replace("2\n", "2,\n")
    loaded = load(tmp_path, with_group(""), obs=obs)
    np.testing.assert_allclose(loaded.network.point_observations.sigma[:, 0], [3e-3, 5e-3, 5e-3])


def test_points_of_a_table_with_roles(tmp_path: Path) -> None:
    header = "point,role,x,y,z,sigma_x,sigma_y,sigma_z\n"
    points = header + "1e-6,control,1,2,3,0.1,fixed,free\nt1,tie,,,,,,\nc,check,1,2,3,,,\n"
    old = PROJECT[PROJECT.index("points:\n  - {id") : PROJECT.index("observations:")]
    text = changed(old, "points: {table: points.csv, except: [c]}\n")
    network = load(tmp_path, text, points=points).network
    assert network.points.ids == ("1e-6", "t1")
    np.testing.assert_array_equal(network.points.sigma, [[0.1, 0.0, np.inf], [np.inf] * 3])
    assert np.isnan(network.points.xyz[1]).all()


def test_sigma_of_a_table_is_not_that_of_its_tie_points(tmp_path: Path) -> None:
    points = "point,role,x,y,z,sigma\n1e-6,control,1,2,3,\nt1,tie,,,,\n"
    old = PROJECT[PROJECT.index("points:\n  - {id") : PROJECT.index("observations:")]
    text = changed(old, "points: {table: points.csv, sigma: 0.03}\n")
    network = load(tmp_path, text, points=points).network
    np.testing.assert_array_equal(network.points.sigma, [[0.03] * 3, [np.inf] * 3])
    with pytest.raises(ProjectError, match="tie point `t1` has a σ"):
        load(tmp_path, text, points=points.replace("t1,tie,,,,", "t1,tie,,,,0.1"))
    with pytest.raises(ProjectError, match="tie point `t1` has a σ"):
        load(tmp_path, text.replace("csv, sigma", "csv, role: tie, sigma"), points="point\nt1\n")


def test_splines_of_a_table(tmp_path: Path) -> None:
    knots = "spline,x,y,z\nroad,0,0,0\ncoast,0,0,0\nroad,1,1,1\ncoast,5,5,5\ncoast,9,9,9\n"
    old = PROJECT[PROJECT.index("splines:") : PROJECT.index("points:\n  - {id")]
    network = load(tmp_path, changed(old, "splines: {table: knots.csv, role: tie}\n"), knots=knots).network
    assert [(c.id, c.values[:, 0].tolist()) for c in network.curves] == [
        ("road", [0, 1]),
        ("coast", [0, 5, 9]),
    ]


def test_images_of_a_table(tmp_path: Path) -> None:
    header = "image,camera,x,y,z,omega,phi,kappa,sigma_x,prior_x\n"
    images = header + "no,0101,1,2,3,10,20,30,fixed,5\n12:30,0101,1,2,3,,,,,\n"
    old = PROJECT[PROJECT.index("images:") : PROJECT.index("splines:")]
    loaded = load(tmp_path, changed(old, "images: {table: images.csv}\n"), images=images)
    network = loaded.network
    assert network.images.has_orientation.tolist() == [True, False]
    assert network.images.position[0].tolist() == [5.0, 2.0, 3.0]  # a fixed value is the prior one
    assert network.images.prior_sigma[0, 3] == 0.0 and np.isinf(network.images.prior_sigma[1]).all()
    assert network.images.prior[0, 3] == 5.0 and np.isnan(network.images.prior[0, 4])


def test_hashes_of_all_files(tmp_path: Path) -> None:
    loaded = load(tmp_path, with_group(""), obs="image,point,x,y\n" + ROWS)
    assert loaded.source_hashes == {
        name: hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
        for name in ("project.yaml", "obs.csv")
    }


def test_a_shared_table_is_read_and_reported_once(tmp_path: Path) -> None:
    knots = "spline,x,y,z\ncoast,0,0,0\ncoast,1,O,1\nroad,0,0,0\nroad,1,1,1\nroad,2,2,2\n"
    text = changed(
        "    knots: |\n      0 0 0\n      100 10 5\n      200 20 0\n", "    knots: {table: knots.csv}\n"
    )
    text = changed("knots: [[0, 100, 0], [100, 110, 5], [200, 120, 0]]", "knots: {table: knots.csv}", text)
    found = diagnostics(written(tmp_path, text, knots=knots))
    assert [(d.code, d.line, d.column) for d in found] == [("SBB403", 3, 9)]
    loaded = load_project(written(tmp_path, text, knots=knots.replace("O", "1")))
    assert [len(curve.values) for curve in loaded.network.curves] == [2, 3]
    (found_missing,) = diagnostics(
        written(tmp_path, text, knots=knots.replace("road", "raod").replace("O", "1"))
    )
    assert found_missing.code == "SBB301"
