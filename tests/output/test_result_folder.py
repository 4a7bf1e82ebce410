"""The result folder as a whole: all promised files, the same bytes twice, nothing of other people's lost."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from splinebba_cli.errors import OutputError, UsageError
from splinebba_cli.output.provenance import provenance
from splinebba_cli.output.result_json import load_result_json
from tests.output.factory import Loaded, make_result, write_results

FILES = {
    "adjusted.yaml",
    "dispersion.npz",
    "exterior_orientation.csv",
    "points.csv",
    "prior_residuals.csv",
    "report.txt",
    "residuals.csv",
    "result.json",
    "spline_coefficients.csv",
    "spline_locations.csv",
    "spline_samples.csv",
}


def _write(folder: Path, **options: Any) -> None:
    options = {"html": False, **options}
    write_results(folder, make_result(), adjusted_files={"adjusted.yaml": "a: 1\n"}, **options)


def test_all_files_and_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    _write(tmp_path / "a", html=True, timings={"solve": 1.0})
    _write(tmp_path / "b", html=True, timings={"solve": 2.0})
    assert {entry.name for entry in (tmp_path / "a").iterdir()} == FILES | {"report.html"}
    for name in FILES | {"report.html"}:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name


def test_only_the_timestamps_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    contents = []
    for moment in ("1700000000", "1800000000"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", moment)
        _write(tmp_path / "a")
        contents.append(load_result_json(tmp_path / "a"))
    assert contents[0] != contents[1]
    for content in contents:
        del content["provenance"]["timestamps"]
    assert contents[0] == contents[1]


def test_choices(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    _write(tmp_path / "a", tables="parquet", dispersion="none")
    names = {entry.name for entry in (tmp_path / "a").iterdir()}
    assert "residuals.parquet" in names
    assert "dispersion.npz" not in names
    _write(tmp_path / "a")
    assert {entry.name for entry in (tmp_path / "a").iterdir()} == FILES


def test_keeps_what_people_have_put_in(tmp_path: Path) -> None:
    folder = tmp_path / "a"
    _write(folder)
    (folder / "notes").mkdir()
    (folder / "notes" / "note.txt").write_text("mine")
    (folder / "plot.png").write_bytes(b"png")
    _write(folder)
    assert (folder / "notes" / "note.txt").read_text() == "mine"
    assert (folder / "plot.png").read_bytes() == b"png"


def test_refuses_a_folder_that_is_not_its_own(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "result.json").write_text("{}")
    with pytest.raises(OutputError) as caught:
        _write(tmp_path / "a")
    assert caught.value.code == "SBB602"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]


def test_adjusted_file_outside_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="outside"):
        write_results(tmp_path / "a", make_result(), adjusted_files={"../x": ""}, html=False)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_parent(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError) as caught:
            _write(tmp_path / "a")
    finally:
        tmp_path.chmod(0o700)
    assert caught.value.code == "SBB605"


def test_provenance_tells_no_folder_of_the_machine(tmp_path: Path) -> None:
    project = tmp_path / "block" / "project.yaml"
    loaded = Loaded(path=project, source_hashes={str(project): "1", str(project.parent / "t" / "p.csv"): "2"})
    content = provenance(loaded, {"read": 0.12345})
    assert [item["file"] for item in content["inputs"]] == ["project.yaml", "t/p.csv"]
    assert str(tmp_path) not in str(content)
    assert content["timestamps"]["timings_s"] == {"read": 0.123}


def test_source_date_epoch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    assert provenance(Loaded(), {"read": 1.0})["timestamps"] == {
        "written": "2023-11-14T22:13:20Z",
        "timings_s": {},
    }
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "soon")
    with pytest.raises(UsageError):
        provenance(Loaded())
