"""Files of digitised points: tables and GeoJSON, and what is wrong with them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from splinebba_cli.errors import PointsFileError
from splinebba_cli.exchange.digitised_lines import DigitisedLine, ReadingOptions, read_digitised_lines

XYZ = [[500.0, 1000.0, 5.0], [501.0, 1001.0, 5.5], [502.0, 1003.0, 6.0], [500.0, 1000.0, 5.0]]


def lines(path: Path, **options: Any) -> tuple[DigitisedLine, ...]:
    return read_digitised_lines(path, ReadingOptions(**options))[0]


def codes(path: Path, **options: Any) -> list[str]:
    with pytest.raises(PointsFileError) as caught:
        lines(path, **options)
    return [item.code for item in caught.value.diagnostics]


def written(folder: Path, name: str, content: str | dict[str, Any]) -> Path:
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("x,y,z\n500,1000,5\n501,1001,5.5\n", {}),
        ("X;Y;Z;note\n500;1000;5;a\n501;1001;5.5;b\n", {}),
        ("# from the field\n500 1000 5\n501 1001 5.5\n", {}),
        ("y x z\n1000 500 5\n1001 501 5.5\n", {}),
        ("N\tE\tH\n1000\t500\t5\n1001\t501\t5.5\n", {"columns": ("E", "N", "H")}),
        ("7,1000,500,5\n8,1001,501,5.5\n", {"columns": ("-", "y", "x", "z")}),
    ],
)
def test_tables(tmp_path: Path, text: str, options: dict[str, Any]) -> None:
    (line,) = lines(written(tmp_path, "a.csv", text), **options)
    assert line.id == "" and not line.closed
    np.testing.assert_array_equal(line.points, XYZ[:2])


def test_a_table_with_several_lines(tmp_path: Path) -> None:
    path = written(tmp_path, "a.csv", "spline,x,y,z\n01,1,2,3\nb,4,5,6\n01,7,8,9\n")
    first, second = lines(path)
    assert (first.id, second.id) == ("01", "b")
    np.testing.assert_array_equal(first.points, [[1, 2, 3], [7, 8, 9]])
    path = written(tmp_path, "b.csv", "n,e,u,road\n1,2,3,a\n4,5,6,a\n")
    (line,) = lines(path, columns=("e", "n", "u", "road"))
    assert line.id == "a" and line.points[0].tolist() == [2, 1, 3]


def test_heights_are_asked_for(tmp_path: Path) -> None:
    for text in ("x,y\n1,2\n3,4\n", "1,2\n3,4\n"):
        path = written(tmp_path, "a.csv", text)
        assert lines(path, height=7.0)[0].points.tolist() == [[1, 2, 7], [3, 4, 7]]
    assert codes(written(tmp_path, "a.csv", "x,y\n1,2\n3,4\n")) == ["SBB322"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x,y,z\n1,2,nan\n1,inf,3\n1,2,x\n", ["SBB403"] * 3),
        ("x,y,z\n1,2\n", ["SBB404"]),
        ("x,y,z\n", ["SBB405"]),
        ("", ["SBB405"]),
        ("a,b,c\n1,2,3\n", ["SBB402"]),
        ("lon,lat,z\n1,2,3\n", ["SBB321"]),
    ],
)
def test_bad_tables(tmp_path: Path, text: str, expected: list[str]) -> None:
    assert codes(written(tmp_path, "a.csv", text)) == expected


def test_columns_that_are_not_there(tmp_path: Path) -> None:
    path = written(tmp_path, "a.csv", "east,north,h\n1,2,3\n")
    with pytest.raises(PointsFileError) as caught:
        lines(path, columns=("est", "north", "h"))
    assert caught.value.diagnostics[0].help == "did you mean `east`?"
    assert codes(written(tmp_path, "b.csv", "1,2,3\n"), columns=("e", "n", "h")) == ["SBB402"]


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    written(tmp_path, "road.csv", "x,y,z\n1,2,3\n")
    with pytest.raises(PointsFileError) as caught:
        lines(tmp_path / "raod.csv")
    assert caught.value.code == "SBB401" and "road.csv" in caught.value.diagnostics[0].help
    (tmp_path / "latin.csv").write_bytes(b"x,y,z\n\xe4,2,3\n")
    assert codes(tmp_path / "latin.csv") == ["SBB103"]


def feature(geometry: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": {}, **more}


def test_geojson(tmp_path: Path) -> None:
    line = {"type": "LineString", "coordinates": XYZ[:3]}
    data = {
        "type": "FeatureCollection",
        "features": [
            feature(line, properties={"id": 12, "name": "n"}),
            feature(
                {"type": "MultiLineString", "coordinates": [XYZ[:2], XYZ[1:3]]}, properties={"name": "m"}
            ),
            feature({"type": "Polygon", "coordinates": [XYZ]}, id="lake"),
            feature(line, properties=None),
            feature({"type": "MultiPolygon", "coordinates": [[XYZ]]}),
            feature({"type": "Point", "coordinates": XYZ[0]}),
        ],
    }
    path = written(tmp_path, "a.geojson", data)
    found, warnings = read_digitised_lines(path, ReadingOptions())
    assert [line.id for line in found] == ["12", "m-1", "m-2", "lake", "", ""]
    assert [line.closed for line in found] == [False, False, False, True, False, True]
    np.testing.assert_array_equal(found[0].points, XYZ[:3])
    (warning,) = warnings
    assert warning.code == "SBB407" and "Point" in warning.message
    assert len(lines(written(tmp_path, "b.json", line))) == 1


@pytest.mark.parametrize(
    "data",
    [
        "{",
        "[1, 2]",
        {"type": "FeatureCollection"},
        {"type": "LineString"},
        {"type": "LineString", "coordinates": [[1, 2, 3], "x"]},
        {"type": "LineString", "coordinates": [[1, 2, 3], [1, True, 3]]},
        {"type": "LineString", "coordinates": [[1, 2, 3], [1]]},
        {"type": "MultiPolygon", "coordinates": [[3]]},
    ],
)
def test_what_is_no_geojson(tmp_path: Path, data: str | dict[str, Any]) -> None:
    assert codes(written(tmp_path, "a.geojson", data)) == ["SBB407"]


def test_geojson_without_lines(tmp_path: Path) -> None:
    path = written(tmp_path, "a.geojson", {"type": "Point", "coordinates": [1000.0, 2, 3]})
    assert codes(path) == ["SBB407", "SBB405"]


def test_degrees_are_refused(tmp_path: Path) -> None:
    degrees = {"type": "LineString", "coordinates": [[11.1, 48.2, 500.0], [11.2, 48.3, 501.0]]}
    path = written(tmp_path, "a.geojson", degrees)
    assert codes(path) == ["SBB321"]
    assert len(lines(path, cartesian=True)) == 1
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    assert len(lines(written(tmp_path, "b.geojson", {**degrees, "crs": crs}))) == 1
    crs["properties"] = {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}  # type: ignore[assignment]
    metres = {"type": "LineString", "coordinates": XYZ}
    assert codes(written(tmp_path, "c.geojson", {**metres, "crs": crs})) == ["SBB321"]


def test_heights_and_numbers_of_geojson(tmp_path: Path) -> None:
    flat = {"type": "LineString", "coordinates": [[500, 600], [501, 601]]}
    path = written(tmp_path, "a.geojson", flat)
    assert codes(path) == ["SBB322"]
    assert lines(path, height=2.5)[0].points[:, 2].tolist() == [2.5, 2.5]
    path = written(
        tmp_path, "b.geojson", '{"type": "LineString", "coordinates": [[500, 600, NaN], [1, 2, 3]]}'
    )
    assert codes(path) == ["SBB403"]
