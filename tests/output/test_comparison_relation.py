"""Input files of two results by their content: a file that was moved is the same file."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from splinebba_cli.output.comparison_relation import compared_inputs
from splinebba_cli.output.stored_result import StoredResult


def result(**files: str) -> StoredResult:
    inputs: list[dict[str, Any]] = [{"file": name, "sha256": content} for name, content in files.items()]
    return cast(StoredResult, SimpleNamespace(content={"provenance": {"inputs": inputs}}))


def test_files_are_matched_by_their_content() -> None:
    first = result(**{"images.csv": "1", "points.csv": "2", "knots.csv": "3", "old.csv": "4"})
    second = result(**{"../images.csv": "1", "points.csv": "5", "knots.csv": "3", "new.csv": "6"})
    assert [(item["file"], item["status"]) for item in compared_inputs(first, second)] == [
        ("images.csv", "same"),
        ("knots.csv", "same"),
        ("new.csv", "only B"),
        ("old.csv", "only A"),
        ("points.csv", "changed"),
    ]
