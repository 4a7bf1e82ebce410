"""Large tables by compiled readers: the same numbers, ids, places of errors as by rows, with and without pyarrow."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.errors import ProjectError
from splinebba_cli.project import regular_table
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.project.labels import Labels
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.regular_table import Shape, regular_columns
from tests.project.project_text import PROJECT, written

SHAPE = Shape(["image", "x", "spline", "y"], frozenset({"image", "spline"}), frozenset({"x", "y"}), ",", True)
GROUP = PROJECT[: PROJECT.index("  points:\n    - sigma_um")] + (
    "  points:\n    - {sigma_um: 5, table: obs.csv, columns: {image: foto, point: nr, x: x, y: y}}\n"
)


@pytest.fixture(params=["pyarrow", "numpy"], autouse=True)
def reader(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Every reader, also for small tables."""
    monkeypatch.setattr(regular_table, "_FEWEST_BYTES", 0)
    if request.param == "numpy":
        monkeypatch.setitem(sys.modules, "pyarrow.csv", None)
        monkeypatch.setattr(regular_table, "_BLOCK", 64)
    else:
        pytest.importorskip("pyarrow.csv")
    return str(request.param)


def columns(folder: Path, text: str, shape: Shape = SHAPE) -> regular_table.Columns | None:
    path = folder / "t.csv"
    path.write_text(text, encoding="utf-8", newline="")
    return regular_columns(path, path.read_bytes(), shape)


def rows(count: int, line_end: str = "\n") -> str:
    rng = np.random.default_rng(1)
    lines = [
        f"{i // 3},{x!r},küste-{i % 7}{'x' * (i % 5)},{y!r}"
        for i, (x, y) in enumerate(rng.normal(0, 100, (count, 2)).tolist())
    ]
    return line_end.join(["image,x,spline,y", *lines, ""])


@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_all_digits_and_all_ids(tmp_path: Path, line_end: str) -> None:
    text = rows(60, line_end)
    found = columns(tmp_path, text)
    assert found is not None
    expected = list(zip(*(line.split(",") for line in text.split(line_end)[1:-1]), strict=True))
    for name, column in (("image", 0), ("spline", 2)):
        labels = found[name]
        assert isinstance(labels, Labels)
        assert tuple(labels) == expected[column]
        assert len(set(labels.names)) == len(labels.names)
    np.testing.assert_array_equal(np.asarray(found["y"]), [float(text) for text in expected[3]])


@pytest.mark.parametrize(
    "text",
    [
        'image,x,spline,y\n"a",1,b,2\n',
        "image,x,spline,y\n# note\na,1,b,2\n",
        "image,x,spline,y\na,1,b,2\n\na,1,b,2\n",
        "image,x,spline,y\na,1,b\n",
        "image,x,spline,y\na,1,b,2,3\n",
    ],
)
def test_others_are_left_to_the_reader_of_rows(tmp_path: Path, text: str) -> None:
    assert columns(tmp_path, text) is None


@pytest.mark.parametrize("bad", ["x", "nan", "inf", "1_0", "1 2"])
def test_a_bad_number_is_never_a_number(tmp_path: Path, bad: str) -> None:
    found = columns(tmp_path, f"image,x,spline,y\na,1,b,2\na,{bad},b,2\n")
    assert found is None or isinstance(found["x"], Labels)


OBSERVED = "foto,x,nr,y\nno,1,1e-6,2\nno,1,t1,2.5\n12:30,-1e1,t1,2\n"


def test_a_project_of_such_tables(tmp_path: Path) -> None:
    observed = load_project(written(tmp_path, GROUP, obs=OBSERVED)).network.point_observations
    assert observed.point.tolist() == [0, 1, 1] and observed.image.tolist() == [0, 0, 1]
    assert observed.photo_xy.tolist() == [[1, 2], [1, 2.5], [-10, 2]]


@pytest.mark.parametrize(
    ("row", "code", "column"),
    [
        ("no,1,t9,2", "SBB301", 6),
        ("no,O,t1,2", "SBB403", 4),
        ("no,,t1,2", "SBB403", 4),
        ("no,nan,t1,2", "SBB403", 4),
        (",1,t1,2", "SBB403", 1),
        ("no,1,t1", "SBB404", 1),
    ],
)
def test_the_place_of_an_error(tmp_path: Path, row: str, code: str, column: int) -> None:
    path = written(tmp_path, GROUP, obs=OBSERVED + row + "\nno,1,t1,2\n")
    with pytest.raises(ProjectError) as caught:
        load_project(path)
    found: list[Diagnostic] = [d for d in caught.value.diagnostics if d.file.endswith("obs.csv")]
    assert [(d.code, d.line, d.column, d.snippet) for d in found] == [(code, 5, column, row)]
