"""Lee's experiments as projects: counts as a user sees them, how they end, and the page that is made of them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app

ROOT = Path(__file__).parents[2]
PROJECTS = ROOT / "sample_projects" / "dissertation"
PAGE = (ROOT / "docs" / "dissertation.md").read_text(encoding="utf-8")
# theory.md, section 6 (tables 5.11 and 5.12: counted by hand, rank by an independent program): equations, unknowns,
# rank, nullity, redundancy = equations - rank; and the exit code of adjust from Lee's initial values
ROWS = {
    "table_5_4": (30, 24, 22, 2, 8, 0),
    "table_5_5": (30, 21, 20, 1, 10, 0),
    "table_5_6": (36, 18, 18, 0, 18, 0),
    "table_5_7": (66, 60, 60, 0, 6, 3),
    "section_5_3": (132, 102, 97, 5, 35, 3),
    "table_5_8": (96, 84, 82, 2, 14, 3),
    "table_5_10": (24, 21, 19, 2, 5, 0),
    "table_5_11": (12, 6, 6, 0, 6, 0),
    "table_5_12": (33, 30, 30, 0, 3, 3),
}
BUDGET = ("equations", "unknowns", "rank", "nullity", "redundancy")


def run(*arguments: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    return result.exit_code, result.stdout


def test_every_folder_is_here() -> None:
    assert {path.parent.name for path in PROJECTS.glob("*/project.yaml")} == set(ROWS)


@pytest.mark.parametrize("name", ROWS)
def test_rank_table(name: str) -> None:
    _, output = run("check", PROJECTS / name, "--format", "json")
    found = json.loads(output)["budget"]
    assert tuple(found[key] for key in BUDGET) == ROWS[name][:5]


@pytest.mark.parametrize("name", ROWS)
def test_how_it_ends(name: str, tmp_path: Path) -> None:
    code, output = run("adjust", PROJECTS / name, "-o", tmp_path / "out", "--format", "json", "-q")
    assert code == ROWS[name][5], output
    if code == 0:
        result = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
        assert result["status"]["converged"]
        statistics = result["statistics"]
        assert statistics["redundancy"] == pytest.approx(statistics["sum_redundancy_numbers"], abs=1e-6)
    else:
        assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ROWS)
def test_the_page_has_the_same_counts(name: str) -> None:
    row = re.search(rf"\(#{name.replace('_', '-')}\) \| (.*) \|$", PAGE, re.MULTILINE)
    assert row is not None
    assert tuple(int(cell) for cell in row.group(1).split(" | ")[:5]) == ROWS[name][:5]
