"""What is written at the end is refused before a command begins."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.commands.places import require_place
from splinebba_cli.errors import OutputError


def test_places_that_will_do(tmp_path: Path) -> None:
    (tmp_path / "old.xml").write_text("old", encoding="utf-8")
    for place in (None, tmp_path / "old.xml", tmp_path / "new.xml"):
        require_place(place)
    assert (tmp_path / "old.xml").read_text(encoding="utf-8") == "old" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(("name", "code"), [("nothing/j.xml", "SBB601"), (".", "SBB607")])
def test_places_that_will_not_do(tmp_path: Path, name: str, code: str) -> None:
    with pytest.raises(OutputError) as caught:
        require_place(tmp_path / name)
    assert caught.value.code == code and caught.value.help


def test_a_folder_that_takes_no_files(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        if os.access(tmp_path, os.W_OK):
            pytest.skip("root may write everywhere")
        with pytest.raises(OutputError) as caught:
            require_place(tmp_path / "j.xml")
        assert caught.value.code == "SBB605"
    finally:
        tmp_path.chmod(0o700)


def test_nothing_is_adjusted_before_it_is_said(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["simulate", "strip", "-o", str(tmp_path / "p"), "-q"]).exit_code == 0
    words = [
        "adjust",
        str(tmp_path / "p"),
        "-o",
        str(tmp_path / "out"),
        "--junit",
        str(tmp_path / "no" / "j"),
    ]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2 and "reading" not in done.output and not (tmp_path / "out").exists()
