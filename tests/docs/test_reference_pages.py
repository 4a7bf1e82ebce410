"""Pages of reference say what the program does."""

from __future__ import annotations

import csv
import re
from itertools import product
from pathlib import Path

import pytest

from docs import build_command_line, build_error_codes
from splinebba_cli.commands.app import app
from splinebba_cli.errors import ERROR_CODES
from tests.docs.page_runner import ROOT, run_in_process

RESULT_FILES = (ROOT / "docs" / "result-files.md").read_text(encoding="utf-8")


def test_command_line_is_up_to_date() -> None:
    """To renew: python -m docs.build_command_line."""
    assert build_command_line.PAGE.read_text(encoding="utf-8") == build_command_line.page()


def test_command_line_has_all_options() -> None:
    """Every name of an option in the help of a command stands in its section of the page."""
    sections = re.split(r"^### ", build_command_line.page(), flags=re.MULTILINE)[1:]
    assert [section.split("\n", 1)[0] for section in sections] == [c.name for c in app.registered_commands]
    for section in sections:
        name = section.split("\n", 1)[0]
        code, help = run_in_process(f"splinebba {name} --help")
        assert code == 0
        shown = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", help)) - {"--help"}
        assert {option for option in shown if f"`{option}`" not in section} == set()


def test_error_codes_are_up_to_date() -> None:
    """To renew: python -m docs.build_error_codes."""
    text = build_error_codes.PAGE.read_text(encoding="utf-8")
    assert text == build_error_codes.page()
    assert set(re.findall(r"^\| \[?(SBB\d+)", text, re.MULTILINE)) == set(ERROR_CODES)


def expanded(name: str) -> list[str]:
    """`sigma_{x,y}_mm` is sigma_x_mm and sigma_y_mm."""
    parts = re.split(r"\{([^}]*)\}", name)
    choices = [part.split(",") if i % 2 else [part] for i, part in enumerate(parts)]
    return ["".join(one) for one in product(*choices)]


def columns_described(table: str) -> list[str]:
    """Columns of a table in docs/result-files.md, in their order there."""
    section = re.split(rf"^### {table}$", RESULT_FILES, flags=re.MULTILINE)[1]
    section = re.split(r"^##", section, flags=re.MULTILINE)[0]
    cells = re.findall(r"^\| (`.*?) \|", section, re.MULTILINE)
    return [column for cell in cells for name in re.findall(r"`([^`]+)`", cell) for column in expanded(name)]


@pytest.fixture(scope="module")
def headers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """Columns of all tables that the samples give."""
    found: dict[str, list[str]] = {}
    for sample in ("six_image_mixed", "free_network", "dissertation/table_5_4"):
        output = tmp_path_factory.mktemp("results") / "out"
        code, text = run_in_process(
            f"splinebba adjust {ROOT / 'sample_projects' / sample} -o {output} -q --no-html"
        )
        assert code == 0, text
        for path in sorted(output.glob("*.csv")):
            if not path.name.startswith("adjusted_"):
                with path.open(encoding="utf-8", newline="") as file:
                    found[path.stem] = next(csv.reader(file))
    return found


def test_columns_of_all_tables_are_described(headers: dict[str, list[str]]) -> None:
    assert {table: sorted(columns_described(table)) for table in headers} == {
        table: sorted(columns) for table, columns in headers.items()
    }


def test_keys_of_result_json_are_described() -> None:
    from splinebba_cli.project.result_schema import result_schema

    section = RESULT_FILES.split("## result.json")[1]
    named = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (.*?) \|", section, re.MULTILINE))))
    optional = {"format", "segments_table"}
    assert set(result_schema()["properties"]) - named - optional == set()


def test_a_missing_column_is_found() -> None:
    assert expanded("a_{x,y}_{1,2}") == ["a_x_1", "a_x_2", "a_y_1", "a_y_2"]
    assert "sigma_c3_m" in columns_described("spline_coefficients")


def test_pages_of_the_site_are_listed() -> None:
    """Every page of docs/ stands in an index, so that the site's navigation has it."""
    docs = ROOT / "docs"
    for folder, index in ((docs, docs / "index.md"), (docs / "decisions", docs / "decisions" / "index.md")):
        text = index.read_text(encoding="utf-8")
        pages = [*folder.glob("*.md"), *(docs.glob("how-to/*.md") if folder == docs else [])]
        for page in pages:
            if page != index and not page.name.endswith((".intro.md", ".words.md")):
                assert f"({page.relative_to(folder).as_posix()})" in text, page


def test_navigation_comes_from_the_index() -> None:
    from docs.extensions.navigation import navigation

    text = "# T\n\n- [No](a.md)\n\n## One\n\n- [A](a.md)\n- [Out](../b.md)\n\n## Two\n\nWords.\n"
    assert navigation(text) == "```{toctree}\n:hidden:\n:caption: One\n\na\n```"


def test_links_out_of_the_documentation() -> None:
    from docs.extensions.repository_links import rewritten

    text = "[a](../../splinebba_cli/x.py#L1) [b](../splinebba_cli/y.py) [c](../file-format.md) [d](other.md)"
    assert rewritten("how-to/page", text) == (
        "[a](repository:splinebba_cli/x.py) [b](repository:docs/splinebba_cli/y.py) [c](/file-format.md) [d](other.md)"
    )
    assert (
        rewritten("error-codes", "[e](../splinebba_cli/explanations/SBB101.md)") == "[e](/errors/SBB101.md)"
    )


def test_comments_of_fields() -> None:
    from docs.extensions.public_api import field_comments
    from splinebba_cli.core.result import CurveResult, Statistics

    assert field_comments(Statistics)["redundancy"] == ""
    assert field_comments(Statistics)["vtpv"] == ""
    assert field_comments(Statistics)["unknowns"] == "locations included"
    assert field_comments(CurveResult)["values"].startswith("(k, 3) knots")
    assert field_comments(CurveResult)["values_dispersion"] == "(k, 3, 3) of each value"


def test_explanations_become_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from docs.extensions import error_pages

    source, docs = tmp_path / "explanations", tmp_path / "docs"
    docs.mkdir()
    monkeypatch.setattr(error_pages, "EXPLANATIONS", source)
    assert error_pages.copy_explanations(docs) == []
    source.mkdir()
    (source / "SBB101.md").write_text("# SBB101: x\n", encoding="utf-8")
    assert error_pages.copy_explanations(docs) == ["SBB101"]
    assert (docs / "errors" / "SBB101.md").read_text(encoding="utf-8") == "# SBB101: x\n"
    (source / "SBB101.md").unlink()
    assert error_pages.copy_explanations(docs) == []
    assert not (docs / "errors" / "SBB101.md").exists()
