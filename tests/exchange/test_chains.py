"""Files of tracing tools become one table of chains: formats, names, origin of y, thinning, and what is refused."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from splinebba_cli.errors import ChainsFileError
from splinebba_cli.exchange.chain_conversion import ConversionOptions, ConvertedChains, converted_chains
from splinebba_cli.exchange.chain_thinning import thinned, without_repeats
from splinebba_cli.exchange.traced_chains import TracingOptions, image_name

LINE = [[10.0, 20.0], [30.5, 21.0], [50.0, 25.25]]
RING = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 0.0]]


def written(folder: Path, name: str, content: str | dict[str, Any]) -> Path:
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def feature(kind: str, coordinates: Any, **members: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, **members}


def collection(*features: dict[str, Any]) -> dict[str, Any]:
    return {"type": "FeatureCollection", "features": list(features)}


def table(converted: ConvertedChains) -> dict[tuple[str, str], list[list[float]]]:
    """What a reader of the table finds."""
    out: dict[tuple[str, str], list[list[float]]] = {}
    for row in csv.DictReader(io.StringIO(converted.csv_text())):
        out.setdefault((row["image"], row["chain"]), []).append([float(row["x"]), float(row["y"])])
    return out


def chains(*files: Path, **options: Any) -> dict[tuple[str, str], list[list[float]]]:
    return table(converted_chains(files, ConversionOptions(**options)))


def codes(*files: Path, **options: Any) -> list[tuple[str, str]]:
    with pytest.raises(ChainsFileError) as caught:
        converted_chains(files, ConversionOptions(**options))
    return [(item.code, item.position) for item in caught.value.diagnostics]


def columns(text: str) -> dict[str, Any]:
    return {"tracing": TracingOptions(columns=tuple(text.split(",")))}


def test_geojson(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "DSC_1.geojson",
        collection(
            feature("LineString", [[*p, 7.0] for p in LINE], properties={"chain": "a", "image": "DSC_9"}),
            feature("MultiLineString", [LINE, LINE[:2]], properties={"id": 4}),
            feature("Polygon", [RING], id="pool", properties={"id": None}),
            feature("LineString", LINE, properties={}),
        ),
    )
    found = chains(path)
    assert found == {
        ("DSC_9", "a"): LINE,
        ("DSC_1", "4-1"): LINE,
        ("DSC_1", "4-2"): LINE[:2],
        ("DSC_1", "pool"): RING,
        ("DSC_1", "1"): LINE,
    }


def test_what_is_no_line_is_left_out_and_named(tmp_path: Path) -> None:
    points = feature("Point", [1.0, 2.0], properties={})
    path = written(tmp_path, "a.geojson", collection(points, points, feature("LineString", LINE)))
    (warning,) = converted_chains([path], ConversionOptions()).warnings
    assert warning.code == "SBB333" and "2 Point" in warning.message


def test_labelme(tmp_path: Path) -> None:
    shapes = [
        {"label": "kerb", "shape_type": "linestrip", "points": LINE},
        {"label": "kerb", "shape_type": "line", "points": LINE[:2]},
        {"label": "roof", "points": RING[:3]},
        {"shape_type": "linestrip", "points": LINE[1:]},
        {"label": "hole", "shape_type": "circle", "points": LINE[:2]},
    ]
    path = written(
        tmp_path, "a.json", {"shapes": shapes, "imagePath": "..\\images\\DSC_1.JPG", "imageData": None}
    )
    converted = converted_chains([path], ConversionOptions())
    assert table(converted) == {
        ("DSC_1", "kerb-1"): LINE,
        ("DSC_1", "kerb-2"): LINE[:2],
        ("DSC_1", "roof-1"): RING,
        ("DSC_1", "1"): LINE[1:],
    }
    assert [w.code for w in converted.warnings] == ["SBB333"]
    suffixed = chains(path, tracing=TracingOptions(image_suffix=".JPG"))
    assert {image for image, _ in suffixed} == {"DSC_1.JPG"}


def test_segments(tmp_path: Path) -> None:
    path = written(tmp_path, "DSC_1.txt", "1 2 30 40 2.0 0.1 9\n5 6 70 8 2.0 0.1 9\n")
    expected = {("DSC_1", "1"): [[1, 2], [30, 40]], ("DSC_1", "2"): [[5, 6], [70, 8]]}
    assert chains(path, **columns("x1,y1,x2,y2")) == expected
    path = written(tmp_path, "all.csv", "Image;X1;Y1;X2;Y2\nDSC_1;1;2;30;40\nDSC_1;5;6;70;8\n")
    assert chains(path) == expected


def test_points(tmp_path: Path) -> None:
    path = written(tmp_path, "DSC_1.csv", "chain,row,col\nb,20,10\na,5,4\nb,21,30.5\na,6,4\n")
    expected = {("DSC_1", "b"): LINE[:2], ("DSC_1", "a"): [[4, 5], [4, 6]]}
    assert chains(path) == expected
    path = written(tmp_path, "DSC_1.txt", "20 10\n21 30.5\n")
    assert chains(path, **columns("row,col")) == {("DSC_1", "1"): LINE[:2]}


def test_names_of_columns_stand_in_place_of_a_header_only_where_there_is_one(tmp_path: Path) -> None:
    for text in ("DSC_1,c,10,20\nDSC_1,c,30.5,21\n", "photo,id,u,v\nDSC_1,c,10,20\nDSC_1,c,30.5,21\n"):
        path = written(tmp_path, "all.csv", text)
        assert chains(path, **columns("image,chain,x,y")) == {("DSC_1", "c"): LINE[:2]}


def test_a_table_without_a_header_is_not_guessed(tmp_path: Path) -> None:
    path = written(tmp_path, "a.txt", "1 2 30 40\n5 6 70 8\n")
    assert codes(path) == [("SBB402", f"{path}:1")]
    path = written(tmp_path, "b.csv", "u,v\n1,2\n3,4\n")
    assert codes(path) == [("SBB402", f"{path}:1:1")]


def test_every_error_of_all_files_in_one_go(tmp_path: Path) -> None:
    missing, broken = tmp_path / "nothing.json", written(tmp_path, "b.json", '{"type": \n]')
    other, bad = written(tmp_path, "c.json", "[1]"), written(tmp_path, "d.csv", "x,y\n1,2\n3,NaN\n")
    assert codes(missing, broken, other, bad) == [
        ("SBB401", str(missing)),
        ("SBB332", f"{broken}:2:1"),
        ("SBB332", str(other)),
        ("SBB403", f"{bad}:3:3"),
    ]
    assert codes(written(tmp_path, "e.json", {"shapes": [{"points": [[1, 2, 3]]}]}))[0][0] == "SBB332"
    infinite = written(tmp_path, "f.geojson", '{"type": "LineString", "coordinates": [[1, 2], [1e999, 4]]}')
    assert codes(infinite) == [("SBB403", str(infinite))]
    assert codes(written(tmp_path, "g.json", collection()))[0][0] == "SBB332"


def test_one_name_twice(tmp_path: Path) -> None:
    one = written(tmp_path, "DSC_1.geojson", feature("LineString", LINE, properties={"name": "kerb"}))
    two = written(
        tmp_path, "b.csv", "image,chain,x,y\nDSC_1,kerb,1,2\nDSC_1,kerb,3,4\nDSC_1,1,3,4\nDSC_1,1,8,4\n"
    )
    assert codes(one, two) == [("SBB334", f"{two}:2:12")]
    assert list(chains(one, two, renumber=True)) == [("DSC_1", "1"), ("DSC_1", "2"), ("DSC_1", "3")]


def test_numbers_pass_over_names_that_are_numbers(tmp_path: Path) -> None:
    data = collection(
        feature("LineString", LINE), feature("LineString", LINE, id=1), feature("LineString", LINE)
    )
    assert list(chains(written(tmp_path, "a.geojson", data))) == [("a", "2"), ("a", "1"), ("a", "3")]


@pytest.mark.parametrize("name", ["=1+1", "a\nb", "-"])
def test_names_that_cannot_be_ids(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, "a.geojson", feature("LineString", LINE, properties={"name": name}))
    assert codes(path) == [("SBB210", str(path))]
    assert list(chains(path, renumber=True)) == [("a", "1")]
    if name != "-":
        path = written(tmp_path, "b.geojson", feature("LineString", LINE, properties={"image": name}))
        assert codes(path) == [("SBB210", str(path))]


@pytest.mark.parametrize(
    ("file", "image"),
    [
        ("DSC_1.geojson", "DSC_1"),
        ("DSC_1.JPG.json", "DSC_1"),
        ("DSC_1.tif", "DSC_1"),
        ("../a/DSC_1.jpeg", "DSC_1"),
        ("..\\a\\DSC.1.json", "DSC.1"),
    ],
)
def test_names_of_images(file: str, image: str) -> None:
    assert image_name(file, TracingOptions()) == image
    assert image_name(file, TracingOptions(image_suffix=".JPG")) == f"{image}.JPG"


def test_y_that_points_up(tmp_path: Path) -> None:
    up = written(tmp_path, "a.csv", "x,y\n10,-20\n30.5,-21\n")
    (warning,) = converted_chains([up], ConversionOptions()).warnings
    assert warning.code == "SBB335" and "--y-up 0" in warning.help
    turned = converted_chains([up], ConversionOptions(y_up_from=0.0))
    assert not turned.warnings and table(turned) == {("a", "1"): LINE[:2]}
    high = written(tmp_path, "b.csv", "x,y\n10,3580\n30.5,3579\n")
    assert chains(high, y_up_from=3600.0) == {("b", "1"): LINE[:2]}


def test_coordinates_of_a_map(tmp_path: Path) -> None:
    path = written(tmp_path, "a.csv", "x,y\n412345.1,5381000.2\n412346,5381001\n")
    assert codes(path) == [("SBB335", f"{path}:2:1")]


def test_short_chains_are_left_out_and_counted(tmp_path: Path) -> None:
    path = written(tmp_path, "a.csv", "chain,x,y\na,1,1\na,1,1\na,2,1\nb,5,5\nb,6,5\nb,7,5\n")
    converted = converted_chains([path], ConversionOptions(min_points=3))
    assert list(table(converted)) == [("a", "b")]
    (count,) = converted.counts
    assert (count.chains_read, count.points_read, count.chains, count.points) == (2, 6, 1, 3)
    assert codes(path, min_points=4)[0][0] == "SBB332"


def test_the_chains_of_an_image_stand_together(tmp_path: Path) -> None:
    text = "image,x1,y1,x2,y2\na,1,2,3,4\nb,1,2,3,4\na,5,6,7,8\n"
    assert list(chains(written(tmp_path, "all.csv", text))) == [("a", "1"), ("a", "2"), ("b", "1")]


def test_points_that_stand_still() -> None:
    xy = np.array([[1.0, 1], [1, 1], [2, 1], [1, 1], [1, 1], [1, 2]])
    np.testing.assert_array_equal(without_repeats(xy), [[1, 1], [2, 1], [1, 1], [1, 2]])


@pytest.mark.parametrize("spacing", [0.5, 2.0, 2.5, 7.0, 30.0])
def test_thinned_points_are_a_spacing_apart(spacing: float) -> None:
    angle = np.linspace(0.0, 2.0, 50)
    xy = 10.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = 20.0 * np.sin(0.5 * (angle[1] - angle[0])) * np.arange(50)
    kept = [int(np.flatnonzero((xy == point).all(axis=1))[0]) for point in thinned(xy, spacing)]
    assert kept[0] == 0 and kept[-1] == 49
    gaps = np.diff(along[kept])
    assert (gaps[:-1] >= spacing - 1e-9).all() and gaps[-1] >= min(0.5 * spacing, along[-1]) - 1e-9
    assert (gaps < 1.5 * spacing + along[1]).all()


@pytest.mark.parametrize(
    ("spacing", "kept"), [(5.0, [0, 5, 11]), (4.0, [0, 4, 8, 11]), (9.0, [0, 11]), (100.0, [0, 11])]
)
def test_the_last_but_one_goes_where_the_end_is_near(spacing: float, kept: list[int]) -> None:
    xy = np.stack([np.arange(12.0), np.zeros(12)], axis=1)
    assert thinned(xy, spacing)[:, 0].tolist() == kept


def test_thinning_keeps_what_is_sparse() -> None:
    xy = np.array(LINE)
    np.testing.assert_array_equal(thinned(xy, 5.0), xy)
    np.testing.assert_array_equal(thinned(xy[:1], 5.0), xy[:1])
