"""The same input gives the same bytes: whatever the number of threads, hash seed, language, time zone and folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from benchmarks.kill_nine import digest
from splinebba_cli.output.result_json import load_result_json
from tests.regenerate_expected import FOLDER

MOMENT = {"SOURCE_DATE_EPOCH": "1700000000"}
ONE = {
    "SPLINEBBA_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONHASHSEED": "1",
    "LC_ALL": "C",
    "TZ": "UTC",
}
TWO = {
    "SPLINEBBA_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "PYTHONHASHSEED": "77", "LC_ALL": "de_DE.UTF-8",
    "TZ": "Asia/Kolkata", "COLUMNS": "50", "FORCE_COLOR": "1",
}  # fmt: skip


def sample(folder: Path) -> Path:
    shutil.copytree(
        FOLDER / "six_image_mixed", folder, ignore=shutil.ignore_patterns("*.results", "expected")
    )
    return folder


def adjust(project: str, where: Path, environment: Mapping[str, str], *options: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "splinebba_cli", "adjust", project, "-q", *options],
        cwd=where, env={**os.environ, **environment}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_threads_hashes_languages_and_folders(tmp_path: Path) -> None:
    one = sample(tmp_path / "one")
    two = sample(tmp_path / "elsewhere" / "zwei σ")
    adjust("one/project.yaml", tmp_path, MOMENT | ONE, "--dispersion", "full")
    adjust(".", two, MOMENT | TWO, "--dispersion", "full")
    assert len(digest(one / "project.results")) > 10
    assert digest(one / "project.results") == digest(two / "project.results")
    for path in (one / "project.results").iterdir():
        assert str(tmp_path).encode() not in path.read_bytes(), f"{path.name} tells folders of the machine"


def test_only_the_block_of_timestamps_changes(tmp_path: Path) -> None:
    project = sample(tmp_path / "block")
    contents: list[dict[str, Any]] = []
    files: list[dict[str, bytes]] = []
    for moment in ("1700000000", "1800000000"):
        adjust("block", tmp_path, {"SOURCE_DATE_EPOCH": moment}, "--no-html")
        folder = project / "project.results"
        contents.append(load_result_json(folder))
        files.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert contents[0]["provenance"].pop("timestamps") != contents[1]["provenance"].pop("timestamps")
    assert contents[0] == contents[1]
    differing = {name for name, content in files[0].items() if files[1][name] != content}
    assert differing == {"result.json", "report.txt"}


def test_threads_of_compiled_kernels_change_nothing(tmp_path: Path) -> None:
    pytest.importorskip("numba")
    project = sample(tmp_path / "block")
    found = set()
    for threads in ("1", "2"):
        adjust(
            "block",
            tmp_path,
            MOMENT | {"SPLINEBBA_SPEED": "always", "SPLINEBBA_THREADS": threads},
            "--no-html",
        )
        found.add(digest(project / "project.results"))
    assert len(found) == 1
