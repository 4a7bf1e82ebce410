"""From the JSON of every benchmark to its table, and into its place in docs/performance.md."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from benchmarks.machine import machine
from benchmarks.measurements import Run, runs_of, write_measurements
from benchmarks.performance_tables import PLACE, filled, tables_of
from benchmarks.start_up import PAIRS

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "performance.md"


def run(task: str, mode: str = "", images: int = 1000, wall_s: float = 2.0, **figures: Any) -> Run:
    return Run(images, 0, task, mode, wall_s, 3.0, 2**30, figures)


ITERATED = {"iterations": 5, "estimation_s": 1.0, "quality_s": 0.5}
COAST = {**ITERATED, "images": 80, "points": 12_000, "total_s": 1.5, "approximation_s": 0.0, "functions": {}}
CONTENTS: dict[str, tuple[list[Run], dict[str, Any]]] = {
    "against_ceres": (
        [
            run("solve", "plain", solve_s=[0.65], dispersion_s=[0.05], iteration_s=[0.1]),
            run("ceres_vp", solve_s=1.3),
            run("first_use", "speed", import_s=0.4, warm_up_s=6.0),
        ],
        {"agreement": {"1000": {
            "sigma_x": None, "sigma_z": 4e-6, "cost": 1e-7, "cost_peer_rule": 1e-10, "largest_difference": 1e-5,
            "rms_difference": 1e-6,
        }}},
    ),
    "growth": (
        [run("adjust", "plain", observations=400_000, result_bytes=2**30, **ITERATED)],
        {"exponents": {"plain": {"wall time, s": 1.1, "quality, s": None}}, "first": 1000},
    ),
    "coastline": (
        [Run(500, 0, "coastline", "plain", 2.0, 3.0, 2**30, COAST)],
        {"exponents": {"plain": {"total_s": 2.01}}, "role": "partial"},
    ),
    "roofline": (
        [],
        {
            "peaks": {"GB/s, all threads": 3e10, "GFLOP/s, all threads": 1e11}, "images": 1000, "threads": 2,
            "steps": [{"name": "factorisation", "seconds": 0.04, "operations": 2e9, "bytes": 1e8}],
        },
    ),
    "start_up": ([run(pair.name, mode, images=0) for pair in PAIRS for mode in ("command", "imports")], {}),
}  # fmt: skip


def content_of(name: str, folder: Path) -> dict[str, Any]:
    runs, more = CONTENTS[name]
    write_measurements(folder / "figures.json", name, machine(), runs, **more)
    content: dict[str, Any] = json.loads((folder / "figures.json").read_text(encoding="utf-8"))
    assert runs_of(content) == runs
    return content


@pytest.mark.parametrize("name", CONTENTS)
def test_every_table_has_its_place_in_the_document(name: str, tmp_path: Path) -> None:
    tables = tables_of(content_of(name, tmp_path))
    document = filled(DOCUMENT.read_text(encoding="utf-8"), tables)
    for table in tables.values():
        assert table in document
        head, rule, *rows = table.split("\n\n")[0].strip().splitlines()
        assert rows
        assert {line.count("|") for line in (rule, *rows)} == {head.count("|")}
    assert filled(document, tables) == document  # filling again changes nothing


def test_the_document_has_no_other_places(tmp_path: Path) -> None:
    made = {place for name in CONTENTS for place in tables_of(content_of(name, tmp_path))} | {"coastline-tie"}
    assert {match["name"] for match in PLACE.finditer(DOCUMENT.read_text(encoding="utf-8"))} == made


def test_figures_of_the_peer(tmp_path: Path) -> None:
    tables = tables_of(content_of("against_ceres", tmp_path))
    assert (
        "| solution | 1000 | numpy | 0.65 | Ceres vp | 1.3 | 0.5 / 0.5 / 0.5 | 0.7 | yes |"
        in tables["against_ceres"]
    )
    agreement = "| 1000 | +1.0e-07 | +1.0e-10 | +1.0e-05 | +1.0e-06 | – | +4.0e-06 |"
    assert agreement in tables["against_ceres-agreement"]


def test_share_of_the_roofline(tmp_path: Path) -> None:
    # 2 GFLOP at 100 GFLOP/s take 20 ms, 100 MB at 30 GB/s 3.3 ms: half of 40 ms
    table = tables_of(content_of("roofline", tmp_path))["roofline"]
    assert re.search(r"\| factorisation \| 40 \| 2 \| 100 \| 50 \| 2.5 \| 50.0% \|", table)


def test_only_what_stands_between_the_marks_is_replaced() -> None:
    end = "<!-- end of figures -->\n"
    document = f"before\n<!-- figures: a -->\nold\n{end}after\n<!-- figures: b -->\nkept\n{end}"
    assert filled(document, {"a": "new\n"}) == document.replace("old", "\nnew\n")
    with pytest.raises(KeyError, match="no place for c"):
        filled(document, {"c": "new\n"})
