"""Where side tables may lie: every way out of the folder is seen, and no folder beside it is taken for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinebba_cli.project.table_folders import lies_within


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """``block`` with a table, beside ``block-2`` with one, and links between them."""
    for name in ("block", "block-2", "shared/deep"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "t.csv").touch()
    (tmp_path / "block" / "link.csv").symlink_to(tmp_path / "block-2" / "t.csv")
    (tmp_path / "block" / "inside.csv").symlink_to(tmp_path / "block" / "t.csv")
    return tmp_path / "block"


@pytest.mark.parametrize(
    ("table", "further", "within"),
    [
        ("t.csv", [], True),
        ("sub/../t.csv", [], True),
        ("inside.csv", [], True),
        ("not/there.csv", [], True),
        ("../block-2/t.csv", [], False),  # begins with the name of the folder
        ("link.csv", [], False),
        ("link.csv", ["../block-2"], True),
        ("../shared/deep/t.csv", ["../shared"], True),
        ("../shared/deep/t.csv", ["../shared/de"], False),
        ("/dev/null", ["../shared"], False),
    ],
)
def test_within(folder: Path, table: str, further: list[str], within: bool) -> None:
    assert lies_within(folder / table, folder, further) is within
