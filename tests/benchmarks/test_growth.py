"""The growth study: what it measures of a small block, and that it goes on where it ended."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks import growth
from benchmarks.blocks import NotAvailableError, bench_folder


def studied(folder: Path) -> dict[str, Any]:
    options = [
        "--sizes",
        "20",
        "--modes",
        "plain",
        "--folder",
        str(folder),
        "--json",
        str(folder / "out.json"),
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["growth", *options, "--plot", str(folder / "out.svg")])
        growth.main()
    content: dict[str, Any] = json.loads((folder / "out.json").read_text(encoding="utf-8"))
    return content


def test_a_study_keeps_what_it_measured(tmp_path: Path) -> None:
    try:
        bench_folder()
    except NotAvailableError as reason:
        pytest.skip(str(reason))
    first = studied(tmp_path)
    (run,) = first["runs"]
    assert (run["size"], run["mode"]) == (20, "plain")
    figures = run["figures"]
    assert figures["converged"] and figures["iterations"] > 3
    assert 0.0 < figures["estimation_s"] + figures["quality_s"] < run["wall_s"]
    assert figures["result_bytes"] > 2**20
    assert not (tmp_path / "r20").exists()  # results of large blocks are not kept
    assert (tmp_path / "out.svg").exists()
    assert studied(tmp_path)["runs"] == first["runs"]  # not measured again
